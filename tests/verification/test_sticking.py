"""Friction that sticks, against closed forms: where and when joints stop and slide, and orders of methods."""

from math import atan, cos, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.simulation.checkpoint import Checkpoint
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.resume import resume

ROOT = Path(__file__).parents[2]
OSCILLATOR = """
model Oscillator "k = 100 N/m, m = 1 kg, mu N = 2 N"
  Ground ground(g = 10 m/s2);
  Frame wall(ground, r = {-1 m, 0});
  Body block(m = 1 kg, I = 1 kg.m2);
  Prismatic slide(ground, block.c, mu = 0.2, sticks = true);
  SpringDamper spring(wall, block.c, k = 100 N/m, s0 = 1 m);
initial equation
  slide.s = 0.25 m; slide.v = 0 m/s;
end Oscillator;
"""
STACK = """
model Stack "a block carries another one"
  parameter Force F = 8 N;
  Ground ground(g = 10 m/s2);
  Body lower(m = 1 kg, I = 1 kg.m2), upper(m = 0.5 kg, I = 1 kg.m2);
  Prismatic floor(ground, lower.c, mu = 0.2, mu_s = 0.3, sticks = true);
  Prismatic top(lower.c, upper.c, mu = 0.3, mu_s = 0.4, sticks = true);
  Force pull(lower.c, fx = F);
initial equation
  floor.s = 0 m; floor.v = 0 m/s; top.s = 0 m; top.v = 0 m/s;
end Stack;
"""


def belt() -> mbdsl.Scene:
    text = (ROOT / "models" / "stick_slip_belt.mbd").read_text()
    return mbdsl.parse(text.replace("v_s = v_s, v_st = v_st", "sticks = true"))


def on_belt(t: float) -> float:
    """The block carried at 0.1 m/s to 50 mm, where the spring pulls with mu_s N = 5 N; it slips about 30 mm, where it
    pulls with mu N = 3 N, with 10 rad/s, until it has the speed of the belt again, after 0.406888787 s at 10 mm."""
    slip = (2 * pi - 2 * atan(2)) / 10
    if t < 0.5:
        return 0.1 * t
    after = (t - 0.5) % (slip + 0.4)
    return 0.03 + 0.02 * cos(10 * after) + 0.01 * sin(10 * after) if after < slip else 0.1 * (after - slip + 0.1)


@pytest.mark.parametrize(("h", "error"), [(0.01, 3e-5), (0.0025, 5e-7)])
def test_an_oscillator_with_dry_friction_comes_to_rest(h, error):
    run = mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=2.5, step=h, method="hht-si2", interval=h)
    assert run["slide.s"][-1] == pytest.approx(0.01, abs=error)
    last = run.events[-1]
    assert (last.kind, last.t) == ("stick", pytest.approx(6 * pi / 10, abs=20 * h * h))
    moving = np.flatnonzero(run["slide.sliding"])
    assert run.t[moving[-1]] == pytest.approx(6 * pi / 10, abs=1.1 * h)
    assert run["slide.v"][-1] == pytest.approx(0.0, abs=1e-12)
    assert run["slide.friction"][-1] == pytest.approx(-100 * run["slide.s"][-1])


def test_a_block_on_a_belt_sticks_and_slips():
    run = mbdsl.simulate(belt(), stop=2.0, tol=1e-7, interval=0.01)
    assert run["block.x"] == pytest.approx([on_belt(t) for t in run.t], abs=1e-6)
    slip, period = 0.406888787, 0.806888787
    times = [0.5, 0.5 + slip, 0.5 + period, 0.5 + period + slip]
    assert [(x.kind, x.t) for x in run.events] == [
        (kind, pytest.approx(t, abs=1e-6)) for kind, t in zip(("slip", "stick", "slip", "stick"), times, strict=True)
    ]
    sliding = [0.5 < t < 0.906888 or 1.306889 < t < 1.713777 for t in run.t]
    assert (run["contact.sliding"][1:] == -np.array(sliding, float)[1:]).mean() > 0.98  # but at the changes
    assert {"contact.sliding", "contact.friction"} <= set(run.signals)


@pytest.mark.parametrize(
    ("method", "order"),
    [
        ("newmark", 1.0),
        *((name, 2.0) for name in ("hht-i3", "hht-si2", "hht-add", "generalized-alpha", "generalized-alpha-i3")),
        *((name, 2.0) for name in ("nstiff", "nstiff-si2")),
    ],
)
def test_no_order_is_lost_where_a_block_sticks_and_slips(method, order):
    scene, errors = belt(), []
    for steps in (200, 400, 800):
        run = mbdsl.simulate(scene, stop=2.0, step=1.0 / steps, method=method)
        errors.append(abs(run["block.x"][-1] - on_belt(2.0)))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("method", ["radau5", "radau9", "dop853"])
