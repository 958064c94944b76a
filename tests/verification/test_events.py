"""Events of models, `when`, against closed forms and against a controller in discrete time."""

import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError, ModelError, UsageError
from mbdsl.integrators import compiled

METHODS = sorted(set(compiled()) - {"kinematic"})
SLIDE = """model M
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground{angle}, b.c);
  {declared}
initial equation
  rail.s = {s} m; rail.v = {v} m/s;
equation
  {events}
  annotation(experiment(StopTime = {stop} s));
end M;"""


def slide(declared, events, s=0.0, v=0.0, stop=3.0):
    text = SLIDE.format(angle="", declared=declared, events=events, s=s, v=v, stop=stop)
    return mbdsl.parse(text)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("given", [{"step": 7e-3}, {"tol": 1e-6}])
def test_bouncing_ball(method, given):
    """A constant force 9 N towards a wall at 0, and reinit of the velocity: the hits are a geometric series."""
    model = slide(
        "Integer hits(start = 0); Force weight(b.c, fx = -9 N);",
        """when rail.s <= 0 m then
             reinit(rail.v, -0.8*rail.v);
             hits = pre(hits) + 1;
           end when;
           when hits >= 5 then terminate("five hits"); end when;""",
        s=1.0,
        stop=10.0,
    )
    run = mbdsl.simulate(model, method=method, interval=0.1, **given)
    first = np.sqrt(2 / 9)
    last = first * (1 + 2 * sum(0.8**k for k in range(1, 5)))
    within = 2e-2 if method == "newmark" and "step" in given else 1e-6
    assert run.t[-1] == pytest.approx(last, rel=within)
    assert run["rail.v"][-1] == pytest.approx(9 * first * 0.8**5, rel=within)
    assert run["hits"][-1] == 5
    assert run["hits"][np.searchsorted(run.t, first) - 1] == 0


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "nstiff", "nstiff-si2", "generalized-alpha"])
def test_relay_with_hysteresis_keeps_the_order(method):
    """An oscillator x'' = F - x, F = 1 or -1 with hysteresis in x: errors fall by four when the step is halved."""
    model = slide(
        "Boolean on(start = true); Force f(b.c, fx = if on then 1 N else -1 N);"
        " TranslationalSpringDamper k(rail, k = 1 N/m);",
        "when rail.s > 0.5 m then on = false; elsewhen rail.s < -0.3 m then on = true; end when;",
        s=0.1,
        stop=4.0,
    )
    x, v, t, force = 0.1, 0.0, 0.0, 1.0  # exact: arcs of circles about F, from event to event
    while t < 4.0:
        r, phase = np.hypot(x - force, v), np.arctan2(-v, x - force)
        limit = 0.5 if force > 0 else -0.3
        turn = np.inf
        if abs(limit - force) < r:
            reached = [s * np.arccos((limit - force) / r) + 2 * np.pi * k for s in (1, -1) for k in (-1, 0, 1, 2)]
            rising = [a for a in reached if (-np.sin(a) > 0) == (force > 0)]
            turn = min(a - phase for a in rising if a - phase > 1e-12)
        step = min(turn, 4.0 - t)
        x, v, t = force + r * np.cos(phase + step), -r * np.sin(phase + step), t + step
        force = -force if step == turn else force
    errors = []
    for h in (5e-3, 2.5e-3, 1.25e-3):
        run = mbdsl.simulate(model, method=method, step=h, interval=4.0)
        errors.append(np.hypot(run["rail.s"][-1] - x, run["rail.v"][-1] - v))
    assert errors[-1] < 1e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.1)


#: a pendulum whose motor has a relay with hysteresis, between stops with e = 0.7 on one side: two unknowns, no closed
#: form; the reference is SciPy's DOP853 with the terminal events of the text
RELAY = """model Relay
  Ground ground;
  Body arm(m = 1 kg, I = 0.02 kg.m2, length = 0.6 m);
  Revolute pin(ground, arm.a);
  discrete Real u(unit = "N.m", start = 2);
  Torque motor(pin, tau = u - 0.3 N.m.s*pin.w);
initial equation
  pin.phi = -90 deg - 0.3; pin.w = 0 rad/s;
equation
  when pin.phi + pi/2 > 0.2 then u = -2; elsewhen pin.phi + pi/2 < -0.2 then u = 2; end when;
  when pin.phi + pi/2 > 0.35 then reinit(pin.w, -0.7*pin.w); end when;
end Relay;"""
RELAY_STOP = 2.0


