"""RADAU13: Radau IIA with 7 stages on the stabilised index-2 equations, order 13, with error-controlled steps."""

from mbdsl.integrators.methods.radau_step import interpolate, method, next_length, store, take, trial_length

__all__ = ["METHOD", "interpolate", "next_length", "store", "take", "trial_length"]

METHOD = method(7, factor=5.0, power=1.0)
