"""Friction of rigid contacts against closed forms: sliding, sticking, rolling, impact, several feet, and space."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError, ModelError
from mbdsl.system import build

G = 9.81
RUNS = [
    {},
    {"method": "dop853", "tol": 1e-8},
    *({"method": x, "step": 2.5e-3} for x in ("hht-i3", "nstiff", "hht-add")),
]

OSCILLATOR = """
model Oscillator
  Ground ground;
  PointMass p(m = 1 kg);
  Force spring(p, fx = -100 N/m*p.x);
  Contact floor(gap = p.y, slip = p.vx, mu = 2/9.81, e = 0);
initial equation
  p.x = 0.25 m; p.y = 0 m; p.vx = 0 m/s; p.vy = 0 m/s;
  annotation(experiment(StopTime = 3 s));
end Oscillator;
"""


@pytest.mark.parametrize(
    ("options", "bound"),
    [
        ({"method": "hht-i3", "step": 2.5e-3}, 5e-7),
        ({"method": "hht-si2", "step": 2.5e-3}, 5e-7),
        ({"method": "hht-add", "step": 2.5e-3}, 5e-7),
        ({"method": "nstiff-si2", "step": 2.5e-3}, 2e-5),
        ({"method": "radau9", "tol": 1e-9}, 1e-9),
        ({"method": "dop853", "tol": 1e-9}, 1e-9),
    ],
)
def test_coulomb_oscillator(options, bound):
    """Each half period of pi/10 s takes 2 mu N/k = 4 cm of the amplitude: it rests at 1 cm, from 6 pi/10 s on."""
    found = mbdsl.simulate(mbdsl.parse(OSCILLATOR), **options)
    rests = found.t > 6 * np.pi / 10 + 6e-3
    assert found["p.x"][-1] == pytest.approx(0.01, abs=bound)
    np.testing.assert_array_equal(found["p.x"][rests], found["p.x"][-1])
    np.testing.assert_array_equal(found["floor.sliding"][rests], 0.0)
    np.testing.assert_array_equal(np.abs(found["floor.sliding"][~rests][1:-2]), 1.0)
    assert found["floor.friction"][-1] == pytest.approx(-1.0, abs=100 * bound)
    np.testing.assert_allclose(found["floor.friction"][5:40], -2.0)


BALL = """
model Ball
  Ground ground;
  Body b(m = 2 kg, I = 0.008 kg.m2);
  Contact floor(gap = b.y - 0.1 m, slip = b.vx + 0.1 m*b.w, mu = 0.2, mu_s = 0.3, e = 0.5);
initial equation
  b.x = 0 m; b.y = 0.1 m; b.vx = 3 m/s; b.vy = 0 m/s; b.phi = 0; b.w = 0 rad/s;
  annotation(experiment(StopTime = 2 s));
end Ball;
"""


@pytest.mark.parametrize("options", RUNS)
def test_a_ball_begins_to_roll(options):
    """It slides for 2 v0/(7 mu g) and rolls with 5/7 v0."""
    found = mbdsl.simulate(mbdsl.parse(BALL), **options)
    t, v = 2 * 3 / (7 * 0.2 * G), 15 / 7
    np.testing.assert_array_equal(found["floor.sliding"], (found.t < t).astype(float))
    assert found["b.vx"][-1] == pytest.approx(v, rel=1e-9)
    assert found["b.x"][-1] == pytest.approx(3 * t - 0.1 * G * t**2 + v * (2 - t), rel=1e-8)


SPIN = """
model Spin
  Ground ground(g = 0 m/s2);
  Body b(m = 2 kg, I = 0.008 kg.m2);
  Contact floor(gap = b.y - 0.1 m, slip = b.vx + 0.1 m*b.w, mu = {mu}, e = 0.5);
initial equation
  b.x = 0 m; b.y = 0.2 m; b.vx = 1 m/s; b.vy = -2 m/s; b.phi = 0; b.w = 20 rad/s;
  annotation(experiment(StopTime = 0.1 s));
