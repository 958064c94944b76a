"""radau9 and radau13: coefficients for any number of stages.

Orders and tolerances: tests/verification/test_double_pendulum.py. Three stages: test_radau5.py.
"""

import numpy as np
import pytest

from mbdsl.integrators.methods import radau5_coefficients, radau_coefficients
from mbdsl.integrators.methods.radau_coefficients import (
    BACK,
    E1,
    E2,
    EIGENVALUES,
    INTEGRALS,
    INVERSE,
    NODES,
    SQUARE,
    THERE,
    A,
    tables,
)

STAGES = [3, 5, 7]
#: rounding of sums with weights of up to 100
NEAR = 1e-13


@pytest.mark.parametrize("s", STAGES)
def test_order_conditions(s):
    """B(2s - 1), C(s) and D(s - 1) of Butcher, of which the order 2s - 1 follows; and not B(2s)."""
    a, c = tables(s)[A], tables(s)[NODES]
    b = a[-1]
    for k in range(1, 2 * s):
        assert b @ c ** (k - 1) == pytest.approx(1 / k, abs=NEAR)
    assert abs(b @ c ** (2 * s - 1) - 1 / (2 * s)) > 1e-9
    for k in range(1, s + 1):
        assert a @ c ** (k - 1) == pytest.approx(c**k / k, abs=NEAR)
    for k in range(1, s):
        assert (b * c ** (k - 1)) @ a == pytest.approx(b * (1 - c**k) / k, abs=NEAR)


@pytest.mark.parametrize("s", STAGES)
def test_eigenvectors(s):
    found = tables(s)
    values, blocks = found[EIGENVALUES], np.zeros((s, s))
    blocks[0, 0] = values[0]
    for j in range(1, s, 2):
        re, im = values[j : j + 2]
        blocks[j : j + 2, j : j + 2] = [[re, -im], [im, re]]
    assert found[BACK] @ blocks @ found[THERE] == pytest.approx(found[A], abs=NEAR)
    assert found[BACK] @ found[THERE] == pytest.approx(np.eye(s), abs=NEAR)
    assert found[INVERSE] @ found[A] == pytest.approx(np.eye(s), abs=NEAR)
    assert found[SQUARE] == pytest.approx(found[A] @ found[A], abs=NEAR)


@pytest.mark.parametrize("s", STAGES)
def test_embedded_formula_and_output(s):
    found = tables(s)
    c, real = found[NODES], found[EIGENVALUES][0]
    errors = [real * (k == 0) + found[E1] @ c**k for k in range(s + 1)]
    assert errors[:s] == pytest.approx(np.zeros(s), abs=NEAR) and abs(errors[s]) > 1e-6
    assert found[E2] == pytest.approx(found[E1] @ found[A], abs=NEAR)
    powers = c[:, None] ** np.arange(1, s + 1)
    assert powers @ found[INTEGRALS].T == pytest.approx(found[A], abs=NEAR)


def test_three_stages_are_those_of_the_closed_form():
    found, closed = tables(3), radau5_coefficients
    for place, known in ((A, closed.A), (NODES, closed.NODES), (INVERSE, closed.INVERSE), (E1, closed.E1)):
        assert found[place] == pytest.approx(np.array(known), abs=1e-13)
    assert found[EIGENVALUES] == pytest.approx([closed.REAL, closed.RE, closed.IM], abs=1e-14)


def test_vector_of_the_kernels():
    """The tables do not overlap."""
    vector, found = np.array(radau_coefficients.coefficients(7)), tables(7)
    assert len(vector) == radau_coefficients.SIZE
    for place, table in found.items():
        assert np.array_equal(vector[place : place + table.size].reshape(table.shape), table)
