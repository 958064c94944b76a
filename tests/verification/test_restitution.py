"""Impacts of compliant contacts whose damping is that of the speed of each touch: restitution, slopes and energy."""

import numpy as np
import pytest

import mbdsl

BALL = """model Ball
  Ground ground(g = 0 m/s2);
  PointMass ball(m = 2 kg);
  {contact}
initial equation
  ball.x = 0 m; ball.vx = 0 m/s; ball.y = 1 cm; ball.vy = -{speed} m/s;
end Ball;"""
G = 9.81


@pytest.mark.parametrize(
    ("e", "n", "speed"),
    [(0.05, 1.5, 3.0), (0.3, 1.0, 0.02), (0.7, 10 / 9, 0.4), (0.95, 1.5, 3.0), (0.5, 1.0, 50.0), (0.5, 1.0, 0.4)],
)
def test_every_impact_has_the_given_restitution(e, n, speed):
    contact = f"PointContact c(ground, ball, k = 1e5 N/m, e = {e}, exponent = {n});"
    run = mbdsl.simulate(mbdsl.parse(BALL.format(contact=contact, speed=speed)), stop=0.03 / speed + 0.3, tol=1e-8)
    assert run["c.gap"][-1] > 0.0
    assert run["ball.vy"][-1] == pytest.approx(e * speed, rel=1e-6)
    assert [(x.kind, x.span.line, x.name) for x in run.events] == [("touch", 4, "c")]  # and none at the start


@pytest.mark.parametrize(("method", "accuracy"), [("hht-si2", 3e-3), ("radau5", 1e-5)])
def test_other_methods(method, accuracy):
    """A stop with two limits, between which a mass goes back and forth: e^4 of its speed after four impacts."""
    contact = "TranslationalStop c(ground, ball, n, s_min = -5 cm, s_max = 5 cm, k = 1e6 N/m, e = 0.8);"
    text = BALL.format(contact=contact.replace(" n,", ""), speed=0.0).replace("ball.vx = 0", "ball.vx = 1")
    step = {"step": 1e-4} if method == "hht-si2" else {"tol": 1e-7}
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.5, method=method, **step)
    speeds = np.abs(run["ball.vx"][np.abs(run["ball.x"]) < 0.04])
    assert speeds.min() == pytest.approx(0.8 ** round(np.log(speeds.min()) / np.log(0.8)), rel=accuracy)
    assert speeds.min() < 0.6


def test_given_speed():
    """At the speed v_0 the impact has this restitution, and a slower one loses less."""
    contact = "PointContact c(ground, ball, k = 1e5 N/m, e = 0.5, v_0 = 2 m/s);"
    found = []
    for speed in (2.0, 0.2):
        run = mbdsl.simulate(mbdsl.parse(BALL.format(contact=contact, speed=speed)), stop=0.4, tol=1e-8)
        found.append(run["ball.vy"][-1] / speed)
    assert found[0] == pytest.approx(0.5, rel=1e-6)
    assert 0.7 < found[1] < 1.0


def test_a_ball_bounces():
    """Stiff contact: heights are those of e^2 at each bounce, within the time of contact."""
    text = """model Bounce
      Ground ground;
      PointMass ball(m = 1 kg);
      CircleContact c(ground, ball, r_a = 0.5 m, r_b = 0.5 m, k = 1e9 N/m, e = 0.8);
    initial equation
      ball.x = 0 m; ball.y = 2 m; ball.vx = 0 m/s; ball.vy = 0 m/s;
    end Bounce;"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=2.2, tol=1e-8, interval=1e-4)
    first = np.sqrt(2.0 / G)
    top = [run["ball.y"][abs(run.t - at) < 2e-3].max() - 1.0 for at in (first * 1.8, first * (1 + 1.6 + 0.64))]
    assert top == pytest.approx([0.8**2, 0.8**4], rel=1e-3)


SLOPE = """{spatial}model Slope
  Ground ground;
  {frame}
  Body ball(m = 2 kg, I = {I});
  PointContact c(slope, ball.c, radius = 0.5 m, k = 1e6 N/m, mu = {mu}{n});
initial equation
  ball.x = {r}*sin(20 deg); ball.y = {r}*cos(20 deg);
  ball.vx = 0 m/s; ball.vy = 0 m/s;
end Slope;"""


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize("mu", [0.05, 0.5])
def test_a_ball_on_a_slope(mu, spatial):
    """It slides below mu = tan(20 deg)/(1 + m r^2/J), else it rolls: m r^2/J = 2."""
    r = float(0.5 - 2.0 * G * np.cos(np.radians(20.0)) / 1e6)
    if spatial:
        given = {"spatial": "spatial ", "frame": "Frame slope(ground);", "I": "{0.25, 0.25, 0.25} kg.m2"}
        given["n"] = ", n = {sin(20 deg), cos(20 deg), 0}"
    else:
        given = {"spatial": "", "frame": "Frame slope(ground, phi = -20 deg);", "I": "0.25 kg.m2", "n": ""}
    run = mbdsl.simulate(mbdsl.parse(SLOPE.format(mu=mu, r=f"{r!r} m", **given)), stop=0.5, tol=1e-6)
    s, c = np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    slides = mu < s / c / 3.0
    a = G * (s - mu * c) if slides else G * s / 1.5
    spin = -(mu * G * c * 0.5 * 2.0 / 0.25 if slides else a / 0.5)
    assert np.hypot(run["ball.vx"][-1], run["ball.vy"][-1]) == pytest.approx(0.5 * a, rel=2e-3)
    assert run["ball.wz" if spatial else "ball.w"][-1] == pytest.approx(0.5 * spin, rel=2e-3)
    assert run["c.force"][-1] == pytest.approx(2.0 * G * c, rel=1e-4)


def test_energy_never_grows():
    """A rectangle that tumbles on two of its corners, with friction and losses."""
    text = """model Tumble
      Ground ground;
      Body box(m = 1 kg, I = 0.05 kg.m2);
      BoxContact c(ground, box.c, length = 0.6 m, width = 0.4 m, k = 1e5 N/m, e = 0.6, exponent = 1.5, mu = 0.3);
    initial equation
      box.x = 0 m; box.y = 0.6 m; box.phi = 20 deg; box.vx = 1 m/s; box.vy = 0 m/s; box.w = 3 rad/s;
    end Tumble;"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.8, tol=1e-6, interval=1e-3)
    energy = run["energy.total"]
    assert np.diff(energy).max() < 1e-4 * energy[0]
    assert energy[-1] < 0.9 * energy[0]
