"""Contacts that are first met late, by long steps: two equal masses exchange their velocities, a ball meets a ceiling;
a motor with backlash, whose contacts open without a jump of forces.

Between contacts accelerations are constant, so that steps are as long as they may be, and some of their stages lie in
the contact. Four stages of dop853 have no weight; if only these meet the contact, the step must not be accepted.
"""

import numpy as np
import pytest

import mbdsl

MASSES = """{spatial}model Masses
  Ground ground(g = 0);
  Body A(m = 1 kg, I = 1 kg.m2);
  Body B(m = 1 kg, I = 1 kg.m2);
  Prismatic pa(ground, A.c{axis});
  Prismatic pb(ground, B.c{axis});
  SpringDamper bump(A.c, B.c, force = if s < 1 m then {k}*(s - 1 m) else 0 N);
initial equation
  pa.s = 0 m; pa.v = 1 m/s; pb.s = {distance} m; pb.v = 0 m/s;
  annotation(experiment(StopTime = {stop} s));
end Masses;"""

CEILING = """model Ceiling
  Ground ground(g = 9.81);
  PointMass ball(m = 1 kg);
  Force roof(ball, fy = if ball.y > {height} m then {k}*({height} m - ball.y) else 0 N);
initial equation
  ball.x = 0 m; ball.y = 0 m; ball.vx = 0 m/s; ball.vy = 30 m/s;
  annotation(experiment(StopTime = 5 s));
end Ceiling;"""


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("k", [1e6, 1e8])
@pytest.mark.parametrize("gap", [8.005, 6.721802573159248, 2.3843008255512137])
def test_equal_masses_exchange_their_velocities(gap, k, spatial):
    """The contact lasts pi/sqrt(2 k/m): A moves with 1 m/s until then, and B afterwards; the centre all the time."""
    axis = ", n = {1, 0, 0}" if spatial else ""
    text = MASSES.format(spatial=spatial, axis=axis, k=f"{k} N/m", distance=gap + 1.0, stop=gap + 2.3)
    for tol in (1e-3, 1e-6):
        run = mbdsl.simulate(mbdsl.parse(text), method="dop853", tol=tol)
        lasts = np.pi / np.sqrt(2.0 * k)
        end = gap + 0.5 * lasts  # half of the way is done by each
        assert run["pa.v"][-1] == pytest.approx(0.0, abs=3.0 * tol)
        assert run["pb.v"][-1] == pytest.approx(1.0, abs=3.0 * tol)
        assert run["pa.s"][-1] == pytest.approx(end, abs=30.0 * tol)
        assert run.stats["steps"] < 200


@pytest.mark.parametrize("method", ["scipy-dop853", "scipy-lsoda"])
@pytest.mark.parametrize(("gap", "k"), [(8.005, 1e6), (6.069954397163704, 3.7e8), (0.7637212143008403, 9.9e7)])
def test_backends_do_not_pass_through_the_contact(gap, k, method):
    """The same, where the estimate of a step is that of the backend."""
    text = MASSES.format(spatial="", axis="", k=f"{k} N/m", distance=gap + 1.0, stop=gap + 2.3)
    run = mbdsl.simulate(mbdsl.parse(text), method=method, tol=1e-5)
    assert run["pa.v"][-1] == pytest.approx(0.0, abs=5e-5)
    assert run["pb.v"][-1] == pytest.approx(1.0, abs=5e-5)


@pytest.mark.parametrize(("height", "k"), [(45.8, 1e6), (45.24, 3.5e6), (25.0, 1e8), (43.5, 5e3)])
def test_a_ball_meets_the_ceiling(height, k):
    """The motion is symmetric about the middle of the contact: y(2 tc - t) = y(t), with y = 30 t - g t^2/2 before.

    In the contact y'' = -g - k/m (y - height), so that v = 0 where tan(w t) = v1 w/g.
    """
    run = mbdsl.simulate(mbdsl.parse(CEILING.format(height=height, k=f"{k} N/m")), method="dop853", tol=1e-6)
    first, w = np.sqrt(900.0 - 2.0 * 9.81 * height), np.sqrt(k)
    middle = (30.0 - first) / 9.81 + np.arctan2(first * w, 9.81) / w
    t = 2.0 * middle - run.t[run.t > middle + 0.5]
    np.testing.assert_allclose(run["ball.y"][run.t > middle + 0.5], 30.0 * t - 4.905 * t**2, rtol=0, atol=1e-4)


