"""Couplings and planetary gears against closed forms, in the plane and in space; springs and torques in given axes.

Lagrange's equations of the coupled coordinates: with b = r a + u(t), (I_a + r^2 I_b) a'' = Q_a + r (Q_b - I_b u''), and
the generalised force on b is I_b (r a'' + u'') - Q_b.
"""

import re

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError, ModelError

BOTH = pytest.mark.parametrize("spatial", [False, True], ids=["plane", "space"])
G = 9.81


def model(text, spatial):
    """A planar model, or the same one in space."""
    return mbdsl.parse(f"{'spatial ' if spatial else ''}model M\n{text}\nend M;")


SHAFTS = """  Ground ground(g = 0);
  Body a(m = 1, I = 0.2);  Body b(m = 2, I = 0.5);
  Revolute pa(ground, a.c);  Revolute pb(ground, b.c);"""


@BOTH
def test_shafts_with_an_offset_that_varies(spatial):
    scene = model(
        SHAFTS + "Coupling g(pa.phi, pb.phi, ratio = -3, offset = 0.1 rad*sin(2*time)); Torque t(pa, tau = 1);", spatial
    )
    run = mbdsl.simulate(scene, stop=2.0, tol=1e-8)
    t, inertia = run.t, 0.2 + 9 * 0.5
    u2 = -0.4 * np.sin(2 * t)
    a2 = (1.0 + 3 * 0.5 * u2) / inertia
    # the start has the rate of the offset: a' = 0 is not possible for both; b' + 3 a' = 0.2
    a1 = run["pa.w"][0] + t / inertia - 1.5 * 0.2 * (1 - np.cos(2 * t)) / inertia
    np.testing.assert_allclose(run["pa.w"], a1, atol=1e-6)
    np.testing.assert_allclose(run["pb.phi"] + 3 * run["pa.phi"], 0.1 * np.sin(2 * t), atol=1e-9)
    np.testing.assert_allclose(run["g.force"], 0.5 * (-3 * a2 + u2), atol=1e-6)
    expected = {"a": "rad", "b": "rad", "offset": "rad", "force": "N.m", "ratio": "1"}
    assert scene.components["g"].units == expected


@BOTH
@pytest.mark.parametrize("method", ["hht-si2", "generalized-alpha-i3", "hht-add", "radau5", "dop853"])
def test_a_load_on_a_rope(spatial, method):
    """An angle and a position: s = r phi, with (I/r^2 + m) s'' = -m g, whatever the method."""
    up = (
        "Prismatic guide(ground, load.c, n = {0, 1, 0});"
        if spatial
        else "Frame up(ground, phi = 90 deg); Prismatic guide(up, load.c, phi0 = -90 deg);"
    )
    text = f"Ground ground; Body drum(m = 2, I = 0.02); Body load(m = 5, I = 1); Revolute pin(ground, drum.c); {up}"
    run = mbdsl.simulate(
        model(text + "Coupling rope(pin.phi, guide.s, ratio = 80 mm);", spatial), step=1e-3, stop=1.0, method=method
    )
    s2 = -5 * G / (5 + 0.02 / 0.08**2)
    np.testing.assert_allclose(run["guide.s"], s2 * run.t**2 / 2, atol=1e-9)
    np.testing.assert_allclose(run["pin.phi"], run["guide.s"] / 0.08, atol=1e-9)  # 10 turns
    np.testing.assert_allclose(run["rope.force"], 5 * (G + s2), atol=1e-6)
    assert run["pin.phi"][-1] < -6 * np.pi


