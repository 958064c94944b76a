"""radau5: its coefficients, its linear algebra, a step against the full system of its stages, and controlled steps.

Orders and tolerances against references: tests/verification/test_radau5.py.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import loop_state, sparse_lu
from mbdsl.integrators.methods import radau13
from mbdsl.integrators.methods.radau5 import SCHEME
from mbdsl.integrators.methods.radau_coefficients import ERROR, ERROR2, METRIC, QB, RATES, VB
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import build

MODELS = Path(__file__).parents[3] / "models"
SCRIPT = Path(__file__).with_name("uncompiled_stages.py")
A, C = np.array(SCHEME.A), np.array(SCHEME.nodes)

# -- coefficients ----------------------------------------------------------------------------------------------------


def test_collocation():
    """Radau IIA: polynomials of degree 2 are integrated exactly from 0 to every node, of degree 4 to the end."""
    for k in range(3):
        assert A @ C**k == pytest.approx(C ** (k + 1) / (k + 1), abs=1e-15)
    for k in range(5):
        assert A[2] @ C**k == pytest.approx(1 / (k + 1), abs=1e-15)
    assert A[2] @ C**5 != pytest.approx(1 / 6, abs=1e-4)


def test_what_diagonalises_it():
    (s, re, im), there, back = SCHEME.values, np.array(SCHEME.there), np.array(SCHEME.back)
    assert back @ np.array([[s, 0, 0], [0, re, -im], [0, im, re]]) @ there == pytest.approx(A, abs=1e-14)
    assert back @ there == pytest.approx(np.eye(3), abs=1e-14)
    assert np.array(SCHEME.inverse) @ A == pytest.approx(np.eye(3), abs=1e-14)
    assert np.array(SCHEME.square) == pytest.approx(A @ A, abs=1e-15)


def test_the_embedded_formula_is_of_order_three():
    """With f at the start, the difference to the formula of order 5 vanishes for f of degree 2, not for f of degree
    3."""
    errors = [SCHEME.values[0] * (k == 0) + np.array(SCHEME.e1) @ C**k for k in range(4)]
    assert errors[:3] == pytest.approx([0, 0, 0], abs=1e-15)
    assert abs(errors[3]) > 0.01
    assert np.array(SCHEME.e2) == pytest.approx(np.array(SCHEME.e1) @ A, abs=1e-15)


# -- Newton's corrections --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def uncompiled():
    environment = {**os.environ, "MBDSL_NO_COMPILE": "1", "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    done = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_corrections_are_newtons_but_for_terms_of_order_h(uncompiled):
    """The stages are h apart and share their matrices; for a rolling disc, nothing changes between them."""
    assert len(uncompiled["moving"]) >= 8
    for name, (coarse, fine) in uncompiled["moving"].items():
        assert fine < 0.01, name
        # friction far above v_s: terms with multipliers are linearised without mu
        assert fine < (0.7 if name == "stick_slip_belt" else 0.4) * coarse or fine < 1e-8, name


def test_corrections_at_rest_are_exact(uncompiled):
    """The stages are then at one state, and the test covers every block of the splitting, with K and D of any
    stiffness. Dampers that are not stiff are left to the next iteration: those of the crank and of the rope."""
    for name, left in uncompiled["at rest"].items():
        assert left < {"slider_crank": 1e-6, "hoist": 1e-4}.get(name, 1e-8), name
    assert uncompiled["spoilt"]["slider_crank"] > 1e-5  # K is wrong by 1 %, of h^2 K/M = 0.1


# -- a step ----------------------------------------------------------------------------------------------------------

#: a soft beam with a mass matrix that depends on its shape, held by a joint
SOFT = """
model Soft
  Ground ground;
  FlexibleBeam beam(length = 1 m, mass = 2 kg, E = 20 MPa, S = 4 cm2, I = 3e-6 m4, elements = 1,
                    reference = "clamped-free");
  Rod arm(m = 0.5 kg, length = 0.4 m);
  Revolute O(ground, beam.a);
  Revolute A(beam.b, arm.a);
initial equation
  beam.phi = -20 deg;
  beam.w = 3 rad/s;
  guess arm.phi = -40 deg;
