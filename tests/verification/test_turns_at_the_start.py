"""Angles of more than half a turn at the start, in space: what acts on the angle of a joint has the joint's turns."""

import numpy as np
import pytest

import mbdsl

SHAFT = """spatial model Shaft
  parameter Angle start = {start} deg;
  Ground ground(g = 0);
  Body b(m = 1 kg, I = {{0.05, 0.05, 0.05}} kg.m2);
  {joint}
  {force}
initial equation
  {values}
  annotation(experiment(StopTime = 1 s, Interval = 0.1 s));
end Shaft;"""
JOINTS = {
    "Revolute": ("Revolute j(ground, b.c, n = {0.48, -0.6, 0.64});", "j.phi = start;"),
    "Cylindrical": ("Cylindrical j(ground, b.c, n = {0.48, -0.6, 0.64});", "j.phi = start; j.s = 0 m;"),
    "Universal": ("Universal j(ground, b.c, n_a = {0, 0, 1}, n_b = {1, 0, 0});", "j.phi_a = start; j.phi_b = 0 deg;"),
}
FORCES = {
    "k": "RotationalSpringDamper s(j, k = 1 N.m/rad);",
    "law": "RotationalSpringDamper s(j, torque = 1 N.m*s.phi);",
    "twice": "RotationalSpringDamper s(j, k = 0.5 N.m/rad); RotationalSpringDamper s2(j, k = 0.5 N.m/rad);",
}


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("start", [200.0, -250.0, 800.0])
def test_a_wound_up_shaft(joint, force, start):
    """phi = start cos(sqrt(k/I) t): one axis, one stiffness of 1 N.m/rad."""
    declaration, values = JOINTS[joint]
    text = SHAFT.format(start=start, joint=declaration, force=FORCES[force], values=values)
    run = mbdsl.simulate(mbdsl.parse(text), tol=1e-6, method="radau5")
    phi, angle = np.radians(start) * np.cos(np.sqrt(1.0 / 0.05) * run.t), "j.phi_a" if joint == "Universal" else "j.phi"
    assert run[angle] == pytest.approx(phi, abs=1e-4)
    assert run["s.phi"] == pytest.approx(phi, abs=1e-4)
    assert run["s.torque"] == pytest.approx((0.5 if force == "twice" else 1.0) * phi, abs=1e-4)


WALL = """model Wall
  parameter Angle dir = {direction} deg;
  Ground ground;
  {wall}
  {rod}
  Revolute j(wall, rod.{end});
  {force}
initial equation
  rod.phi = {start} deg;
  annotation(experiment(StopTime = 0.3 s, Interval = 50 ms, Tolerance = 1e-6));
end Wall;"""
LAWS = (
    "RotationalSpringDamper s(j, k = 2 N.m/rad, phi0 = 20 deg);",
    "Torque s(j, tau = -2 N.m*sin(j.phi/3));",
    "RotationalStop s(j, phi_max = 40 deg, k = 50 N.m/rad);",
)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("nested", [False, True])
@pytest.mark.parametrize(("direction", "start"), [(270, 300), (-200, -150), (400, 420), (90, 120)])
def test_frames_at_any_angle_mean_the_same_in_the_plane_and_in_space(direction, start, nested, law):
    """`spatial` in front of a planar model is the same mechanism."""
    wall = "Frame wall(ground, phi = dir);"
    if nested:
        wall = "Frame half(ground, phi = dir/2); Frame wall(half, phi = dir/2);"
    given = {"direction": direction, "start": start, "force": law, "wall": wall, "end": "a"}
    plane = mbdsl.simulate(mbdsl.parse(WALL.format(rod="Rod rod(m = 1 kg, length = 0.5 m);", **given)))
    inertia = "Body rod(m = 1 kg, I = {1, 1, 1/48} kg.m2, frames(a = {-0.25, 0, 0} m));"
    space = mbdsl.simulate(mbdsl.parse("spatial " + WALL.format(rod=inertia, **given)))
    assert plane["j.phi"][0] == pytest.approx(np.radians(start - direction), abs=1e-12)
    assert space["j.phi"] == pytest.approx(plane["j.phi"], abs=1e-5)
    assert space["energy.total"] == pytest.approx(plane["energy.total"], abs=1e-4)


def test_a_frame_of_a_body_at_more_than_half_a_turn():
    """The joint's angle is counted from the frame's: 270 deg less than that of the body."""
    text = """spatial model Bodies
      Ground ground(g = 0);
      Body b(m = 1 kg, I = {1, 1, 1} kg.m2, frames(seat(r = {0, 0, 0} m, phi = 270 deg)));
      Revolute j(ground, b.seat);
    initial equation
      b.phi = 30 deg;
      annotation(experiment(StopTime = 10 ms));
    end Bodies;"""
    assert np.degrees(mbdsl.Simulation(mbdsl.parse(text), step=1e-3)["j.phi"]) == pytest.approx(300.0)
    plane = (
        text.replace("spatial ", "")
        .replace("{1, 1, 1}", "1")
        .replace("seat(r = {0, 0, 0} m, phi = 270 deg)", "seat = {0, 0, 270 deg}")
    )
    assert np.degrees(mbdsl.Simulation(mbdsl.parse(plane), step=1e-3)["j.phi"]) == pytest.approx(300.0)


@pytest.mark.parametrize("rate", [20.0, 900.0])
@pytest.mark.parametrize("spring", ["", "RotationalSpringDamper s(hinge, k = 1e-9 N.m/rad);"])
def test_a_linear_model_at_a_time_has_the_turns_of_its_angles(rate, spring):
    """phi = 0.4 rad + w t."""
    text = f"""spatial model Spin
      Ground ground(g = 0);
      Body b(m = 1 kg, I = 0.1 kg.m2);
      Revolute hinge(ground, b.c, n = {{0.6, 0, 0.8}});
      {spring}
    initial equation
      hinge.phi = 0.4 rad; hinge.w = {rate} rad/s;
      annotation(experiment(StopTime = 1 s));
    end Spin;"""
    found = mbdsl.linearise(mbdsl.parse(text), at=0.7, signals=["hinge.phi"])
    assert found.x0[0] == pytest.approx(0.4 + 0.7 * rate, rel=1e-6)
    assert found.y0[0] == pytest.approx(0.4 + 0.7 * rate, rel=1e-6)