def test_a_differential_of_an_expression():
    """The case has the mean angle of both shafts, and they get the same torque, -1/2 of that on the case."""
    text = """Ground ground(g = 0); Body l(m = 1, I = 0.1); Body r(m = 1, I = 0.4); Body c(m = 1, I = 0.3);
      Revolute left(ground, l.c); Revolute right(ground, r.c); Revolute case(ground, c.c);
      Coupling d(0.5*(left.phi + right.phi), case.phi); Torque motor(case, tau = 2);"""
    run = mbdsl.simulate(model(text, False), step=1e-3, stop=0.5)
    # I_l l'' = T/2 = I_r r'', c'' = (l'' + r'')/2, I_c c'' = 2 - T
    T = 2 / (1 + 0.3 * (1 / 0.1 + 1 / 0.4) / 4)
    np.testing.assert_allclose(run["left.w"], T / 2 / 0.1 * run.t, atol=1e-9)
    np.testing.assert_allclose(run["right.w"], T / 2 / 0.4 * run.t, atol=1e-9)
    np.testing.assert_allclose(run["d.force"], -T, rtol=1e-8)


STAGE = """Ground ground(g = 0); Body housing(m = 1, I = 1); Revolute base(ground, housing.c);
  Body s(m = 1, I = 0.01); Body c(m = 1, I = 0.2); Body r(m = 1, I = 0.05);
  Revolute sun(housing.c, s.c); Revolute carrier(housing.c, c.c); Revolute ring(housing.c, r.c);
  PlanetaryGear stage(sun.phi, carrier.phi, ring.phi, ratio = 70/30);"""


@BOTH
def test_willis(spatial):
    """w_s + (z_r/z_s) w_r = (1 + z_r/z_s) w_c, and the torques 1 : z_r/z_s : -(1 + z_r/z_s), with no rest."""
    drives = (
        "RotationalDriver dr(ring, phi = 3*time); RotationalDriver dc(carrier, phi = (40 + time/(1 s))*time*(1 rad/s));"
    )
    run = mbdsl.simulate(
        model(STAGE + drives + "RotationalDriver db(base, phi = (time/(1 s))^2);", spatial), step=1e-3, stop=1.0
    )
    i = 70 / 30
    np.testing.assert_allclose(run["sun.phi"], (1 + i) * (40 * run.t + run.t**2) - i * 3 * run.t, atol=1e-8)
    tau = 0.01 * ((1 + i) * 2 + 2)  # of the sun, whose angle in the world is that of its pin plus that of the housing
    np.testing.assert_allclose(run["stage.tau_sun"], tau, atol=1e-7)
    np.testing.assert_allclose(run["stage.tau_ring"], i * tau, atol=1e-7)
    np.testing.assert_allclose(run["stage.tau_carrier"], -(1 + i) * tau, atol=1e-7)


@BOTH
def test_static_modes_and_linear_model(spatial):
    text = """Ground ground; Body a(m = 1, I = 0.2); Body b(m = 1.5, I = 0.5);
      Revolute pa(ground, a.c); Prismatic pb(ground, b.c); input Real F(unit = "N"); Force f(b.c, fx = F);
      RotationalSpringDamper k(pa, k = 20); TranslationalSpringDamper ks(pb, k = 100, c = 1);
      Coupling g(pa.phi, pb.s, ratio = 0.3 m/rad, offset = 0.2 m);"""
    scene = model(text, spatial)
    m, c, k = 0.2 + 0.09 * 1.5, 0.09, 20 + 0.09 * 100
    found = mbdsl.static(scene)
    assert found["pa.phi"] == pytest.approx(-0.3 * 100 * 0.2 / k, rel=1e-9)
    assert found["g.force"] == pytest.approx(-20 * found["pa.phi"] / 0.3, rel=1e-9)  # ratio*force turns the spring
    linear = mbdsl.linearise(scene)
    np.testing.assert_allclose(linear.A, [[0, 1], [-k / m, -c / m]], atol=1e-9)
    np.testing.assert_allclose(linear.B[1], 0.3 / m)
    (mode,) = mbdsl.eigen(scene).modes
    assert abs(mode.eigenvalue - np.roots([m, c, k])).min() < 1e-7


