"""Output of dop853 between the ends of a step: polynomials of degree 7, for which three further stages are computed.

    y(x) = y0 + x (d + z (f0 - d + x (2 d - f0 - f1 + z (d4 + x (d5 + z (d6 + x d7))))))

with z = 1 - x, d = y1 - y0, the slopes f at the ends (per step), and d4 ... d7 = h sum_j D_j y'_j from all stages.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.rotation_chart import from_rates, to_rates, to_second_rates
from mbdsl.integrators.methods.dop853_coefficients import ALL, ENDS, NODE, OF_D, SQUARE, STAGES, SUM
from mbdsl.integrators.methods.dop853_stages import (
    END,
    OF_Q,
    OF_V,
    OTHER_VELOCITY,
    READY,
    STAGE,
    evaluate_state,
    motion,
    solve_state,
)
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare


@kernel
def interpolate(k, x, h, out, run):
    """q and v at the part x of the step, in row k of ``out``."""
    vectors, n = run.vectors, run.layout[L.N_Q]
    if run.memory[READY] == 0.0:
        prepare(h, run)
    for i in range(n):
        q0, v0, a0 = vectors[L.POSITION0, i], vectors[L.VELOCITY0, i], vectors[STAGE, i]
        q1, v1, a1 = vectors[L.POSITION, i], vectors[OTHER_VELOCITY, i], vectors[STAGE + STAGES, i]
        out[k, i] = polynomial(x, q0, q1, h * v0, h * v1, OF_Q, i, run)
        out[k, n + i] = polynomial(x, v0, v1, h * a0, h * a1, OF_V, i, run)
    from_rates(out[k], out[k, n:], run)


@rare
def prepare(h, run):
    """Compute the further stages and the coefficients d4 ... d7; the end of the step remains as it is.

    If a stage fails, these coefficients are zero, and the interpolation has order 3.
    """
    vectors, c, n, size = run.vectors, run.coefficients, run.layout[L.N_Q], run.layout[L.N_ALL]
    t0, status = run.reals[S.STEP_END] - h, S.RUNNING
    for i in range(n):
        vectors[L.BEFORE, i], vectors[L.BEFORE2, i] = vectors[L.POSITION, i], vectors[L.VELOCITY, i]
    for k in range(ENDS, ALL):
        if status == S.RUNNING:
            motion(k, k, h, run)
            t = t0 + c[NODE + k] * h
            evaluate_state(t, run)
            status = solve_state(t, STAGE + k, run)
            to_second_rates(STAGE + k, run)
    for i in range(size):
        vectors[L.UNKNOWN, i] = vectors[END, i]
    for i in range(n):
        vectors[L.POSITION, i], vectors[L.VELOCITY, i] = vectors[L.BEFORE, i], vectors[L.BEFORE2, i]
        vectors[OTHER_VELOCITY, i] = vectors[L.VELOCITY, i]
        for k in range(4):
            v, q = 0.0, 0.0
            for j in range(ALL):
                v += c[ALL * (OF_D + k) + j] * vectors[STAGE + j, i]
                q += c[ALL * (SQUARE + OF_D + k) + j] * vectors[STAGE + j, i]
            q = h * (c[SUM + k] * vectors[L.VELOCITY0, i] + h * q)
            vectors[OF_Q + k, i] = q if status == S.RUNNING else 0.0
            vectors[OF_V + k, i] = h * v if status == S.RUNNING else 0.0
    to_rates(OTHER_VELOCITY, run)
    run.memory[READY] = 1.0


@kernel
def polynomial(x, y0, y1, f0, f1, more, i, run):
    """The value at the part x of a step with the values y and slopes f (per step) at its ends, and the coefficients in
    four rows from ``more`` on."""
    y, z = run.vectors, 1.0 - x
    d = y1 - y0
    end = y[more, i] + x * (y[more + 1, i] + z * (y[more + 2, i] + x * y[more + 3, i]))
    return y0 + x * (d + z * (f0 - d + x * (2.0 * d - (f0 + f1) + z * end)))
