"""Rigid contacts against closed forms: bouncing, rest, lift-off, cradle, valve train and verge clock."""

import numpy as np
import pytest
from scipy.integrate import quad

import mbdsl
from mbdsl.errors import InitialisationError, IntegrationError, ModelError, UsageError

BALL = """
model Ball
  Ground ground;
  PointMass ball(m = 2 kg);
  Contact floor(gap = ball.{up}, e = {e});
initial equation
  {start}
  annotation(experiment(StopTime = 5 s));
end Ball;
"""
IN_PLANE = "ball.x = 0 m; ball.y = {h} m; ball.vx = 0 m/s; ball.vy = 0 m/s;"
IN_SPACE = "ball.x = 0 m; ball.y = {h} m; ball.z = 0 m; ball.vx = 0 m/s; ball.vy = 0 m/s; ball.vz = 0 m/s;"
G = 9.81
SECOND = [
    "newmark",
    "hht-i3",
    "hht-si2",
    "hht-add",
    "nstiff",
    "nstiff-si2",
    "generalized-alpha",
    "generalized-alpha-i3",
]


def ball(e=0.8, h=1.0, spatial=False):
    text = BALL.format(e=e, up="y", start=(IN_SPACE if spatial else IN_PLANE).format(h=h))
    return mbdsl.parse(text.replace("model Ball", "spatial model Ball") if spatial else text)


def height(t, e=0.8, h=1.0):
    """The height of a bouncing ball."""
    v, start = np.sqrt(2 * G * h), np.sqrt(2 * h / G)
    if t < start:
        return h - G * t * t / 2
    while v > 1e-12:
        v *= e
        if t < start + 2 * v / G:
            return v * (t - start) - G * (t - start) ** 2 / 2
        start += 2 * v / G
    return 0.0


@pytest.mark.parametrize("options", [{"step": 5e-3}, {"tol": 1e-6, "method": "dop853"}])
def test_a_ball_bounces_and_rests(options):
    """It rests from t1 (1 + e)/(1 - e) = 4.0637 s on; impacts with flight times below 1e-8 of the run are left out."""
    found = mbdsl.simulate(ball(), **options)
    np.testing.assert_allclose(found["ball.y"], [height(t) for t in found.t], atol=1e-9)
    rest = found.t > np.sqrt(2 / G) * 9
    np.testing.assert_array_equal(found["floor.active"][rest], 1.0)
    np.testing.assert_allclose(found["floor.force"][rest], 2 * G, rtol=1e-9)
    np.testing.assert_allclose(found["ball.ay"][rest], 0.0, atol=1e-9)
    np.testing.assert_allclose(found["ball.ay"][~rest], -G, rtol=1e-9)
    assert not found["floor.force"][~rest].any()
    assert found["floor.impacts"][found.t < 1.5].max() == 2
    (closes,) = [x.t for x in found.events if x.kind == "contact"]
    assert closes == pytest.approx(9 * np.sqrt(2 / G), abs=2e-6)  # 4.0637 s
    assert found["floor.impulse"][60] == pytest.approx(2 * 1.8 * np.sqrt(2 * G))


def test_a_ball_at_rest_stays():
    found = mbdsl.simulate(ball(h=0.0), step=0.01, stop=0.1)
    np.testing.assert_array_equal(found["ball.y"], 0.0)
    np.testing.assert_allclose(found["floor.force"], 2 * G)
    assert found["floor.impacts"][-1] == 0


def test_elastic_impacts_keep_the_energy():
    found = mbdsl.simulate(ball(e=1.0), step=0.02, stop=5.0)
    np.testing.assert_allclose(found["ball.y"], [height(t, 1.0 - 1e-16) for t in found.t], atol=1e-8)
    np.testing.assert_allclose(found["energy.total"], 2 * G, rtol=1e-10)


DOME = """
model Dome
  Ground ground;
  PointMass p(m = 1 kg);
  Contact dome(gap = sqrt(p.x^2 + p.y^2) - 1 m, e = 0);
initial equation
  p.x = 0 m; p.y = 1 m; p.vx = 0.5 m/s; p.vy = 0 m/s;
  annotation(experiment(StopTime = 1.2 s));
end Dome;
"""


