"""RADAU13: Radau IIA with 7 stages on the stabilised index-2 equations, order 13, with error-controlled steps.

The equations: :mod:`mbdsl.integrators.methods.radau5_stages`; their solution, and output within steps:
:mod:`mbdsl.integrators.methods.radau_stages`; control of steps: :mod:`mbdsl.integrators.methods.radau_step`.

Source: Hairer, Wanner, Stiff differential equations solved by Radau methods, J. Comput. Appl. Math. 111 (1999) 93-111.
"""

from mbdsl.integrators.methods.radau_coefficients import coefficients
from mbdsl.integrators.methods.radau_stages import (
    constraint_size,
    correct,
    estimate,
    finish,
    interpolate,
    matrices,
    own_matrices,
    own_rows,
    predict,
    residuals,
    store,
)
from mbdsl.integrators.methods.radau_step import method, next_length, take, trial_length

__all__ = ["METHOD", "constraint_size", "correct", "estimate", "finish", "interpolate", "matrices", "next_length"]
__all__ += ["predict", "residuals", "store", "take", "trial_length"]

METHOD = method(7, own_rows(7), own_matrices(7), lambda: coefficients(7))