FLOOR = """model Bounce
  Ground ground(g = {g!r});
  PointMass ball(m = 1 kg);
  Force floor(ball, fy = if ball.y < 0 m then -{k!r} N/m*ball.y else 0 N);
initial equation
  ball.x = 0 m; ball.y = {y!r} m; ball.vy = {v!r} m/s;
  annotation(experiment(StopTime = {stop!r} s));
end Bounce;"""


def bounces(g, k, y, v, times):
    """y and v of a ball that falls on a linear spring: parabolas above it, y = -g/k + A cos(w t) + B sin(w t) on it."""
    w, t0, found = np.sqrt(k), 0.0, []
    above = True
    while len(found) < len(times):
        if above:
            lasts = (v + np.sqrt(v * v + 2.0 * g * y)) / g if g else (y / -v if v < 0.0 else np.inf)
            state = lambda s, y=y, v=v: (y + v * s - g * s * s / 2.0, v - g * s)  # noqa: E731
        else:
            A, B = y + g / k, v / w
            lasts = (2.0 * np.pi - np.arccos(g / k / np.hypot(A, B)) + np.arctan2(B, A)) % (2.0 * np.pi) / w
            state = lambda s, A=A, B=B: (  # noqa: E731
                -g / k + A * np.cos(w * s) + B * np.sin(w * s),
                w * (B * np.cos(w * s) - A * np.sin(w * s)),
            )
        inside = times[len(found) :]
        found += [state(t - t0) for t in inside[inside <= t0 + lasts]]
        if np.isfinite(lasts):
            (_, v), y = state(lasts), 0.0
            t0, above = t0 + lasts, not above
    return np.array(found).T


CONTACTS = [
    ("radau9", 1e-4, 0.0, 16924790.83908309, 0.8626590429094386, -2.8661318320501894, 1.0891284846990708),
    ("radau9", 1e-3, 9.81, 231288.4604373144, 0.03947137558204767, 4.816491710499463, 3.164840792427517),
    ("radau9", 1e-5, 0.0, 118436595.20153204, 0.16590102224297285, -2.643326888461204, 0.1547420189501225),
    ("radau13", 1e-4, 9.81, 479544.23347789067, 4.727150851580689, -2.3947894710979054, 1.6344646161518785),
    ("radau13", 1e-4, 9.81, 668116.3825874414, 0.2963444726321109, 0.3984253574744212, 0.5862893097920387),
    ("radau13", 1e-5, 0.0, 48246030.46186998, 1.2135992080493352, -1.2855635505203018, 2.646928027465842),
    ("scipy-dop853", 1e-7, 9.81, 58546079.02510311, 0.17543036584620283, 4.669719061665745, 2.0027128937556062),
    ("scipy-dop853", 1e-5, 0.0, 760254.4601530004, 0.01668290995730037, -1.912908945746709, 0.03297824311891277),
    ("scipy-dop853", 1e-4, 9.81, 7658436.210280064, 0.11096202777076801, -0.11115000063901746, 0.25973442582292133),
]  # fmt: skip


@pytest.mark.parametrize(("method", "tol", "g", "k", "y", "v", "stop"), CONTACTS)
def test_stated_errors_of_contacts_in_few_steps(method, tol, g, k, y, v, stop):
    """Runs with different tolerances must not take the same steps in a contact: they would have the same error."""
    run = mbdsl.simulate(mbdsl.parse(FLOOR.format(g=g, k=k, y=y, v=v, stop=stop)), method=method, tol=tol)
    true = bounces(g, k, y, v, run.t)
    size = run.system.tables.size
    speed = max(1.0 / stop, np.abs(run["ball.vy"]).max() / size)
    error = max(np.abs(run["ball.y"] - true[0]).max() / size, np.abs(run["ball.vy"] - true[1]).max() / size / speed)
    assert error <= 3.0 * tol
    assert error <= 10.0 * run.stats["error"]


