"""Saddle-point systems, against closed forms and the equations themselves."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from mbdsl.numerics.saddle_point import Saddle, least_squares, null_space, refined


def as_matrix(A, sparse):
    return csr_array(np.array(A)) if sparse else np.array(A)


@pytest.mark.parametrize("sparse", [False, True])
def test_two_masses_and_a_rod(sparse):
    """Masses 1 and 3 on a line, tied together: a = (f1 + f2) / 4, mu from either body's equation."""
    A, J = as_matrix([[1.0, 0.0], [0.0, 3.0]], sparse), as_matrix([[1.0, -1.0]], sparse)
    x, mu = Saddle(A, J.T, J, np.ones(2)).solve(np.array([6.0, 2.0]))
    np.testing.assert_allclose(x, [2.0, 2.0], rtol=1e-13)
    np.testing.assert_allclose(mu, [4.0], rtol=1e-13)


@pytest.mark.parametrize("sparse", [False, True])
def test_dependent_rows(sparse):
    """The same constraint twice: the motion is determined, and the multipliers add up to that of one constraint."""
    A, J = as_matrix(np.diag([1.0, 3.0]), sparse), as_matrix([[1.0, -1.0], [2.0, -2.0]], sparse)
    x, mu = Saddle(A, J.T, J, np.ones(2)).solve(np.array([6.0, 2.0]))
    np.testing.assert_allclose(x, [2.0, 2.0], rtol=1e-10)
    np.testing.assert_allclose(mu[0] + 2.0 * mu[1], 4.0, rtol=1e-10)


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_units_of_length_do_not_matter(sparse, unit):
    rng = np.random.default_rng(3)
    n, m = 7, 3
    J, f, g = rng.normal(size=(m, n)), rng.normal(size=n), rng.normal(size=m)
    A = rng.normal(size=(n, n))
    A = A @ A.T
    d = np.where(np.arange(n) % 3 < 2, unit, 1.0)  # positions in another unit, angles not
    K = np.block([[A, J.T], [J, np.zeros((m, m))]])
    expected = np.linalg.solve(K, np.concatenate([f, g]))
    saddle = Saddle(
        as_matrix(A / d[:, None] / d, sparse), as_matrix((J / d).T, sparse), as_matrix(J / d, sparse), 1 / d
    )
    x, mu = saddle.solve(f / d, g)
    np.testing.assert_allclose(x / d, expected[:n], rtol=1e-9)
    np.testing.assert_allclose(mu, expected[n:], rtol=1e-9)


def test_singular_systems_have_no_solution():
    A = csr_array((2, 2))
    x, _ = Saddle(A, csr_array((2, 0)), csr_array((0, 2)), np.ones(2)).solve(np.ones(2))
    assert np.isnan(x).all()
    assert np.isnan(refined(A, 2, np.ones(2))).all()


def test_null_space():
    Z = null_space(np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]]))  # rank 1
    assert Z.shape == (3, 2)
    np.testing.assert_allclose(Z.T @ Z, np.eye(2), atol=1e-14)
    np.testing.assert_allclose(Z[0] + Z[1], 0.0, atol=1e-14)
    assert null_space(np.zeros((0, 2))).shape == (2, 2)


def test_least_squares_is_the_shortest_and_refuses_values_that_are_not_finite():
    np.testing.assert_allclose(least_squares(np.array([[1.0, 1.0]]), np.array([2.0])), [1.0, 1.0])
    with pytest.raises(np.linalg.LinAlgError):
        least_squares(np.array([[np.inf]]), np.array([1.0]))