def test_methods_of_high_order_find_where_a_block_sticks_and_slips(method):
    run = mbdsl.simulate(belt(), stop=2.0, tol=1e-9, method=method)
    assert run["block.x"][-1] == pytest.approx(on_belt(2.0), abs=2e-9)


@pytest.mark.parametrize(
    ("force", "lower", "upper"),
    [
        (4.0, 0.0, 0.0),  # less than 0.3*15 N: both rest
        (8.0, (8.0 - 3.0) / 1.5, (8.0 - 3.0) / 1.5),  # the lower one slides and carries the upper one
        (12.0, 12.0 - 3.0 - 1.5, 3.0),  # the upper one would need 3 N, more than 0.4*5 N: both slide
    ],
)
def test_several_joints_stick_or_slide(force, lower, upper):
    run = mbdsl.simulate(mbdsl.parse(STACK).with_parameters(F=force), stop=0.2, step=0.01, method="hht-si2")
    assert run["lower.ax"][-1] == pytest.approx(lower, abs=1e-9)
    assert run["upper.ax"][-1] == pytest.approx(upper, abs=1e-9)
    assert run["lower.x"][-1] == pytest.approx(lower * 0.02, abs=1e-9)
    assert run["upper.x"][-1] == pytest.approx(upper * 0.02, abs=1e-9)


def test_a_pin_with_friction_holds_a_pendulum():
    text = """
model Pin
  Ground ground(g = 10 m/s2);
  Rod rod(m = 1 kg, length = 0.1 m);
  Revolute pin(ground, rod.a, radius = 0.1 m, mu = 0.2, sticks = true);
initial equation
  pin.phi = -90 deg + 10 deg; pin.w = 0 rad/s;
end Pin;
"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=1.0, step=0.01, method="hht-i3")
    # the weight needs 10*0.05*sin(10 deg) = 0.087 N.m; 0.2*0.1*10 = 0.2 N.m are there
    assert run["pin.phi"] == pytest.approx(np.full(len(run.t), radians(-80)), abs=1e-14)
    assert run["pin.friction"] == pytest.approx(np.full(len(run.t), -10 * 0.05 * sin(radians(-10))) * -1, rel=1e-6)


def test_a_slide_in_space_holds_its_load():
    text = """
spatial model Incline
  Ground ground;
  Body block(m = 1 kg, I = {1e-3, 1e-3, 1e-3} kg.m2);
  Prismatic slide(ground, block.c, n = {cos(20 deg), -sin(20 deg), 0}, mu = MU, mu_s = 0.5, sticks = true);
initial equation
  slide.s = 0 m; slide.v = 0.5 m/s;
end Incline;
"""
    N, pull = 9.81 * cos(radians(20)), 9.81 * sin(radians(20))
    run = mbdsl.simulate(mbdsl.parse(text.replace("MU", "0.4")), stop=6.0, step=0.01, method="hht-si2")
    assert run["slide.s"][-1] == pytest.approx(0.5**2 / 2 / (0.4 * N - pull), rel=1e-5)
    assert run["slide.v"][-1] == pytest.approx(0.0, abs=1e-12)
    assert run["slide.friction"][-1] == pytest.approx(pull)


FEET = """
model Feet "a block on two feet that carry 0.9 N and 0.1 N"
  parameter Real first = 0.6, second = 0.6;
  Ground ground(g = 1 m/s2);
  Body block(m = 1 kg, I = 0.1 kg.m2, frames(left = {-0.1 m, 0}, right = {0.9 m, 0}));
  PointOnLine left(ground, block.left, mu = first, sticks = true);
  PointOnLine right(ground, block.right, mu = second, sticks = true);
  Force load(block.c, fx = LOAD);
initial equation
  block.x = 0 m; block.vx = 0 m/s;
