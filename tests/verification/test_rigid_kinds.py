"""Stops and contacts without stiffness `k`, which are rigid, against closed forms."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError, ModelError, UsageError
from mbdsl.integrators.touching import alike

G = 9.81
SLIDER = """
{of}model Slider
  Ground ground(g = 0);
  Body b(m = 2 kg, I = {I});
  Prismatic s(ground, b.c);
  TranslationalStop stop(ground, b.c, s_min = 0 m, s_max = 1 m, {given});
initial equation
  s.s = 0.5 m; s.v = 1 m/s;
  annotation(experiment(StopTime = 5 s));
end Slider;
"""
PENDULUM = """
{of}model Pendulum
  Ground ground;
  Body b(m = 2 kg, I = {I}, frames(pin = {{-0.5 m, 0{zero}}}));
  Revolute p(ground, b.pin);
  RotationalStop stop(ground, b.pin, phi_min = 0, e = 0.6);
initial equation
  p.phi = 60 deg; p.w = 0 rad/s;
  annotation(experiment(StopTime = 20 s));
end Pendulum;
"""
SPACES = pytest.mark.parametrize("spatial", [False, True], ids=["plane", "space"])


def made(text, spatial, **given):
    """The model in the plane or in space; its motion is the same."""
    words = {"of": "spatial " * spatial, "I": "{0.1, 0.1, 0.1} kg.m2" if spatial else "0.1 kg.m2"}
    return mbdsl.parse(text.format(zero=", 0" * spatial, **words, **given))


@SPACES
def test_a_slider_between_two_stops(spatial):
    """It meets them at 0.5 s, 0.5 + 1/e s and 0.5 + 1/e + 1/e^2 s, and each time keeps e of its speed."""
    found = mbdsl.simulate(made(SLIDER, spatial, given="e = 0.8"), step=0.01, interval=0.01)
    times = np.array([0.5, 0.5 + 1 / 0.8, 0.5 + 1 / 0.8 + 1 / 0.64])
    count = (found.t[:, None] > times).sum(axis=1)
    away = np.abs(found.t[:, None] - times).min(axis=1) > 1e-6
    np.testing.assert_allclose(found["s.v"][away], (-0.8) ** count[away], rtol=1e-9)
    np.testing.assert_array_equal(found["stop.impacts"][away], count[away])
    assert found["stop.impulse_max"][-1] == pytest.approx(2 * 0.64 * 1.8)
    assert found["stop.impulse_min"][-1] == pytest.approx(2 * 0.8 * 1.8)
    starts = np.array([-0.5 / 1.0 + 0.5, *times])
    inside = np.where(count % 2 == 0, 0.0, 1.0) + (-0.8) ** count * (found.t - starts[count]) + 0.5 * (count == 0)
    np.testing.assert_allclose(found["stop.s"], inside, atol=1e-9)


def returns(w, e, start, phi):
    """Time of the n-th impact of a pendulum with phi'' = -k cos(phi), k = ``w``**2, from rest at ``phi``."""
    from scipy.integrate import quad

    def fall(top):  # time from the angle top to 0: phi' = sqrt(2 k (sin top - sin phi)), with sin phi = sin top (1-u^2)
        s = np.sin(top)
        return quad(lambda u: 2 * s * u / np.sqrt(1 - (s * (1 - u * u)) ** 2) / np.sqrt(2 * s * u * u), 0, 1)[0] / w

    t = start + fall(phi)
    while True:
        yield t, phi
        phi = np.arcsin(e * e * np.sin(phi))
        t += 2 * fall(phi)


@SPACES
def test_a_pendulum_on_a_stop_comes_to_rest(spatial):
    """phi'' = -(m g l/J) cos(phi); each impact leaves e^2 of the energy; at rest the torque of the stop is m g l."""
    found = mbdsl.simulate(made(PENDULUM, spatial), step=5e-3, stop=4.0, interval=1e-3)
    w = np.sqrt(2 * G * 0.5 / (0.1 + 2 * 0.25))
    impacts = found["stop.impacts"]
    expected = returns(w, 0.6, 0.0, np.pi / 3)
    for n in range(4):
        t, _ = next(expected)
        k = int(np.flatnonzero(impacts > n)[0])
        assert found.t[k - 1] - 1e-5 <= t <= found.t[k] + 1e-5
    assert found["stop.active"][-1] == 1.0
    assert found["stop.torque"][-1] == pytest.approx(-2 * G * 0.5)
    assert found["stop.frame_b.tau"][-1] == pytest.approx(2 * G * 0.5)
    np.testing.assert_allclose(found["p.phi"][-1], 0.0, atol=1e-9)


def test_a_stop_without_stiffness_or_restitution():
    with pytest.raises(ModelError, match=r"without `k` it is rigid, and needs `e`"):
        made(SLIDER, False, given="v_0 = 1 m/s")
    with pytest.raises(ModelError, match=r"`v_0` and `exponent` have no meaning"):
        made(SLIDER, False, given="e = 0.5, v_0 = 1 m/s")
    outside = PENDULUM.replace("p.phi = 60 deg", "p.phi = -0.2")
    with pytest.raises(InitialisationError, match=r"the gap of `stop.min` is -0.2 rad at the start"):
        mbdsl.simulate(made(outside, False), stop=0.01)
    with pytest.raises(ModelError, match=r"e is 1.2, the coefficient of restitution must be between 0 and 1"):
        made(SLIDER, False, given="e = 1.2")


ROLLING = """
{of}model Rolling
  Ground ground;
  Body b(m = 3 kg, I = {I});
  FreeMotion free(ground, b.c);
  PointContact floor(ground, b.c, radius = 0.5 m, mu = 0.2, e = 0.5{n});
  Sensor cell(ground);
