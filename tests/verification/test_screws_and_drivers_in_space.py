"""Screws, and drivers on the free coordinates of joints in space, against closed forms."""

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import modules

METHODS = [name for name, module in modules().items() if module.METHOD.chosen and not hasattr(module, "take")]
G = 9.81
M, J, PITCH = 2.0, np.array([0.01, 0.02, 0.03]), 0.05
OFF = np.array([0.1, 0.05])  #: of the centre of mass from the axis


def nut(pitch=PITCH, start="thread.s = 0.12 m; thread.v = 0 m/s;", eye="c", more=""):
    """A nut on a vertical spindle through its centre of mass, or through its frame "eye"."""
    return f"""spatial model Nut
      Ground ground;
      Body nut(m = {M}, I = {{{J[0]}, {J[1]}, {J[2]}}}, frames(eye = {{{OFF[0]}, 0, {OFF[1]}}} m));
      Screw thread(ground, nut.{eye}, n = {{0, 1, 0}}, pitch = {pitch} m);
      {more}
    initial equation
      {start}
    end Nut;"""


def acceleration(pitch, off=0.0 * OFF):
    """-g m/(m + J/h^2), with J about the axis and h = pitch/(2 pi)."""
    return -G / (1 + (J[1] + M * off @ off) / M * (2 * np.pi / pitch) ** 2)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pitch", [PITCH, -0.4])
def test_a_nut_falls_along_its_spindle(pitch, method):
    """s = s0 + a t^2/2, and the angle is s/h. Methods of order 2 are exact for constant accelerations, up to their
    starts, with errors of a h^2; newmark, whose gamma is 0.6, has s by a h t/20 off."""
    t = mbdsl.simulate(mbdsl.parse(nut(pitch)), method=method, step=1e-3, stop=0.8, interval=0.1)
    a = acceleration(pitch)
    bound = 1e-4 * abs(a) if method == "newmark" else 2e-6 * abs(a) + 1e-12
    np.testing.assert_allclose(t["thread.s"], 0.12 + a * t.t**2 / 2, rtol=0, atol=bound)
    np.testing.assert_allclose(t["thread.phi"], 2 * np.pi * t["thread.s"] / pitch, rtol=1e-13)
    np.testing.assert_allclose(t["nut.wy"], t["thread.w"], rtol=0, atol=1e-6 * abs(t["thread.w"]).max())


def test_the_thread_carries_thrust_and_torque():
    """F = m (g + a) along the axis, and the torque J a/h about it, which has the moment of the centripetal force."""
    t = mbdsl.simulate(mbdsl.parse(nut(eye="eye")), step=1e-3, stop=0.8, interval=0.1)
    a, h = acceleration(PITCH, OFF), PITCH / (2 * np.pi)
    np.testing.assert_allclose(t["thread.fy"], M * (G + a), rtol=1e-7)
    np.testing.assert_allclose(t["thread.ty"], (J[1] + M * OFF @ OFF) * a / h, rtol=1e-6)
    radial = np.hypot(t["thread.fx"], t["thread.fz"])
    expected = M * np.hypot(*OFF) * np.hypot(t["thread.w"] ** 2, a / h)
    np.testing.assert_allclose(radial, expected, rtol=1e-5)


def test_turns_of_a_thread_follow_from_its_position():
    """A quarter of a turn in each step, from the eleventh turn on: s = s0 + v t without gravity."""
    start = f"thread.phi = {2 * np.pi * 10.3:.17g} rad; thread.v = 0.5 m/s;"
    text = nut(start=start).replace("Ground ground", "Ground ground(g = 0)")
    t = mbdsl.simulate(mbdsl.parse(text), step=0.025, stop=2.0, interval=0.5)
    np.testing.assert_allclose(t["thread.s"], 10.3 * PITCH + 0.5 * t.t, rtol=0, atol=1e-9)
    np.testing.assert_allclose(t["thread.phi"], 2 * np.pi * (10.3 + 0.5 * t.t / PITCH), rtol=1e-8)


@pytest.mark.parametrize("pitch", [0.2, -0.2])
def test_friction_in_a_thread(pitch):
    """By hand, with the lead angle l: m A = m g - N (cos l + mu sin l), J A/h = r N (sin l - mu cos l)."""
    mu, r = 0.1, 0.03
    lead, h = np.arctan(0.2 / (2 * np.pi * r)), 0.2 / (2 * np.pi)
    text = nut(pitch, "thread.s = 0 m; thread.v = -1 m/s;").replace("m);\n", f"m, mu = {mu}, radius = {r} m);\n", 1)
    assert "radius" in text
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=1.0, interval=0.1)
    across, along = np.cos(lead) + mu * np.sin(lead), np.sin(lead) - mu * np.cos(lead)
    a = M * G / (M + J[1] * across / (h * r * along))
    np.testing.assert_allclose(t["thread.v"], -1 - a * t.t, rtol=1e-6)
    np.testing.assert_allclose(t["thread.friction"], mu * J[1] * a / (h * r * along), rtol=1e-6)