@cache
def relay_reference():
    """Angle and speed at the end, with SciPy."""
    from scipy.integrate import solve_ivp

    t, y, u, past = 0.0, np.array([-0.3, 0.0]), 2.0, 0.0
    levels = ((0.2, 1), (-0.2, -1), (0.35, 1))
    while t < RELAY_STOP:
        events = [lambda t, y, level=level: y[0] - level for level, _ in levels]
        for event, (_, direction) in zip(events, levels, strict=True):
            event.terminal, event.direction = True, direction
        rates = lambda t, y, u=u: [y[1], (u - 0.3 * y[1] - 9.81 * 0.3 * np.sin(y[0])) / 0.11]  # noqa: E731
        given = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
        if past:  # away from the event
            near = solve_ivp(rates, (t, t + past), y, **given)
            t, y = near.t[-1], near.y[:, -1]
        found = solve_ivp(rates, (t, RELAY_STOP), y, events=events, **given)
        t, y, past = found.t[-1], found.y[:, -1].copy(), 1e-5
        hit = [len(x) > 0 for x in found.t_events]
        u = -2.0 if hit[0] else 2.0 if hit[1] else u
        y[1] *= -0.7 if hit[2] else 1.0
    return y


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"dop853", "radau5", "radau9", "radau13"}))
def test_fixed_steps_are_shortened_at_events_and_return_to_their_grid(method):
    """Impacts and a relay: no method loses its order, and reactions of index 3 bear short steps."""
    model, errors = mbdsl.parse(RELAY), []
    for n in (200, 400, 800):
        run = mbdsl.simulate(model, method=method, step=1 / n, stop=RELAY_STOP, interval=RELAY_STOP)
        found = run["pin.phi"][-1] + np.pi / 2, run["pin.w"][-1]
        errors.append(np.abs(np.array(found) - relay_reference()).max())
        # at most one step more for each event, before which one ends; a sliver joins its neighbour
        assert run.stats["steps"] <= RELAY_STOP * n + 3 * run.stats["events"]
    order = 1.0 if method == "newmark" else 2.0
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(order, abs=0.1)


def test_sampled_controller():
    """x'' = u with u held between samples of 10 ms: the exact discrete motion."""
    model = slide(
        'discrete Real u(unit = "N"); Force f(b.c, fx = u);',
        "when sample(0, 10 ms) then u = -4 N/m*rail.s - 2 N.s/m*rail.v; end when;",
        s=1.0,
        stop=2.0,
    )
    x, v, T = 1.0, 0.0, 0.01
    for _ in range(200):
        u = -4 * x - 2 * v
        x, v = x + T * v + T * T / 2 * u, v + T * u
    for method in ("hht-si2", "radau5", "nstiff"):
        run = mbdsl.simulate(model, method=method, step=1e-2, interval=1.0)
        assert run["rail.s"][-1] == pytest.approx(x, abs=1e-9 if method == "radau5" else 2e-5)
        assert run["u"][0] == pytest.approx(-4.0)


def test_coinciding_clocks_tick_once_and_late_ticks_are_exact():
    """0.1 k = 0.3 j: both clocks act at the same event; the last tick is 1 s."""
    model = slide(
        "Integer a(start = 0), c(start = 0), both(start = 0); Force f(b.c, fx = 1 N);",
        """when sample(0, 0.1 s) then a = pre(a) + 1; end when;
           when sample(0, 0.3 s) then c = pre(c) + 1; end when;
           when change(a) and change(c) then both = pre(both) + 1; end when;""",
        stop=3.0,
    )
    run = mbdsl.simulate(model, method="hht-si2", step=1e-2, interval=1.5)
    assert (run["a"][-1], run["c"][-1], run["both"][-1]) == (31, 11, 11)


def test_conditions_that_hold_at_the_start_do_not_act_and_initial_does():
    model = slide(
        "Integer n(start = 0), m(start = 0); Force f(b.c, fx = 0 N);",
        "when time >= 0 s then n = pre(n) + 1; end when; when initial() then m = 7; end when;",
        stop=1.0,
    )
    run = mbdsl.simulate(model, method="hht-si2", step=1e-2)
    assert set(run["n"]) == {0} and set(run["m"]) == {7}


def test_an_assertion_ends_the_run_with_its_values():
    model = slide("Force f(b.c, fx = 1 N);", 'when rail.s > 0.5 m then assert(rail.v < 0.5 m/s, "too fast"); end when;')
    with pytest.raises(IntegrationError, match=r"`rail.v < 0.5 m/s` is false at t = 1 s \(1 against 0.5\): too fast"):
        mbdsl.simulate(model, method="hht-si2", step=1e-2)


