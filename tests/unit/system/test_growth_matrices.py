"""The parts of the growth of errors: matrices at many states, null spaces, exponentials."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm, null_space

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.simulation.error_growth import _halves, _propagated, _split
from mbdsl.system import build
from mbdsl.system.tangents import tangents

MODELS = Path(__file__).parents[3] / "models"


@pytest.mark.parametrize("name", ["pendulum", "slider_crank"])
def test_matrices_at_many_states_are_those_at_each(name):
    scene = mbdsl.load(MODELS / f"{name}.mbd")
    system = build(scene, graph.build(scene))
    rng = np.random.default_rng(3)
    t, (q, v) = np.array([0.0, 0.3, 0.7]), rng.standard_normal((2, 3, system.n))
    lam = rng.standard_normal((3, system.m + system.p))
    requests = [dict(cK=1.0, cP=1.0), dict(cD=2.0, cN=1.0), dict(cM=1.0)]
    for k, found in enumerate(tangents(system, t, q, v, lam, None, requests)):
        for i in range(len(t)):
            assert np.array_equal(found[i], system.tangent(t[i], q[i], v[i], lam[i], **requests[k]))


def test_null_spaces_and_inverses():
    """By QR factors if J has full rank, else by singular values."""
    rng = np.random.default_rng(4)
    J = rng.standard_normal((5, 3, 7))
    for given in (J, np.concatenate([J, J[:, :1]], axis=1)):
        Z, inverse = _split(given)
        for i in range(5):
            other = null_space(given[i])
            # the same projection, and the pseudo-inverse; condition numbers are below 100
            assert np.allclose(Z[i] @ Z[i].T, other @ other.T, atol=1e-12)
            assert np.allclose(inverse[i], np.linalg.pinv(given[i]), atol=1e-12)
    J[2, 2] = J[2, 1]
    assert _split(J) is None  # the rank changes


def test_solutions_over_both_halves_of_unequal_intervals():
    rng, h = np.random.default_rng(5), np.array([0.1, 0.1, 0.4, 0.1, 0.1])
    rate = rng.standard_normal((6, 4, 4))
    rate[:, 2:, :2] *= 1e4  # stiff springs
    first, one, second, two = _halves(rate.copy(), h, 2)
    for k in range(5):
        for E, s, A in ((first[k], one[k], rate[k]), (second[k], two[k], rate[k + 1])):
            exact = expm(A * 0.5 * h[k])
            # squarings magnify rounding by the norm of the matrix, here below 1e3
            assert np.abs(E * np.exp(s) - exact).max() < 1e-10 * np.abs(exact).max()


def test_sums_of_perturbations_with_and_without_scaling():
    rng = np.random.default_rng(6)
    steps, added = rng.standard_normal((30, 2, 2)), np.abs(rng.standard_normal((31, 2, 1)))
    logs = np.zeros(30)
    x, log, done = _propagated(steps, logs, added)
    logs[3], steps[3] = 300.0, steps[3] * np.exp(-300.0)  # the same step, written so that it is scaled
    y, other, reached = _propagated(steps, logs, added)
    assert done == reached == 31 and not log.any() and other.any()
    assert np.allclose(x, y * np.exp(other)[:, None, None], rtol=1e-10)