BACKLASH = """model Backlash
  parameter Angle b = 0.05;
  Ground ground(g = 0 m/s2);
  Body r1(m = 1 kg, I = 0.01 kg.m2), r2(m = 1 kg, I = 0.03 kg.m2);
  Revolute A(ground, r1.c), B(ground, r2.c);
  Current i(start = 0 A);
  Voltage u = 12 V*sin(4 rad/s*time);
  Torque motor(A, tau = 0.1 N.m/A*i);
  RotationalSpringDamper load(B, k = 0.2 N.m/rad, c = 0.01 N.m.s/rad);
  Contact up(gap = (b - A.phi + B.phi)*(1 m), e = 0.4), lo(gap = (b + A.phi - B.phi)*(1 m), e = 0.4);
  Contact stop(gap = (0.8 - B.phi)*(1 m), e = 0.5);
initial equation
  A.phi = 0; A.w = 0 rad/s; B.phi = 0; B.w = 0 rad/s;
equation
  der(i) = (u - 0.5 Ohm*i - 0.1 V.s*A.w)/(0.02 H);
  annotation(experiment(StopTime = 2.5 s));
end Backlash;"""


def test_a_gap_that_opens_without_a_jump_of_forces_does_not_end_the_run():
    """Behind the lift-off at 0.83 s, the gap is the rounding of its angles for many steps. The bounds hold for any
    motion with these contacts, and a method of another kind, without error of its reactions, ends at the same place."""
    scene = mbdsl.parse(BACKLASH)
    run, precise = (
        mbdsl.simulate(scene, method=method, tol=tol) for method, tol in (("hht-si2", 1e-5), ("dop853", 1e-8))
    )
    assert (np.abs(run["A.phi"] - run["B.phi"]) < 0.05 + 1e-9).all()
    assert (run["B.phi"] < 0.8 + 1e-9).all()
    assert [run["A.phi"][-1], run["B.phi"][-1]] == pytest.approx([precise[x][-1] for x in ("A.phi", "B.phi")], abs=1e-3)


LIFTED = """
model Lifted
  Ground ground;
  PointMass ball(m = 2 kg);
  Contact floor(gap = ball.y, e = 0);
  Force lift(ball, fy = 20 N/s*time);
initial equation
  ball.x = 0 m; ball.y = 0 m; ball.vx = 0 m/s; ball.vy = 0 m/s;
end Lifted;
"""


@pytest.mark.parametrize("method", ["newmark", "hht-i3", "hht-si2", "nstiff", "generalized-alpha"])
def test_a_force_that_grows_lifts_a_ball_within_a_step(method):
    """N = m g - 20 N/s t is zero at 0.981 s. Newton's last correction of the step shows it, not its extrapolation."""
    found = mbdsl.simulate(mbdsl.parse(LIFTED), method=method, step=5e-3, stop=1.0)
    assert [(x.kind, x.t) for x in found.events] == [("lift-off", pytest.approx(0.981, abs=1e-9))]


PRESSED = """
model Pressed
  Ground ground(g = 0 m/s2);
  Body plate(m = 0.1 kg, I = 1 kg.m2), disc(m = 1 kg, I = 0.2 kg.m2);
  Prismatic guide(ground, plate.c);
  Revolute shaft(ground, disc.c);
  Contact face(gap = -plate.x, slip = 0.1 m*disc.w, mu = {mu}, e = {e});
  Force press(plate.c, fx = {force});
initial equation
  plate.x = 0 m; plate.vx = 0 m/s; shaft.phi = 0; shaft.w = 30 rad/s;
end Pressed;
"""


@pytest.mark.parametrize(
    ("force", "mu", "e", "stops"),
    [
        ("500 N/s*time", 0.3, 0.0, np.sqrt(0.8)),  # the torque is 15 N.m/s t: w = 30 - 37.5 t^2
        ("500 N/s2*time^2", 0.3, 0.5, 1.2 ** (1 / 3)),  # 15 N.m/s2 t^2: w = 30 - 25 t^3
        ("500 N/s2*time^2", 0.0, 0.5, np.inf),
    ],
)
def test_a_force_that_grows_from_zero_presses_a_brake(force, mu, e, stops):
    """At the start the plate touches without a force, and its acceleration is zero."""
    run = mbdsl.simulate(mbdsl.parse(PRESSED.format(force=force, mu=mu, e=e)), step=1e-3, stop=1.25)
    assert [x.t for x in run.events if x.kind == "stick"] == pytest.approx([stops] if mu else [], abs=1e-4)
    assert run["face.active"][-1] == 1.0
    assert run["shaft.w"][-1] == pytest.approx(0.0 if mu else 30.0, abs=1e-9)