def test_a_thread_that_locks_itself():
    """With mu > tan(lead angle), the nut stays where it is, up to a creep below v_s."""
    text = nut(0.01, "thread.s = 0 m; thread.v = 0 m/s;").replace("m);\n", "m, mu = 0.1, radius = 0.03 m);\n", 1)
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=1.0, interval=0.1)
    assert -1e-3 < t["thread.s"][-1] < 0.0


def test_a_thread_without_pitch_is_refused():
    with pytest.raises(mbdsl.ModelError, match="the joint is a Revolute"):
        mbdsl.parse(nut(pitch=0.0))


# -- drivers on the free coordinates of joints -------------------------------------------------------------------------

N = "{2, 3, 6}"  #: a skew axis of length 7
JOINTS = {
    "Revolute": (f"Revolute joint(ground, body.c, n = {N})", ("phi",)),
    "Prismatic": (f"Prismatic joint(ground, body.c, n = {N})", ("s",)),
    "PointOnLine": (f"PointOnLine joint(ground, body.c, n = {N})", ("s",)),
    "Cylindrical": (f"Cylindrical joint(ground, body.c, n = {N})", ("s", "phi")),
    "Planar": (f"Planar joint(ground, body.c, n = {N})", ("s_x", "phi")),
    "Screw by its angle": (f"Screw joint(ground, body.c, n = {N}, pitch = 0.05 m)", ("phi",)),
    "Screw by its position": (f"Screw joint(ground, body.c, n = {N}, pitch = 0.05 m)", ("s",)),
}
ANGLE, LENGTH = "4 rad/s*time + 3 rad/s^2*time^2", "0.5 m/s*time + 0.2 m/s^2*time^2"
RATES = {"phi": "4 rad/s + 6 rad/s^2*time", "s": "0.5 m/s + 0.4 m/s^2*time"}


def driven(joint, coordinates, of_velocity):
    """A body of which ``coordinates`` are driven by drivers on the joint: without n, they have its axis."""
    drivers, start = "", ""
    for name in coordinates:
        kind = "Rotational" if name == "phi" else "Translational"
        key = name[:3].removesuffix("_x")
        if of_velocity:
            rate = "w" if name == "phi" else "v"
            drivers += f"{kind}VelocityDriver drive_{key}(joint, {rate} = {RATES[key]});\n"
            start += f"joint.{name} = 0 {'rad' if name == 'phi' else 'm'};\n"
        else:
            drivers += f"{kind}Driver drive_{key}(joint, {key} = {ANGLE if name == 'phi' else LENGTH});\n"
    return f"""spatial model Driven
      Ground ground(g = 0 m/s2);
      Body body(m = {M}, I = {{0.1, 0.1, 0.1}});
      {joint};
      {drivers}
    initial equation
      {start}
    end Driven;"""


@pytest.mark.parametrize("of_velocity", [False, True], ids=["position", "velocity"])
@pytest.mark.parametrize("name", JOINTS)
def test_drivers_on_joints(name, of_velocity):
    """Angles of several turns and positions as prescribed; force m a and torque I alpha along the joint's axis.

    Positions that follow from velocities of degree 1 are exact; accelerations start with an error that decays."""
    joint, coordinates = JOINTS[name]
    scene = mbdsl.parse(driven(joint, coordinates, of_velocity))
    t = mbdsl.simulate(scene, step=1e-3, stop=1.5, interval=0.1, general=True)
    expected = {"phi": 4 * t.t + 3 * t.t**2, "s": 0.5 * t.t + 0.2 * t.t**2}
    along = np.array([2, 3, 6]) / 7
    for coordinate in coordinates:
        key = coordinate.removesuffix("_x")
        np.testing.assert_allclose(t[f"joint.{coordinate}"], expected[key], rtol=0, atol=1e-6)
        np.testing.assert_allclose(t[f"drive_{key}.{key}"], expected[key], rtol=0, atol=1e-6)
        effort = [t[f"drive_{key}.{'t' if key == 'phi' else 'f'}{i}"][-1] for i in "xyz"]
        if name.startswith("Screw"):
            h = 0.05 / (2 * np.pi)
            size = (0.1 + M * h * h) * 6 if key == "phi" else (M + 0.1 / h**2) * 0.4
        else:
            size = 0.1 * 6 if key == "phi" else M * 0.4
        if coordinate != "s_x":
            np.testing.assert_allclose(effort, size * along, rtol=0, atol=1e-4 * size)
        else:
            assert np.linalg.norm(effort) == pytest.approx(size, rel=1e-4)
            assert effort @ along == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("of_velocity", [False, True], ids=["position", "velocity"])
