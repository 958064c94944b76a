"""RADAU13: Radau IIA with 7 stages on the stabilised index-2 equations, order 13, with error-controlled steps.

The equations, their solution, and output within steps: :mod:`mbdsl.integrators.methods.radau_stages`; control of steps:
:mod:`mbdsl.integrators.methods.radau_step`.

Source: Hairer, Wanner, Stiff differential equations solved by Radau methods, J. Comput. Appl. Math. 111 (1999) 93-111.
"""

from mbdsl.integrators.methods import radau_stages
from mbdsl.integrators.methods.radau_coefficients import scheme
from mbdsl.integrators.methods.radau_step import LOOSER, NOISY, method, next_length, take, trial_length
from mbdsl.kernels.marks import kernel

__all__ = ["METHOD", "SCHEME", "interpolate", "next_length", "store", "take", "trial_length"]

SCHEME = scheme(7)
METHOD = method(SCHEME, LOOSER, 1.0, 1 / 8, NOISY, 0.0)


@kernel
def interpolate(k, x, h, out, run):
    radau_stages.interpolate(SCHEME, k, x, h, out, run)


@kernel
def store(h, run):
    radau_stages.store(SCHEME, h, run)
