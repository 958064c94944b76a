"""Linkages against closed forms and against constructions with compass and ruler, 1,000 revolutions long."""

import numpy as np

#: lengths of the models are up to 1 m; rounding of the angle of the 1,000th revolution is 5e-13 rad
EXACT = 2e-12


def circles(a, ra, b, rb, side):
    """The intersection of circles about a and b, left (1) or right (-1) of the line from a to b."""
    d = b - a
    apart = np.hypot(d.real, d.imag)
    along = (apart**2 + ra**2 - rb**2) / (2 * apart)
    return a + d / apart * (along + 1j * side * np.sqrt(ra**2 - along**2))


def point(run, name):
    return run[f"{name}.x"] + 1j * run[f"{name}.y"]


def assert_same(found, expected):
    assert np.abs(found - expected).max() < EXACT


def test_four_bar_curves(turned):
    run = turned("four_bar_curves")
    A = 0.04 * np.exp(1j * 2 * np.pi / 3 * run.t)
    B = circles(A, 0.1, 0.11 + 0j, 0.09, 1)
    axis = (B - A) / 0.1
    for name, x, y in (("P", -0.02, 0.06), ("Q", 0.04, 0.07), ("R", 0.08, 0.025)):
        assert_same(point(run, f"coupler.{name}"), (A + B) / 2 + axis * (x + 1j * y))