#: where the particle leaves the dome of 1 m: cos = 2/3 + v0^2/(3 g R); the speed there, and the time until then
EDGE = np.arccos(2 / 3 + 0.25 / (3 * G))
EDGE_SPEED = np.sqrt(0.25 + 2 * G * (1 - np.cos(EDGE)))
EDGE_TIME = quad(lambda phi: 1 / np.sqrt(0.25 + 2 * G * (1 - np.cos(phi))), 0, EDGE, epsabs=1e-14)[0]


def behind_the_dome(t):
    """x, y, vx and vy of the flight."""
    s, vx, vy = t - EDGE_TIME, EDGE_SPEED * np.cos(EDGE), -EDGE_SPEED * np.sin(EDGE)
    return np.array([np.sin(EDGE) + vx * s, np.cos(EDGE) + vy * s - G * s * s / 2, vx, vy - G * s])


@pytest.mark.parametrize(("method", "order"), [(x, 1 if x == "newmark" else 2) for x in SECOND])
def test_no_order_is_lost_where_a_particle_leaves_a_dome(method, order):
    """Velocities are projected onto the row before it is opened; the reactions that open it are those of the motion."""
    scene, errors = mbdsl.parse(DOME), []
    for n in (200, 400, 800):
        found = mbdsl.simulate(scene, method=method, step=1 / n, stop=1.0, interval=1.0)
        (left,) = [x.t for x in found.events if x.kind == "lift-off"]
        assert left == pytest.approx(EDGE_TIME, abs=0.2 / n if method == "newmark" else 4 / n**2)
        end = np.array([found[f"p.{x}"][-1] for x in ("x", "y", "vx", "vy")])
        errors.append(np.abs(end - behind_the_dome(1.0)).max())
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize(
    ("method", "step", "within"),
    [
        ("radau5", 0.02, 1e-8),
        ("radau9", 0.02, 1e-10),
        ("radau13", 5e-3, 1e-10),  # rounding decides the reaction of a step that ends shortly before the event
        ("dop853", 0.02, 1e-12),
    ],
)
def test_fixed_steps_of_high_order_leave_a_dome(method, step, within):
    found = mbdsl.simulate(mbdsl.parse(DOME), method=method, step=step, stop=1.0, interval=1.0)
    (left,) = [x.t for x in found.events if x.kind == "lift-off"]
    assert left == pytest.approx(EDGE_TIME, abs=within)
    end = np.array([found[f"p.{x}"][-1] for x in ("x", "y", "vx", "vy")])
    np.testing.assert_allclose(end, behind_the_dome(1.0), atol=within)


CRADLE = """
model Cradle
  Ground ground(g = 0);
  Frame rail(ground);
  Body b[{n}](each m = 1 kg, each I = 1 kg.m2);
  Prismatic s[{n}](each frame_a = rail, frame_b = b.c);
  Contact c[{m}](gap = {{s[i + 1].s - s[i].s - 0.1 m for i in 1:{m}}}, each e = {e}, each impacts = "{law}");
initial equation
  {start}
  annotation(experiment(StopTime = 1 s));
end Cradle;
"""


def cradle(n, e, moving, law="sequential"):
    start = " ".join(
        f"s[{i}].s = {0.1 * i - (0.2 if i <= moving else 0.0)} m; s[{i}].v = {1.0 if i <= moving else 0.0} m/s;"
        for i in range(1, n + 1)
    )
    return mbdsl.parse(CRADLE.format(n=n, m=n - 1, e=e, law=law, start=start))


