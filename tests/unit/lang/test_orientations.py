"""Frames in space by angle and axis, two directions, successive angles and quaternions, against SciPy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.errors import ModelError

TEXT = """spatial model M
  Ground ground;
  Body b(m = 1 kg, I = {{1, 2, 2}} kg.m2{body});
  {more}
  Spherical ball(ground, b.c);
end M;
"""
ROUNDING = 8 * np.finfo(float).eps  #: of products of two or three rotation matrices


def axes(more="", body="", frame="f"):
    """The axes of a frame as columns."""
    found = mbdsl.parse(TEXT.format(more=more, body=body)).frames[frame]
    return np.array(found.axes).reshape(3, 3).T


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("n = {1, 2, -2}, phi = 50 deg", Rotation.from_rotvec(np.deg2rad(50) / 3 * np.array([1, 2, -2]))),
        ("phi = 50 deg", Rotation.from_rotvec([0, 0, np.deg2rad(50)])),
        ("angles = {10, 20, 30} deg", Rotation.from_euler("XYZ", [10, 20, 30], degrees=True)),
        ("angles = {0.1, 2, -3}", Rotation.from_euler("XYZ", [0.1, 2, -3])),
        ("angles = {10, 20, 30} deg, sequence = {3, 1, 3}", Rotation.from_euler("ZXZ", [10, 20, 30], degrees=True)),
        ("angles = {10, 90, 30} deg, sequence = {3, 2, 1}", Rotation.from_euler("ZYX", [10, 90, 30], degrees=True)),
        ("quaternion = {1, 2, -3, 4}", Rotation.from_quat([2, -3, 4, 1])),
        ("quaternion = {0, 0, -2, 0}", Rotation.from_quat([0, 1, 0, 0])),
        ("n_x = {0, 1, 0}, n_y = {-1, 5, 0}", Rotation.from_rotvec([0, 0, np.pi / 2])),
        ("n_x = {0, 0, 2}, n_y = {0, 3, 1}", Rotation.from_rotvec([0, -np.pi / 2, 0])),
        ("r = {1, 2, 3} m", Rotation.identity()),
    ],
)
def test_a_frame_has_the_given_axes_in_each_place_where_it_can_be_declared(given, expected):
    R = expected.as_matrix()
    assert np.abs(axes(f"Frame f(b, {given});") - R).max() < ROUNDING
    assert np.abs(axes(body=f", frames(tip({given}))", frame="b.tip") - R).max() < ROUNDING
    base = Rotation.from_euler("XYZ", [-40, 70, 5], degrees=True).as_matrix()
    turned = axes(f"Frame e(b, angles = {{-40, 70, 5}} deg); Frame f(e, {given});")
    assert np.abs(turned - base @ R).max() < ROUNDING


def test_directions_need_not_be_at_right_angles():
    R = axes("Frame f(b, n_x = {1, 2, 3}, n_y = {-2, 1, 7});")
    assert np.abs(R.T @ R - np.eye(3)).max() < ROUNDING
    assert np.linalg.det(R) == pytest.approx(1.0, abs=ROUNDING)
    assert np.abs(np.cross(R[:, 0], [1, 2, 3])).max() < 4 * ROUNDING
    in_plane = np.array([-2.0, 1.0, 7.0]) @ R
    assert abs(in_plane[2]) < 8 * ROUNDING and in_plane[1] > 0.0


def test_elements_of_arrays_have_their_own_orientations():
    more = "parameter Real a[2] = {10, 80} deg; Frame g[2](b, angles = {{0, 0, a[1]}, {a[2], 0, 0}});"
    scene = mbdsl.parse(TEXT.format(more=more, body=""))
    assert scene.frames["g[1]"].axes[0] == pytest.approx(np.cos(np.deg2rad(10)), abs=ROUNDING)
    assert scene.frames["g[2]"].axes[4] == pytest.approx(np.cos(np.deg2rad(80)), abs=ROUNDING)


@pytest.mark.parametrize(
    ("wrong", "message", "hint"),
    [
        ("n_x = {1, 0, 0}", "`f` has `n_x`, but no `n_y`", "add `n_y = {0, 1, 0}`"),
        ("n = {1, 0, 0}", "`f` has `n`, but no `phi`", "add `phi = 30 deg`"),
        ("sequence = {1, 2, 3}", "`f` has `sequence`, but no `angles`", "add `angles = {0, 0, 30} deg`"),
        ("n_x = {1, 0, 0}, n_y = {-2, 0, 0}", "`n_x` and `n_y` of `f` are parallel", "at right angles to n_x"),
        ("n_x = {0, 0, 0}, n_y = {0, 1, 0}", "`n_x` of `f` is zero, expected a direction", None),
        ("n = {0, 0, 0}, phi = 1", "`n` of `f` is zero, expected the direction of an axis", None),
        ("quaternion = {0, 0, 0, 0}", "`quaternion` of `f` is zero, expected a rotation; for none, write {1", None),
        ("quaternion = {1, 0, 0}", "found an array of 3 values, expected an array of 4 values", None),
        ("quaternion = {1, 0, 0, 0} m", "found a length [m], expected a pure number", None),
        ("phi = 3 deg, angles = {1, 2, 3} deg", "is given twice, by `phi` and by `angles`", "keep one of"),
        ("quaternion = {1, 0, 0, 0}, n_x = {1, 0, 0}", "is given twice, by `n_x` and by `quaternion`", "keep one of"),
        ("angles = {1, 2} deg", "`angles` of `f`: found two angles, expected three", None),
        ("angles = {1, 2, 3} m", "found a length [m], expected an angle or pure number", None),
        ("angles = {1, 2, 3}, sequence = {1, 1, 3}", "`sequence` of `f` is {1, 1, 3}", "Euler's angles"),
        ("angles = {1, 2, 3}, sequence = {1, 2, 4}", "`sequence` of `f` is {1, 2, 4}", "Euler's angles"),
        ("nx = {1, 0, 0}", "a Frame has no `nx`", "did you mean `n_x`"),
    ],
)
def test_incomplete_and_impossible_orientations_are_refused_at_their_place(wrong, message, hint):
    text = TEXT.format(more=f"Frame f(b, {wrong});", body="")
    with pytest.raises(ModelError) as problem:
        mbdsl.parse(text)
    assert message in problem.value.message
    assert problem.value.span.line == 4
    assert hint is None or hint in problem.value.hint
    inner = TEXT.format(more="", body=f", frames(tip({wrong}))")
    with pytest.raises(ModelError) as problem:
        mbdsl.parse(inner)
    assert problem.value.span.line == 3


def test_the_builder_takes_the_same():
    b = mbdsl.SpatialBuilder("M")
    b.Ground("ground")
    tip = {"r": (1, 2, 3), "angles": "{10, 20, 30} deg"}
    b.Body("b", m=1, I=(1, 2, 2), frames={"tip": tip, "side": (0, 1)})
    b.frame("f", "b", n_x=(1, 2, 3), n_y=np.array([0.0, 1.0, 0.0]))
    b.frame("g", "b.tip", quaternion=(1, 2, -3, 4))
    b.Spherical("ball", "ground", "b.c")
    more = "Frame f(b, n_x = {1, 2, 3}, n_y = {0, 1, 0}); Frame g(b.tip, quaternion = {1, 2, -3, 4});"
    text = TEXT.format(more=more, body=", frames(tip(r = {1, 2, 3} m, angles = {10, 20, 30} deg), side = {0, 1} m)")
    assert b.scene() == mbdsl.parse(text)
    b.frame("h", "b", phi=1, quaternion=(1, 0, 0, 0))
    with pytest.raises(ModelError, match="is given twice"):
        b.scene()