end Feet;
"""


def test_friction_of_two_feet_is_shared_in_proportion_to_their_loads():
    run = mbdsl.simulate(mbdsl.parse(FEET.replace("LOAD", "0.5 N")), stop=1.0, step=0.1, method="hht-si2")
    assert any("friction of left, right is not unique from t = 0 s on" in x for x in run.stats["warnings"])
    assert run["left.friction"] == pytest.approx(np.full(len(run.t), 0.45))
    assert run["right.friction"] == pytest.approx(np.full(len(run.t), 0.05))
    assert np.abs(run["block.x"]).max() < 1e-30


def test_two_feet_slide_where_all_of_their_friction_is_used():
    scene = mbdsl.parse(FEET.replace("LOAD", "0.7 N/s*time"))
    # with 0.9 of the load and other coefficients: shares in proportion to mu N reach the limits at the same time
    for first, second in ((0.6, 0.6), (0.5, 0.2)):
        run = mbdsl.simulate(scene.with_parameters(first=first, second=second), stop=1.0, step=0.01, method="hht-si2")
        start = (0.9 * first + 0.1 * second) / 0.7
        moving = run["left.sliding"] != 0.0
        assert run.t[moving][0] == pytest.approx(start, abs=0.0101)
        assert (moving == (run["right.sliding"] != 0.0)).all()
        assert run["block.x"][-1] == pytest.approx(0.7 * (1.0 - start) ** 3 / 6, rel=5e-3)


def test_a_law_that_reads_friction_that_is_not_unique_is_refused():
    text = FEET.replace("LOAD", "0.5 N").replace("initial", "  Force spy(block.c, fy = -1e-3*left.friction);\ninitial")
    with pytest.raises(mbdsl.InitialisationError, match="`spy` reads the friction of `left`, which is not unique"):
        mbdsl.simulate(mbdsl.parse(text), stop=1.0, step=0.1, method="hht-si2")


@pytest.mark.parametrize("speed", ["0 m/s", "0.1 m/s"])
def test_joints_that_hold_the_same_motion_stop_together(speed):
    text = """
model Two
  Ground ground(g = 10 m/s2);
  Body a(m = 1 kg, I = 1 kg.m2), b(m = 3 kg, I = 1 kg.m2);
  Prismatic p(ground, a.c, mu = 0.5, sticks = true), q(ground, b.c, mu = 0.5, sticks = true);
  Distance rod(a.c, b.c, length = 1 m);
  Force pull(a.c, fx = if time < 0.5 s then 0 N else 4 N);
initial equation
  p.s = 0 m; p.v = V; guess q.s = 1 m;
end Two;
"""
    run = mbdsl.simulate(mbdsl.parse(text.replace("V", speed)), stop=1, step=0.01, method="hht-si2", interval=0.01)
    stopped = float(speed.split()[0]) / 5.0
    assert ((run["p.sliding"] != 0.0) == (run.t < stopped + 1e-9))[1:].all()
    assert run["p.friction"][-1] == pytest.approx(1.0)
    assert run["q.friction"][-1] == pytest.approx(3.0)


def test_backends_are_refused():
    with pytest.raises(mbdsl.UsageError, match="does not know friction that sticks, of `slide`"):
        mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=1, tol=1e-5, method="scipy-radau")


def test_a_stribeck_speed_is_refused():
    with pytest.raises(mbdsl.ModelError, match="leave the Stribeck speed out"):
        mbdsl.parse(OSCILLATOR.replace("sticks = true", "sticks = true, v_st = 1 mm/s"))


@pytest.mark.parametrize("reached", [0.15, 0.6, 1.6])  # it is held, slips, and has slipped and been held before
@pytest.mark.parametrize("name", ["belt", "feet"])
def test_a_run_that_is_resumed_knows_what_sticks(tmp_path, monkeypatch, name, reached):
    """The run pauses at least every 20 steps; how many slices of steps it takes depends on the machine's speed."""
    advance = MechanismRun.advance
    monkeypatch.setattr(MechanismRun, "advance", lambda self, most: advance(self, min(most, 20)))
    (tmp_path / "belt.mbd").write_text(
        (ROOT / "models" / "stick_slip_belt.mbd").read_text().replace("v_s = v_s, v_st = v_st", "sticks = true")
    )
    (tmp_path / "feet.mbd").write_text(FEET.replace("LOAD", "0.9 N*sin(4*time/(1 s))"))
    given = {"stop": 2.0, "step": 0.005, "method": "hht-si2", "interval": 0.01}

    def until(progress):
        if progress.t > reached:
            raise KeyboardInterrupt

    whole = mbdsl.simulate(tmp_path / f"{name}.mbd", **given)
    kept = tmp_path / "run.cp"
    with pytest.raises(mbdsl.Interrupted):
        mbdsl.simulate(tmp_path / f"{name}.mbd", **given, checkpoint=Checkpoint(kept, every=0.0), progress=until)
    resumed = resume(kept)
    assert len(set(whole[f"{'contact' if name == 'belt' else 'left'}.sliding"])) > 1
    for signal in whole.default_names:
        assert np.array_equal(whole[signal], resumed[signal])
    for signal in ("contact.friction",) if name == "belt" else ("left.friction", "right.friction"):
        assert np.array_equal(whole[signal], resumed[signal])
    assert whole.stats["warnings"] == resumed.stats["warnings"]


