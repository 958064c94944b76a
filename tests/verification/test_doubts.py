"""Runs with fixed steps that cannot be right warn, and runs that can be right do not."""

from pathlib import Path

import numpy as np
import pytest

from mbdsl import cli, load, simulate
from mbdsl.lang.load import parse_text
from mbdsl.simulation.diagnostics.fixed_steps import passive

MODELS = Path(__file__).parents[2] / "models"
SHIPPED = sorted(path.stem for path in MODELS.glob("*.mbd"))

BALL = """model Ball parameter Stiffness k = 1e8 N/m; Ground g0; PointMass ball(m = 1 kg);
  Force stop(ball.c, fy = if ball.y < 0 m then -k*ball.y else 0 N);
initial equation ball.x = 0 m; ball.y = 1 m; ball.vx = 0 m/s; ball.vy = 0 m/s;
  annotation(experiment(StopTime = 2 s)); end Ball;"""


def ball(k):
    return parse_text(BALL.replace("1e8", str(k)))


def test_a_ball_that_rises_above_where_it_fell_from():
    """It cannot be right: no source brings energy. And its contact has omega = sqrt(k/m), 1592 Hz, for any step."""
    run = simulate(ball(1e8), step=1e-3)
    assert np.ptp(run["ball.y"]) > 1.2  # otherwise this test would check nothing
    growth, contact = run.stats["warnings"]
    assert growth.startswith("energy grows by ")
    assert "but the model has no source of energy: the step of 0.001 s is too long" in growth
    assert contact.startswith("Force stop acts for 1 step at t = 0.45")
    assert "the step does not resolve its 1.59e+03 Hz (h omega = 10): try a step of 1e-05 s" in contact


def test_what_is_advised_helps():
    for given in ({"step": 1e-4}, {}):  # of a contact of 1000 rad/s
        run = simulate(ball(1e6), **given, stop=0.9)
        assert run.stats["warnings"] == []
        assert abs(run["ball.y"][run.t > 0.6].max() - 1.0) < 1e-3


def test_the_command_says_it(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.mbd").write_text(BALL)
    assert cli.main("simulate ball.mbd --step 1ms --quiet --stop 1s".split()) == 0
    err = capsys.readouterr().err
    assert "warning: Force stop acts for 1 step at t = 0.45" in err


@pytest.mark.parametrize("name", SHIPPED)
def test_no_false_alarm(name):
    scene = load(MODELS / f"{name}.mbd")
    span = min(scene.experiment.stop, 500 * (scene.experiment.step or 1e-3))
    assert simulate(scene, step=scene.experiment.step or 1e-3, stop=span).stats["warnings"] == []


def test_a_stiff_mode_that_is_at_rest_or_damped_out_is_none_of_it():
    text = """model Stiff Ground g0; PointMass m(m = 1 kg); PointMass e(m = 1 kg); Prismatic rail(g0, slide.c);
      Body slide(m = 1 kg, I = 1 kg.m2); SpringDamper soft(g0, m.c, k = 10 N/m);
      SpringDamper hard(m.c, e.c, k = 1e12 N/m, s0 = 0.1 m);
    initial equation m.x = 1 m; m.y = 0 m; e.x = 1.1 m; e.y = 0 m; slide.x = 0 m;
      annotation(experiment(StopTime = 1 s, Step = 1 ms)); end Stiff;"""
    assert simulate(parse_text(text)).stats["warnings"] == []


LAWS = """model Laws input Torque u(start = 0 N.m); parameter Damping c = 0 N.s/m; Ground g0(g = 0 m/s2);
  Rod rod(m = 1 kg, length = 1 m); Revolute pin(g0, rod.a); {}
  annotation(experiment(StopTime = 2 s, Step = 1 ms)); end Laws;"""


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("Torque T(g0, rod.a, tau = -3 N.m*rod.phi);", True),
        ("Torque T(g0, rod.a, tau = if rod.phi > 0 then -3 N.m*rod.phi^3 else 0 N.m);", True),
        ("SpringDamper S(g0, rod.b, force = 100 N/m*(s - 1 m)^3/1 m^2);", True),
        ("SpringDamper S(g0, rod.b, k = 5 N/m, c = 1 N.s/m);", True),
        ("Torque T(g0, rod.a, tau = 1 N.m);", False),
        ("Torque T(g0, rod.a, tau = 1 N.m*sin(time/1 s));", False),
        ("Torque T(g0, rod.a, tau = 1 N.m.s*rod.w*(1 - rod.phi^2));", False),
        ("Torque T(g0, rod.a, tau = 1 N.m/1 m*rod.b.x);", False),
        ("Force F(rod.b, fx = 1 N/m*rod.b.y);", False),
        ("SpringDamper S(g0, rod.b, k = 5 N/m, c = -1 N.s/m);", False),
        ("RotationalVelocityDriver D(pin, w = 1 rad/s);", False),
    ],
)
def test_what_may_bring_energy(more, expected):
    assert passive(parse_text(LAWS.replace("input Torque u(start = 0 N.m);", "").format(more))) is expected
    assert not passive(parse_text(LAWS.format(more)))  # an input


def test_a_contact_of_a_small_body_that_turns_is_found():
    """Velocities are compared in the mechanism's size, here 10 mm, and in radians."""
    text = BALL.replace("PointMass ball(m = 1 kg)", "Body ball(m = 1 kg, I = 1 kg.m2)")
    text = text.replace("ball.y = 1 m", "ball.y = 10 mm; ball.phi = 0 rad; ball.w = 30 rad/s")
    run = simulate(parse_text(text), step=1e-3, interval=1e-3, stop=0.1)
    (contact,) = [x for x in run.stats["warnings"] if "energy" not in x]
    assert contact.startswith("Force stop acts for 1 step at t = 0.04")


def test_rounding_of_energy_is_none_of_it():
    """A mass that hangs on a spring, 10 nm from its rest position: it exchanges 1e-14 J, of 16 J."""
    run = simulate(MODELS / "spring_mass.mbd", step=1e-3, stop=1.0, parameters={"s1": 0.59810001, "c": 0.0})
    assert 0.0 < run["energy.kinetic"].max() < 1e-13
    assert run.stats["warnings"] == []