initial equation
  b.x = 0 m; b.y = 0.5 m; b.vx = 2 m/s; b.vy = 0 m/s;
  annotation(experiment(StopTime = 1 s));
end Rolling;
"""


@SPACES
@pytest.mark.parametrize(
    ("part", "options"),
    [(2 / 5, {"step": 0.01}), (1 / 2, {"tol": 1e-6}), (2 / 5, {"method": "moreau-jean", "step": 2e-3})],
    ids=["ball", "disc", "moreau-jean"],
)
def test_a_sliding_ball_begins_to_roll(spatial, part, options):
    """With I = c m r^2 it rolls at v0/(1 + c), 5/7 or 2/3 of v0, from t = v0 c/((1 + c) mu g) on."""
    text = ROLLING.replace(
        "{I}", f"{{{{{part * 0.75},{part * 0.75},{part * 0.75}}}}} kg.m2" if spatial else f"{part * 0.75} kg.m2"
    )
    found = mbdsl.simulate(made(text, spatial, n=", n = {0, 1, 0}" * spatial), interval=0.01, stop=0.5, **options)
    start = 2 * part / (1 + part) / (0.2 * G)
    close = 1e-2 if "method" in options else 1e-9
    np.testing.assert_allclose(found["b.vx"], np.maximum(2 - 0.2 * G * found.t, 2 / (1 + part)), atol=close)
    slides = found.t < start - close
    np.testing.assert_allclose(found["floor.force"], 3 * G, rtol=1e-9)
    np.testing.assert_allclose(found["floor.friction_force"][slides], 0.6 * G, rtol=1e-9)
    np.testing.assert_allclose(found["cell.fx"][slides], 0.6 * G, rtol=1e-9)  # on the ground
    np.testing.assert_allclose(found["cell.fy"], -3 * G, rtol=1e-9)
    np.testing.assert_allclose(found["floor.friction_force"][found.t > start + close], 0.0, atol=1e-8)
    np.testing.assert_allclose(found["b.w"][-1], -2 / (1 + part) / 0.5, rtol=1e-9 + close)


DISCS = """
{of}model Discs
  Ground ground(g = 0);
  Body a(m = 1 kg, I = {I}), b(m = 2 kg, I = {I});
  FreeMotion fa(ground, a.c), fb(ground, b.c);
  CircleContact c(a.c, b.c, r_a = 0.1 m, r_b = 0.2 m, {given});
initial equation
  a.x = 0 m; a.y = 0 m; a.vx = 1 m/s; a.vy = 0 m/s; a.w = 0 rad/s;
  b.x = 1 m; b.y = 0.18 m; b.vx = -1 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
  annotation(experiment(StopTime = 1 s));