end Spin;
"""


@pytest.mark.parametrize("mu", [0.1, 5.0])
def test_an_impact_with_spin(mu):
    """The impulse along the floor is mu times the normal one, or ends the slip of 3 m/s."""
    found = mbdsl.simulate(mbdsl.parse(SPIN.format(mu=mu)), step=5e-3)
    impulse = min(mu * 2 * 2 * 1.5, 3 / (1 / 2 + 0.01 / 0.008))
    after = [found[f"b.{x}"][-1] for x in ("vy", "vx", "w")]
    np.testing.assert_allclose(after, [1, 1 - impulse / 2, 20 - impulse * 0.1 / 0.008], atol=1e-12)


FEET = """
model Feet
  Ground ground(g = 9.81 m/s2);
  Body b(m = 1 kg/9.81, I = 0.01 kg.m2, frames(l = {{-0.1 m, -0.2 m}}, r = {{0.9 m, -0.2 m}}, p = {{0, -0.2 m}}));
  Force push(b.p, fx = {rate}*time*1 N);
  Contact left(gap = b.l.y, slip = b.l.vx, mu = {mu}, mu_s = 0.6, e = 0);
  Contact right(gap = b.r.y, slip = b.r.vx, mu = {mu}, mu_s = 0.6, e = 0);
initial equation
  b.x = 0 m; b.y = 0.2 m; b.phi = 0; b.vx = 0 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
  annotation(experiment(StopTime = 1 s));
end Feet;
"""


@pytest.mark.parametrize("mu", [0.6, 0.5])
@pytest.mark.parametrize("rate", [0.8, 0.79])
def test_two_feet_slide_together(mu, rate):
    """With N = 0.9 and 0.1 they hold 0.6 N, however the load is shared; equal shares would slip at a load of 0.12 N."""
    t = 0.6 / rate
    for options in RUNS:
        found = mbdsl.simulate(mbdsl.parse(FEET.format(mu=mu, rate=rate)), **options)
        assert found["b.vx"][-1] == pytest.approx(G * (rate / 2 * (1 - t * t) - mu * (1 - t)), rel=1e-6)
        held = found.t < t - 2e-3
        assert np.abs(found["b.x"][held]).max() < 1e-9
        np.testing.assert_allclose(found["left.force"][held], 0.9, rtol=1e-9)
        total = found["left.friction"] + found["right.friction"]
        np.testing.assert_allclose(total[held], rate * found.t[held], atol=1e-9)


PLANE = """
spatial model Plane
  Ground ground(g = 9.81 m/s2, n = {{0, {y}, {z}}});
  PointMass p(m = 1 kg);
  Contact floor(gap = p.z, slip = p.vx, slip_2 = p.vy, mu = {mu}, e = 0);
initial equation
  p.x = 0 m; p.y = 0 m; p.z = 0 m; p.vx = 2 m/s; p.vy = 0 m/s; p.vz = 0 m/s;
  annotation(experiment(StopTime = {stop} s));