@pytest.mark.parametrize(
    ("n", "e", "moving", "law", "after"),
    [
        (3, 1.0, 1, "sequential", (0, 0, 1)),
        (5, 1.0, 1, "sequential", (0, 0, 0, 0, 1)),
        (5, 1.0, 2, "sequential", (0, 0, 0, 1, 1)),
        (3, 0.9, 1, "sequential", (0.047625, 0.049875, 0.9025)),
        (3, 1.0, 1, "simultaneous", (-1 / 3, 2 / 3, 2 / 3)),
    ],
)
def test_cradle(n, e, moving, law, after):
    found = mbdsl.simulate(cradle(n, e, moving, law), step=0.05)
    v = [found[f"s[{i}].v"][-1] for i in range(1, n + 1)]
    np.testing.assert_allclose(v, after, atol=1e-9)


def test_energy_and_laws_of_many_impacts():
    """Two walls, 1 mm apart, 1 m/s, e = 1: an impact each millisecond."""
    text = """
model Walls
  Ground ground(g = 0);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic s(ground, b.c);
  Contact left(gap = s.s, e = 1), right(gap = 1 mm - s.s, e = 1);
initial equation
  s.s = 0.5 mm; s.v = 1 m/s;
end Walls;
"""
    found = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=0.05)
    assert abs(found["s.v"][-1]) == pytest.approx(1.0, abs=1e-9)
    assert found["left.impacts"][-1] + found["right.impacts"][-1] == 50


def test_bad_contacts():
    with pytest.raises(ModelError, match=r"e = 1.2 is larger than 1"):
        ball(e=1.2)
    with pytest.raises(InitialisationError, match=r"the gap of `floor` is -0.1 m at the start: the bodies overlap"):
        mbdsl.simulate(ball(h=-0.1), step=0.01, stop=0.1)
    with pytest.raises(ModelError, match="found a velocity"):
        mbdsl.parse(BALL.format(e=0.5, up="vy", start=IN_PLANE.format(h=1)))


def test_what_does_not_know_contacts():
    with pytest.raises(UsageError, match="scipy-radau does not know the rigid contact `floor`"):
        mbdsl.simulate(ball(), method="scipy-radau", stop=0.1, tol=1e-6)
    with pytest.raises(InitialisationError, match="equilibria and linear models with rigid contacts"):
        mbdsl.static(ball())


def test_a_jammed_body():
    """A driver presses a block against a wall: no reaction can hold both."""
    text = """
model Jammed
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic s(ground, b.c);
  TranslationalDriver d(s, s = 1 m/s*time);
  Contact wall(gap = 0.1 m - s.s, e = 0.5);
end Jammed;
"""
    with pytest.raises(IntegrationError, match=r"no impulses satisfy the laws of the contacts `wall` at t = 0.1") as e:
        mbdsl.simulate(mbdsl.parse(text), step=0.01, stop=0.5)
    assert e.value.span is not None


def test_in_space():
    found = mbdsl.simulate(ball(spatial=True), step=5e-3, stop=1.5)
    np.testing.assert_allclose(found["ball.y"], [height(t) for t in found.t], atol=1e-9)


FLAT = """
model Flat
  Ground ground;
  Body b(m = 2 kg, I = 0.05 kg.m2, frames(p = {-0.3, -0.1} m, q = {0.3, -0.1} m));
  Contact left(gap = b.p.y, e = 0.4), right(gap = b.q.y, e = 0.4);
initial equation
  b.x = 0 m; b.y = 0.3 m; b.phi = 0; b.vx = 0.2 m/s; b.vy = 0 m/s; b.w = 0 rad/s;
  annotation(experiment(StopTime = 1 s));
end Flat;
"""
PRESSED = """
model Pressed
  Ground ground(g = 0 m/s2);
  PointMass b(m = 2 kg);
  Contact wall(gap = 0.4 m - b.x, e = 0.8);
  discrete Real F(unit = "N", start = 0);
  Force push(b, fx = F);
initial equation
  b.x = 0 m; b.y = 0 m; b.vx = 0 m/s; b.vy = 0 m/s;
equation
  when sample(0, 10 ms) then
    F = 10 N/m*(1 m - b.x) - 5 N.s/m*b.vx;
  end when;
  annotation(experiment(StopTime = 3 s));
end Pressed;
"""
BY_TOLERANCE = [("hht-si2", 1e-5), ("nstiff", 1e-4), ("dop853", 1e-6)]


