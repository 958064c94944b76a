"""RADAU5: Radau IIA with three stages on the stabilised index-2 equations, order 5, with error-controlled steps.

The equations and their solution: :mod:`mbdsl.integrators.methods.radau_stages`; the loop over steps and the control of
their lengths: :mod:`mbdsl.integrators.methods.radau_step`.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8, on the equations of Gear,
Gupta, Leimkuhler, J. Comput. Appl. Math. 12 & 13 (1985) 77-90. The splitting is our own.
"""

from math import inf

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.rotation_chart import from_rates, with_rates
from mbdsl.integrators.methods import radau_stages
from mbdsl.integrators.methods.radau_coefficients import QB, RATES, VB, scheme
from mbdsl.integrators.methods.radau_newton import LAST
from mbdsl.integrators.methods.radau_step import method, next_length, take, trial_length
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

__all__ = ["METHOD", "SCHEME", "interpolate", "next_length", "store", "take", "trial_length"]

SCHEME = scheme(3)
#: the embedded formula, of order 3, is held to 0.1 tol^{4/5}
METHOD = method(SCHEME, 0.1, 0.8, 0.25, 100.0, inf)


@kernel
def interpolate(k, x, h, out, run):
    """q and v at the part x of the step, by the polynomial of degree 5 with the values of both at the ends of the last
    two steps; in the first step, with the accelerations at both ends."""
    vectors, n, r = run.vectors, run.layout[L.N_Q], run.memory[LAST] / h
    now, before = with_rates(L.POSITION, L.VELOCITY, RATES, run), with_rates(QB, VB, RATES + 1, run)
    for i in range(n):
        q0, v0 = vectors[L.POSITION0, i], h * vectors[L.VELOCITY0, i]
        q1, v1 = vectors[L.POSITION, i], h * vectors[now, i]
        c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
        if run.integers[S.HISTORY] > 1:
            g, dg = (r * (1.0 + r)) ** 2, -2.0 * r * (1.0 + r) * (1.0 + 2.0 * r)
            off = vectors[QB, i] - (q0 - r * (v0 - r * (c2 - r * c3)))
            slope = h * vectors[before, i] - (v0 - r * (2.0 * c2 - r * 3.0 * c3))
            b1 = (slope - dg * off / g) / g
            b0 = off / g + b1 * r
        else:
            b0 = h * h / 2.0 * vectors[L.UNKNOWN0, i] - c2
            b1 = h * h / 2.0 * vectors[SCHEME.STAGE + 2, i] - c2 - 3.0 * c3 - b0
        g, dg, b = (x * (1.0 - x)) ** 2, 2.0 * x * (1.0 - x) * (1.0 - 2.0 * x), b0 + b1 * x
        out[k, i] = q0 + x * (v0 + x * (c2 + x * c3)) + g * b
        out[k, n + i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3) + dg * b + g * b1) / h
    from_rates(out[k], out[k, n:], run)


@kernel
def store(h, run):
    radau_stages.store(SCHEME, h, run)