@pytest.mark.parametrize("given", [{"step": 1e-2, "method": "hht-si2"}, {"tol": 1e-6}])
def test_an_assertion_with_the_level_warning_lets_the_run_go_on(given):
    """A speed of 1 m/s s: 0.5 m/s at 0.5 s and 2 m/s at 2 s; a `when` asks at 1 s and 2 s."""
    model = slide(
        "Force f(b.c, fx = if time < 2.5 s then 1 N else -8 N);",
        """when sample(1, 1) then assert(rail.v < 0.5 m/s, "fast", AssertionLevel.warning); end when;
           assert(rail.v < 2 m/s, "very fast", level = AssertionLevel.warning);
           assert(rail.s > -1 m, "far", AssertionLevel.error);""",
    )
    run = mbdsl.simulate(model, interval=0.1, **given)
    assert run.t[-1] == 3.0 and run.stats["kinds of events"] == {"warning": 3}
    assert [x.t for x in run.events if x.kind == "warning"] == pytest.approx([1.0, 2.0, 2.0], abs=1e-6)
    fast, very = [x for x in run.stats["warnings"] if x.startswith("the assertion")]
    assert fast.startswith(
        "the assertion `rail.v < 0.5 m/s` is false: fast (line <text>:9, t = 1 s, the first of 2 times)"
    )
    assert very.startswith("the assertion `rail.v < 2 m/s` is false: very fast (line <text>:10, t = 2 s)")
    known = slide(
        "parameter Length L = 1 m; Force f(b.c, fx = 0 N);", 'assert(L > 2 m, "short", AssertionLevel.warning);'
    )
    assert [x.message for x in known.warnings] == ["the assertion `L > 2 m` is false: short"]


def test_equations_that_act_without_end_are_named():
    model = slide(
        "Integer x(start = 0), y(start = 0), z(start = 0); Real n = pre(x) + pre(y) + pre(z);",
        """when time > 1 s then z = 1; end when;
           when mod(n, 2) > 0.5 then x = pre(x) + 1; end when;
           when mod(n, 2) < 0.5 then y = pre(y) + 1; end when;""",
        v=1.0,
    )
    with pytest.raises(IntegrationError, match="act without end at t = 1") as problem:
        mbdsl.simulate(model, method="hht-si2", step=1e-2)
    assert problem.value.notes


def test_refusals():
    with pytest.raises(ModelError, match="positions do not jump"):
        slide("Integer n(start = 0);", "when time > 1 s then reinit(rail.s, 0 m); end when;")
    with pytest.raises(ModelError, match="set by two when-equations"):
        slide("Integer n(start = 0);", "when time > 1 s then n = 1; end when; when time > 2 s then n = 2; end when;")
    with pytest.raises(ModelError, match="no discrete variable"):
        slide("Force f(b.c, fx = 1 N);", "when time > 1 s then rail.s = 1 m; end when;")
    with pytest.raises(ModelError, match="takes a condition"):
        slide("Integer n(start = 0);", "when rail.s then n = 1; end when;")
    fast = slide("Integer n(start = 0);", "when sample(0, 1e-12 s) then n = 1; end when;", stop=3600.0)
    with pytest.raises(ModelError, match=r"ticks 3\.6e"):
        mbdsl.simulate(fast)


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "hht-add", "nstiff", "nstiff-si2", "generalized-alpha"])
def test_ticks_in_compiled_code_are_those_of_python(method, monkeypatch):
    """Two clocks, one of them off the grid of steps, forces that jump, and a value before the event: bit for bit the
    same counts, and motions that differ by rounding."""
    text = RELAY.replace("when pin.phi + pi/2 > 0.35", "when pin.phi > 9").replace(
        "when pin.phi + pi/2 > 0.2 then u = -2; elsewhen pin.phi + pi/2 < -0.2 then u = 2; end when;",
        """when sample(0, 10 ms) then u = -3 N.m*(pin.phi + pi/2) - 0.2 N.m.s*pin.w + 1 N.m*d; n = pre(n) + 1; end when;
        when sample(2.5 ms, 0.03 s) then d = cos(40*time); end when;""",
    )
    text = text.replace("discrete Real u", "Integer n(start = 0); discrete Real d(start = 0); discrete Real u")
    given = {"method": method, "step": 5e-3, "stop": 1.0, "interval": 0.1}
    compiled_ones = mbdsl.simulate(mbdsl.parse(text.replace("+ 1 N.m*d", "+ 1 N.m*pre(d)")), **given)
    assert compiled_ones.stats["events"] == 100 + 34
    monkeypatch.setattr("mbdsl.integrators.tick_history.HIGHEST", -1)
    python = mbdsl.simulate(mbdsl.parse(text.replace("+ 1 N.m*d", "+ 1 N.m*pre(d)")), **given)
    for name in ("n", "d", "u", "pin.phi", "pin.w"):
        assert compiled_ones[name] == pytest.approx(python[name], abs=1e-9, rel=1e-9), name


