"""Coordinates of joints in space at the start, against rotations of SciPy, and along motions, against differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdsl

MODEL = """spatial model Held
  Ground ground(frames(f(r = {{1, 2, 3}} m, angles = {{20, -30, 40}} deg)));
  Body b(m = 1 kg, I = {{1, 2, 2.5}} kg.m2, frames(tip(r = {{1, 0.3, 0}} m, angles = {{10, 20, 30}} deg)));
  {joint}(ground.f, b.tip{more});
initial equation
  {initial}
end Held;
"""
#: the assembly ends below 1e-13 for models of this size
EXACT = 1e-12


def run(joint, more="", stop=1e-3, interval=1e-3, **initial):
    said = " ".join(f"j.{name} = {value!r};" for name, value in initial.items())
    text = MODEL.format(joint=f"{joint} j", more=more, initial=said)
    return mbdsl.simulate(mbdsl.parse(text), stop=stop, interval=interval, step=1e-3, general=True)


def relative(t, k=0):
    """The attitude of frame_b relative to frame_a."""
    a, b = (Rotation.from_quat([t[f"{f}.p{i}"][k] for i in (1, 2, 3, 0)]) for f in ("ground.f", "b.tip"))
    return a.inv() * b


def about(n, angle):
    return Rotation.from_rotvec(angle * np.array(n) / np.linalg.norm(n))


@pytest.mark.parametrize(("n_a", "n_b"), [((1, 0, 0), (0, 1, 0)), ((0, 3, 0), (-1, 0, 2))])
def test_angles_of_a_universal_joint_with_turns(n_a, n_b):
    more = f", n_a = {{{n_a[0]}, {n_a[1]}, {n_a[2]}}}, n_b = {{{n_b[0]}, {n_b[1]}, {n_b[2]}}}"
    t = run("Universal", more, phi_a=7.0, phi_b=-11.0, w_a=0.5, w_b=-2.0)
    assert (relative(t).inv() * about(n_a, 7) * about(n_b, -11)).magnitude() < EXACT
    for name, value in {"phi_a": 7.0, "phi_b": -11.0, "w_a": 0.5, "w_b": -2.0}.items():
        assert t[f"j.{name}"][0] == pytest.approx(value, abs=EXACT)


def test_cardan_angles_of_a_ball_joint():
    t = run("Spherical", phi_x=2.9, phi_y=-0.9, phi_z=1.7, w_x=1.0, w_y=2.0, w_z=3.0)
    assert relative(t).as_euler("XYZ") == pytest.approx([2.9, -0.9, 1.7], abs=EXACT)
    assert [t[f"j.w_{i}"][0] for i in "xyz"] == pytest.approx([1, 2, 3], abs=10 * EXACT)


@pytest.mark.parametrize("n", [(0, 0, 1), (1, 0, 0)])
def test_bends_of_a_homokinetic_joint(n):
    t = run("ConstantVelocity", f", n = {{{n[0]}, {n[1]}, {n[2]}}}", phi_x=0.35, phi_y=-0.9, w_x=1.0, w_y=2.0)
    bend = relative(t).as_rotvec()
    assert abs(bend @ n) < EXACT  # no rotation about the shaft
    assert np.cos(np.linalg.norm(bend)) == pytest.approx(np.cos(0.35) * np.cos(0.9), abs=EXACT)
    found = [t[f"j.{x}"][0] for x in ("phi_x", "phi_y", "w_x", "w_y")]
    assert found == pytest.approx([0.35, -0.9, 1, 2], abs=10 * EXACT)


@pytest.mark.parametrize(
    ("joint", "initial"),
    [
        ("Revolute", {"phi": 9.0, "w": -1.0}),
        ("Prismatic", {"s": -2.0, "v": 0.5}),
        ("Cylindrical", {"s": 2.0, "phi": -9.0, "v": 0.5, "w": 3.0}),
        ("Planar", {"s_x": 2.0, "s_y": -3.0, "phi": 9.0, "w": 3.0}),
        ("PointOnLine", {"s": 5.0, "v": 1.0}),
        ("PointOnPlane", {"s_x": 5.0, "s_y": 1.0}),
    ],
)
def test_other_joints_start_at_their_coordinates(joint, initial):
    t = run(joint, **initial)
    assert t.moved == ()
    for name, value in initial.items():
        assert t[f"j.{name}"][0] == pytest.approx(value, abs=EXACT)


MOTIONS = {
    "Universal": ("phi_a", "phi_b", {"w_a": 9.0, "w_b": 1.0}),
    "Spherical": ("phi_x", "phi_y", "phi_z", {"w_x": 1.0, "w_y": 2.0}),
    "ConstantVelocity": ("phi_x", "phi_y", {"w_x": 1.0, "w_y": 2.0}),
}


@pytest.mark.parametrize("joint", MOTIONS)
def test_rates_are_the_derivatives_of_the_angles(joint):
    *names, initial = MOTIONS[joint]
    t = run(joint, stop=1.0, interval=1e-3, **initial)
    for name in names:
        angle, rate = t[f"j.{name}"], t[f"j.{name.replace('phi', 'w')}"]
        # Simpson's rule: its error is below h^4/180 times the fourth derivative of the rate, here below 1e4
        change = (rate[:-2:2] + 4 * rate[1:-1:2] + rate[2::2]) / 3e3
        drift = 1e-6 * np.abs(rate).max()  # a step of 1 ms has an error of second order in the velocities
        assert np.abs(angle[2::2] - angle[:-2:2] - change).max() < drift
    if joint == "Universal":
        assert abs(t["j.phi_a"][-1]) > 2 * np.pi  # it counts turns


def test_frames_with_the_axes_of_a_joint_are_not_signals():
    """In laws `J.frame_a` is the frame that the joint is attached to, and not one with the joint's axes."""
    text = """spatial model M
      Ground ground;
      Rod bar(m = 1 kg, length = 1 m);
      Revolute J(ground, bar.a, n = {0, 1, 0});
      Real s = J.frame_b.wy_local;
    end M;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-2, stop=0.1)
    assert not [name for name in t.signals if name.startswith("J.frame")]
    assert "bar.a.wy_local" in t
    np.testing.assert_array_equal(t["s"], t["bar.a.wy_local"])