end Plane;
"""
TILT = np.radians(20)


@pytest.mark.parametrize("options", RUNS)
def test_across_a_slope(options):
    """Thrown across a slope of 20 deg with 2 m/s, it stops at k v0/(g sin(20 deg)(k^2 - 1)), k = mu/tan(20 deg)."""
    text = PLANE.format(y=-np.sin(TILT), z=-np.cos(TILT), mu=0.5, stop=1)
    found = mbdsl.simulate(mbdsl.parse(text), **options)
    k = 0.5 / np.tan(TILT)
    stops = k * 2 / (G * np.sin(TILT) * (k * k - 1))
    np.testing.assert_array_equal(found["floor.sliding"], (found.t < stops).astype(float))
    assert found["floor.friction"][-1] == pytest.approx(G * np.sin(TILT))
    assert found["p.vy"][-1] == 0.0
    # the hodograph of sliding with friction: v = v0 (tan(x/2))^(k-1) ..., of which dx/dt, dy/dt are integrals
    from scipy.integrate import solve_ivp

    def f(t, y):
        size = np.hypot(*y[2:]) or 1.0
        return [*y[2:], *(np.array([0.0, -G * np.sin(TILT)]) - 0.5 * G * np.cos(TILT) * y[2:] / size)]

    own = solve_ivp(f, (0, stops - 1e-7), [0, 0, 2, 0], rtol=1e-10, atol=1e-12).y[:2, -1]
    np.testing.assert_allclose([found["p.x"][-1], found["p.y"][-1]], own, atol=3e-5)


def test_along_a_slope_of_the_angle_of_friction():
    """With mu = tan(20 deg), the speed falls to half, down the slope."""
    text = PLANE.format(y=-np.sin(TILT), z=-np.cos(TILT), mu=np.tan(TILT), stop=4)
    found = mbdsl.simulate(mbdsl.parse(text), step=5e-3)
    assert found["p.vy"][-1] == pytest.approx(-1.0, abs=1e-4)
    np.testing.assert_allclose(np.hypot(found["p.vx"], found["p.vy"]) - found["p.vy"], 2.0, atol=1e-4)


MOVING = """
{spatial}model Moving
  Ground ground;
  {body} a(m = 1 kg, I = {I});
  {body} b(m = 2 kg, I = {I});
  Contact c(gap = a.y^2*1 m-1 - b.x, slip = a.vx*cos(b.{turn}) + b.x*b.{rate} - 0.2*b.vy{more}, mu = 0.3, e = 0);
end Moving;
"""


@pytest.mark.parametrize("spatial", [False, True])
def test_derivatives(spatial):
    """The friction of a sliding contact, which depends on positions, velocities and the normal force."""
    given = {"spatial": "", "body": "Body", "I": "0.1 kg.m2", "turn": "phi", "rate": "w", "more": ""}
    if spatial:
        more = ", slip_2 = a.vz*b.y*1 m-1 + 0.3 m*a.wx"
        given |= {
            "spatial": "spatial ",
            "body": "Body",
            "I": "{{0.1, 0, 0}, {0, 0.2, 0}, {0, 0, 0.25}} * 1 kg.m2",
            "rate": "wz",
            "more": more,
        }
    text = MOVING.format(**given).replace("1 m-1", "(1/(1 m))")
    system = build(mbdsl.parse(text.replace("cos(b.phi)", "sin(b.y/(1 m))") if spatial else text))
    for name, x in (("coefficient", -0.3), ("sliding", 1.0), ("slow", 0.1), ("along", 0.6), ("along_2", 0.8)):
        system.set_input(f"c.{name}", x)
    rng = np.random.default_rng(3)
    q, v, lam = (rng.uniform(0.3, 1.0, k) for k in (system.n, system.n, system.m + system.p))

    def f(dq=0.0, dv=0.0, dlam=0.0):
        return system.evaluate(0.0, system.moved(q, np.zeros_like(q) + dq), v + dv, lam + dlam)[0]

    def differences(n, key):
        e = 1e-5
        return np.array([(f(**{key: e * x}) - f(**{key: -e * x})) / (2 * e) for x in np.eye(n)]).T

    n = system.n
    found = system.tangent(0.0, q, v, lam, cK=1.0)[:n, :n], system.tangent(0.0, q, v, lam, cD=1.0)[:n, :n]
    np.testing.assert_allclose(-found[0], differences(n, "dq"), atol=1e-8)
    np.testing.assert_allclose(-found[1], differences(n, "dv"), atol=1e-8)
    of_lam = system.tangent(0.0, q, v, lam, cL=1.0, cV=1.0)[:n, n:]
    np.testing.assert_allclose(-of_lam, differences(system.m + system.p, "dlam"), atol=1e-8)


ROD = """
model Rod
  Ground ground;
  Body rod(m = 1 kg, I = (1 kg.m2)/12, frames(tip = {{-0.5 m, 0}}));
  Contact floor(gap = rod.tip.y, slip = rod.tip.vx, mu = {mu}, e = 0);