def test_the_last_of_many_samples_is_at_the_exact_time():
    """A sum of 0.1 s would be late by 1e-9 s after 100,000 of them; 0.1 k is the nearest double."""
    model = slide("Integer n(start = 0); discrete Real t(start = 0); Force f(b.c, fx = 0 N);",
                  "when sample(0, 0.1 s) then n = pre(n) + 1; t = time/(1 s); end when;", stop=10_000.0)  # fmt: skip
    run = mbdsl.simulate(model, method="hht-si2", step=0.1, interval=10_000.0)
    assert (run["n"][-1], run["t"][-1]) == (100_001, 10_000.0)


CLOCKED = (
    'discrete Real u(unit = "N", start = 1); Force f(b.c, fx = u);',
    "when sample(0, 10 ms) then u = -4 N/m*rail.s; end when; "
    "when rail.s > 0.05 m then reinit(rail.v, -0.5*rail.v); end when;",
)


def test_events_are_listed_with_kinds_and_lines(tmp_path, capsys):
    model = slide(*CLOCKED, v=1.0, stop=0.1)
    run = mbdsl.simulate(model, method="hht-si2", step=1e-3)
    assert run.stats["kinds of events"] == {"sample": 11, "reinit": 1}
    reinit = next(x for x in run.events if x.kind == "reinit")
    x, v, t, u = 0.0, 1.0, 0.0, 0.0  # exact: u is constant between samples
    while x + 0.01 * v + 5e-5 * u < 0.05:
        x, v, t = x + 0.01 * v + 5e-5 * u, v + 0.01 * u, t + 0.01
        u = -4 * x
    at = t + (v - np.sqrt(v * v + 2 * u * (0.05 - x))) / -u
    assert reinit.t == pytest.approx(at, abs=1e-9) and reinit.span.line == 9
    assert [x.t for x in run.events if x.kind == "sample"] == [k / 100 for k in range(11)]
    (tmp_path / "m.mbd").write_text(SLIDE.format(angle="", declared=CLOCKED[0], events=CLOCKED[1], s=0, v=1, stop=0.1))
    words = "simulate m.mbd --step 1ms --method hht-si2 --events e.csv --output o.csv".split()
    from mbdsl.cli import main

    here = os.getcwd()
    os.chdir(tmp_path)
    try:
        assert main(words) == 0
        shown = capsys.readouterr().out
        assert main([*words[:-3], "-", "--output", "o.csv", "--quiet"]) == 0
        assert not os.path.exists("-") and capsys.readouterr().out == (tmp_path / "e.csv").read_text()
    finally:
        os.chdir(here)
    assert "12 events (11 sample, 1 reinit); most of them by line m.mbd:9: 12" in shown
    rows = (tmp_path / "e.csv").read_text().splitlines()
    assert rows[:2] == ["time,kind,line,name", "0.0,sample,m.mbd:9,"] and len(rows) == 13


@pytest.mark.parametrize("given", [{"step": 1e-3, "method": "nstiff"}, {"tol": 1e-5, "method": "hht-si2"}])
def test_a_checkpoint_keeps_events(given, tmp_path):
    """A run that is interrupted and resumed equals an uninterrupted one bit for bit."""
    model = slide(*CLOCKED, v=1.0, stop=2.0)
    whole = mbdsl.simulate(model, interval=0.1, **given)
    calls = []

    def interrupt(progress):
        calls.append(progress.t)
        if len(calls) == 2:
            raise KeyboardInterrupt

    file = str(tmp_path / "c.ck")
    with pytest.raises(KeyboardInterrupt):
        mbdsl.simulate(model, interval=0.1, checkpoint=file, progress=interrupt, **given)
    resumed = mbdsl.resume(file, model)
    for name in ("rail.s", "u"):
        np.testing.assert_array_equal(resumed[name], whole[name])
    assert resumed.stats["kinds of events"] == whole.stats["kinds of events"]


