"""dop853: its coefficients, its accelerations, the projection, and the test for stiffness.

Orders, tolerances and events: the tests of all methods.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as scipys

import mbdsl
from mbdsl.errors import IntegrationError
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.methods import dop853_coefficients as table
from mbdsl.integrators.methods import dop853_stages
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import build
from mbdsl.system.accelerations import accelerations
from mbdsl.system.index1 import Index1

MODELS = Path(__file__).parents[3] / "models"
A, C = np.array(table.A), np.array(table.NODES)
B = A[table.STAGES]

# -- coefficients ----------------------------------------------------------------------------------------------------


def test_the_same_numbers_as_in_scipy():
    assert np.array_equal(A, scipys.A)
    assert np.array_equal(C, scipys.C)
    assert np.array_equal(table.D, scipys.D)
    assert np.array_equal(table.E5[:13], scipys.E5)
    assert np.array_equal(table.E3[:13], scipys.E3)


def test_conditions_of_order_8():
    """Those of the trees without and with one or two further levels (Hairer, Norsett, Wanner I, section II.2).

    The largest entries of A are near 40: rounding is some 1e-15.
    """
    assert A.sum(axis=1) == pytest.approx(C, abs=1e-14)
    for k in range(8):
        assert B @ C**k == pytest.approx(1 / (k + 1), abs=1e-14)
    for i in range(7):
        for j in range(7 - i):
            assert (B * C**i) @ A @ C**j == pytest.approx(1 / ((j + 1) * (i + j + 2)), abs=1e-14)
    for k in range(6):
        assert B @ A @ A @ C**k == pytest.approx(1 / ((k + 1) * (k + 2) * (k + 3)), abs=1e-14)
    assert abs(B @ C**8 - 1 / 9) > 1e-7


def test_embedded_formulas():
    """Differences from order 5 and 3 vanish for polynomials of degree 4 and 2, and not for the next degree."""
    for row, order in ((np.array(table.E5), 5), (np.array(table.E3), 3)):
        for k in range(order):
            assert row @ C**k == pytest.approx(0.0, abs=1e-14)
        assert abs(row @ C**order) > 1e-4


def test_tables_of_the_kernels():
    """Each row is followed, SQUARE rows further, by its product with A, for positions."""
    rows = np.array(table.TABLE[: 2 * table.SQUARE * table.ALL]).reshape(2, table.SQUARE, table.ALL)
    assert np.array_equal(rows[0, : table.ALL], A)
    assert rows[1] == pytest.approx(rows[0] @ A, abs=1e-12)  # entries of D reach 500
    assert np.array_equal(table.TABLE[table.NODE : table.NODE + table.ALL], C)
    assert table.TABLE[table.SUM :] == pytest.approx(np.sum(table.D, axis=1), abs=1e-12)


# -- steps -----------------------------------------------------------------------------------------------------------


def run(model, stop, steps=1, tol=None):
    scene = mbdsl.load(MODELS / f"{model}.mbd")
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    start = initial_state(system, mechanism, 0.0)
    found = MethodRun(system, "dop853", stop / steps if tol is None else stop, 0.0, stop, np.array([]), tol=tol)
    found.begin(start.q, start.v, start.a, start.lam, start.redundant)
    return system, found


@pytest.mark.parametrize(
    ("model", "h"),
    [
        ("slider_crank", 0.01),
        ("driven_crank", 0.01),
        ("rolling_disc", 0.01),
        ("stick_slip_belt", 1e-3),
        # multipliers from C C^T: a tree, and loops with springs and a redundant constraint
        ("chain", 0.01),
        ("seven_body", 1e-4),
        ("four_bar", 1e-3),
    ],
)
def test_accelerations_at_the_end_of_a_step(model, h):
    """By one tangent and the factorisation of the loop, or by the matrix of the multipliers, as from the equations at
    acceleration level; with drivers, nonholonomic constraints and laws. Constraints hold to rounding."""
    system, found = run(model, 3 * h, steps=3)
    assert found.advance() == S.DONE
    q, v, lam = found.state()
    a = found.vectors[L.UNKNOWN0, : system.n]
    expected = accelerations(system, found.time, q, v, found.left_out)
    size = max(np.abs(x).max(initial=0.0) for x in expected)
    assert a == pytest.approx(expected[0], abs=1e-11 * size)
    assert lam == pytest.approx(expected[1], abs=1e-11 * size)
    assert np.abs(system.Phi(found.time, q)).max(initial=0.0) < 1e-15 * max(1.0, system.tables.size)
    speed = np.abs(v).max()
    assert np.abs(system.evaluate(found.time, q, v)[2]).max(initial=0.0) < 4e-15 * speed
    assert np.abs(system.Gam(found.time, q, v)).max(initial=0.0) < 4e-15 * speed


def test_steps_as_those_of_an_independent_code():
    """On seven bodies, steps of 0.75 ms of SciPy's formulas, with accelerations and projections by dense matrices.

    The orders that follow from errors lie between 5 and 15 there, with both codes: the error of 3e-4 is not asymptotic.
    The codes differ in the projection, whose iterations end at other states on the constraints.
    """
    steps, stop = 40, 0.03
    system, found = run("seven_body", stop, steps=steps)
    f, h, (q, v, _) = Index1(system, found.left_out), stop / steps, found.state()
    y = f.join(q, v)
    for k in range(steps):
        slopes = np.zeros((table.STAGES, len(y)))
        for i in range(table.STAGES):
            slopes[i] = f((k + scipys.C[i]) * h, y + h * scipys.A[i, :i] @ slopes[:i])
        y = f.project((k + 1) * h, y + h * scipys.B @ slopes)
    assert found.advance() == S.DONE
    _, finer = run("seven_body", stop, steps=2 * steps)
    assert finer.advance() == S.DONE
    error = np.abs(found.state()[0] - finer.state()[0]).max()
    assert 1e-5 < error < 1e-2
    assert np.abs(found.state()[0] - f.split(y)[0]).max() < 1e-3 * error


def test_rows_of_its_own_are_separate():
    assert dop853_stages.STAGE == L.ROWS
    rows = (dop853_stages.STAGE + table.ALL, dop853_stages.OF_Q + 4, dop853_stages.OF_V + 4)
    assert rows == (dop853_stages.OF_Q, dop853_stages.OF_V, dop853_stages.ROOT)
    end = L.ROWS + dop853_stages.OWN_ROWS
    assert dop853_stages.ROOT < dop853_stages.END < dop853_stages.OTHER_VELOCITY < end


# -- stiffness -------------------------------------------------------------------------------------------------------


def test_a_stiff_model_ends_a_controlled_run():
    """The damper in the knee of the double pendulum has a rate of some 1e5/s: after the first few dozen steps."""
    with pytest.raises(IntegrationError, match=r"the model is stiff.*h \|lambda\| = \d.*stable up to 6\.1") as caught:
        mbdsl.simulate(MODELS / "double_pendulum.mbd", method="dop853", tol=1e-6)
    assert "radau5" in caught.value.hint
    _, found = run("double_pendulum", 2.0, tol=1e-6)
    while (status := found.advance()) == S.RUNNING:
        pass
    assert status == S.STIFF
    assert found.steps < 500  # 2 s would take some 100,000 steps


@pytest.mark.parametrize("h", [1e-2, 1e-4])
def test_an_unstable_step_of_fixed_length(h):
    """The message states a stable step: with half of it the run continues."""
    with pytest.raises(IntegrationError, match="the model is stiff") as caught:
        mbdsl.simulate(MODELS / "double_pendulum.mbd", method="dop853", step=h, stop=0.02)
    stable = float(caught.value.hint.split("below ")[1].split(" s")[0])
    assert 1e-6 < stable < 1e-4
    _, found = run("double_pendulum", 400 * 0.5 * stable, steps=400)
    assert found.advance() == S.DONE


@pytest.mark.parametrize(("model", "tol"), [("pendulum", 1e-3), ("slider_crank", 1e-3), ("slider_crank", 1e-10)])
def test_models_that_are_not_stiff(model, tol):
    _, found = run(model, 2.0, tol=tol)
    assert found.advance() == S.DONE
    assert found.memory[dop853_stages.STIFF_STEPS] == 0.0