NONLINEAR = """Ground ground;
  Body housing(m = 3, I = {0.2, 0.3, 0.25}, com = {0, 0, -0.4});
  Body x(m = 1, I = {0.03, 0.02, 0.04}, com = {0, 0, 0.1}); Body y(m = 2, I = {0.04, 0.05, 0.08});
  Spherical ball(ground, housing.c); Revolute px(housing.c, x.c, n = {1, 0, 0});
  Revolute py(housing.c, y.c, n = {0, 1, 0});"""


@pytest.mark.parametrize("method", ["dop853", "hht-si2", "hht-add"])
def test_a_nonlinear_coupling_is_its_constraint_of_velocities(method):
    """On a housing that tumbles, b = f(a) + u(t) has the motion of b' = f'(a) a' + u'(t)."""
    start = "initial equation px.w = 20; housing.wx = 1; housing.wy = 0.5;"
    first = f"Coupling g(px.phi + 0.2*sin(px.phi), py.phi, ratio = 0.5, offset = 0.3*sin(3*time)); {start}"
    second = f"VelocityConstraint g(gamma = py.w - 0.5*px.w*(1 + 0.2*cos(px.phi)) - 0.9*cos(3*time)); {start}"
    given = {"stop": 0.25, "interval": 0.05}
    expected = mbdsl.simulate(model(NONLINEAR + second, True), method="dop853", step=1e-3, **given)
    found = mbdsl.simulate(model(NONLINEAR + first, True), method=method, step=5e-4, **given)
    for name in ("px.phi", "py.phi", "housing.wz"):
        np.testing.assert_allclose(found[name], expected[name], atol=1e-7 if method == "dop853" else 2e-4)
    for name in ("g.Phi[1]", "g.dPhi[1]"):
        np.testing.assert_allclose(found[name], 0.0, atol=1e-9)


def test_a_redundant_coupling_in_space_counts_turns():
    """Half a turn between outputs, and a start after several turns: the coupling that is left out stays satisfied."""
    text = """Ground ground; Body a(m = 1, I = 0.2); Body b(m = 1, I = 0.2); Body c(m = 1, I = 0.2);
      Revolute pa(ground, a.c, n = {1, 0, 0}); Revolute pb(ground, b.c, n = {0, 1, 0});
      Revolute pc(ground, c.c, n = {0, 0, 1}); RotationalDriver d(pa, phi = 400 deg + 20*time);
      Coupling ab(pa.phi, pb.phi, ratio = 2); Coupling bc(pb.phi, pc.phi, ratio = 3);
      Coupling ac(pa.phi, pc.phi, ratio = 6);"""
    run = mbdsl.simulate(model(text, True), step=1e-3, stop=0.3)
    np.testing.assert_allclose(run["pc.phi"], 6 * (np.radians(400) + 20 * run.t), atol=1e-8)
    np.testing.assert_allclose(run["ac.Phi[1]"], 0.0, atol=1e-8)


def test_inconsistent_values_name_the_coupling():
    with pytest.raises(InitialisationError) as problem:
        mbdsl.simulate(
            model(SHAFTS + "Coupling g(pa.phi, pb.phi, ratio = 2); initial equation pa.phi = 1; pb.phi = 1;", False),
            stop=1,
        )
    assert any("Coupling g is violated" in text for text, _ in problem.value.notes)


