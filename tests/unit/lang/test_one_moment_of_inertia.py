"""Planar values in models in space: one moment of inertia, alone and in arrays, and angles of frames."""

import math

import pytest

import mbdsl

MATRIX = ((2, 0, 0), (0, 3, 0), (0, 0, 4))


def bodies(declaration):
    scene = mbdsl.parse(f"spatial model M Ground ground; {declaration}; end M;")
    return [c.values["I"] for c in scene.bodies()], [w.message for w in scene.warnings]


@pytest.mark.parametrize(
    ("declaration", "found"),
    [
        ("Body b(m = 1 kg, I = 2 kg.m2)", [(2, 2, 2)]),
        ("Body b[2](each m = 1 kg, each I = 2 kg.m2)", [(2, 2, 2)] * 2),
        ("Body b[2](each m = 1 kg, I = {2, 3} kg.m2)", [(2, 2, 2), (3, 3, 3)]),
        ("Body b[2](each m = 1 kg, I = {2, 3, 4} kg.m2)", [(2, 3, 4)] * 2),
        ("Body b[3](each m = 1 kg, each I = {2, 3, 4} kg.m2)", [(2, 3, 4)] * 3),
        (
            "Body b[2](each m = 1 kg, each I = {{2, 0, 0}, {0, 3, 0}, {0, 0, 4}})",
            [((2, 0, 0), (0, 3, 0), (0, 0, 4))] * 2,
        ),
    ],
)
def test_moments_of_inertia(declaration, found):
    """As in the plane, the values of an array without `each` are one by one."""
    values, warnings = bodies(declaration)
    assert values == found and not warnings


def test_three_values_of_three_bodies():
    """They could be those of each body: a warning says how that is written."""
    values, (warning,) = bodies("Body b[3](each m = 1 kg, I = {2, 3, 4} kg.m2)")
    assert values == [(2, 2, 2), (3, 3, 3), (4, 4, 4)]
    assert "each component of the array takes one value" in warning


def test_negative_moment():
    with pytest.raises(mbdsl.ModelError, match="must be at least 0"):
        bodies("Body b(m = 1 kg, I = -2 kg.m2)")


def test_angles_of_frames():
    """A number adopts the unit of the other coordinates; what is an angle turns the frame about z."""
    text = "spatial model M Ground ground(frames(p = {1, 2, 0.5}, q = {1, 2, atan2(1, 1)})); end M;"
    frames = mbdsl.parse(text).frames
    assert frames["ground.p"].pose[:6] == (1, 2, 0.5, 1, 0, 0)
    c = math.sqrt(0.5)
    assert frames["ground.q"].pose[:6] == pytest.approx((1, 2, 0, c, c, 0))