@pytest.mark.parametrize(("method", "tol"), BY_TOLERANCE)
def test_a_block_lands_flat(method, tol):
    """Both feet strike at once; it rests from (1 + e)/(1 - e) times the time of the fall on."""
    found = mbdsl.simulate(mbdsl.parse(FLAT), method=method, tol=tol)
    rests = found.t > np.sqrt(0.4 / G) * 1.4 / 0.6
    np.testing.assert_allclose(found["left.force"][rests] + found["right.force"][rests], 2 * G, rtol=1e-9)
    np.testing.assert_allclose(found["b.y"][rests], 0.1, atol=1e-9)
    assert np.abs(found["b.phi"]).max() < 1e-12


@pytest.mark.parametrize(("method", "tol"), BY_TOLERANCE)
def test_a_sampled_force_presses_on_a_stop(method, tol):
    """Far from zero, rounding of the position decides the last impacts."""
    found = mbdsl.simulate(mbdsl.parse(PRESSED), method=method, tol=tol)
    assert found["wall.force"][-1] == pytest.approx(6.0, rel=1e-9)
    assert found["b.x"][-1] == pytest.approx(0.4, abs=1e-12)
    assert found["wall.active"][-1] == 1.0


@pytest.mark.parametrize("options", [{"step": 5e-3}, {"tol": 1e-6}, {"method": "moreau-jean", "step": 1e-3}])
def test_without_contact(options):
    """A free fall."""
    text = BALL.format(e=0.8, up="y", start=IN_PLANE.format(h=1.0))
    found = mbdsl.simulate(mbdsl.parse(text), without=["contact"], stop=1.0, **options)
    np.testing.assert_allclose(found["ball.y"], 1 - G * found.t**2 / 2, atol=1e-9)
    assert not found["floor.active"].any()


CURVED = """
model Curved
  Ground ground;
  PointMass p(m = 1 kg);
  Contact {contacts};
initial equation
  p.x = 0 m; p.y = 0 m; p.vx = 1 m/s; p.vy = 0 m/s;
  annotation(experiment(StopTime = 0.8 s));
end Curved;
"""
LEVEL, CURVE = "level(gap = p.y, e = 0)", "curve(gap = p.y - 1 m*(p.x/(1 m))^3, e = 0)"


@pytest.mark.parametrize("contacts", [(LEVEL, CURVE), (CURVE, LEVEL)])
def test_contacts_that_depend_on_each_other_in_one_pose(contacts):
    """The rows are the same at x = 0 only: the particle climbs the curve, whichever is declared first."""
    found = mbdsl.simulate(mbdsl.parse(CURVED.format(contacts=", ".join(contacts))), step=2.5e-3)
    assert found["curve.gap"].min() > -1e-6
    energy = (found["p.vx"] ** 2 + found["p.vy"] ** 2) / 2 + G * found["p.y"]
    np.testing.assert_allclose(energy, 0.5, rtol=1e-4)
    assert found["p.x"].max() > 0.3


STACK = """
model Stack
  Ground ground;
  PointMass block(m = 1 kg), ball(m = 0.1 kg);
  Contact floor(gap = block.y, e = 0), top(gap = ball.y - block.y, e = 0.5);
initial equation
  block.x = 0 m; block.y = 0 m; block.vx = 0 m/s; block.vy = 0 m/s;
  ball.x = 0 m; ball.y = 0.2 m; ball.vx = 0 m/s; ball.vy = 0 m/s;
  annotation(experiment(StopTime = 0.6 s));
end Stack;
"""


@pytest.mark.parametrize("options", [{"method": "hht-i3", "step": 2.5e-3}, {"method": "dop853", "tol": 1e-6}])
def test_a_ball_comes_to_rest_on_a_block(options):
    """Its bounces end, because the floor carries the block: gaps have no acceleration while all contacts are open."""
    found = mbdsl.simulate(mbdsl.parse(STACK), **options)
    assert found["top.force"][-1] == pytest.approx(0.1 * G)
    assert found["floor.force"][-1] == pytest.approx(1.1 * G)