@BOTH
def test_a_bushing_in_axes_of_the_world(spatial):
    """Two free bodies that spin: their relative motion is that of the reduced mass along x and y."""
    spin = "a.wz = 3; b.wz = -2; b.wx = 1;" if spatial else "a.w = 3; b.w = -2;"
    I = ("{0.1, 0.2, 0.15}", "{0.3, 0.2, 0.2}") if spatial else ("0.1", "0.2")
    text = f"""Ground ground(g = 0); Body a(m = 2, I = {I[0]}); Body b(m = 3, I = {I[1]});
      FreeMotion fa(ground, a.c); FreeMotion fb(ground, b.c);
      Bushing s(a.c, b.c, k = {{50, 120}}, c = {{0.5, 0}}, axes = "world");
      initial equation a.x = 0; a.y = 0; b.x = 0.1; b.y = 0.2; a.vx = 0; a.vy = 0; b.vx = 0; b.vy = 0; {spin}"""
    run = mbdsl.simulate(model(text, spatial), stop=1.0, tol=1e-8)
    t, mu = run.t, 6 / 5
    d, w = 0.5 / mu / 2, np.sqrt(50 / mu - (0.25 / mu) ** 2)
    np.testing.assert_allclose(run["s.y"], 0.2 * np.cos(np.sqrt(120 / mu) * t), atol=1e-7)
    x = 0.1 * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t))
    np.testing.assert_allclose(run["s.x"], x, atol=1e-7)
    np.testing.assert_allclose(run["b.x"] - run["a.x"], x, atol=1e-7)


def test_a_torque_about_an_axis_of_the_body():
    """Euler's equations of a ball: a torque about the x axis of the body changes its local wx alone."""
    text = """Ground ground(g = 0); Body a(m = 2, I = 0.2); FreeMotion f(ground, a.c);
      Torque t(a.c, tau = 0.4, n = {1, 0, 0}, axes = "frame_b");
      initial equation a.wx = 0; a.wy = 0; a.wz = 2;"""
    run = mbdsl.simulate(model(text, True), stop=1.0, tol=1e-8)
    np.testing.assert_allclose(run["a.wx_local"], 2 * run.t, atol=1e-7)
    np.testing.assert_allclose(run["a.wy_local"], 0, atol=1e-7)
    np.testing.assert_allclose(run["a.wz_local"], 2, atol=1e-7)


def test_a_torque_about_an_axis_of_a_body_that_turns_in_a_plane():
    """The axis z of the frame points against that of the hinge: the torque is negative."""
    text = """Ground ground(g = 0); Body a(m = 2, I = 0.2); Revolute p(ground, a.c);
      Frame down(a.c, r = {0, 0, 0}, n = {1, 0, 0}, phi = 180 deg); Torque t(down, tau = 0.4, axes = "frame_b");"""
    run = mbdsl.simulate(model(text, True), stop=1.0, step=0.01)
    np.testing.assert_allclose(run["p.w"], -2 * run.t, atol=1e-9)


MASSLESS = """  Ground ground(g = 0);
  Frame far(ground, r = {2, 0});
  Body b(m = 1, I = 0.5);
  Prismatic pb(ground, b.c);
  PointMass p(m = 0);
  SpringDamper s1(ground, p, k = 100 N/m, s0 = 0.1 m);
  SpringDamper s2(p, b.c, k = 300 N/m, s0 = 0.1 m);
  SpringDamper s3(b.c, far, k = 75 N/m, s0 = 0.2 m);
initial equation
  pb.s = 1.2;"""


@BOTH
def test_the_advice_about_a_massless_point_between_springs(spatial):
    """Two springs are one of 75 N/m: with the third one of 75 N/m, an oscillation of 1 kg about 1 m."""
    with pytest.raises(InitialisationError, match="p can move without moving a mass") as problem:
        mbdsl.simulate(model(MASSLESS, spatial), stop=1.0)
    hint = problem.value.hint
    (spring,) = re.findall(r"write `(SpringDamper s1.*?;)` in place of `s1`, `s2` and `p`", hint)
    ((m, c),) = re.findall(r"`m = (.*?)` and `c = (.*?)` in `s1`, `s2`", hint)
    one = re.sub(r"  PointMass.*\n|  SpringDamper s2.*\n", "", MASSLESS)
    one = re.sub(r"SpringDamper s1.*;", spring, one)
    small = MASSLESS.replace("m = 0)", f"m = {m})").replace("s0 = 0.1 m", f"s0 = 0.1 m, c = {c}")
    for text, tolerance in ((one, 1e-5), (small + " p.x = 0.8;", 0.01)):
        run = mbdsl.simulate(model(text, spatial), stop=0.5, tol=1e-5)
        np.testing.assert_allclose(run["pb.s"], 1 + 0.2 * np.cos(np.sqrt(150) * run.t), atol=tolerance * 0.2)


