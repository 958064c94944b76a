"""The reductions that backends integrate, for models in space: quaternions, and derivatives against differences."""

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csc_array

from mbdsl.initial.consistent import initial_state
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism import graph
from mbdsl.numerics import rotation_arrays
from mbdsl.system import build
from mbdsl.system.accelerations import accelerations
from mbdsl.system.index1 import Index1
from mbdsl.system.quaternions import Quaternions
from mbdsl.system.stabilised_index2 import StabilisedIndex2

SPACE = Path(__file__).parents[3] / "models" / "space"
MODELS = ("heavy_top", "bricard", "rolling_coin", "haug_four_link", "flyball_governor")
T = 0.0123


def at(name):
    """The System of a model, its consistent state, and a state beside it."""
    mechanism = graph.build(as_scene(SPACE / f"{name}.mbd"))
    system = build(mechanism.scene, mechanism)
    system.kernels(2)
    state = initial_state(system, system.graph, 0.0)
    d = 1e-3 * np.random.default_rng(3).normal(size=(2, system.n)) / system.tables.scale
    return system, state, system.moved(state.q, d[0]), state.v + d[1]


def test_quaternions():
    """A position and two rotations: rates and small rotations against differences, with errors of 1e-12."""
    x = Quaternions(7, np.array([1, 4]))
    rng = np.random.default_rng(0)
    q, v, h = rng.normal(size=7), rng.normal(size=7), 1e-6
    start = x.join(q)
    np.testing.assert_allclose(x.split(start), q, atol=1e-15)
    np.testing.assert_allclose((x.moved(start, h * v) - x.moved(start, -h * v)) / (2 * h), x.rates(start, v), atol=1e-9)
    longer = start.copy()
    longer[x.places] *= 1.7
    np.testing.assert_allclose(x.split(longer), q, atol=1e-15)
    np.testing.assert_allclose(x.rates(longer, v), x.rates(start, v), atol=1e-15)
    turn, p = np.zeros((2, 3, 4)), longer[x.places]
    rates, change = np.zeros((2, 4, 4)), rng.normal(size=7)
    for k in range(4):
        ahead, behind = longer.copy(), longer.copy()
        ahead[x.places[:, k]] += h
        behind[x.places[:, k]] -= h
        moved = rotation_arrays.turned(-x.split(behind)[[[1, 2, 3], [4, 5, 6]]], x.split(ahead)[[[1, 2, 3], [4, 5, 6]]])
        turn[:, :, k] = moved / (2 * h)
        rates[:, :, k] = (x.rates(ahead, change) - x.rates(behind, change))[x.places] / (2 * h)
    np.testing.assert_allclose(x.lowering(longer), turn, atol=1e-9)
    np.testing.assert_allclose(x.turning(longer, change), rates, atol=1e-9)
    spins = v[[[1, 2, 3], [4, 5, 6]]]
    np.testing.assert_allclose(
        (x.lifting(longer) @ spins[:, :, None])[:, :, 0], x.rates(start, v)[x.places], atol=1e-15
    )
    assert np.linalg.norm(p, axis=1) == pytest.approx(1.7)


@pytest.mark.parametrize("name", MODELS)
def test_index_1(name):
    system, state, q, v = at(name)
    f = Index1(system, state.redundant)
    found = f.project(T, f.join(q, v))
    q, v = f.split(found)
    speed = max(1.0, np.abs(v * system.tables.scale).max())
    assert np.abs(system.Phi(T, q)).max() < 1e-13 * system.tables.size
    rates = np.concatenate([system.evaluate(T, q, v)[2], system.Gam(T, q, v)])
    assert np.abs(rates).max() < 1e-12 * speed * max(1.0, system.tables.size)
    a, lam = accelerations(system, T, q, v, state.redundant)
    np.testing.assert_allclose(f(T, found)[-system.n :], a, rtol=1e-9, atol=1e-10 * np.abs(a).max())
    np.testing.assert_allclose(f.motion(T, q, v)[1], lam, rtol=1e-8, atol=1e-9 * np.abs(lam).max())
    # the other sign of a quaternion is the same attitude, and stays
    other = found.copy()
    other[f.coordinates.places] *= -1.0
    np.testing.assert_allclose(f.project(T, other), other, atol=1e-12 * np.abs(other).max())


@pytest.mark.parametrize("name", MODELS)
def test_jacobian_of_index_2(name):
    """dF/dy + cj dF/dy' against central differences, at a state where no multiplier vanishes."""
    system, state, _, _ = at(name)
    cj, F = 7.0, StabilisedIndex2(system, state.redundant)
    y = F.join(state.q, state.v, state.lam)
    rate = F.rates(y, state.a)
    load = max(1.0, np.abs(state.lam).max())
    # balanced to rounding of the forces, at the start
    assert np.abs(F(0.0, y, rate)).max() < 1e-9 * max(load, np.abs(system.Q(0.0, state.q, state.v)).max())
    length = 1.0 / system.tables.scale
    each = np.concatenate([F.coordinates.each(length, 1.0), length])
    unit = np.concatenate([each, np.full(len(F.algebraic), load)])
    rng = np.random.default_rng(0)
    y, rate = y + 1e-1 * unit * rng.normal(size=F.size), rate + unit * rng.normal(size=F.size)
    J = csc_array((F.jacobian(T, y, rate, cj), *F.pattern), shape=(F.size, F.size)).toarray()
    differences = np.zeros_like(J)
    for k in range(F.size):
        d = np.zeros(F.size)
        d[k] = 1e-6 * unit[k]
        differences[:, k] = (F(T, y + d, rate + cj * d) - F(T, y - d, rate - cj * d)) / (2e-6 * unit[k])
    # rounding of the differences, 1e-16/1e-6 of terms up to 1e4 times as large as their changes
    wrong = np.abs(J - differences) * unit > 3e-6 * np.abs(J * unit).max(axis=1)[:, None]
    assert not wrong.any(), list(zip(*np.nonzero(wrong), strict=True))