initial equation
  rod.tip.x = 0 m; rod.tip.y = 0 m; rod.phi = {angle} deg; rod.tip.vx = -2 m/s; rod.tip.vy = 0 m/s; rod.w = 0 rad/s;
  annotation(experiment(StopTime = 0.05 s));
end Rod;
"""


def test_painleve():
    """The reaction is unique for mu < 4/3; with mu = 1.5 it is not between 50.64 and 73.05 deg."""
    for angle in (51.0, 72.7):
        with pytest.raises(InitialisationError, match="Painleve"):
            mbdsl.simulate(mbdsl.parse(ROD.format(mu=1.5, angle=angle)), step=1e-3)
    for mu, angle in ((1.33, 63.4), (1.5, 50.0)):
        found = mbdsl.simulate(mbdsl.parse(ROD.format(mu=mu, angle=angle)), step=1e-3, stop=1e-3)
        s, c = np.sin(np.radians(angle)), np.cos(np.radians(angle))
        # w_N^T M^-1 (w_N - s mu w_T) N = g - w^2 s/2, with the lever arms of the tip
        assert found["floor.force"][0] == pytest.approx(G / (1 + 3 * c * c - 3 * mu * s * c), rel=1e-9)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("mu = 0.3", "slip"),
        ("slip = p.vx^2/(1 m/s), mu = 0.3", "linear"),
        ("slip = p.x/(1 s), mu = 0.3", "no velocity"),
        ("slip = p.vx, mu = 0.3, mu_s = 0.2", "less than mu"),
    ],
)
def test_mistakes(given, message):
    text = OSCILLATOR.replace("slip = p.vx, mu = 2/9.81", given)
    with pytest.raises(ModelError, match=message):
        mbdsl.simulate(mbdsl.parse(text), step=1e-2)


def test_a_rod_lifts_off():
    """Where w^2 L/2 sin(phi) = g its reaction vanishes, before it meets Painleve's angles: energy keeps w nearly."""
    text = ROD.format(mu=1.5, angle=40).replace("rod.w = 0", "rod.w = 5").replace("vx = -2", "vx = -8")
    ends = []
    for options in ({}, {"method": "radau9", "tol": 1e-8}, {"method": "hht-si2", "step": 1e-4}):
        found = mbdsl.simulate(mbdsl.parse(text), stop=0.1, **options)
        k = int(np.flatnonzero(found["floor.active"] == 0.0)[0])
        left = [found["rod.w"][i] ** 2 / 2 * np.sin(found["rod.phi"][i]) - G for i in (k - 1, k)]
        assert left[0] < 0.02 and left[1] > -0.02
        ends.append(found["rod.phi"][-1])
    np.testing.assert_allclose(ends, ends[1], rtol=1e-5)


SCALES = [(1e-6, 1, 1), (1e6, 1, 1), (1, 1e-15, 1), (1, 1e14, 1), (1, 1, 1e-3), (1, 1, 1e3), (1e-6, 1e-6, 1e-3)]


@pytest.mark.parametrize(("length", "mass", "time"), SCALES)
def test_units(length, mass, time):
    """A ball that falls, bounces and rolls does the same in any units, event by event."""

    def run(length, mass, time):
        v, g = 3 * length / time, 9.81 * length / time**2
        text = f"""
model Ball
  Ground ground(g = {g} m/s2);
  Body b(m = {2 * mass} kg, I = {0.008 * mass * length**2} kg.m2);
  Contact floor(gap = b.y - {0.1 * length} m, slip = b.vx + {0.1 * length} m*b.w, mu = 0.2, mu_s = 0.3, e = 0.5);
initial equation
  b.x = 0 m; b.y = {0.3 * length} m; b.vx = {v} m/s; b.vy = 0 m/s; b.phi = 0; b.w = 0 rad/s;
end Ball;
"""
        found = mbdsl.simulate(mbdsl.parse(text), step=1e-2 * time, stop=0.7 * time)
        return found, found["b.x"][-1] / length, found["b.vx"][-1] * time / length

    (own, x, v), (other, y, _) = run(1, 1, 1), run(length, mass, time)
    assert v == pytest.approx(15 / 7, rel=1e-12)
    assert y == pytest.approx(x, rel=1e-12)
    assert other.stats["kinds of events"] == own.stats["kinds of events"]
    assert other.stats["steps"] == own.stats["steps"]