end Discs;
"""


@SPACES
@pytest.mark.parametrize(("e", "mu"), [(0.5, 0.0), (1.0, 0.0), (0.5, 0.1)])
def test_two_discs(spatial, e, mu):
    """They touch with the line of centres at asin(0.6); along it the speeds part with e, the impulse of friction is
    that times mu, as they slip all the time."""
    found = mbdsl.simulate(made(DISCS, spatial, given=f"e = {e}, mu = {mu}"), step=0.02)
    n, t = np.array([0.8, 0.6]), np.array([-0.6, 0.8])
    reduced = 1 / (1 + 1 / 2)
    P = (1 + e) * 1.6 * reduced
    slip = np.array([-2.0, 0.0]) @ t  # of b relative to a
    impulse = P * n - mu * P * np.sign(slip) * t
    v = {"a": np.array([1.0, 0.0]) - impulse, "b": np.array([-1.0, 0.0]) + impulse / 2}
    for name, own in v.items():
        np.testing.assert_allclose([found[f"{name}.v{i}"][-1] for i in "xy"], own, atol=1e-9)
    assert found["c.impulse"][-1] == pytest.approx(P)
    assert found["c.impacts"][-1] == 1.0
    momentum = found["a.vx"] + 2 * found["b.vx"], found["a.vy"] + 2 * found["b.vy"]
    np.testing.assert_allclose(momentum, np.outer([-1.0, 0.0], np.ones_like(found.t)), atol=1e-12)
    spin = -mu * P * np.sign(slip) * -1.0 * 0.1  # on a: friction -P_t at n r_a from its centre
    np.testing.assert_allclose(found["a.w"][-1], spin / 0.1 if mu else 0.0, atol=1e-9)
    if e == 1.0:
        np.testing.assert_allclose(found["energy.total"], 1.5, rtol=1e-12)


CRADLE = """
model Cradle
  Ground ground(g = 0);
  Body a(m = 1 kg, I = 1 kg.m2), b(m = 1 kg, I = 1 kg.m2), c(m = 1 kg, I = 1 kg.m2);
  Prismatic ra(ground, a.c), rb(ground, b.c), rc(ground, c.c);
  CircleContact ab(a.c, b.c, r_a = 0.5 m, r_b = 0.5 m, e = 1);
  CircleContact bc(b.c, c.c, r_a = 0.5 m, r_b = 0.5 m, e = 1, impacts = "LAW");
initial equation
  ra.s = -0.1 m; ra.v = 1 m/s; rb.s = 1 m; rb.v = 0 m/s; rc.s = 2 m; rc.v = 0 m/s;
end Cradle;
"""


@pytest.mark.parametrize(("law", "behind"), [("sequential", (0, 0, 1)), ("simultaneous", (-1 / 3, 2 / 3, 2 / 3))])
def test_balls_that_touch_pass_impacts_on_in_one_of_two_ways(law, behind):
    """The last one leaves; or at once: G P = (1 + e) (1, 0) with G = [[2, -1], [-1, 2]] gives P = (4/3, 2/3)."""
    found = mbdsl.simulate(mbdsl.parse(CRADLE.replace("LAW", law)), step=0.05, stop=0.5)
    np.testing.assert_allclose([found[f"r{k}.v"][-1] for k in "abc"], behind, atol=1e-9)


PILE = """
{of}model Pile
  Ground ground(frames(left = {{-2.2 m, 0{left}}}, right = {{2.2 m, 0{right}}}));
  PointMass a(m = 1 kg), b(m = 1 kg), c(m = 1 kg);
  PointContact fa(ground, a, radius = 1 m, e = 0{n}), fb(ground, b, radius = 1 m, e = 0{n});
  PointContact wa(ground.left, a, radius = 1 m, e = 0{nl}), wb(ground.right, b, radius = 1 m, e = 0{nr});
  CircleContact ac(a, c, r_a = 1 m, r_b = 1 m, e = 0), bc(b, c, r_a = 1 m, r_b = 1 m, e = 0);
