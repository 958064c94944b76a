"""Colours and markers: one style for each name, distinguishable, with contrast."""

from itertools import combinations

import pytest

from mbdsl.integrators import available
from mbdsl.plotting.figure_layout import looks_of
from mbdsl.plotting.figures import Bar, Bars, Figure, Series
from mbdsl.plotting.series_styles import (
    DARK_PAPER,
    DASHED,
    LIGHT_PAPER,
    MARKS,
    METHODS,
    NEUTRAL,
    OTHERS,
    looks,
    method_look,
)


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
    found = looks(["nstiff-si2, tol", "nstiff-si2", "nstiff, tol", "nstiffer", "Exudyn 1.9"])
    assert found["nstiff-si2, tol"].mark == found["nstiff-si2"].mark
    assert found["nstiff-si2, tol"] != found["nstiff-si2"]
    assert found["nstiff, tol"].mark == METHODS["nstiff"].mark
    assert found["nstiffer"] == OTHERS[0]
    assert found["Exudyn 1.9"].mark == METHODS["exudyn"].mark


def figure(*names):
    return Figure("k", "t", "x", "y", [Series(name, [1.0], [1.0]) for name in names])


def test_a_method_looks_the_same_in_all_figures_of_all_pages():
    """Whatever else is shown there, in which order, and whether it is named with its step."""
    one = looks_of([figure("radau5", "hht-si2", "radau5 --tol"), figure("hht-si2, 10 ms", "newmark")])
    other = looks_of([figure("newmark", "radau5 --tol, 1e-6"), Bars("k", "t", "x", [Bar("hht-si2", 1.0, "1")])])
    assert one["hht-si2"] == one["hht-si2, 10 ms"] == other["hht-si2"] == METHODS["hht-si2"]
    assert one["radau5 --tol"] == other["radau5 --tol, 1e-6"] and one["newmark"] == other["newmark"]


def test_kinds_of_steps_are_told_apart_alike_for_all_methods():
    for name, method in available().items():
        both = len(method.steps) == 2
        kinds = {"fixed": name, "controlled": f"{name} --tol" if both else name}
        found = {kind: looks([series, "other"])[series] for kind, series in kinds.items() if kind in method.steps}
        assert len({(look.light, look.mark) for look in found.values()}) == 1
        for kind, look in found.items():
            assert (look.filled, look.dash) == ((True, ()) if kind == "fixed" else (False, DASHED))


def test_a_new_method_has_a_look_of_its_own_name():
    """It does not change when other methods come or go."""
    one = method_look("my-method")
    assert method_look("my-method") == one and one.mark in MARKS and one.filled
    assert not method_look("my-method", only_controlled=True).filled
    known = {"my-method": one, "another": method_look("another")}
    assert looks(["x", "my-method", "another --tol"], known)["my-method"] == one
    assert looks(["my-method, 2 ms"], known)["my-method, 2 ms"] == one


def test_series_of_one_method_in_one_figure_differ():
    found = looks([f"hht-si2 --alpha {a}" for a in (-0.1, -0.2, -0.3)] + ["hht-si2"])
    assert found["hht-si2"] == METHODS["hht-si2"] and len(set(found.values())) == 4


def test_others_in_order_none_twice():
    names = [f"signal {k}" for k in range(40)]
    assert len(set(looks(names).values())) == 40
    assert looks(names) == looks(names)
