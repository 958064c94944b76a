"""Slopes of errors with known parts: a power, terms of higher order, rounding, and noise."""

import numpy as np
import pytest

from mbdsl.studies.reference_solution import POWERS, extrapolation
from mbdsl.studies.slopes import fit, verdict

H = 2.0 ** -np.arange(10.0)


def test_a_power_is_found():
    found = fit(H, 3.0 * H**2)
    assert (found.slope, found.uncertainty) == (pytest.approx(2.0, abs=1e-12), pytest.approx(0.0, abs=1e-12))
    assert (found.low, found.high, found.count, found.below) == (H[-1], 1.0, 10, "")


def test_order_of_the_points_does_not_matter():
    shuffled = np.random.default_rng(1).permutation(10)
    assert fit(H[shuffled], H[shuffled] ** 2) == fit(H, H**2)


def test_rounding_is_not_fitted():
    """Rounding grows with 1/h^2, as in the reactions of index-3 methods."""
    found = fit(H, H**2 + 1e-9 / H**2)
    assert found.slope == pytest.approx(2.0, abs=found.uncertainty) and found.uncertainty < 0.01
    assert found.below == "levels off"
    # neighbours of a slope that is off by 0.25: rounding is a sixth of the error or less
    assert (1e-9 / found.low**4) < 0.2


def test_what_is_not_yet_a_power_is_not_fitted():
    found = fit(H, H**2 / (H**2 + 0.02))  # it levels off at long steps
    assert found.slope == pytest.approx(2.0, abs=found.uncertainty) and found.uncertainty < 0.1
    assert found.high < 0.1


def test_what_the_reference_does_not_tell_is_not_fitted():
    found = fit(H, H**2, floor=1e-4)
    assert found.below == "reference"
    assert found.low**2 > 5e-4 > (found.low / 2) ** 2


def test_the_interval_is_that_of_student():
    """Of 400 lines with noise, about 95 % have the true slope in their interval."""
    random = np.random.default_rng(2)
    x = H[:6]
    hits = 0
    for _ in range(400):
        found = fit(x, x**2 * np.exp(0.02 * random.standard_normal(6)))
        hits += found.count == 6 and abs(found.slope - 2.0) <= found.uncertainty
    assert 0.90 < hits / 400 < 0.99  # 95 % +- 4.6 standard deviations of a count in 400


@pytest.mark.parametrize("errors", [[1e-3] * 10, H**-1, H[:2].tolist() + [np.nan] * 8, np.zeros(10)])
def test_no_line(errors):
    assert fit(H, errors) is None


@pytest.mark.parametrize(
    ("errors", "order", "floor", "said"),
    [
        (H**2, 2, 0.0, ""),
        (H**1, 2, 0.0, "below its order 2"),
        (H**2, 1, 0.0, "above its order 1"),
        (np.full(10, 1e-3), 2, 1e-9, "does not converge at these sizes"),
        (np.array([1.6e-2, 5.1e-3, 9.3e-4, 2.6e-4]), 2, 1e-9, "no line at these sizes"),
        (np.full(10, 1e-3), 2, 1e-3, "below the reference's resolution"),
        (H[:2] ** 2, 2, 0.0, "too few points"),
    ],
)
def test_verdicts(errors, order, floor, said):
    sizes = H[: len(errors)]
    assert verdict(fit(sizes, errors, floor), order, errors, floor) == said


def test_extrapolation_removes_what_it_should():
    steps = [0.1, 0.05, 0.025, 0.0125]
    w = extrapolation(steps)
    assert sum(w) == pytest.approx(1.0, abs=1e-14)
    for p in POWERS:
        assert w @ np.array(steps) ** p == pytest.approx(0.0, abs=1e-15)
    assert abs(w @ np.array(steps) ** 5) > 1e-12  # and no more
