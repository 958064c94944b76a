"""The reductions that backends integrate: against the System's own quantities, and against differences."""

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csc_array

from mbdsl.initial.consistent import initial_state
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import reduce
from mbdsl.system import build
from mbdsl.system import system as system_module
from mbdsl.system.accelerations import accelerations
from mbdsl.system.index1 import Index1
from mbdsl.system.stabilised_index2 import StabilisedIndex2

MODELS = sorted((Path(__file__).parents[3] / "models").glob("*.mbd"))
T = 0.0123


def parts(path):
    """System and consistent state of the parts of a model that are not kinematic, and of the model as it is."""
    mechanism = graph.build(as_scene(path))
    for part in [*reduce(mechanism).parts, None]:
        if part is None or not part.kinematic:
            system = build(mechanism.scene if part is None else part.scene, mechanism if part is None else part.graph)
            system.kernels(2)
            yield system, initial_state(system, system.graph, 0.0)


def beside(system, state, size):
    """A state off the constraints by ``size``, of the mechanism and of its angles."""
    rng = np.random.default_rng(3)
    d = size * rng.normal(size=(2, system.n)) / system.tables.scale
    return state.q + d[0], state.v + d[1]


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_index_1(path):
    for system, state in parts(path):
        f = Index1(system, state.redundant)
        y = f.join(*beside(system, state, 1e-4))
        found = f.project(T, y)
        q, v = f.split(found)
        # to rounding of positions of the mechanism's size, and of its velocities
        speed = max(1.0, np.abs(v * system.tables.scale).max())
        assert np.abs(system.Phi(T, q)).max(initial=0.0) < 1e-13 * system.tables.size
        rates = np.concatenate([system.evaluate(T, q, v)[2], system.Gam(T, q, v)])
        assert np.abs(rates).max(initial=0.0) < 1e-12 * speed * max(1.0, system.tables.size)
        assert np.abs(f.project(T, found) - found).max() <= 1e-12 * np.abs(found).max()
        a, lam = accelerations(system, T, q, v, state.redundant)
        np.testing.assert_allclose(f(T, found), np.concatenate([v, a]), rtol=1e-9, atol=1e-10 * np.abs(a).max())
        np.testing.assert_allclose(f.motion(T, q, v)[1], lam, rtol=1e-8, atol=1e-9 * np.abs(lam).max(initial=0.0))


def test_projection_is_the_nearest_in_the_norm_of_the_masses():
    """M dq is a combination of the constraints' gradients, up to their change over dq."""
    system, state = next(parts(MODELS[[p.stem for p in MODELS].index("slider_crank")]))
    f = Index1(system)
    q, v = beside(system, state, 1e-6)
    d = f.project(T, f.join(q, v))[: system.n] - q
    force, J = system.M(T, q) @ d, system.Phi_q(T, q)
    mu = np.linalg.lstsq(J.T, force, rcond=None)[0]
    assert np.abs(force - J.T @ mu).max() < 1e-4 * np.abs(force).max()


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_jacobian_of_index_2(path):
    """dF/dy + cj dF/dy' against central differences, at a state where no multiplier vanishes."""
    cj = 7.0
    for system, state in parts(path):
        F = StabilisedIndex2(system, state.redundant)
        y, rate = F.join(state.q, state.v, state.lam), F.join(state.v, state.a, 0.0 * state.lam)
        load = max(1.0, np.abs(state.lam).max(initial=0.0))
        # balanced to rounding of the forces, at the start
        assert np.abs(F(0.0, y, rate)).max() < 1e-9 * max(load, np.abs(system.Q(0.0, state.q, state.v)).max())
        length = 1.0 / system.tables.scale
        unit = F.join(length, length, np.full(system.m + system.p, load), np.full(system.m, load))
        rng = np.random.default_rng(0)
        y, rate = y + 1e-2 * unit * rng.normal(size=F.size), rate + unit * rng.normal(size=F.size)
        J = csc_array((F.jacobian(T, y, rate, cj), *F.pattern), shape=(F.size, F.size)).toarray()
        differences = np.zeros_like(J)
        for k in range(F.size):
            d = np.zeros(F.size)
            d[k] = 1e-6 * unit[k]
            differences[:, k] = (F(T, y + d, rate + cj * d) - F(T, y - d, rate - cj * d)) / (2e-6 * unit[k])
        # rounding of the differences, 1e-16/1e-6 of terms up to 1e4 times as large as their changes
        wrong = np.abs(J - differences) * unit > 3e-6 * np.abs(J * unit).max(axis=1)[:, None]
        assert not wrong.any(), list(zip(*np.nonzero(wrong), strict=True))


def test_redundant_constraints_have_no_multipliers(tmp_path):
    """A door on two hinges at one place."""
    model = tmp_path / "door.mbd"
    model.write_text(
        "model Door\n  Ground ground;\n  Rod door(m = 2 kg, length = 1 m);\n"
        "  Revolute a(ground, door.a);\n  Revolute b(ground, door.a);\nend Door;\n"
    )
    system, state = list(parts(model))[-1]
    assert len(state.redundant) == 2
    f, F = Index1(system, state.redundant), StabilisedIndex2(system, state.redundant)
    lam = f.motion(0.0, state.q, state.v)[1]
    assert not lam[list(state.redundant)].any() and np.abs(lam).max() > 1.0
    y, rate = F.join(state.q, state.v, lam), F.join(state.v, f.motion(0.0, state.q, state.v)[0], 0.0 * lam)
    assert np.abs(F(0.0, y, rate)).max() < 1e-12
    J = csc_array((F.jacobian(0.0, y, rate, 100.0), *F.pattern), shape=(F.size, F.size)).toarray()
    assert np.linalg.matrix_rank(J) == F.size


def test_large_systems_are_solved_sparse(monkeypatch):
    """The same by sparse matrices as by dense ones, as in large systems."""
    path = MODELS[[p.stem for p in MODELS].index("seven_body")]
    system, state = next(parts(path))
    y = np.concatenate(beside(system, state, 1e-5))
    dense = Index1(system)
    projected, rates = dense.project(T, y), dense(T, y)
    monkeypatch.setattr(system_module, "DENSE_LIMIT", 10)
    sparse = Index1(system)
    np.testing.assert_allclose(sparse.project(T, y), projected, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(sparse(T, y), rates, rtol=1e-8, atol=1e-9 * np.abs(rates).max())


def test_what_has_no_value_is_no_number():
    """Solvers react with a shorter step."""
    system, state = next(parts(MODELS[[p.stem for p in MODELS].index("seven_body")]))
    f = Index1(system)
    y = f.join(state.q, state.v)
    y[2] = np.nan  # an angle
    assert np.isnan(f(T, y)[system.n :]).all()