initial equation
  a.x = -1.2 m; a.y = 1 m; b.x = 1.2 m; b.y = 1 m; c.x = 0 m; c.y = 2.6 m;
  a.vx = 0 m/s; a.vy = 0 m/s; b.vx = 0 m/s; b.vy = 0 m/s; c.vx = 0 m/s; c.vy = 0 m/s;
  annotation(experiment(StopTime = 0.2 s));
end Pile;
"""


@SPACES
def test_a_pile_between_walls(spatial):
    """The line of centres has the slope 4/3: N 0.8 = m g/2 for each; 0.6 N on walls, 1.5 m g on the floor."""
    plane = {"n": "", "nl": "", "nr": "", "left": ", -90 deg", "right": ", 90 deg"}
    space = {"n": ", n = {0, 1, 0}", "nl": ", n = {1, 0, 0}", "nr": ", n = {-1, 0, 0}", "left": ", 0", "right": ", 0"}
    found = mbdsl.simulate(made(PILE, spatial, **(space if spatial else plane)), step=0.01)
    N = G / 1.6
    for name, force in {"ac": N, "bc": N, "wa": 0.6 * N, "wb": 0.6 * N, "fa": 1.5 * G, "fb": 1.5 * G}.items():
        np.testing.assert_allclose(found[f"{name}.force"], force, rtol=1e-9)
        np.testing.assert_array_equal(found[f"{name}.active"], 1.0)
    np.testing.assert_allclose(found["c.y"], 2.6, atol=1e-9)


def test_contacts_as_one_asks(tmp_path, monkeypatch, capsys):
    """Rigid: the stiffness is ignored; compliant: each contact needs one."""
    from mbdsl.cli import main

    stiff = made(SLIDER, False, given="k = 1e6 N/m, e = 0.8, exponent = 1.5")
    rigid = mbdsl.simulate(stiff, contacts="rigid", step=0.01)
    own = mbdsl.simulate(made(SLIDER, False, given="e = 0.8"), step=0.01)
    np.testing.assert_array_equal(rigid["s.s"], own["s.s"])
    assert mbdsl.simulate(stiff, contacts="compliant", step=1e-3, stop=0.1).scene.contacts == ()
    with pytest.raises(ModelError, match=r":6:\d+: TranslationalStop `stop` has no stiffness"):
        mbdsl.simulate(made(SLIDER, False, given="e = 0.8"), contacts="compliant")
    with pytest.raises(UsageError, match="'soft', expected 'rigid' or 'compliant'"):
        mbdsl.simulate(stiff, contacts="soft")
    swept = mbdsl.sweep(
        stiff, {"b.m": [1, 2]}, "max(stop.impacts)", contacts="rigid", step=0.01, workers=1, store=tmp_path
    )
    np.testing.assert_array_equal(swept["max(stop.impacts)"], 3.0)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slider.mbd").write_text(SLIDER.format(of="", I="0.1 kg.m2", given="e = 0.8"), encoding="utf-8")
    assert main(["simulate", "slider.mbd", "--contacts", "compliant"]) == 2
    assert "slider.mbd:6:" in capsys.readouterr().err
    given = ["--contacts", "rigid", "--quiet", "--output", "a.csv", "--events", "events.csv"]
    assert main(["simulate", "slider.mbd", "--step", "0.01", *given]) == 0
    events = (tmp_path / "events.csv").read_text(encoding="utf-8")
    assert events.count("impact") == 3 and "slider.mbd:6" in events


@SPACES
def test_without_contact(spatial):
    scene = made(SLIDER, spatial, given="e = 0.8")
    found = mbdsl.simulate(scene, without=["contact"], step=0.01)
    np.testing.assert_allclose(found["s.s"], 0.5 + found.t, atol=1e-9)
    assert found.scene.without == {"contact": ("stop",)}


def test_from_python():
    b = mbdsl.Builder("Slider")
    ground, body = b.Ground("ground", g=0), b.Body("b", m=2, I=0.1)
    slide = b.Prismatic("s", ground, body.c)
    b.TranslationalStop("stop", ground, body.c, s_min=0, s_max=1, e=0.8)
    b.initial(slide.s, 0.5)
    b.initial(slide.v, 1.0)
    found = mbdsl.simulate(b, step=0.01, stop=5.0)
    own = mbdsl.simulate(made(SLIDER, False, given="e = 0.8"), step=0.01)
    np.testing.assert_array_equal(found["s.s"], own["s.s"])


def test_a_law_that_reads_impacts():
    """From the impact at 0.5 s on it is pushed away with 1 m/s2, back at 0.5 + 1.6 s."""
    law = "Force f(b.c, fx = if stop.impacts > 0 then 2 N else 0 N);\n  TranslationalStop stop"
    found = mbdsl.simulate(
        made(SLIDER.replace("TranslationalStop stop", law), False, given="e = 0.8"), step=0.01, stop=2.2
    )
    after = (found.t > 0.501) & (found.t < 2.099)
    np.testing.assert_allclose(found["s.v"][after], -0.8 + found.t[after] - 0.5, atol=1e-9)
    assert found["stop.impacts"][-1] == 2.0
    assert found["s.v"][-1] == pytest.approx(-0.8 * 0.8 + 0.1)


DOME = """
spatial model Dome
  Ground ground(n = {0, 0, -1});
  Body b(m = 1 kg, I = {0.4, 0.4, 0.4} kg.m2);
  FreeMotion free(ground, b.c);
  KIND;
