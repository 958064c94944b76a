"""Friction in joints of models in space, driven by the joint's own reaction, against solutions by hand."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import mbdsl

#: one of index 3, and those whose forces take the reaction of another set of multipliers, or of BDF
METHODS = ("hht-i3", "hht-add", "hht-si2", "nstiff-si2")
G = 9.81

# -- a rod on a hinge that is neither horizontal nor vertical ----------------------------------------------------------

M, L, MU, R, W_S = 2.0, 0.8, 0.3, 0.05, 0.2
AXIS = np.array([0.6, 0.0, 0.8])
HINGE = f"""
spatial model Hatch
  Ground ground(g = {G}, n = {{0, 0, -1}});
  Body rod(m = {M}, length = {L}, I = {{0.01, {M * L**2 / 12}, {M * L**2 / 12}}});
  Revolute pin(ground, rod.a, n = {{0.6, 0, 0.8}}, mu = {MU}, radius = {R}, w_s = {W_S});
initial equation
  pin.phi = 1 rad;
  pin.w = 0.5 rad/s;
end Hatch;
"""


def acceleration(phi, w):
    """alpha about the hinge and the size of the reaction, from moments about the hinge and the motion of the centre.

    The hinge's axis is not normal to the rod: it describes a cone."""
    turn = np.cos(phi) * np.eye(3) + (1 - np.cos(phi)) * np.outer(AXIS, AXIS)
    turn += np.sin(phi) * np.array([[0, -AXIS[2], AXIS[1]], [AXIS[2], 0, -AXIS[0]], [-AXIS[1], AXIS[0], 0]])
    c, weight = turn @ (L / 2, 0.0, 0.0), M * np.array([0.0, 0.0, -G])
    n = np.diag([0.01, M * L**2 / 12, M * L**2 / 12])
    inertia = AXIS @ n @ AXIS + M * (c @ c - (AXIS @ c) ** 2)  # the axis is the same in the body

    def reaction(alpha):
        a = alpha * np.cross(AXIS, c) + w * w * np.cross(AXIS, np.cross(AXIS, c))
        return np.linalg.norm(M * a - weight)

    def balance(alpha):
        return inertia * alpha - AXIS @ np.cross(c, weight) + MU * R * reaction(alpha) * np.tanh(w / W_S)

    alpha = brentq(balance, -200.0, 200.0, xtol=1e-13, rtol=1e-14)
    return alpha, reaction(alpha)


@pytest.fixture(scope="module")
def exact():
    end = solve_ivp(
        lambda t, y: [y[1], acceleration(*y)[0]], (0, 1), [1.0, 0.5], method="DOP853", rtol=1e-11, atol=1e-13
    ).y[:, -1]
    return np.array([*end, acceleration(*end)[1]])


def at_end(text, **given):
    t = mbdsl.simulate(mbdsl.parse(text), stop=1.0, interval=1.0, **given)
    return np.array([t["pin.phi"][-1], t["pin.w"][-1], np.linalg.norm([t[f"pin.f{i}"][-1] for i in "xyz"])])


@pytest.mark.parametrize("method", METHODS)
def test_a_hinge_has_the_order_of_the_method(method, exact):
    coarse, fine = (np.abs(at_end(HINGE, method=method, step=2.0**-k) - exact) for k in (11, 12))
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.1)


def test_explicit_steps_with_a_tolerance(exact):
    """Where forces depend on reactions, dop853 iterates; the tolerance bounds the error of positions [rad]."""
    assert np.abs(at_end(HINGE, method="dop853", tol=1e-9) - exact).max() < 1e-7


# -- a block on a slope ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["Prismatic", "PointOnLine"])
@pytest.mark.parametrize("azimuth", [0.0, 1.1])
def test_a_block_on_a_slope(kind, azimuth):
    """s = v0 t + g (sin b - mu cos b) t^2/2, whatever the direction of the slope; tanh(v/v_s) is 1 up to 1e-17.

    The acceleration is constant, for which the method is exact: the bound is Newton's iteration."""
    slope, mu, v0 = 0.7, 0.3, 0.5
    n = np.array([np.cos(slope) * np.cos(azimuth), np.cos(slope) * np.sin(azimuth), -np.sin(slope)])
    axis = ", ".join(f"{x:.17g}" for x in n)
    text = f"""spatial model Slope
      Ground ground(g = {G}, n = {{0, 0, -1}});
      Body block(m = 3 kg, I = {{1, 2, 3}} kg.m2);
      {kind} guide(ground, block.c, n = {{{axis}}}, mu = {mu}, v_s = 0.02 m/s);
    initial equation
      guide.s = 0 m;
      guide.v = {v0} m/s;
    end Slope;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-2, stop=1.0, interval=0.1)
    a = G * (np.sin(slope) - mu * np.cos(slope))
    np.testing.assert_allclose(t["guide.s"], v0 * t.t + a * t.t**2 / 2, rtol=0, atol=1e-8)
    np.testing.assert_allclose(t["guide.friction"], mu * 3.0 * G * np.cos(slope), rtol=1e-7)


# -- sliding in more than one direction --------------------------------------------------------------------------------


def slid(joint, start, bodies="Body body(m = 2 kg, I = {{0.5, 0.5, 0.5}} kg.m2)", g=G):
    return f"""spatial model Slid
      Ground ground(g = {g}, n = {{0, 0, -1}});
      {bodies.format()};
      {joint};
    initial equation
      {start}
    end Slid;"""


def test_a_ball_in_its_socket_comes_to_rest():
    """J w' = -mu r m g whatever the axis is; the axis remains. Constant decelerations are exact, up to the start."""
    start = "body.wx = 2 rad/s; body.wy = 3 rad/s; body.wz = 6 rad/s;"
    text = slid("Spherical ball(ground, body.c, mu = 0.3, radius = 5 cm)", start)
    t = mbdsl.simulate(mbdsl.parse(text), step=2e-3, stop=1.0, interval=0.1)
    w = 7 - 0.3 * 0.05 * 2 * G / 0.5 * t.t
    for key, part in zip("xyz", (2, 3, 6), strict=True):
        np.testing.assert_allclose(t[f"body.w{key}"], part / 7 * w, rtol=1e-6)
    np.testing.assert_allclose(t["ball.friction"], 0.3 * 0.05 * 2 * G, rtol=1e-6)


