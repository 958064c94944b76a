"""Bushings, stops and free motion in space: torques by hand, a potential, frequencies, and planar models in space."""

import math
import re

import numpy as np
import pytest

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.system import build

K, TORSION = np.array([100.0, 200.0, 400.0]), np.array([3.0, 5.0, 7.0])


def mount(more="", start="", torsion="{3, 5, 7}"):
    return f"""spatial model Mount
      Ground ground(g = 0 m/s2);
      Body body(m = 2 kg, I = {{0.1, 0.2, 0.4}} kg.m2);
      Bushing mount(ground, body.c, k = {{100, 200, 400}} N/m, k_phi = {torsion} N.m/rad{more});
    {start}
    end Mount;"""


def system(text):
    scene = mbdsl.parse(text)
    return build(scene, graph.build(scene))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("angle", [1e-6, 0.3, 0.5, 2.0, 3.1])
def test_a_rotation_about_one_axis(axis, angle):
    """The torque is k_phi times the angle, whatever the angle is; forces are those of the displacement."""
    s = system(mount())
    q = np.array([0.1, -0.2, 0.3, 0.0, 0.0, 0.0])
    q[3 + axis] = angle
    expected = np.zeros(6)
    expected[:3] = -K * q[:3]
    expected[3 + axis] = -TORSION[axis] * angle
    # the closed form of the tilt divides differences of size 1 by the square of its sine, of 2e-3 at 3.1 rad
    np.testing.assert_allclose(s.Q(0.0, q, np.zeros(6)), expected, rtol=0, atol=1e-11)


def test_both_forms_of_the_tilt_agree():
    """The series below SMALL and the closed form above it: the same torque up to rounding, on either side."""
    from mbdsl.elements.swing_twist import SMALL

    s, edge = system(mount()), np.arccos(1.0 - SMALL)
    slopes = []
    for angle in (edge - 1e-6, edge + 1e-6):
        q = np.array([0.0, 0.0, 0.0, 0.6 * angle, 0.8 * angle, 0.0])
        slopes.append(s.Q(0.0, q, np.zeros(6))[3:] / angle)
        tilted = s.stiffness(0.0, q, np.zeros(6), np.zeros(0))
        slopes.append(np.diag(tilted)[3:])
    assert slopes[0] == pytest.approx(slopes[2], rel=0, abs=2e-5)  # they vary over 2e-6 rad
    assert slopes[1] == pytest.approx(slopes[3], rel=0, abs=2e-5)


def test_frequencies():
    """Small vibrations: sqrt(k/m) and sqrt(k_phi/I) in three directions each."""
    modes = mbdsl.eigen(mbdsl.parse(mount()))
    expected = np.sqrt([*K / 2.0, *TORSION / (0.1, 0.2, 0.4)])
    assert [mode.omega for mode in modes] == pytest.approx(sorted(expected), rel=1e-9)


LARGE = """initial equation
  body.x = 0.2 m; body.y = -0.1 m; body.z = 0.1 m;
  body.wx = {w} rad/s; body.wy = {w} rad/s; body.wz = {spin} rad/s;"""


def test_the_forces_have_a_potential():
    """A body that tilts by a radian and twists by more than a turn on soft torsional springs keeps its energy.

    The energy changes with the square of the step, and by less than 1e-4 of it."""
    scene = mbdsl.parse(mount(start=LARGE.format(w=9, spin=9), torsion="{3, 5, 0.1}"))
    drifts = []
    for h in (2e-3, 1e-3):
        t = mbdsl.simulate(scene, step=h, stop=1.0, interval=0.02, method="hht-si2")
        drifts.append(np.ptp(t["energy.total"]) / t["energy.total"][0])
    assert np.hypot(t["mount.phi_x"], t["mount.phi_y"]).max() > 0.8
    assert np.abs(t["mount.phi"]).max() > 2 * np.pi
    assert drifts[1] < 1e-4
    assert drifts[0] / drifts[1] == pytest.approx(4.0, abs=0.5)


