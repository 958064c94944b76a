"""Colours and markers: one style for each name, distinguishable, with contrast."""

from itertools import combinations

import pytest

from mbdsl.integrators import available
from mbdsl.plotting.series_styles import DARK_PAPER, LIGHT_PAPER, MARKS, METHODS, NEUTRAL, OTHERS, looks


def luminance(colour):
    """Relative luminance, WCAG 2.1."""
    parts = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    parts = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def contrast(a, b):
    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


VARIANTS = tuple(looks([f"{m}, h = 2^-{k} s" for m in METHODS for k in range(5)]).values())


@pytest.mark.parametrize("look", [*METHODS.values(), *OTHERS, NEUTRAL, *VARIANTS])
def test_contrast_against_the_paper(look):
    assert contrast(look.light, LIGHT_PAPER) >= 3.0  # WCAG 2.1, 1.4.11: graphical objects
    assert contrast(look.dark, DARK_PAPER) >= 3.0
    assert look.mark in MARKS


def test_every_method_has_a_mark_of_its_own():
    """Neither colour-blindness nor a print in grey makes two of them look alike."""
    for (a, one), (b, other) in combinations(METHODS.items(), 2):
        assert (one.mark, one.filled, bool(one.dash)) != (other.mark, other.filled, bool(other.dash)), (a, b)


def test_a_method_looks_the_same_whoever_is_beside_it():
    alone = looks(["hht-si2"])["hht-si2"]
    assert looks(["q", "newmark", "hht-si2", "zeta"])["hht-si2"] == alone
    found = looks(available())
    assert len(set(found.values())) == len(found)


def test_what_begins_with_a_method_keeps_its_mark_and_differs():
    found = looks(["nstiff-si2", "nstiff-si2, tol", "nstiff, tol", "nstiffer", "Exudyn 1.9"])
    assert found["nstiff-si2, tol"].mark == found["nstiff-si2"].mark
    assert found["nstiff-si2, tol"] != found["nstiff-si2"]
    assert found["nstiff, tol"].mark == METHODS["nstiff"].mark
    assert found["nstiffer"] == OTHERS[0]
    assert found["Exudyn 1.9"].mark == METHODS["exudyn"].mark


def test_others_in_order_none_twice():
    names = [f"signal {k}" for k in range(40)]
    assert len(set(looks(names).values())) == 40
    assert looks(names) == looks(names)