@pytest.mark.parametrize("kind", ["PointOnPlane", "Planar"])
def test_a_block_slides_across_a_slope(kind):
    """With mu = tan(slope), v + v_down = v0 for a start across the slope (by hand): it ends with v0/2 downwards.

    The constant is kept with the error of the method, of order 2."""
    slope = 0.5
    normal = f"{{0, {np.sin(slope):.17g}, {np.cos(slope):.17g}}}"  # downwards is y
    joint = f"{kind} plane(ground, body.c, n = {normal}, mu = {np.tan(slope):.17g}, v_s = 1e-4)"
    text = slid(joint, "body.x = 0 m; body.y = 0 m; body.vx = 2 m/s; body.vy = 0 m/s;")
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=1.5, interval=0.05)
    v = np.stack([t[f"body.v{i}"] for i in "xyz"])
    down = v.T @ (0, np.cos(slope), -np.sin(slope))
    np.testing.assert_allclose(np.linalg.norm(v, axis=0) + down, 2.0, rtol=0, atol=1e-4)
    assert down[-1] == pytest.approx(1.0, abs=1e-3)
    assert v[0, -1] < 0.05


@pytest.mark.parametrize("radius", [0.1, None])
def test_a_ring_on_a_shaft(radius):
    """A thin ring slides and spins on a horizontal shaft: J = m r^2, so that the velocity of its surface keeps its
    direction, and its size falls by mu g t. Without a radius the spin is free."""
    body = "Body body(m = 2 kg, I = {{0.02, 0.01, 0.01}} kg.m2)"
    more = f", radius = {radius} m" if radius else ""
    start = "sleeve.s = 0 m; sleeve.v = 3 m/s; sleeve.phi = 0 rad; sleeve.w = 40 rad/s;"
    t = mbdsl.simulate(
        mbdsl.parse(slid(f"Cylindrical sleeve(ground, body.c, mu = 0.2{more})", start, body)),
        step=1e-3, stop=1.0, interval=0.1,
    )  # fmt: skip
    left = (5 - 0.2 * G * t.t) / 5 if radius else 1 - 0.2 * G * t.t / 3
    np.testing.assert_allclose(t["sleeve.v"], 3 * left, rtol=0, atol=1e-6)
    np.testing.assert_allclose(t["sleeve.w"], 40 * (left if radius else 1), rtol=0, atol=1e-5)


def test_a_bead_on_a_hoop():
    """Without gravity the hoop's reaction is m v^2/R: v = v0/(1 + mu v0 t/R), with an error of order 2."""
    joint = "PointOnCurve hoop(ground, body, f1 = x^2 + y^2 - (0.5 m)^2, f2 = z, mu = 0.2)"
    text = slid(joint, "body.x = 0.5 m; body.vy = 3 m/s;", "PointMass body(m = 2 kg)", g=0)
    errors = []
    for step in (2e-3, 1e-3):
        t = mbdsl.simulate(mbdsl.parse(text), step=step, stop=1.0, interval=0.1)
        errors.append(np.abs(np.hypot(t["body.vx"], t["body.vy"]) - 3 / (1 + 0.2 * 3 * t.t / 0.5)).max())
    assert errors[1] < 1e-4 and errors[0] / errors[1] == pytest.approx(4.0, abs=0.3)


# -- planar models in space --------------------------------------------------------------------------------------------