def test_a_driver_turns_the_cross_of_a_cardan_joint(of_velocity):
    """The arm n_b of the cross turns about n_a as prescribed, whatever the body does about n_b.

    An angle that follows from its rate has the error of the method in attitudes, of order 2: a quarter with half steps.
    """
    drive = f"RotationalVelocityDriver motor(cross, w = {RATES['phi']})" if of_velocity else ""
    text = f"""spatial model Cross
      Ground ground(g = 0 m/s2);
      Body body(m = {M}, I = {{0.1, 0.2, 0.3}}, frames(arm = {{0, 1, 0}} m, side = {{1, 0, 0}} m));
      Universal cross(ground, body.c, n_a = {{1, 0, 0}}, n_b = {{0, 1, 0}});
      {drive or f"RotationalDriver motor(cross, phi = {ANGLE})"};
    initial equation
      motor.phi = 0 rad; body.wy = 2 rad/s;
    end Cross;"""
    if not of_velocity:
        text = text.replace("motor.phi = 0 rad; ", "")
    errors = []
    for step in (1e-3, 5e-4):
        t = mbdsl.simulate(mbdsl.parse(text), step=step, stop=1.0, interval=0.1)
        phi = 4 * t.t + 3 * t.t**2
        errors.append(np.abs(t["motor.phi"] - phi).max())
        np.testing.assert_allclose(t["body.arm.y"] + 1j * t["body.arm.z"], np.exp(1j * t["motor.phi"]), atol=1e-8)
    assert np.ptp(t["body.side.x"]) > 0.5
    if of_velocity:
        assert errors[1] < 1e-5 and errors[0] / errors[1] == pytest.approx(4.0, abs=0.1)
    else:
        assert max(errors) < 1e-8


def test_an_axis_that_is_given_is_kept():
    """Springs, stops and torques have the joint's axis as well, unless n is given."""
    elements = "RotationalSpringDamper spring(joint, k = 1 N.m/rad{0}); Torque torque(joint, tau = 1 N.m{0});"
    elements += " RotationalStop stop(joint, k = 1 N.m/rad, phi_max = 1 rad{0});"
    text = f"""spatial model Axes
      Ground ground;
      Body body(m = 1 kg, I = {{1, 1, 1}} kg.m2);
      Cylindrical joint(ground, body.c, n = {N});
      TranslationalSpringDamper slide(joint, k = 1 N/m); TranslationalStop end_stop(joint, k = 1 N/m, s_max = 1 m);
      {elements}
    end Axes;"""
    names = ("spring", "torque", "stop")
    found = mbdsl.parse(text.replace("{0}", "")).components
    assert {found[name].values["n"] for name in (*names, "slide", "end_stop")} == {(2.0, 3.0, 6.0)}
    found = mbdsl.parse(text.replace("{0}", ", n = {0, 1, 0}")).components
    assert {found[name].values["n"] for name in names} == {(0.0, 1.0, 0.0)}


@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize(
    "driver", ["RotationalDriver d(pin, phi = 3 rad/s2*time^2)", "RotationalVelocityDriver d(pin, w = 6 rad/s2*time)"]
)
def test_the_torque_of_a_motor_is_that_about_its_axis(driver, general):
    """n . J n alpha, with n = (2, -1, 2)/3 and alpha = 6 rad/s2, on a body whose bearing is its centre of mass."""
    text = f"""spatial model Motor
      Ground ground(g = 0);
      Body rotor(m = 2 kg, I = {{{{0.3, 0.05, 0}}, {{0.05, 0.4, 0.02}}, {{0, 0.02, 0.5}}}} kg.m2);
      Revolute pin(ground, rotor.c, n = {{2, -1, 2}});
      {driver};
    initial equation
      pin.phi = 0;
      pin.w = 0;
    end Motor;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=0.2, interval=0.1, general=general)
    moment = (4 * 0.3 + 0.4 + 4 * 0.5 - 2 * 2 * 0.05 - 2 * 2 * 0.02) / 9.0
    np.testing.assert_allclose(t["d.tau"], 6.0 * moment, rtol=1e-9)
