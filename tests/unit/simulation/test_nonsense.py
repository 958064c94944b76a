"""Contradictory or meaningless arguments are errors, and are not silently replaced."""

from types import SimpleNamespace

import numpy as np
import pytest

from mbdsl import Builder, InitialisationError, Simulation, UsageError, simulate
from mbdsl.lang.load import parse_text
from mbdsl.messages import once
from mbdsl.simulation.result_checks import inaccurate

PENDULUM = """model Pendulum Ground g0; Rod rod(m = 1 kg, length = 1 m); Revolute pin(g0, rod.a); {}
  annotation(experiment({})); end Pendulum;"""


def pendulum(experiment="StopTime = 1 s, Step = 1 ms", more=""):
    return parse_text(PENDULUM.format(more, experiment))


# -- steps ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("experiment", "given"),
    [
        ("StopTime = 1 s", {"step": 10.0}),
        ("StopTime = 1 s, Step = 1 ms", {"step": 1.001}),
        ("StopTime = 1 s, Step = 10 s", {}),
        ("StopTime = 1 s", {"step": 0.5, "start": 0.9}),
    ],
)
def test_a_step_longer_than_the_run_is_refused(experiment, given):
    with pytest.raises(UsageError, match=r"a step of .* s is longer than the run, from .* to 1 s"):
        simulate(pendulum(experiment), **given)


def test_a_step_as_long_as_the_run_and_a_run_shorter_than_the_models_step_are_meant():
    assert simulate(pendulum(), step=0.01, stop=0.01).stats["steps"] == 1
    assert simulate(pendulum("StopTime = 1 s, Step = 10 ms"), stop=5e-3).stats["h"] == 5e-3
    assert len(simulate(pendulum(), step=10.0, stop=0.0).t) == 1  # only the start


def test_the_command_refuses_a_step_longer_than_the_run(say, tmp_path):
    (tmp_path / "p.mbd").write_text(PENDULUM.format("", "StopTime = 1 s"))
    code, out, err = say("simulate", "p.mbd", "--step", "10")
    assert (code, out) == (2, "")
    assert err.startswith("error: a step of 10 s is longer than the run, from 0 to 1 s\n")
    assert not (tmp_path / "p.csv").exists()


def test_a_step_and_a_tolerance_exclude_each_other():
    with pytest.raises(UsageError, match="found a step and a tolerance"):
        simulate(pendulum(), step=1e-3, tol=1e-3)


# -- tolerances -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"tol": "abc"}, "tol: `abc` is not a number"),
        ({"tol": True}, "tol: found True, expected a number"),
        ({"tol": np.float32(2.0)}, "a tolerance is between 0 and 1, not 2"),
        ({"tol": float("nan")}, "a tolerance is between 0 and 1, not nan"),
        ({"tol": 1e-20}, "less than the rounding errors of a run, .* expected 2.5e-14 or more"),
        ({"tol": 1e-12, "start": 1e6, "stop": 1e6 + 1.0}, "rounding errors of times from 1000000 to 1000001 s"),
        ({"accuracy": "abc"}, "accuracy: `abc` is not a number"),
        ({"accuracy": 1e-16}, "an accuracy of 1e-16 is less than the rounding errors of a run"),
        ({"accuracy": 1e-3, "budget": "long"}, "budget: `long` is not a number, with or without a unit, such as 1.5s"),
    ],
    ids=str,
)
def test_tolerances_that_no_run_keeps_are_refused(given, message):
    with pytest.raises(UsageError, match=message):
        simulate(pendulum("StopTime = 1 s"), **given)


def test_positions_far_away_have_rounding_errors():
    """A length of 1 m at 1e9 m: half of the last digit of a position is 6e-8 m."""
    text = """model Far Ground g(g = 0); Frame there(g, r = {1e9 m, 0}); Rod rod(m = 1 kg, length = 1 m);
      Revolute pin(there, rod.a); annotation(experiment(StopTime = 1 s)); initial equation pin.w = 1; end Far;"""
    with pytest.raises(UsageError, match="rounding errors of coordinates that are 1e"):
        simulate(parse_text(text), tol=6e-8)


def test_a_method_is_meant():
    with pytest.raises(UsageError, match="there is no method `hht-si`") as problem:
        simulate(pendulum(), method="hht-si")
    assert problem.value.hint.startswith("did you mean `hht-si2`")
    with pytest.raises(UsageError) as problem:
        simulate(pendulum(), method="hht-si", accuracy=1e-3)
    assert problem.value.hint.startswith("did you mean `hht-si2`")
    with pytest.raises(UsageError) as problem:
        simulate(pendulum(), method="euler")
    assert "radau5" in problem.value.hint