def test_dampers_take_what_the_energy_loses():
    """The energy falls by the integral of c times the squares of the rates; trapezoids over 1 ms."""
    damped = ", c = {2, 3, 4} N.s/m, c_phi = {0.02, 0.03, 0.04} N.m.s/rad"
    t = mbdsl.simulate(mbdsl.parse(mount(damped, LARGE.format(w=3, spin=9))), step=5e-4, stop=1.0, interval=0)
    power = np.zeros(len(t.t))
    for name, c in zip(("x", "y", "z", "phi_x", "phi_y", "phi"), (2, 3, 4, 0.02, 0.03, 0.04), strict=True):
        power += c * np.gradient(t[f"mount.{name}"], t.t, edge_order=2) ** 2
    lost = t["energy.total"][0] - t["energy.total"][-1]
    assert lost > 0.2 * t["energy.total"][0]
    assert np.trapezoid(power, t.t) == pytest.approx(lost, rel=1e-4)


# -- planar models in space --------------------------------------------------------------------------------------------

PLANAR = {
    "a bushing that turns more than once": """model Mount
      Ground ground(g = 0 m/s2);
      Body body(m = 2 kg, I = 0.4 kg.m2, frames(p = {0.1, 0.2}));
      Bushing mount(ground, body.p, k = {100, 200} N/m, c = {1, 2} N.s/m, k_phi = 0.3 N.m/rad, phi0 = 0.2 rad);
    initial equation body.x = 0 m; body.y = 0 m; body.phi = 0 rad; body.w = 9 rad/s;
    end Mount;""",
    "a swing between stops": """model Swing
      Ground ground;
      Body rod(m = 1 kg, I = 0.1 kg.m2, length = 1 m);
      Revolute pin(ground, rod.a);
      RotationalStop stop(pin, phi_min = -1.7 rad, phi_max = -1.4 rad, k = 500 N.m/rad, e = 0.7, w_0 = 1 rad/s);
    initial equation pin.phi = -1.6 rad; pin.w = 2 rad/s;
    end Swing;""",
    "a slide between stops": """model Slide
      Ground ground;
      Body block(m = 1 kg, I = 0.1 kg.m2);
      Prismatic guide(ground, block.c);
      TranslationalStop stop(guide, s_min = -0.1 m, s_max = 0.05 m, k = 5000 N/m, e = 0.7, v_0 = 1 m/s);
    initial equation guide.s = 0 m; guide.v = 1 m/s;
    end Slide;""",
    "a throw": """model Throw
      Ground ground;
      Body stone(m = 1 kg, I = 0.1 kg.m2);
      FreeMotion free(ground, stone.c);
    initial equation free.x = 1 m; free.y = 2 m; free.phi = 0.5 rad;
      free.vx = 3 m/s; free.vy = 4 m/s; free.w = 20 rad/s;
    end Throw;""",
}


@pytest.mark.parametrize("name", PLANAR)
def test_planar_model_in_space(name):
    """All common signals, relative to their largest value and to 1; Newton's iteration leaves 1e-7 of reactions."""
    text = PLANAR[name]
    solid = re.sub(r"I = (\S+) kg.m2", r"I = {\1, \1, \1} kg.m2", text.replace("model", "spatial model", 1))
    given = {"step": 1e-3, "stop": 1.0, "interval": 0.01}
    flat = mbdsl.simulate(mbdsl.parse(text), **given)
    solid = mbdsl.simulate(mbdsl.parse(solid), general=True, **given)  # by the equations in space
    assert flat.t == pytest.approx(solid.t, rel=0, abs=1e-6)
    common = [x for x in flat.signals if x in solid]
    for signal in common:
        scale = max(1.0, np.abs(flat[signal]).max())
        np.testing.assert_allclose(solid[signal], flat[signal], rtol=0, atol=1e-6 * scale, err_msg=signal)
    own = {x for x in flat.signals if x.startswith(("mount.", "stop.", "free."))}
    assert own <= set(common) and len(own) >= 3


