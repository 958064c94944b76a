"""Friction that sticks in space, against closed forms: each kind of joint, and sliding in several directions."""

from math import atan, cos, hypot, pi, radians, sin, tan

import numpy as np
import pytest
from scipy.integrate import quad

import mbdsl

G = 9.81
SLOPE = radians(20)


def run(text: str, stop: float = 2.0, step: float = 0.01, method: str = "hht-si2") -> mbdsl.Trajectory:
    return mbdsl.simulate(mbdsl.parse(text), stop=stop, step=step, method=method, interval=step)


def of_sliding(found: mbdsl.Trajectory, joint: str) -> np.ndarray:
    """The times at which a joint slides."""
    return found.t[found[f"{joint}.sliding"] != 0.0]


def on_slope(joint: str, mu: float) -> str:
    """A block on a plane of 20 deg, x down the slope, with 2 m/s across it."""
    return f"""
spatial model Slope
  Ground ground(n = {{0, 0, -1}});
  Frame slope(ground, angles = {{0, 20, 0}} deg);
  Body block(m = 1 kg, I = {{1e-3, 1e-3, 1e-3}} kg.m2);
  {joint.replace("mu", f"mu = {mu!r}, sticks = true")};
initial equation
  block.x = 0 m; block.y = 0 m; block.vx = 0 m/s; block.vy = 2 m/s;
end Slope;
"""


def slid(mu: float) -> tuple[float, float, float]:
    """Where and when the block stops: with psi from the line of slope, v = v0 tan(psi/2)^k/sin(psi)."""
    k, a = mu / tan(SLOPE), G * sin(SLOPE)

    def square(p: float) -> float:
        return (2.0 * tan(p / 2) ** k / sin(p)) ** 2 / a

    x, _ = quad(lambda p: square(p) / tan(p), 0, pi / 2, epsabs=1e-13)
    y, _ = quad(square, 0, pi / 2, epsabs=1e-13)
    return x, y, k * 2.0 / (a * (k * k - 1))


JOINTS = [
    "Planar slide(slope, block.c, mu)",
    "PointOnPlane slide(slope, block.c, mu)",
    "PointOnSurface slide(slope, block.c, f = slide.z, mu)",
]


@pytest.mark.parametrize("joint", JOINTS)
def test_a_block_slides_across_a_slope_until_it_stops(joint):
    x, y, t = slid(0.5)
    assert t == pytest.approx(0.92302284)
    found = mbdsl.simulate(mbdsl.parse(on_slope(joint, 0.5)), stop=1.2, tol=1e-7, interval=1e-3, method="dop853")
    assert of_sliding(found, "slide")[-1] == pytest.approx(t, abs=1e-3)
    assert found["block.x"][-1] == pytest.approx(x * cos(SLOPE), abs=1e-6)
    assert found["block.y"][-1] == pytest.approx(y, abs=1e-6)
    assert found["slide.friction"][-1] == pytest.approx(G * sin(SLOPE))


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "nstiff-si2"])
def test_no_order_is_lost_where_a_block_stops_that_turns(method):
    scene, _, y = mbdsl.parse(on_slope(JOINTS[0], 0.5)), *slid(0.5)[:2]
    ends = [mbdsl.simulate(scene, stop=1.0, step=h, method=method)["block.y"][-1] for h in (0.01, 0.005, 0.0025)]
    errors = np.abs(np.array(ends) - y)
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(2.0, abs=0.1)