initial equation
  b.x = 0 m; b.y = 0 m; b.z = 2 m; b.vx = 0.5 m/s; b.vy = 0 m/s; b.vz = 0 m/s;
  b.wx = 0 rad/s; b.wy = 0 rad/s; b.wz = 0 rad/s;
  annotation(experiment(StopTime = 3 s));
end Dome;
"""


@pytest.mark.parametrize(
    ("kind", "centre"),
    [
        ("CircleContact c(ground, b.c, r_a = 1 m, r_b = 1 m, e = 0)", (0, 0)),
        ("SphereCylinderContact c(ground, b.c, radius = 1 m, R = 1 m, length = 4 m, axis = {0, 1, 0}, e = 0)", (0, 0)),
        ("SphereCapsuleContact c(ground, b.c, radius = 1 m, R = 1 m, length = 4 m, axis = {0, 1, 0}, e = 0)", (0, 0)),
        ("SphereBoxContact c(ground, b.c, radius = 1 m, length = 1 m, width = 4 m, height = 2 m, e = 0)", (0.5, 1)),
    ],
    ids=["ball", "cylinder", "capsule", "box"],
)
def test_a_ball_leaves_a_round_body(kind, centre):
    """Without friction, where the slope of its path on a circle of the radius r has cos = 2/3 + v0^2/(3 g r)."""
    found = mbdsl.simulate(mbdsl.parse(DOME.replace("KIND", kind)), step=2e-3, interval=2e-3)
    k = int(np.flatnonzero(found["c.active"] == 0)[0])
    x, z = found["b.x"] - centre[0], found["b.z"] - centre[1]
    r = 2.0 - centre[1]
    expected = np.arccos(2 / 3 + 0.25 / (3 * G * r))
    assert np.arctan2(x[k - 1], z[k - 1]) - 1e-3 < expected < np.arctan2(x[k], z[k]) + 1e-3
    on = slice(0, k)
    np.testing.assert_allclose(np.hypot(np.maximum(x[on], 0.0), z[on]), r, atol=1e-8)
    np.testing.assert_allclose(found["energy.total"], found["energy.total"][0], rtol=1e-5)


BOWL = """
{of}model Bowl
  Ground ground;
  Body b(m = 1 kg, I = {I});
  FreeMotion free(ground, b.c);
  CircleContact c(ground, b.c, r_a = 0.6 m, r_b = 0.1 m, internal = true, e = 0, mu = 0.5);
initial equation
  b.x = 0.3 m; b.y = -0.4 m; b.vx = 0 m/s; b.vy = 0 m/s;
  annotation(experiment(StopTime = 1.5 s));