def test_a_stop_along_any_axis():
    """A block slides up a skew guide against an elastic stop and returns: the depth follows from the energy.

    v^2/2 = g sin(b) d + k d^2/(2 m); the maximum is missed by at most half an interval, in which d falls by a h^2/8."""
    n, v0, k = np.array([2.0, 3.0, 6.0]) / 7.0, 2.0, 4000.0
    text = f"""spatial model Slope
      Ground ground(n = {{0, 0, -1}});
      Body block(m = 1 kg, I = {{1, 2, 3}} kg.m2);
      Prismatic guide(ground, block.c, n = {{2, 3, 6}});
      TranslationalStop stop(ground, block.c, n = {{2, 3, 6}}, s_max = 0 m, k = {k} N/m);
    initial equation
      guide.s = 0 m;
      guide.v = {v0} m/s;
    end Slope;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-4, stop=0.06, interval=0, general=True)
    weight = 9.81 * n[2]
    depth = (np.sqrt(weight**2 + k * v0**2) - weight) / k
    assert t["guide.s"].max() == pytest.approx(depth, abs=2e-6)
    assert t["stop.force"].max() == pytest.approx(k * depth, rel=1e-4)
    assert t["guide.v"][-1] == pytest.approx(-v0, abs=0.06 * weight)  # gravity acts for 0.06 s at most
    assert t["energy.total"] == pytest.approx(v0**2 / 2, rel=1e-4)


@pytest.mark.parametrize(("axis", "speed", "warned"), [("y", 5.0, True), ("y", 4.0, False), ("z", 5.0, False)])
def test_a_tilt_of_half_a_turn_is_reported(axis, speed, warned):
    """The oscillation phi = w/omega sin(omega t) has an amplitude of 3.54 or 2.83 rad; a twist may have any angle."""
    text = """spatial model Mount
      Ground ground;
      Body body(m = 1 kg, I = 0.2 kg.m2);
      Spherical ball(ground, body.c);
      Bushing mount(ground, body.c, k_phi = K N.m/rad);
    initial equation
      body.wAXIS = SPEED rad/s;
    end Mount;"""
    stiffness = "{0, 0.4, 0}" if axis == "y" else "{0, 0, 0.4}"
    model = mbdsl.parse(text.replace("K N", f"{stiffness} N").replace("AXIS", axis).replace("SPEED", str(speed)))
    found = mbdsl.simulate(model, stop=1.5, interval=0.01, step=1e-3).stats["warnings"]
    omega = math.sqrt(0.4 / 0.2)
    passed = math.asin(math.pi * omega / 5.0) / omega
    texts = [w for w in found if "Bushing mount tilts by more than half a turn" in w]
    assert len(texts) == warned
    for text in texts:
        assert float(re.search(r"after t = ([0-9.]+) s", text)[1]) == pytest.approx(passed, abs=0.01)  # the interval


# -- damping of the relative angular velocity ------------------------------------------------------------------------

BALL = """spatial model Ball
  Ground ground(g = 0 m/s2);
  Frame turned(ground, n = {{1, 2, 3}}, phi = 50 deg);
  Body b(m = 0.1 kg, I = 0.01 kg.m2, frames(f(r = {{0, 0, 0}}{axes})));
  Spherical j(turned, b.f);
  Bushing d(j, c_w = {c} N.m.s/rad);
initial equation
  b.phi_x = {tilt} deg; b.phi_y = 0; b.phi_z = 0;
  b.wx = 1 rad/s; b.wy = 2 rad/s; b.wz = 3 rad/s;
  annotation(experiment(StopTime = 0.5 s, Interval = 50 ms));