SLIDE = """Ground ground; PointMass p(m = 0); Body b(m = 1, I = 1); Prismatic one(ground, p); Prismatic pb(ground, b.c);
  TranslationalSpringDamper s1(one, k = 100, s0 = 0.1); TranslationalSpringDamper s2(p, b.c, k = 300, s0 = 0.1);
initial equation
  p.x = 0.1 + 0.15; b.x = 0.4;"""


def test_a_massless_point_on_a_slide():
    """`simulate` names it as `check` does; radau5 solves it: one spring of 75 N/m, of 0.2 m."""
    with pytest.raises(mbdsl.IntegrationError, match="p can move without moving a mass") as problem:
        mbdsl.simulate(model(SLIDE, False), stop=0.1, method="hht-si2")
    assert "give it a mass" in problem.value.hint
    assert "p can move without moving a mass" in str(mbdsl.check(model(SLIDE, False)))
    run = mbdsl.simulate(model(SLIDE, False), stop=0.5, method="radau5", tol=1e-6)
    np.testing.assert_allclose(run["pb.s"], 0.2 + 0.2 * np.cos(np.sqrt(75) * run.t), atol=1e-5)


def test_a_coupling_with_a_constant_offset_is_no_driver():
    text = """Ground ground; Rod a(m = 1, length = 1); Rod b(m = 1, length = 1); Revolute A(ground, a.a);
      Revolute B(ground, b.a); Coupling gear(A.phi, B.phi, ratio = -2, offset = {offset});"""
    for offset, drives in (("0", False), ("30 deg", False), ("sin(1 rad/s*time)", True)):
        found = mbdsl.explain(model(text.replace("{offset}", offset), False), measured=False)
        assert [e.present for e in found.entries if e.effect == "drivers"] == [drives]


def test_a_massless_point_that_joints_hold():
    """A pendulum of two rods without mass and a point without mass between them, in line: one pendulum."""
    text = """Ground ground; PointMass p(m = 0); Body b(m = 2, I = 0.1); Revolute pin(ground, b.c);
      Distance one(ground, p, length = 0.3); Distance two(p, tip, length = 0.5); Frame tip(b.c, r = {0.4, 0});"""
    run = mbdsl.simulate(model(text, False), stop=0.1, step=1e-3)
    assert np.hypot(run["p.x"], run["p.y"]) == pytest.approx(0.3 * np.ones_like(run.t), abs=1e-9)


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("ratio = 3 m", r"`ratio` of Coupling `g`: found a length \[m\], expected a pure number"),
        ("offset = 3 m", r"`offset` of Coupling `g`: found a length \[m\], expected a pure number"),
        ("ratio = 0", "its ratio is zero"),
    ],
)
def test_units_are_checked(written, message):
    with pytest.raises(ModelError, match=message):
        model(SHAFTS + f"Coupling g(pa.phi, pb.phi, {written});", False)


def test_from_python():
    b = mbdsl.Builder("Lift")
    ground = b.Ground("ground")
    drum, load = b.Body("drum", m=2, I=0.02), b.PointMass("load", m=5)
    pin, guide = b.Revolute("pin", ground, drum.c), b.Prismatic("guide", b.frame("up", ground, phi="90 deg"), load)
    b.Coupling("rope", pin.phi, guide.s, ratio="80 mm")
    run = mbdsl.simulate(b, step=1e-3, stop=0.2)
    assert run["guide.s"] == pytest.approx(-5 * G / (5 + 0.02 / 0.08**2) * run.t**2 / 2, abs=1e-9)
    assert b.remove("pin", dependents=True) == ("pin", "rope")