end Bowl;
"""


@SPACES
def test_a_ball_rolls_in_a_bowl(spatial):
    """(1 + c) v^2/2 = g (y0 - y) with I = c m r^2; N = m (v^2/R - g y/R) on the circle of its centre, R = 0.5 m."""
    text = BOWL.replace("{I}", "{{0.004, 0.004, 0.004}} kg.m2" if spatial else "0.004 kg.m2")
    found = mbdsl.simulate(made(text, spatial), step=1e-3)
    square, y = found["b.vx"] ** 2 + found["b.vy"] ** 2, found["b.y"]
    np.testing.assert_allclose(1.4 * square / 2, G * (-0.4 - y), atol=2e-5)
    np.testing.assert_allclose(found["c.force"], (square - G * y) / 0.5, atol=1e-3)
    np.testing.assert_allclose(np.abs(found["b.w"]), np.sqrt(square) / 0.1, atol=1e-4)
    np.testing.assert_array_equal(found["c.active"], 1.0)
    np.testing.assert_allclose(np.abs(found["c.friction_force"]), 2 / 7 * G * np.abs(found["b.x"]) / 0.5, atol=1e-3)


CAM = """
model Cam
  Ground ground(g = 0);
  Frame up(ground, phi = 90 deg);
  Body cam(m = 1 kg, I = 1 kg.m2), f(m = 2 kg, I = 1 kg.m2);
  Revolute axis(ground, cam.c);
  RotationalVelocityDriver drive(axis, w = 100 rad/s);
  Prismatic guide(up, f.c);
  TranslationalSpringDamper spring(guide, k = 1000 N/m, s0 = -0.1 m);
  ProfileContact c(cam.c, f.c, points = {{-0.04, 0}, {0.06, 0}} m, arcs = {0.05, 0.05} m, radius = 10 mm, e = 0);
initial equation
  axis.phi = 0; guide.s = 0.0035^0.5*(1 m); guide.v = 1 m/s;
  annotation(experiment(StopTime = 12 ms));
end Cam;
"""


def test_a_roller_lifts_off_an_eccentric():
    """y = e sin(phi) + r, r = (R^2 - e^2 cos(phi)^2)^(1/2), is its path; N cos(a) = m y'' + k (y - s0), with
    sin(a) = e cos(phi)/R, and r'' = e^2 cos(2 phi)/r - (e^2 sin(phi) cos(phi))^2/r^3 by phi."""
    from scipy.optimize import brentq

    found = mbdsl.simulate(mbdsl.parse(CAM), step=1e-5, interval=2e-5)

    def y(phi):
        return 0.01 * np.sin(phi) + np.sqrt(0.06**2 - (0.01 * np.cos(phi)) ** 2)

    def force(phi):
        r, rate = y(phi) - 0.01 * np.sin(phi), 1e-4 * np.sin(phi) * np.cos(phi)
        second = -0.01 * np.sin(phi) + 1e-4 * np.cos(2 * phi) / r - rate**2 / r**3
        return (2 * second * 1e4 + 1000 * (y(phi) + 0.1)) / np.cos(np.arcsin(np.cos(phi) / 6))

    leaves = brentq(force, 0.5, 1.2) / 100
    k = int(np.flatnonzero(found["c.active"] == 0)[0])
    assert found.t[k - 1] - 1e-6 < leaves < found.t[k] + 1e-6
    np.testing.assert_allclose(found["guide.s"][:k], y(100 * found.t[:k]), atol=1e-9)
    np.testing.assert_allclose(found["c.force"][:k], force(100 * found.t[:k]), rtol=0, atol=1e-4)


@pytest.mark.parametrize("given", ["e = 0", "k = 1e8 N/m, v_0 = 1 m/s"], ids=["rigid", "stiff"])
def test_a_flat_follower_lifts_off_an_eccentric(given):
    """y = e sin(phi) + R on its cam, and N = m y'' + k (y - s0), until it is zero; the cam carries N e cos(phi)."""
    text = CAM.replace("radius = 10 mm, e = 0", "flat = true, " + given)
    text = text.replace("f(m = 2 kg, I = 1 kg.m2)", "f(m = 2 kg, I = 1 kg.m2, frames(face = {0, 0, -90 deg}))")
    text = text.replace("c(cam.c, f.c,", "c(cam.c, f.face,").replace(
        "0.0035^0.5*(1 m)", "50 mm" if "e = 0" in given else "50 mm - 150 N/(1e8 N/m)"
    )
    found = mbdsl.simulate(mbdsl.parse(text), step=1e-5, interval=2e-5)
    leaves = np.arcsin(1000 * 0.15 / (0.01 * (2 * 1e4 - 1000))) / 100
    k = int(np.flatnonzero(found["c.active"] == 0)[0])
    phi, close = 100 * found.t[:k], 1e-9 if "e = 0" in given else 5e-6
    assert leaves == pytest.approx(found.t[k], abs=2.1e-5 if "e = 0" in given else 3e-4)
    np.testing.assert_allclose(found["guide.s"][:k], 0.05 + 0.01 * np.sin(phi), atol=close)
    if "e = 0" in given:
        N = 1000 * (0.15 + 0.01 * np.sin(phi)) - 2 * 100 * np.sin(phi)
        np.testing.assert_allclose(found["c.force"], np.append(N, np.zeros(len(found.t) - k)), atol=1e-4)
        np.testing.assert_allclose(found["drive.tau"][:k], N * 0.01 * np.cos(phi), atol=1e-5)


BOX = """
{of}model Box
  Ground ground;
  Body b(m = 1 kg, I = {I});
  FreeMotion free(ground, b.c);
  BoxContact c(ground, b.c, length = 1 m, width = 1 m, {more}e = 0.4, mu = 0.3);