def test_what_is_said_of_a_tolerance_that_is_kept_for_a_while():
    """The hint names the time, and a method that needs fewer steps."""
    stats = {"tol": 1e-9, "error": 1e-6, "horizon": 4.56, "method": "hht-si2"}
    error = inaccurate(SimpleNamespace(stats=stats, t=np.array([0.0, 10.0])), "it would take too many steps")
    assert error.hint == "ask for a larger tolerance, or take radau5, which needs fewer steps, or stop at t = 4.56 s"


def test_lines_are_announced_once():
    lines: list[str] = []
    say = once(lines.append, {"known"})
    for line in ("compiling", "known", "compiling", "other"):
        say(line)
    assert lines == ["compiling", "other"]


@pytest.mark.parametrize("count", [0, -3, 1.5, True, "2", None])
def test_a_number_of_steps_is_a_whole_number_above_zero(count):
    simulation = Simulation(pendulum())
    with pytest.raises(UsageError, match="steps, expected an integer of 1 or more"):
        simulation.step(count)
    assert simulation.time == 0.0
    assert simulation.step(np.int64(2)) == 2e-3


# -- handles of another Builder -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "use",
    [
        lambda c, r, w: c.Revolute("p", w, r.b),
        lambda c, r, w: c.frame("tip", r.b),
        lambda c, r, w: c.Torque("T", tau=r.b),
        lambda c, r, w: c.variable("x", r.phi),
        lambda c, r, w: c.initial(r.phi, 0.1),
        lambda c, r, w: c.initial("r.phi", r.phi),
        lambda c, r, w: c.connect(w, r.b),
        lambda c, r, w: c.add("Body", "B", m=1.0, I=1.0, frames={"tip": (r.x, 0.0)}),
    ],
)
def test_handles_of_another_builder_are_refused(use):
    a, c = Builder("A"), Builder("C")
    a.Ground("w")
    r = a.Rod("r", m=1.0, length=1.0)
    w = c.Ground("w")
    c.Rod("r", m=2.0, length=3.0)
    with pytest.raises(UsageError, match=r"`r\.?\w*` belongs to another Builder, of A, and not to this one, of C"):
        use(c, r, w)


# -- other names of frames ----------------------------------------------------------------------------------------
def test_other_names_of_frames_have_signals():
    """The same point under any name: an alias, a connector of a sub-model, an alias of that."""
    text = """model Arm
      Frame F; Frame tip = rod.b; Rod rod(m = 2 kg, length = 1 m);
    equation connect(F, rod.a); end Arm;
    model A Ground w; Arm K1; Frame F = K1.F; Frame T = K1.tip; Frame post = w; PointMass q(m = 1 kg); Frame Q = q.c;
      Revolute pin(w, F); SpringDamper s(w, q.c, k = 10 N/m, s0 = 1 m);
      annotation(experiment(StopTime = 0.1 s, Step = 1 ms));
    initial equation pin.phi = 30 deg; q.x = 1 m; end A;"""
    run = simulate(parse_text(text))
    same = {"F": "K1.rod.a", "K1.F": "K1.rod.a", "T": "K1.rod.b", "K1.tip": "K1.rod.b", "Q": "q.c"}
    for other, name in same.items():
        for key in ("x", "y", "phi", "vx", "vy", "w"):
            assert f"{other}.{key}" in run.names
            assert (run[f"{other}.{key}"] == run[f"{name}.{key}"]).all()
            assert run.unit(f"{other}.{key}") == run.unit(f"{name}.{key}")
    assert (run["post.x"] == 0.0).all()
    assert abs(run["T.x"][0] - np.cos(np.pi / 6)) < 1e-12


def test_a_law_without_a_derivative_at_the_start_is_named():
    """-sign(v) sqrt(abs(v)) at rest: its derivative is infinite."""
    scene = parse_text(
        """model Root
  Ground ground(g = 0);
  Body b(m = 1, I = 1);
  Prismatic rail(ground, b.c);
  TranslationalSpringDamper law(rail, force = -4*sign(v)*sqrt(abs(v)) - 100*s);
initial equation
  rail.s = 0.1;
  rail.v = 0;
  annotation(experiment(StopTime = 1));
end Root;"""
    )
    with pytest.raises(InitialisationError, match=r"derivatives of the forces .* are not finite") as found:
        simulate(scene)
    assert "sqrt" in found.value.hint
