"""radau9 and radau13: coefficients for any number of stages.

Orders and tolerances: tests/verification/test_double_pendulum.py. Three stages: test_radau5.py.
"""

import numpy as np
import pytest

from mbdsl.integrators.methods import radau5_coefficients
from mbdsl.integrators.methods.radau_coefficients import scheme, tables

STAGES = [3, 5, 7]
#: rounding of sums with weights of up to 100
NEAR = 1e-13


@pytest.mark.parametrize("s", STAGES)
def test_order_conditions(s):
    """B(2s - 1), C(s) and D(s - 1) of Butcher, of which the order 2s - 1 follows; and not B(2s)."""
    a, c = tables(s)["A"], tables(s)["nodes"]
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
    values, blocks = found["values"], np.zeros((s, s))
    blocks[0, 0] = values[0]
    for j in range(1, s, 2):
        re, im = values[j : j + 2]
        blocks[j : j + 2, j : j + 2] = [[re, -im], [im, re]]
    assert found["back"] @ blocks @ found["there"] == pytest.approx(found["A"], abs=NEAR)
    assert found["back"] @ found["there"] == pytest.approx(np.eye(s), abs=NEAR)
    assert found["inverse"] @ found["A"] == pytest.approx(np.eye(s), abs=NEAR)
    assert found["square"] == pytest.approx(found["A"] @ found["A"], abs=NEAR)


@pytest.mark.parametrize("s", STAGES)
def test_embedded_formula_and_output(s):
    found = tables(s)
    c, real = found["nodes"], found["values"][0]
    errors = [real * (k == 0) + found["e1"] @ c**k for k in range(s + 1)]
    assert errors[:s] == pytest.approx(np.zeros(s), abs=NEAR) and abs(errors[s]) > 1e-6
    assert found["e2"] == pytest.approx(found["e1"] @ found["A"], abs=NEAR)
    powers = c[:, None] ** np.arange(1, s + 1)
    assert powers @ found["integrals"].T == pytest.approx(found["A"], abs=NEAR)


def test_three_stages_are_those_of_the_closed_form():
    """Of eigenvectors, those of the complex pair have another length and phase: their products are compared."""
    found, closed = tables(3), radau5_coefficients.tables()
    for name in ("nodes", "values", "A", "square", "inverse", "e1", "e2"):
        assert found[name] == pytest.approx(np.array(closed[name]), abs=1e-13)
    for pair in ([0], [1, 2]):
        of = np.array(closed["back"])[:, pair] @ np.array(closed["there"])[pair]
        assert found["back"][:, pair] @ found["there"][pair] == pytest.approx(of, abs=1e-13)


def test_stages_are_evaluated_once_and_the_middle_one_last():
    for s in STAGES:
        R = scheme(s)
        assert sorted(R.evaluated) == sorted(R.predicted) == list(R.each) == list(range(s))
        assert R.evaluated[-1] == s // 2