@pytest.mark.parametrize("given", [{"step": 1e-4, "method": "nstiff"}, {"tol": 1e-6, "method": "hht-si2"}])
def test_a_checkpoint_keeps_contacts(given, tmp_path):
    """A ball that has come to rest, and one that still bounces: bit for bit."""
    model = mbdsl.parse(
        "model M Ground o; PointMass a(m = 1 kg); PointMass b(m = 1 kg); Contact f(gap = a.y, e = 0.5); "
        "Contact g(gap = b.y, e = 0.9); initial equation a.x = 0 m; a.vx = 0 m/s; a.y = 0.1 m; a.vy = 0 m/s; "
        "b.x = 0 m; b.vx = 0 m/s; b.y = 1 m; b.vy = 0 m/s; end M;"
    )
    whole = mbdsl.simulate(model, interval=0.1, stop=2.0, **given)
    late = []

    def interrupt(progress):
        if progress.t > 0.5 and not late:  # a is at rest from 0.4283 s on
            late.append(progress.t)
            raise KeyboardInterrupt

    file = str(tmp_path / "c.ck")
    with pytest.raises(KeyboardInterrupt):
        mbdsl.simulate(model, interval=0.1, stop=2.0, checkpoint=file, progress=interrupt, **given)
    resumed = mbdsl.resume(file, model)
    for name in ("a.y", "b.y", "f.force", "g.impacts"):
        np.testing.assert_array_equal(resumed[name], whole[name])
    assert whole["f.force"][-1] == pytest.approx(9.81) and resumed.stats["events"] == whole.stats["events"]


@pytest.mark.parametrize("method", ["scipy-radau", "ida"])
def test_backends_refuse_events(method):
    model = slide(*CLOCKED)
    with pytest.raises(UsageError, match="does not know the `when`"):
        mbdsl.simulate(model, method=method, tol=1e-5)


def test_a_clock_that_would_never_end_is_refused_at_once():
    model = slide(
        "Integer n(start = 0); Force f(b.c, fx = 0 N);", "when sample(0, 1e-12 s) then n = pre(n) + 1; end when;"
    )
    with pytest.raises(ModelError, match=r"sample\(0 s, 1e-12 s\) ticks 3e\+12 times"):
        mbdsl.simulate(model, method="hht-si2", step=1e-3)


def test_sampled_cart_pole():
    """A pole on a cart with a sampled controller, whose force is held for 1 ms: RK4 in two coordinates, from sample to
    sample."""
    model = mbdsl.parse(
        (Path(__file__).parents[2] / "docs" / "events.md").read_text().split("```mbd\n")[1].split("```")[0]
    )
    M, m, c, J = 1.0, 0.2, 0.3, 0.2 * 0.6**2 / 12

    def rates(y, F):
        _, phi, vx, w = y
        A = np.array([[M + m, -m * c * np.sin(phi)], [-m * c * np.sin(phi), J + m * c * c]])
        b = np.array([F + m * c * np.cos(phi) * w * w, -m * 9.81 * c * np.cos(phi)])
        return np.array([vx, w, *np.linalg.solve(A, b)])

    y, h = np.array([0.0, np.pi / 2 + 0.2, 0.0, 0.0]), 1e-3
    for _ in range(1000):
        F = 6.3 * y[0] + 8 * y[2] - 53.3 * (y[1] - np.pi / 2) - 10.6 * y[3]
        F = max(-20.0, min(20.0, F))
        k1 = rates(y, F)
        k2 = rates(y + h / 2 * k1, F)
        k3 = rates(y + h / 2 * k2, F)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(y + h * k3, F))
    assert y[:2] - [0, np.pi / 2] == pytest.approx([-0.220807, -0.0332855], abs=1e-6)  # as the specification says
    for method, within in (("hht-si2", 2e-6), ("nstiff", 5e-6), ("radau5", 1e-7)):
        run = mbdsl.simulate(model, method=method, stop=1.0, step=1e-3)
        assert [run["cart.x"][-1], run["pole.phi"][-1]] == pytest.approx(y[:2], abs=within)