initial equation
  b.x = 0 m; b.y = 0.6 m; b.vx = 1 m/s; b.vy = 0 m/s; b.phi = 0; b.w = 0 rad/s;
  annotation(experiment(StopTime = 0.7 s));
end Box;
"""


@pytest.mark.parametrize(
    ("spatial", "options", "close"),
    [(False, {"step": 0.01}, 1e-7), (True, {"method": "moreau-jean", "step": 2e-3}, 1e-3)],
    ids=["plane", "space"],
)
def test_a_box_lands_flat_and_slides_to_rest(spatial, options, close):
    """Each impact takes mu (1 + e) u of its speed, u being that of the fall; on its feet N = m g, and nothing slips."""
    found = mbdsl.simulate(made(BOX, spatial, more="height = 1 m, n = {0, 1, 0}, " * spatial), **options)
    u, v, x = np.sqrt(2 * G * 0.1), 1.0, np.sqrt(2 * 0.1 / G)
    while u > 1e-12:
        v, u = max(v - 0.3 * 1.4 * u, 0.0), 0.4 * u
        x += v * 2 * u / G
    x += v * v / (2 * 0.3 * G)
    assert found["b.x"][-1] == pytest.approx(x, abs=close)
    assert found["b.y"][-1] == pytest.approx(0.5, abs=close)
    assert found["c.force"][-1] == pytest.approx(G, rel=1e-6)
    assert found["b.vx"][-1] == pytest.approx(0.0, abs=1e-9)


NOTCH = """
model Notch
  Ground ground;
  Body b(m = 1 kg, I = 0.02 kg.m2);
  ProfileContact c(ground, b.c, points = POINTS m, radius = 0.2 m, e = 0.3);
initial equation
  b.x = 0.1 m; b.y = 0.6 m; b.phi = 0; b.vx = 0 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
  annotation(experiment(StopTime = 1 s));