end Ball;"""


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "dop853"])
@pytest.mark.parametrize(("tilt", "axes"), [(60, ""), (179, ""), (0, ", n_x = {1, 0, 0}, n_y = {0, -1, 0}")])
def test_a_damped_ball_joint(tilt, axes, method):
    """I dw/dt = -c w: the angular velocity keeps its direction, at any attitude, also after half a turn."""
    run = mbdsl.simulate(mbdsl.parse(BALL.format(c=0.1, tilt=tilt, axes=axes)), method=method, tol=1e-7)
    for key, w in zip("xyz", (1.0, 2.0, 3.0), strict=True):
        assert run[f"b.w{key}"] == pytest.approx(w * np.exp(-10.0 * run.t), abs=2e-6)


def test_each_axis_of_the_first_frame_has_its_damping():
    scene = mbdsl.parse(BALL.format(c="{0.1, 0.2, 0.4}", tilt=70, axes=""))
    run = mbdsl.simulate(scene, stop=1e-3, step=1e-3)
    n, angle = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0), math.radians(50.0)
    cross = np.cross(n, np.eye(3)).T  # n x
    R = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    expected = -R @ np.diag([10.0, 20.0, 40.0]) @ R.T @ [1.0, 2.0, 3.0]
    assert [run[f"b.alpha{key}"][0] for key in "xyz"] == pytest.approx(expected, rel=1e-12)


def test_damping_between_two_free_bodies():
    """The relative angular velocity decays with c (1/I + 1/J), the angular momentum stays; damping can be left out."""
    text = """spatial model Two
      Ground ground(g = 0);
      Body a(m = 1 kg, I = 0.2 kg.m2); Body b(m = 3 kg, I = 0.3 kg.m2);
      Bushing d(a.c, b.c, c_w = 0.6 N.m.s/rad); FreeMotion free(ground, a.c);
    initial equation
      a.wx = 1 rad/s; a.wy = 0; a.wz = -2 rad/s; b.wx = 0; b.wy = 4 rad/s; b.wz = 1 rad/s; b.phi_x = 100 deg;
      annotation(experiment(StopTime = 0.4 s, Interval = 0.1 s));
    end Two;"""
    run = mbdsl.simulate(mbdsl.parse(text), method="radau5", tol=1e-8)
    for key, wa, wb in (("x", 1.0, 0.0), ("y", 0.0, 4.0), ("z", -2.0, 1.0)):
        mean, left = 0.4 * wa + 0.6 * wb, (wb - wa) * np.exp(-5.0 * run.t)
        assert run[f"a.w{key}"] == pytest.approx(mean - 0.6 * left, abs=1e-6)
        assert run[f"b.w{key}"] == pytest.approx(mean + 0.4 * left, abs=1e-6)
    free = mbdsl.simulate(mbdsl.parse(text, without=["damping"]), method="radau5", tol=1e-8)
    assert free["b.wy"] == pytest.approx(4.0, abs=1e-9)


def test_one_number_about_z_is_the_damping_of_the_plane():
    """Both names damp a rotation about z alone; c_phi is the one of the plane, where c_w is answered with it."""
    text = """{}model Wheel
      Ground ground(g = 0); Body b(m = 1 kg, I = 0.5 kg.m2); Revolute pin(ground, b.c);
      Bushing d(ground, b.c, {} = 0.2 N.m.s/rad);
    initial equation b.w{} = 3 rad/s;
      annotation(experiment(StopTime = 1 s));
    end Wheel;"""
    for head, name, z in (("", "c_phi", ""), ("spatial ", "c_phi", "z"), ("spatial ", "c_w", "z")):
        run = mbdsl.simulate(mbdsl.parse(text.format(head, name, z)), method="dop853", tol=1e-9)
        assert run[f"b.w{z}"][-1] == pytest.approx(3.0 * math.exp(-0.4), rel=1e-8)
    with pytest.raises(mbdsl.ModelError, match="in the plane it is `c_phi`"):
        mbdsl.parse(text.format("", "c_w", ""))


@pytest.mark.parametrize("joint", ["Spherical", "Universal", "ConstantVelocity"])
def test_damping_in_a_joint_is_answered_with_a_bushing_on_it(joint):
    text = BALL.replace("Spherical j(turned, b.f);", f"{joint} j(turned, b.f, damping = 0.1 N.m.s/rad);")
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.parse(text.format(c=0, tilt=0, axes=""))
    (written,) = re.findall(r"write `(.*?)`", problem.value.hint)
    assert written == "Bushing damper(joint, c_w = 0.1 N.m.s/rad);"
    text = text.replace(", damping = 0.1 N.m.s/rad", "").format(c=0, tilt=0, axes="")
    scene = mbdsl.parse(text.replace("Bushing d(j, c_w = 0 N.m.s/rad);", written.replace("joint", "j")))
    assert scene.components["damper"].values["c_w"] == (0.1, 0.1, 0.1)