def test_equations_of_one_event_are_sorted_and_circles_are_errors():
    """y = 2 x is after x = 1 + pre(x), whatever the text says first; and so is a chain of three."""
    declared = "Integer x(start = 0), y(start = 0), z(start = 0); Force f(b.c, fx = 0 N);"
    events = ("when sample(0, 1 s) then z = y + x; end when;", "when sample(0, 1 s) then y = 2*x; end when;",
              "when sample(0, 1 s) then x = 1 + pre(x); end when;")  # fmt: skip
    for text in (" ".join(events), " ".join(events[::-1])):
        run = mbdsl.simulate(slide(declared, text, stop=2.0), method="hht-si2", step=0.1, interval=1.0)
        assert [list(run[x]) for x in "xyz"] == [[1, 2, 3], [2, 4, 6], [3, 6, 9]]
    with pytest.raises(ModelError, match=r"cyclic definition: x -> y -> x") as problem:
        slide(declared, "when time > 1 s then x = y + 1; y = x; end when;")
    assert "pre(x)" in problem.value.hint and problem.value.notes
    with pytest.raises(ModelError, match=r"cyclic definition: x -> x"):
        slide(declared, "when time > 1 s then x = x + 1; end when;")


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_an_assertion_at_the_end(method):
    """It is checked by `terminal()`, although the run is complete then."""
    scene = slide("Force f(b.c, fx = 0 N);", 'when terminal() then assert(time < 0.5 s, "late"); end when;')
    assert mbdsl.simulate(scene, stop=0.4, step=1e-2, method=method).status == "done"
    with pytest.raises(IntegrationError, match="late"):
        mbdsl.simulate(scene, stop=0.6, step=1e-2, method=method)


def test_arrays_sub_models_and_the_end():
    counter = """model Counter
      parameter Time T = 0.1 s;
      Integer n(start = 0);
    equation
      when sample(0, T) then n = pre(n) + 1; end when;
    end Counter;
    """
    declared = (
        "Counter c[2](T = {0.1 s, 0.25 s}); Integer last(start = 0); Real x[3](each start = 0);"
        "Force f(b.c, fx = 1 N*c[1].n);"
    )
    events = (
        "when sample(0, 0.5 s) then for i in 1:3 loop x[i] = pre(x[i]) + i*time/(1 s); end for; end when;"
        "when terminal() then last = c[2].n; end when;"
    )
    text = counter + SLIDE.format(angle="", s=0, v=0, stop=1.0, declared=declared, events=events)
    run = mbdsl.simulate(mbdsl.parse(text), method="hht-si2", step=1e-2, interval=0.5)
    assert [run[f"c[{k}].n"][-1] for k in (1, 2)] == [11, 5]
    assert [run[f"x[{k}]"][-1] for k in (1, 2, 3)] == [1.5, 3.0, 4.5]
    assert list(run["last"]) == [0, 0, 5]
    with pytest.raises(ModelError, match="set twice in one event"):
        slide("Integer n(start = 0); Force f(b.c, fx = 0 N);", "when time > 1 s then n = 1; n = 2; end when;")


def test_events_in_space():
    """A rotor that swings against a wall without loss: w'' = -w between impacts at 0.3 rad, phi = sin t."""
    model = mbdsl.parse("""spatial model M
      Ground ground;
      Body b(m = 1 kg, I = {1, 1, 1} kg.m2);
      Revolute pin(ground, b.c, n = {0, 0, 1});
      Torque f(pin, tau = -1 N.m*pin.phi);
      Integer n(start = 0);
    initial equation
      pin.phi = 0; pin.w = 1 rad/s;
    equation
      when pin.phi > 0.3 then reinit(pin.w, -pin.w); n = pre(n) + 1; end when;
    end M;""")
    run = mbdsl.simulate(model, method="hht-si2", step=2e-3, stop=3.0, interval=1.0)
    to_wall = np.arcsin(0.3)  # then backwards in time: phi = sin(2 to_wall - t), until the next impact
    period = 2 * to_wall + np.pi
    assert run["n"][-1] == 1 and period > 3.0
    assert run["pin.phi"][-1] == pytest.approx(np.sin(2 * to_wall - 3.0), abs=1e-5)


def test_a_model_of_parts_with_events_is_checked(tmp_path, capsys):
    """A state beside a mechanism, which nothing joins to it: conditions read bodies of any part."""
    model = slide(
        "Current i(start = 0 A);", "der(i) = 1 A/s; when rail.s > 0.5 m then reinit(i, 0 A); end when;", v=1.0
    )
    path = tmp_path / "m.mbd"
    path.write_text(next(iter(model.files.values())))
    from mbdsl import cli

    cli.main(["check", str(path)])
    assert "internal error" not in capsys.readouterr().err
    run = mbdsl.simulate(model, stop=1.0, interval=1.0)
    assert run["i"][-1] == pytest.approx(0.5)