SLIDER_CRANK = """
model DryCrank
  Ground ground;
  Body crank(m = 1 kg, I = 0.01 kg.m2, length = 0.2 m);
  Body rod(m = 2 kg, I = 0.1 kg.m2, length = 0.6 m);
  Body slider(m = 3 kg, I = 0.02 kg.m2);
  Revolute main(ground, crank.a, mu = 0.1, mu_s = 0.15, radius = 2 cm);
  Revolute pin(crank.b, rod.a, mu = 0.1, radius = 2 cm);
  Revolute wrist(rod.b, slider.c, mu = 0.2, radius = 1 cm, w_s = 0.1);
  {guide} guide(ground, slider.c, mu = 0.2, v_s = 0.01);
initial equation
  main.phi = 0.6 rad;
  main.w = 30 rad/s;
  guess slider.x = 0.7 m;
end DryCrank;
"""


@pytest.mark.parametrize("kind", ["PointOnLine", "Prismatic"])
def test_a_planar_mechanism_in_space(kind):
    """A slider crank, whose constraints in space are redundant: the same loads, and Newton's iteration leaves 1e-7."""
    text = SLIDER_CRANK.format(guide=kind)
    moments = re.sub(r"I = (\S+) kg.m2", r"I = {\1, \1, \1} kg.m2", text).replace("model", "spatial model", 1)
    given = {"step": 5e-4, "stop": 0.2, "interval": 0.01}
    flat, solid = (mbdsl.simulate(mbdsl.parse(x), **given) for x in (text, moments))
    # none of the loads is out of the plane: that there are several reactions does not matter
    assert solid.stats["redundant"] and not of_friction(solid)
    names = [f"{joint}.{key}" for joint in ("main", "pin", "wrist", "guide") for key in ("fx", "fy", "friction")]
    for name in (*names, "crank.phi", "crank.w", "slider.x", "slider.vx"):
        scale = max(1.0, np.abs(flat[name]).max())
        np.testing.assert_allclose(solid[name], flat[name], rtol=0, atol=1e-6 * scale, err_msg=name)


def test_friction_that_is_not_determined_is_named():
    """A door between two hinges: how they share its weight along their axis does not follow from rigid bodies.

    With the lower hinge alone, nothing is undetermined."""
    text = """spatial model Door
      Ground ground(n = {{0, 0, -1}});
      Frame high(ground, r = {{0, 0, 2}} m);
      Body leaf(m = 30 kg, I = {{10, 3, 13}} kg.m2, frames(low = {{-0.4, 0, -1}} m, high = {{-0.4, 0, 1}} m));
      Revolute lower(ground, leaf.low, mu = 0.2, radius = 1 cm);
      {upper}
    initial equation
      lower.phi = 0 rad;
      lower.w = 1 rad/s;
    end Door;"""
    run = {"step": 1e-3, "stop": 0.1, "interval": 0.01}
    twice = mbdsl.simulate(mbdsl.parse(text.format(upper="Revolute upper(high, leaf.high);")), **run)
    once = mbdsl.simulate(mbdsl.parse(text.format(upper="")), **run)
    assert len(of_friction(twice)) == 1 and "lower" in of_friction(twice)[0]
    assert not once.stats["redundant"] and not of_friction(once)


@pytest.mark.parametrize("before", [True, False])
@pytest.mark.parametrize("g", [0, 9.81])
@pytest.mark.parametrize("spatial", [True, False])
def test_a_clutch_between_shafts_that_have_bearings_is_named(spatial, g, before):
    """The bearings hold both shafts, so that nothing presses the clutch: its friction is not that of a clutch."""
    bearings = "Revolute a(ground, fly.c); Revolute b(ground, load.c);"
    clutch = "\nRevolute clutch(fly.c, load.c, mu = 0.3, radius = 0.1 m);\n"
    joints = clutch + bearings if before else bearings + clutch
    inertia = "{0.1, 0.1, 0.1}" if spatial else "0.1"
    text = f"""{"spatial " * spatial}model Shafts
      Ground ground(g = {g});
      Body fly(m = 1, I = {inertia}); Body load(m = 1, I = {inertia});
      {joints}
    initial equation
      a.w = 10 rad/s; b.w = 0 rad/s;
    end Shafts;"""
    scene = mbdsl.parse(text, "shafts.mbd")
    line = text[: text.index("Revolute clutch")].count("\n") + 1
    run = mbdsl.simulate(scene, step=1e-2, stop=0.1)
    assert len(of_friction(run)) == 1
    assert f"friction of Revolute clutch (shafts.mbd:{line}) is not determined" in of_friction(run)[0]
    assert "in a Torque" in of_friction(run)[0]
    law = "Torque clutch(fly.c, load.c, tau = -3 N.m*tanh((load.w - fly.w)/(0.1 rad/s)));"
    if not spatial:  # what the warning says to write: 3 N.m until both have the same speed
        run = mbdsl.simulate(mbdsl.parse(text.replace(clutch, law)), step=1e-3, stop=0.1)
        assert not of_friction(run)
        assert run["load.w"][-1] == pytest.approx(3 / 0.1 * 0.1, rel=1e-6)


def of_friction(trajectory):
    return [w for w in trajectory.stats["warnings"] if w.startswith("friction of")]