THREE = """
model Three
  Ground ground;
  Body b(m = 1 kg, I = 0.1 kg.m2, frames(f1 = {-0.5 m, -0.2 m}, f2 = {0.1 m, -0.2 m}, f3 = {0.6 m, -0.2 m}));
  Contact c1(gap = b.f1.y, slip = b.f1.vx, mu = 0.3, e = 0), c2(gap = b.f2.y, slip = b.f2.vx, mu = 0.3, e = 0),
    c3(gap = b.f3.y, slip = b.f3.vx, mu = 0.3, e = 0);
initial equation
  b.x = 0 m; b.y = 0.2 m; b.phi = 0; b.vx = 3 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
  annotation(experiment(StopTime = 0.5 s));
end Three;
"""


def test_three_feet_slide():
    """Their normal forces are not unique, which is no paradox."""
    found = mbdsl.simulate(mbdsl.parse(THREE), step=2.5e-3)
    assert found["b.vx"][-1] == pytest.approx(3 - 0.3 * G * 0.5)


FEET_IN_SPACE = """
spatial model Table
  Ground ground(n = {{{sin}, 0, -{cos}}});
  Body b(m = 2 kg, I = {{{{0.1, 0, 0}}, {{0, 0.1, 0}}, {{0, 0, 0.1}}}}*1 kg.m2, frames(
    p = {{0.3 m, 0.2 m, -0.1 m}}, q = {{0.3 m, -0.2 m, -0.1 m}}, r = {{-0.3 m, 0.2 m, -0.1 m}},
    s = {{-0.3 m, -0.2 m, -0.1 m}}, at = {{0, 0, {height} m}}));
  Force push(b.at, fx = {push});
  Contact {feet};
initial equation
  b.x = 0 m; b.y = 0 m; b.z = {z} m; b.vx = 0 m/s; b.vy = 0 m/s; b.vz = 0 m/s;
  b.wx = 0 rad/s; b.wy = 0 rad/s; b.wz = 0 rad/s;
end Table;
"""


def table(push="0 N", height=0.0, tilt=0.0, z=0.1, feet="pqrs"):
    """A table on feet with mu = 0.5, at heights of 0.1 m below its centre."""
    each = (f"{f}(gap = b.{f}.z, slip = b.{f}.vx, slip_2 = b.{f}.vy, mu = 0.5, e = 0)" for f in feet)
    given = {"sin": np.sin(tilt), "cos": np.cos(tilt), "push": push, "height": height, "z": z}
    return mbdsl.parse(FEET_IN_SPACE.format(feet=", ".join(each), **given))


@pytest.mark.parametrize("height", [-0.1, 0.1])
@pytest.mark.parametrize("options", [{"step": 5e-3}, {"method": "radau5", "tol": 1e-8}], ids=str)
def test_a_table_on_four_feet_begins_to_slide(options, height):
    """The sum of friction is mu m g, however weight and friction are shared; pushed 20 cm above the floor, the front
    feet carry more by F h/l. A push of 20 N/s reaches it at t, and v = ((F + mu m g)/2 - mu m g)(1 - t)/m."""
    run = mbdsl.simulate(table("time*20 N/(1 s)", height), stop=1.0, **options)
    t = 0.5 * 2 * G / 20
    rests = run.t < t - 2e-3  # reactions of short steps have larger errors
    assert run["b.vx"][-1] == pytest.approx((10 * (1 - t * t) - 0.5 * 2 * G * (1 - t)) / 2, rel=1e-7)
    assert np.abs([run[f"b.{x}"][rests] for x in ("x", "y", "wz")]).max() < 1e-12
    force = {f: run[f"{f}.force"][rests] for f in "pqrs"}
    np.testing.assert_allclose(sum(force.values()), 2 * G, rtol=1e-9)
    moment = (0.1 + height) * 20 * run.t[rests]
    np.testing.assert_allclose(0.3 * (force["p"] + force["q"] - force["r"] - force["s"]), moment, atol=1e-8)
    for f in "pqrs":
        assert (run[f"{f}.friction"][rests] <= 0.5 * force[f] * (1 + 1e-6)).all()
    assert any("friction of p, q, r, s is not unique from t = 0 s on" in x for x in run.stats["warnings"])