end Notch;
"""
BLOCK = "{{-1, 1}, {0, 0}, {1, 1}, {1, -1}, {-1, -1}}"
HOLE = "{{0, 0}, {1, 1}, {0, 2}, {-1, 1}}"


@pytest.mark.parametrize("points", [BLOCK, HOLE + " m, hole = true, arcs = {0, 0, 0, 0}"], ids=["block", "hole"])
@pytest.mark.parametrize(
    ("options", "close"), [({"step": 1e-3}, 1e-9), ({"method": "moreau-jean", "step": 2e-3}, 2e-3)], ids=["", "moreau"]
)
def test_a_ball_comes_to_rest_in_a_notch(points, options, close):
    """It falls onto a wall of 45 deg, from a distance d = 0.5 m/2^(1/2) - r, after (2^(3/2) d/g)^(1/2); at rest both
    walls carry m g/2^(1/2)."""
    found = mbdsl.simulate(mbdsl.parse(NOTCH.replace("POINTS", points)), interval=1e-3, **options)
    first = np.sqrt(2**1.5 * (0.5 / np.sqrt(2) - 0.2) / G)
    assert found.t[np.flatnonzero(found["c.impacts"])[0]] == pytest.approx(first, abs=2e-3 + close)
    assert found["b.y"][-1] == pytest.approx(0.2 * np.sqrt(2), abs=close) and abs(found["b.x"][-1]) < close
    assert found["c.active"][-1] == 2.0
    assert sorted(x for i in (1, 2) if (x := found[f"c.force_{i}"][-1]))[-1] == pytest.approx(G / np.sqrt(2), rel=1e-6)
    assert found["c.force"][-1] == pytest.approx(G * np.sqrt(2), rel=1e-6)


@pytest.mark.parametrize("turn", [1, 6])
def test_a_flat_face_along_a_straight_side_touches_it(turn):
    """Sides of a stadium of width 20 mm, whose smooth joins have rounding: no direction lies between two pieces."""
    al = np.radians(turn)
    R = np.array([[np.cos(al), -np.sin(al)], [np.sin(al), np.cos(al)]])
    points = [(R @ p).tolist() for p in ((-0.02, -0.01), (0.02, -0.01), (0.02, 0.01), (-0.02, 0.01))]
    pairs = ", ".join(f"{{{x!r}, {y!r}}}" for x, y in points)
    for off in np.arange(-4, 2) * 1.6e-16:
        run = mbdsl.simulate(
            mbdsl.parse(f"""
model Face
  Ground ground(g = 0 m/s2);
  Body b(m = 1 kg, I = 1e-3 kg.m2);
  ProfileContact c(ground, b.c, points = {{{pairs}}} m, arcs = {{0, 0.01, 0, 0.01}} m, flat = true, e = 0);
initial equation
  b.x = {-0.02 * np.sin(al):.17g} m; b.y = {0.02 * np.cos(al):.17g} m; b.phi = {al + off:.17g};
  b.vx = 0 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
end Face;
"""),
            step=1e-3,
            stop=1e-3,
        )
        assert run["c.gap"][0] == pytest.approx(0.01, abs=1e-9)


DROPPED = """
spatial model Dropped
  Ground ground(frames(plane(r = {0, 0, 0} m)));
  Box crate(m = 4 kg, length = 0.3 m, width = 0.2 m, height = 0.25 m);
  FreeMotion free(ground, crate.c);
  BoxContact floor(
    ground.plane, crate.c, length = 0.3 m, width = 0.2 m, height = 0.25 m, n = {0, 1, 0}, e = 0.3, mu = 0.4);
initial equation
  crate.x = 0 m; crate.y = 0.8 m; crate.z = 0 m; crate.phi_x = 20 deg; crate.phi_y = 15 deg; crate.phi_z = 10 deg;
  crate.vx = 0.3 m/s; crate.vy = 0 m/s; crate.vz = 0.2 m/s; crate.wx = 1 rad/s; crate.wy = 0 rad/s; crate.wz = 2 rad/s;
  annotation(experiment(StopTime = 0.9 s));
end Dropped;
"""


def test_a_box_tumbles_in_space_and_comes_to_rest_on_a_face(optimised):
    """It rests on one of its faces, its energy never grows, and friction stops it where Moreau's method does, whose
    pose with h = 0.1 ms is given: impacts of four corners amplify errors."""
    found = mbdsl.simulate(mbdsl.parse(DROPPED), method="hht-si2", step=1e-3)
    assert found["crate.y"][-1] == pytest.approx(0.15, abs=1e-9)
    assert max(abs(found[f"crate.{x}"][-1]) for x in ("vx", "vy", "vz", "wx", "wy", "wz")) < 1e-12
    assert np.diff(found["energy.total"]).max() < 1e-6 * found["energy.total"][0]
    assert found["crate.x"][-1] == pytest.approx(-0.0894, abs=6e-3)
    assert found["crate.z"][-1] == pytest.approx(-0.0044, abs=6e-3)
    assert found["crate.p0"][-1] == pytest.approx(0.6500, abs=2e-3)
    assert found["crate.p1"][-1] == pytest.approx(0.2785, abs=2e-3)


def test_arrays_of_other_shapes_differ():
    """A contact that sticks in space has a row more than one that slides."""
    assert not alike(np.zeros(4), np.zeros(6))
    assert alike(np.ones(4), np.ones(4) + 1e-12)