end Soft;
"""
STEPS = {"slider_crank": 1e-2, "double_pendulum": 5e-3, "seven_body": 5e-4, "soft": 4e-3}


def begun(model, h, stop=None, tol=None, times=()):
    scene = mbdsl.parse(SOFT) if model == "soft" else mbdsl.load(MODELS / f"{model}.mbd")
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    start = initial_state(system, mechanism, 0.0)
    stop = 1000 * h if stop is None else stop
    run = MethodRun(system, "radau5", h if tol is None else stop, 0.0, stop, np.array(times), tol=tol)
    run.begin(start.q, start.v, start.a, start.lam)
    return system, run


def full_system(S, t, h, q0, v0, a, lam):
    """q and v at the end of the step from the unsplit equations of the stages, by Newton's method with differences.

    w multiplies M here; the unknowns start at the accelerations and multipliers of the step's start.
    """
    n, m = S.n, S.m
    counts = np.cumsum([3 * n, 3 * n, 3 * m])

    def parts(x):
        a, w, lam, mu = np.split(x, counts)
        a, w, lam, mu = a.reshape(3, n), w.reshape(3, n), lam.reshape(3, m), mu.reshape(3, m)
        V = v0 + h * A @ a
        return q0 + h * A @ (V + w), V, a, w, lam, mu

    def residual(x):
        Q, V, a, w, lam, mu = parts(x)
        R = []
        for i in range(3):
            f, Phi, dPhi = S.evaluate(t + C[i] * h, Q[i], V[i], lam[i])
            M = S.M(t, Q[i])
            R.append([M @ a[i] - f, M @ w[i] / h + S.Phi_q(t, Q[i]).T @ mu[i], Phi / h**2, dPhi / h])
        return np.concatenate([part for kind in zip(*R, strict=True) for part in kind])

    x = np.concatenate([np.tile(a, 3), np.zeros(3 * n), np.tile(lam, 3), np.zeros(3 * m)])
    d = np.repeat([1e-3 / h, 1e-3, 1.0, 1.0], [3 * n, 3 * n, 3 * m, 3 * m])
    last = np.inf
    for _ in range(30):
        J = np.column_stack([(residual(x + e) - residual(x - e)) / (2 * e.max()) for e in np.diag(d)])
        change = np.linalg.solve(J * d, -residual(x)) * d
        x, size = x + change, np.abs(change / d).max()
        if size < 1e-4 and size >= 0.5 * last:
            Q, V, *_ = parts(x)
            return Q[2], V[2]
        last = size
    raise AssertionError("no convergence")


@pytest.mark.parametrize("done", [0, 7])
@pytest.mark.parametrize("model", STEPS)
def test_a_step(model, done):
    h = STEPS[model]
    S, run = begun(model, h)
    assert not done or run.advance(done) == loop_state.RUNNING
    Y, n = run.vectors.copy(), S.n
    assert run.advance(1) == loop_state.RUNNING
    q0, v0 = Y[L.POSITION0, :n], Y[L.VELOCITY0, :n]
    a = np.zeros(n) if model == "double_pendulum" else Y[L.UNKNOWN0, :n]  # its start is a transient
    q, v = full_system(S, done * h, h, q0, v0, a, Y[L.UNKNOWN0, n:])
    eps = 1e3 * np.finfo(float).eps * max(1.0, np.abs(q0).max())
    assert np.abs(run.vectors[L.POSITION0, :n] - q).max() < eps
    assert np.abs(run.vectors[L.VELOCITY0, :n] - v).max() < eps / h
    moved = np.abs(q - q0).max(), np.abs(v - v0).max()
    assert moved[0] > 1e8 * eps and moved[1] > 1e6 * eps / h  # the step is long enough for an error to show


@pytest.mark.parametrize("model", ["slider_crank", "soft"])
def test_dense_and_sparse_elimination_agree(model):
    from mbdsl.integrators.loop import linear_solve

    found = []
    for solver in (linear_solve.SPARSE_LU, linear_solve.DENSE):
        S, run = begun(model, STEPS[model])
        run.use_solver(solver)
        assert run.advance(20) == loop_state.RUNNING
        found.append(run.vectors[L.POSITION0, : S.n].copy())
    assert found[0] == pytest.approx(found[1], abs=1e-12)


def test_updates_that_are_not_listed(monkeypatch):
    """Large mechanisms test whether a pivot changes."""
    listed = begun("seven_body", 1e-4)[1]
    assert listed.advance(5) == loop_state.RUNNING
    analyse = sparse_lu.analyse
    monkeypatch.setattr(sparse_lu, "analyse", lambda *a: analyse(*a, most=0))
    other = begun("seven_body", 1e-4)[1]
    assert len(other.layout) < len(listed.layout)
    assert other.advance(5) == loop_state.RUNNING
    assert np.array_equal(other.vectors, listed.vectors)


# -- controlled steps ------------------------------------------------------------------------------------------------


def test_the_same_in_pieces_with_controlled_steps():
    runs = [begun("slider_crank", 0.0, stop=2.0, tol=1e-7, times=np.arange(1, 21) / 10)[1] for _ in range(2)]
    while runs[0].advance(1000) == loop_state.RUNNING:
        pass
    while runs[1].advance(3) == loop_state.RUNNING:
        pass
    assert np.array_equal(runs[0].vectors, runs[1].vectors)
    assert np.array_equal(runs[0].integers, runs[1].integers)
    assert np.array_equal(runs[0].out, runs[1].out)


def test_the_stop_time_is_hit():
    """And no step before it is much shorter than the others."""
    _, run = begun("slider_crank", 0.0, stop=1.7321, tol=1e-6)
    lengths, status, before = [], loop_state.RUNNING, 0.0
    while status == loop_state.RUNNING:
        status = run.advance(1)
        lengths.append(run.time - before)
        before = run.time
    assert run.time == 1.7321
    assert min(lengths[-3:]) > 0.2 * max(lengths[-10:])
    assert max(lengths) <= 0.02 * 1.7321 * (1 + 1e-12)
    assert run.steps == len(lengths)


def test_statistics():
    r = mbdsl.simulate(MODELS / "double_pendulum.mbd", method="radau5", tol=1e-6)
    s = r.stats
    assert (s["tol"], s["h"], s["status"]) == (1e-6, None, "done")
    assert 0 < s["rejected"] < 0.2 * s["steps"]
    assert s["steps"] < s["iterations"] < 4 * s["steps"]
    assert 0 < s["factorisations"] < s["steps"]  # matrices are kept


def test_a_transient_is_resolved_and_then_left_behind():
    """The knee of the stiff pendulum is pulled to its creep within 10 us; steps grow ten thousandfold after it."""
    _, run = begun("double_pendulum", 0.0, stop=2.0, tol=1e-6)
    lengths, before = [], 0.0
    while run.advance(1) == loop_state.RUNNING:
        lengths.append(run.time - before)
        before = run.time
    assert min(lengths) < 1e-5
    assert max(lengths) > 1e3 * min(lengths)


def wheel(law):
    b = mbdsl.Builder("Wheel")
    ground, body = b.Ground("ground"), b.Body("wheel", m=1.0, I=1.0)
    b.Revolute("pin", ground, body.c)
    b.Torque("motor", ground, body.c, tau=law)
    b.initial(body.w, 1.0)
    return b.scene()


def test_not_a_number_ends_a_controlled_run_with_its_results():
    with pytest.raises(IntegrationError, match="not finite") as caught:
        mbdsl.simulate(wheel("1e-9 N.m*sqrt(0.5 - time/1 s)"), method="radau5", tol=1e-6, stop=1.0, interval=0.1)
    r = caught.value.trajectory
    assert r.status == "failed"
    assert r.t[-1] == pytest.approx(0.5, abs=1e-6)  # as close as there are numbers
    assert r["wheel.phi"] == pytest.approx(r.t, abs=1e-9)


def test_a_force_too_large_for_any_step_ends_it():
    """It rises almost instantly, by tanh, which is not a switch: within the shortest possible step, 4e-15 s, it changes
    the speed by a hundred thousand times the tolerance."""
    law = "1e10 N.m*(1 + tanh(1e18*(time/1 s - 0.5)))"
    with pytest.raises(IntegrationError, match="no step is small enough for the tolerance") as caught:
        mbdsl.simulate(wheel(law), method="radau5", tol=1e-10, stop=1.0, interval=0.1)
    r = caught.value.trajectory
    assert r.t[-1] == pytest.approx(0.5, abs=1e-9)
    assert r["wheel.w"] == pytest.approx(np.ones(len(r.t)), abs=1e-12)


# -- a massless coordinate, redundant constraints --------------------------------------------------------------------


def test_a_coordinate_without_mass():
    """A massless link between two springs stands where they balance: x2 = x1 k1/(k1 + k2), slowly dragged along."""
    b = mbdsl.Builder("Massless")
    ground = b.Ground("ground", g=0.0)
    mass, link = b.Body("mass", m=2.0, I=1.0), b.Body("link", m=0.0, I=0.0)
    b.Bushing("near", mass.c, link.c, k=(30.0, 30.0), k_phi=1.0)
    b.Bushing("far", ground, link.c, k=(60.0, 60.0), k_phi=1.0)
    b.initial(mass.x, 0.3)
    b.initial(link.x, 0.1, fixed=False)
    r = mbdsl.simulate(b, method="radau5", tol=1e-8, stop=3.0, interval=0.1)
    w = np.sqrt(20.0 / 2.0)  # springs of 30 and 60 N/m in line
    assert r["mass.x"] == pytest.approx(0.3 * np.cos(w * r.t), abs=1e-7)
    assert r["link.x"] == pytest.approx(0.1 * np.cos(w * r.t), abs=1e-7)


def test_singular_poses_are_passed():
    """Two parallelograms, whose bars are collinear about once a second."""
    found = mbdsl.simulate(MODELS / "four_bar.mbd", method="radau5", tol=1e-8, stop=2.0)
    energy = found["energy.total"]
    assert np.abs(energy - energy[0]).max() < 1e-6 * np.abs(found["energy.kinetic"]).max()
    assert max(np.abs(found[row]).max() for row in found.select(["*.Phi[*]"])) < 1e-8


@pytest.mark.parametrize("scheme", [SCHEME, radau13.SCHEME])
def test_rows_do_not_overlap(scheme):
    names = ("STAGE", "STAGE2", "RESIDUAL", "RESIDUAL2", "CHANGE", "DV", "PAST", "PAST2")
    rows = [getattr(scheme, name) + k for name in names for k in scheme.each]
    rows += [ERROR, ERROR2, METRIC, QB, VB, RATES, RATES + 1]
    assert sorted(rows) == list(range(L.ROWS, L.ROWS + scheme.ROWS))