def test_a_block_whose_slope_is_as_steep_as_its_friction_keeps_half_of_its_speed():
    scene = mbdsl.parse(on_slope(JOINTS[0], tan(SLOPE)))
    found = mbdsl.simulate(scene, stop=10.0, tol=1e-8, method="dop853")
    assert hypot(found["block.vx"][-1], found["block.vz"][-1]) == pytest.approx(1.0, abs=1e-6)
    assert found["block.vy"][-1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("joint", JOINTS)
def test_a_block_begins_to_slide_where_pull_and_weight_exceed_friction(joint):
    text = on_slope(joint, 0.4).replace("2 m/s", "0 m/s").replace("sticks", "mu_s = 0.5, sticks")
    found = run(text.replace("initial eq", "  Force pull(block.c, fy = 4 N/s*time);\ninitial eq"), stop=1.0, step=2e-3)
    weight, most = G * sin(SLOPE), 0.5 * G * cos(SLOPE)
    start = (most**2 - weight**2) ** 0.5 / 4.0
    sliding = of_sliding(found, "slide")
    assert start < sliding[0] < start + 0.0021
    before = found.t < start
    assert found["block.y"][before] == pytest.approx(0.0, abs=1e-16)
    assert found["slide.friction"][before] == pytest.approx(np.hypot(weight, 4.0 * found.t[before]))
    # it begins to slide along the pull, with what mu_s exceeds mu by
    after = int(np.flatnonzero(found.t == sliding[0])[0])
    pull = np.array([weight, 4.0 * start]) / most
    assert found["block.ay"][after] / found["block.ax"][after] * cos(SLOPE) == pytest.approx(
        pull[1] / pull[0], rel=0.02
    )


def test_a_hinge_runs_down_and_holds():
    text = """
spatial model Wheel
  Ground ground(n = {0, 0, -1});
  Body wheel(m = 2 kg, I = {0.02, 0.02, 0.04} kg.m2);
  Revolute hinge(ground, wheel.c, radius = 0.05 m, mu = 0.2, mu_s = 0.3, sticks = true);
  Torque motor(hinge, tau = if time < 1 s then 0 N.m else 0.2 N.m/s*(time - 1 s));
initial equation
  hinge.phi = 0 deg; hinge.w = 2 rad/s;
end Wheel;
"""
    found, torque = run(text, stop=3.0), 0.05 * 2 * G
    stopped = 0.04 * 2.0 / (0.2 * torque)
    started = 1.0 + 0.3 * torque / 0.2
    still = (found.t > stopped) & (found.t < started)
    assert (found["hinge.sliding"] == np.where(still, 0.0, 1.0)).mean() > 0.99
    assert found["hinge.phi"][still] == pytest.approx(2.0 * stopped / 2, abs=1e-5)
    assert np.ptp(found["hinge.phi"][still]) < 1e-15
    assert found["hinge.friction"][still] == pytest.approx(np.maximum(0.2 * (found.t[still] - 1.0), 0.0))
    assert found["wheel.alphaz"][-1] == pytest.approx((0.4 - 0.2 * torque) / 0.04)


SHAFT = """
spatial model Shaft "the inertia of the sleeve is that of a thin tube"
  Ground ground;
  Body sleeve(m = 2 kg, I = {8e-4, 0.01, 0.01} kg.m2);
  Cylindrical shaft(ground, sleeve.c, radius = 20 mm, mu = 0.2, mu_s = 0.3, sticks = true);
  Force push(sleeve.c, fx = if time < 1 s then 0 N else 3 N/s*(time - 1 s));
  Torque twist(shaft, tau = if time < 1 s then 0 N.m else 80 N.mm/s*(time - 1 s));
initial equation
  shaft.s = 0 m; shaft.v = V; shaft.phi = 30 deg; shaft.w = 50 rad/s;
end Shaft;
"""


def test_a_sleeve_that_slides_and_turns_on_a_shaft_stops_and_starts_along_a_helix():
    found = run(SHAFT.replace("V", "0.75 m/s"), stop=2.5)
    speed, most = hypot(0.75, 0.02 * 50.0), 2 * G
    stopped, started = speed / (0.2 * G), 1.0 + 0.3 * most / hypot(3.0, 4.0)
    still = (found.t > stopped) & (found.t < started)
    assert (found["shaft.sliding"] == np.where(still, 0.0, 1.0)).mean() > 0.99
    assert found["shaft.s"][still] == pytest.approx(0.75 * stopped / 2, abs=1e-4)
    assert found["shaft.phi"][still] == pytest.approx(radians(30) + 50.0 * stopped / 2, abs=5e-3)
    assert max(np.ptp(found["shaft.s"][still]), np.ptp(found["shaft.phi"][still])) < 1e-14
    assert found["shaft.friction"][still] == pytest.approx(np.maximum(5.0 * (found.t[still] - 1.0), 0.0))
    slid = (found.t - started)[-1]  # the pull grows along the same helix
    along = (0.3 - 0.2) * G * slid**2 / 2 + 5.0 / 2.0 * slid**3 / 6
    assert found["shaft.s"][-1] - found["shaft.s"][still][-1] == pytest.approx(0.6 * along, abs=1e-4)


def test_friction_of_a_shaft_without_a_radius_holds_its_position_only():
    found = run(SHAFT.replace("V", "0.75 m/s").replace("radius = 20 mm, ", "").replace("3 N/s", "0 N/s"), stop=1.5)
    assert found["shaft.s"][-1] == pytest.approx(0.75**2 / 2 / (0.2 * G), rel=1e-4)
    assert found["shaft.w"][-1] == pytest.approx(50.0 + 0.08 * 0.5**2 / 2 / 8e-4)


@pytest.mark.parametrize("pitch", [5.0, -5.0])
def test_a_thread_holds_its_load_and_starts_at_the_torque_of_the_wedge(pitch):
    text = f"""
spatial model Jack
  Ground ground(n = {{0, 0, -1}});
  Body nut(m = 100 kg, I = {{1, 1, 0.01}} kg.m2);
  Screw thread(ground, nut.c, n = {{0, 0, 1}}, pitch = {pitch} mm, radius = 10 mm,
    mu = 0.1, mu_s = 0.15, sticks = true);
  Torque motor(thread, tau = {"-" if pitch < 0 else ""}1 N.m/s*time);
initial equation
  thread.s = 0 m; thread.v = 0 m/s;
end Jack;
"""
    found = run(text, stop=3.0)
    lead = atan(5.0 / (2 * pi * 10.0))
    start = 100 * G * 0.01 * tan(lead + atan(0.15))
    still = found.t < start
    assert of_sliding(found, "thread")[0] == pytest.approx(start, abs=0.0101)
    assert np.abs(found["thread.s"][still]).max() < 1e-17
    assert (found["thread.s"][~still] >= 0.0).all()
    # the slope of the thread carries the load; friction along it: (T - r W tan(lead)) cos(lead)/r
    pull = found.t[still] / 0.01 * cos(lead) - 100 * G * sin(lead)
    assert found["thread.friction"][still] == pytest.approx(pull, rel=1e-9)


def test_a_ball_joint_runs_down_and_holds_its_attitude():
    text = """
spatial model Ball
  Ground ground(n = {0, 0, -1});
  Body ball(m = 2 kg, I = {8e-3, 8e-3, 8e-3} kg.m2);
  Spherical socket(ground, ball.c, radius = 50 mm, mu = 0.2, mu_s = 0.3, sticks = true);
  Torque motor(ground, ball.c, n = {1, 2, 2}, tau = if time < 1 s then 0 N.m else 0.2 N.m/s*(time - 1 s));
initial equation
  ball.phi_x = 0.2; ball.phi_y = 0.3; ball.phi_z = -0.4; ball.wx = 6 rad/s; ball.wy = -3 rad/s; ball.wz = 6 rad/s;
end Ball;
"""
    found, torque = run(text, stop=2.9), 0.05 * 2 * G
    stopped, started = 8e-3 * 9.0 / (0.2 * torque), 1.0 + 0.3 * torque / 0.2
    still = (found.t > stopped) & (found.t < started)
    assert (found["socket.sliding"] == np.where(still, 0.0, 1.0)).mean() > 0.98
    assert np.abs(found["ball.wx"][still]).max() < 1e-14
    assert max(np.ptp(found[f"socket.phi_{i}"][still]) for i in "xyz") < 1e-14
    assert found["socket.friction"][still] == pytest.approx(np.maximum(0.2 * (found.t[still] - 1.0), 0.0), abs=1e-12)
    slid = found.t[-1] - started
    w = ((0.3 - 0.2) * torque * slid + 0.2 * slid**2 / 2) / 8e-3
    speeds = [found[f"ball.w{i}"][-1] for i in "xyz"]
    assert speeds == pytest.approx([w / 3, 2 * w / 3, 2 * w / 3], rel=1e-3)


def test_a_bead_on_a_helix_stops_and_is_held():
    text = """
spatial model Helix "radius 0.1 m, pitch 20 deg: the incline of 20 deg without the force of the curve"
  parameter Real h = 0.1*tan(20 deg), mu = 0.5;
  Ground ground(n = {0, 0, -1});
  PointMass bead(m = 1 kg);
  PointOnCurve wire(ground, bead, f1 = wire.x - 0.1 m*cos(wire.z/(h*1 m)), f2 = wire.y - 0.1 m*sin(wire.z/(h*1 m)),
    mu = mu, sticks = true);
initial equation
  bead.z = 0 m; bead.vz = -0.3 m/s; guess bead.x = 0.1 m; guess bead.y = 0 m;
end Helix;
"""
    found = run(text, stop=1.5, step=2e-3)
    # N^2 = (m g cos)^2 + (m v^2 cos^2/r)^2 with the speed v along the wire: v dv/ds = g sin - mu N
    speed = 0.3 / sin(SLOPE)

    def braked(v: float) -> float:
        return 0.5 * hypot(G * cos(SLOPE), (v * cos(SLOPE)) ** 2 / 0.1) - G * sin(SLOPE)

    way, _ = quad(lambda v: v / braked(v), 0.0, speed)
    time, _ = quad(lambda v: 1.0 / braked(v), 0.0, speed)
    assert found["bead.z"][-1] == pytest.approx(-way * sin(SLOPE), rel=1e-4)
    assert of_sliding(found, "wire")[-1] == pytest.approx(time, abs=2.1e-3)
    assert np.abs(found["wire.friction"][-1]) == pytest.approx(G * sin(SLOPE))
    assert np.ptp(found["bead.z"][found.t > time + 2e-3]) < 1e-15