@pytest.mark.parametrize(("part", "slides"), [(0.999, False), (1.001, True)])
def test_a_table_on_an_incline(part, slides):
    """It slides from atan(mu) on."""
    slope = np.arctan(part * 0.5)
    run = mbdsl.simulate(table(tilt=slope), stop=0.2, step=5e-3)
    a = G * (np.sin(slope) - 0.5 * np.cos(slope)) if slides else 0.0
    assert run["b.vx"][-1] == pytest.approx(0.2 * a, rel=1e-6, abs=1e-13)


def test_a_table_lands_rests_is_pushed_slides_and_stops():
    """It lands after sqrt(2 h/g), is pushed with 2 mu m g from 0.3 s to 0.5 s, and slides as far again until 0.7 s."""
    run = mbdsl.simulate(
        table("if time > 0.3 s and time < 0.5 s then 19.62 N else 0 N", -0.1, z=0.15), stop=1, step=5e-3
    )
    touch = min(e.t for e in run.events if e.kind == "impact")
    assert touch == pytest.approx(np.sqrt(2 * 0.05 / G), rel=1e-9)
    assert np.abs(run["b.x"][run.t < 0.3]).max() < 1e-12
    assert run["b.x"][-1] == pytest.approx(0.5 * G * 0.2**2, rel=1e-6)
    rests = run.t > 0.701
    np.testing.assert_array_equal(run["b.x"][rests], run["b.x"][-1])
    assert sum(run[f"{f}.force"][-1] for f in "pqrs") == pytest.approx(2 * G)


TURNED_LOAD = """
model TurnedLoad
  Ground ground(g = 10 m/s2);
  Body b(m = 1 kg, I = 0.1 kg.m2);
  discrete Real F(unit = "N", start = {before});
  Force push(b.c, fx = F);
  Contact one(gap = b.y + 0.1 m*b.phi, slip = b.vx, mu = 0.5, e = 0);
  Contact two(gap = b.y - 0.1 m*b.phi, slip = b.vx, mu = 0.5, e = 0);
initial equation
  b.x = 0 m; b.y = 0 m; b.phi = 0; b.vx = 0 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
equation
  when time > 0.5 s then F = 4 N; end when;
end TurnedLoad;
"""


@pytest.mark.parametrize("before", [0, -4])
@pytest.mark.parametrize("given", [{}, {"method": "radau5", "step": 0.01}], ids=["default", "step"])
def test_shares_are_those_of_the_forces_behind_an_event(before, given):
    """Two equal contacts: half of the load is each one's share, which mu N = 2.5 N can hold."""
    run = mbdsl.simulate(mbdsl.parse(TURNED_LOAD.format(before=before)), stop=1.0, interval=0.1, **given)
    for name in ("one.friction", "two.friction"):
        assert run[name][[3, -1]] == pytest.approx([0.5 * before, 2.0], abs=1e-9)


