"""RADAU9: Radau IIA with 5 stages on the stabilised index-2 equations, order 9, with error-controlled steps."""

from mbdsl.integrators.methods.radau_step import interpolate, method, next_length, store, take, trial_length

__all__ = ["METHOD", "interpolate", "next_length", "store", "take", "trial_length"]

METHOD = method(5, factor=5.0, power=1.0)
