"""RADAU5: Radau IIA with 3 stages on the stabilised index-2 equations, order 5, with error-controlled steps."""

from mbdsl.integrators.methods.radau_step import interpolate, method, next_length, store, take, trial_length

__all__ = ["METHOD", "interpolate", "next_length", "store", "take", "trial_length"]

METHOD = method(3, factor=0.1, power=0.8)