def test_a_simulation_goes_on_step_by_step_and_is_copied():
    run = mbdsl.Simulation(belt(), step=0.005, method="hht-si2")
    run.step(120)  # it slips
    other = run.copy()
    run.step(280)
    other.step(280)
    assert run["block.x"] == other["block.x"] == pytest.approx(on_belt(2.0), abs=3e-5)
    assert run["contact.sliding"] == 0.0
    assert run["contact.friction"] == pytest.approx(-100 * run["block.x"])


def test_statics_leave_friction_out_and_states_of_a_motion_have_it():
    text = OSCILLATOR.replace("0.25 m", "0.01 m").replace(
        "(m = 1 kg, I = 1 kg.m2)", "(m = 1 kg, I = 1 kg.m2), free(m = 1 kg, I = 1 kg.m2)"
    )
    more = "  Prismatic other(ground, free.c);\n  SpringDamper link(block.c, free.c, k = 100 N/m, s0 = 1 m);\n"
    text = text.replace("  SpringDamper", f"{more}  SpringDamper")
    text = text.replace("  slide.s", "  other.s = 1 m; other.v = 0 m/s; slide.s")
    scene = mbdsl.parse(text)
    rest = mbdsl.static(scene)
    assert "friction of slide is left out: it can hold other poses as well" in rest.notes
    assert rest["slide.s"] == pytest.approx(0.0, abs=1e-9)
    held = mbdsl.eigen(scene, at="start")
    assert [mode.frequency for mode in held.modes] == pytest.approx([10 / (2 * pi)])
    with pytest.raises(mbdsl.EquilibriumError, match="keeps moving") as caught:
        mbdsl.static(mbdsl.load(ROOT / "tests" / "data" / "machines" / "incline.mbd"))
    assert "friction of slide is left out, mbdsl simulate shows whether it holds" in caught.value.hint


ROD = """
model Jam "a uniform rod whose tip slides in a slot: no solution from mu = 4/3 on where its slope is 2"
  Ground ground;
  Rod rod(m = 1 kg, length = 2 m);
  PointOnLine tip(ground, rod.a, mu = MU, sticks = true);
initial equation
  tip.s = 0 m; tip.v = SPEED; rod.phi = PHI; rod.w = TURN;
end Jam;
"""


def rod(mu, speed, phi, turn):
    text = ROD.replace("MU", str(mu)).replace("SPEED", speed).replace("PHI", phi).replace("TURN", turn)
    return mbdsl.simulate(mbdsl.parse(text), stop=1.0, step=1e-3, method="hht-si2")


def test_painleves_paradox_is_named_with_the_least_coefficient():
    expected = r"reactions of `tip` do not exist or are not unique from mu = 1\.33333 on \(Painleve's paradox\)"
    with pytest.raises(mbdsl.InitialisationError, match=expected) as caught:
        rod(1.4, "1 m/s", "180 deg - atan(2)", "0 rad/s")
    assert caught.value.span.line == 5
    rod(1.3, "1 m/s", "180 deg - atan(2)", "0 rad/s")


def test_a_rod_that_slides_into_painleves_paradox():
    with pytest.raises(mbdsl.IntegrationError, match=r"from mu = 1\.4[89]\d* on \(Painleve's paradox\)"):
        rod(1.5, "10 m/s", "140 deg", "-4 rad/s")


def test_a_joint_that_others_drive_slides_at_once_and_rests_where_the_motion_does():
    text = """
model Driven "10 N and mu = 0.2: friction of 2 N against the motion, which the drive overcomes"
  Ground ground(g = 10 m/s2);
  Body block(m = 1 kg, I = 1 kg.m2);
  Prismatic slide(ground, block.c, mu = 0.2, sticks = true);
  TranslationalDriver drive(slide, s = if time < 0.5 s then 0.1 m*sin(2*pi*time/(1 s))^2 else 0 m);
end Driven;
"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=1.0, step=0.01, method="hht-si2", interval=0.01)
    forth, back, rest = ((t0 + 0.005 < run.t) & (run.t < t1 - 0.005) for t0, t1 in ((0, 0.25), (0.25, 0.5), (0.5, 1.0)))
    a = 0.1 * 8 * pi**2 * np.cos(4 * pi * run.t)
    for moving, sense in ((forth, 1.0), (back, -1.0)):
        assert (run["slide.sliding"][moving] == sense).all()
        assert run["slide.friction"][moving] == pytest.approx(np.full(moving.sum(), 2.0 * sense))
        assert run["drive.force"][moving] == pytest.approx(-a[moving] - 2.0 * sense, abs=0.1)
    assert (run["slide.sliding"][rest] == 0.0).all()
    assert run["drive.force"][rest] == pytest.approx(np.zeros(rest.sum()), abs=1e-9)