def test_a_contact_slides_in_the_direction_of_the_force_behind_an_event():
    """A `when` turns the force of 10 N; friction is 3 N."""
    run = mbdsl.simulate(
        mbdsl.parse("""
spatial model TurnedForce
  Ground ground(g = 10 m/s2);
  PointMass b(m = 1 kg);
  discrete Real F(unit = "N", start = 10), H(unit = "N", start = 0);
  Force push(b.c, fx = F, fz = H);
  PointContact c(ground, b.c, n = {0, 1, 0}, mu = 0.3, e = 0);
initial equation
  b.x = 0 m; b.y = 0 m; b.z = 0 m; b.vx = 0 m/s; b.vy = 0 m/s; b.vz = 0 m/s;
equation
  when initial() then F = 0; H = 10; end when;
end TurnedForce;
"""),
        step=1e-3,
        stop=0.1,
    )
    assert abs(run["b.vx"][-1]) < 1e-12
    assert run["b.vz"][-1] == pytest.approx(0.7, rel=1e-9)


SLIDING_ROD = """
spatial model Rod
  Ground ground;
  Body rod(m = 4 kg, I = {0.01, 0.03, 0.03} kg.m2, frames(a = {-0.15, 0, 0} m, b = {0.15, 0, 0} m));
  FreeMotion free(ground, rod.c);
  PointContact A(ground, rod.a, n = {0, 1, 0}, e = 0, mu = 0.4), B(ground, rod.b, n = {0, 1, 0}, e = 0, mu = 0.4);
initial equation
  rod.x = 0 m; rod.y = 0 m; rod.z = 0 m; rod.phi_x = 0; rod.phi_y = 0; rod.phi_z = 0;
  rod.vx = 0.1 m/s; rod.vy = 0 m/s; rod.vz = -0.35 m/s; rod.wx = 0 rad/s; rod.wy = 2 rad/s; rod.wz = 0 rad/s;
  annotation(experiment(StopTime = 0.4 s));
end Rod;
"""


@pytest.mark.parametrize(
    ("options", "bound"),
    [
        ({"method": "hht-i3", "step": 2e-3}, 4e-6),
        ({"method": "hht-si2", "step": 2e-3}, 4e-6),
        ({"method": "nstiff-si2", "step": 2e-3}, 2e-5),
        ({"method": "generalized-alpha-i3", "step": 2e-3}, 4e-6),
        ({"method": "radau9", "step": 2e-3}, 5e-9),
        ({"method": "hht-si2", "tol": 1e-5}, 1e-6),
        ({"method": "radau5", "tol": 1e-7}, 1e-8),
    ],
)
def test_one_end_of_a_rod_stops_while_the_other_slides_on(options, bound):
    """Each end carries m g/2. Expected: DOP853 of SciPy (rtol 1e-13) with both ends sliding until A is at rest, then
    a turn about A, which friction of 3.95 N holds (of 7.85 N that it may have), with the constant torque of B."""
    found = mbdsl.simulate(mbdsl.parse(SLIDING_ROD), **options)
    assert [(x.kind, x.name) for x in found.events] == [("stick", "A.contact"), ("stick", "B.contact")]
    assert [x.t for x in found.events] == pytest.approx([0.0696528784, 0.1136914003], abs=bound)
    assert [found[x][-1] for x in ("rod.x", "rod.z", "rod.phi_y")] == pytest.approx(
        [0.0023877784, -0.0197423206, 0.1157425723], abs=bound
    )
    moves = found.t < 0.1136914
    assert np.abs(found["rod.wy"][~moves]).max() < 1e-9
    np.testing.assert_array_less(np.diff(found["rod.wy"][moves]), 0.0)  # outputs on the way to the stop, too


def test_single_steps_end_at_their_ends_where_a_slide_ends_behind():
    sim = mbdsl.Simulation(mbdsl.parse(SLIDING_ROD), step=0.01391, method="hht-si2")
    sim.step(5)  # to 0.06955 s: 1e-4 s before A stops
    other = mbdsl.simulate(mbdsl.parse(SLIDING_ROD), method="radau9", step=1e-3, stop=5 * 0.01391)
    assert sim["rod.wy"] == pytest.approx(other["rod.wy"][-1], abs=1e-3)