CLUTCH = """
model Clutch "three equal shoes, which ever larger forces press on a drum"
  parameter Integer n = 3;
  Ground ground(g = 0);
  Body hub(m = 1 kg, I = 2e-3 kg.m2), drum(m = 2 kg, I = 0.01 kg.m2);
  Revolute engine_pin(ground, hub.c), drum_pin(ground, drum.c);
  Frame radial[n](hub.c, phi = {2*pi*i/n for i in 1:n});
  PointMass shoe[n](each m = 0.15 kg);
  Prismatic slot[n](radial, shoe);
  Contact lining[n](gap = {80 mm - slot[i].s for i in 1:n}, slip = {80 mm*(drum_pin.w - engine_pin.w) for i in 1:n},
    each mu = 0.35, each e = 0);
  Torque engine(engine_pin, tau = 6 N.m);
initial equation
  engine_pin.phi = 0; drum_pin.phi = 0; drum_pin.w = 0 rad/s;
  engine_pin.w = 80 rad/s;
  for i in 1:n loop
    slot[i].s = 80 mm; slot[i].v = 0 m/s;
  end for;
end Clutch;
"""


@pytest.mark.parametrize("options", [{"step": 2e-3, "method": "radau5"}, {"tol": 1e-5}])
def test_contacts_that_slide_alike_stick_alike(options):
    """All shoes stick at once, and each has a third of the torque that turns the drum with the hub, 6 N.m I/(I + J).

    One of them stuck before, and the others pushed it at their limit, with friction against a slip of zero; where the
    forces grew, the run ended.
    """
    run = mbdsl.simulate(mbdsl.parse(CLUTCH), stop=0.3, **options)
    J = 2e-3 + 3 * 0.15 * 0.08**2
    held = run["lining[1].sliding"] == 0.0
    assert 0.02 < run.t[held][0] < 0.2
    for i in (1, 2, 3):
        assert (run[f"lining[{i}].sliding"][held] == 0.0).all()
        third = 6.0 * 0.01 / (0.01 + J) / 0.08 / 3.0
        assert run[f"lining[{i}].friction"][held] == pytest.approx(-third, rel=1e-4)
    w = (80.0 * J + 6.0 * 0.3) / (0.01 + J)
    assert run["drum_pin.w"][-1] == pytest.approx(w, rel=1e-5)


def test_events_of_contacts_are_conditions():
    """Impacts with e = 0.5 from 1 m at t1, t1 (1 + 2 e), t1 (1 + 2 e + 2 e^2), ...: counted, with their times."""
    text = """model M
      Ground ground; PointMass ball(m = 2 kg); PointContact floor(ground, ball, e = 0.5);
      Integer n(start = 0);
      discrete Real t[3](each start = 0, each unit = "s"), last(start = 0);
      Boolean rests(start = false);
    initial equation
      ball.x = 0 m; ball.vx = 0 m/s; ball.y = 1 m; ball.vy = 0 m/s;
    equation
      when change(floor.impacts) then
        n = pre(n) + 1; last = pre(floor.impacts);
        for i in 1:3 loop t[i] = if n == i then time else pre(t[i]); end for;
      end when;
      when edge(floor.active > 0) then rests = true; end when;
    end M;"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=1.6, step=0.02, method="radau5")
    t1 = np.sqrt(2.0 / 9.81)
    assert [run[f"t[{i}]"][-1] for i in (1, 2, 3)] == pytest.approx([t1, 2.0 * t1, 2.5 * t1], rel=1e-9)
    assert run["n"][-1] == run["floor.impacts"][-1] == run["last"][-1] + 1
    assert (run["rests"] == (run.t > 3.0 * t1)).all()
    with pytest.raises(ModelError, match=r"change\(\) takes a discrete variable"):
        mbdsl.parse(text.replace("change(floor.impacts)", "change(floor.gap)"))
