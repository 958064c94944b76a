"""Models with ``initial(state = steady)`` start at their equilibrium, everywhere that a start is used."""

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import EquilibriumError, ModelError, SyntaxProblem, UsageError

SPRING = """model Hanging
  parameter Mass m = 2 kg;
  Ground ground;
  Frame down(ground, phi = -90 deg);
  Body block(m = m, I = 1 kg.m2);
  Prismatic slide(down, block.c, phi0 = 90 deg);
  TranslationalSpringDamper spring(slide, k = 100 N/m, c = 1 N.s/m, s0 = 0.3 m);
initial equation
  guess slide.s = 0.1 m;
initial(state = steady);
annotation(experiment(StopTime = 0.1));
end Hanging;"""
REST = 0.3 + 2.0 * 9.81 / 100.0


def test_a_run_stays_at_rest():
    run = mbdsl.simulate(mbdsl.parse(SPRING))
    assert run["slide.s"] == pytest.approx(REST, rel=1e-9)
    assert np.abs(run["slide.v"]).max() < 1e-9


def test_with_another_parameter():
    run = mbdsl.simulate(mbdsl.parse(SPRING), parameters={"m": 4.0})
    assert run["slide.s"][0] == pytest.approx(0.3 + 4.0 * 9.81 / 100.0, rel=1e-9)


def test_in_space():
    """A pendulum that is guessed at 60 degrees hangs down, along -y."""
    text = """spatial model Pendulum
      Ground ground;
      Body rod(m = 3 kg, I = {0.1, 0.1, 0.1} kg.m2, frames(top = {0, 0.5 m, 0}));
      Revolute pin(ground, rod.top);
    initial equation
      guess pin.phi = 60 deg;
    initial(state = steady);
    end Pendulum;"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.05)
    assert run["pin.phi"] == pytest.approx(0.0, abs=1e-9) and run["pin.fy"] == pytest.approx(29.43, rel=1e-6)


def test_flexible_bodies_begin_in_their_static_shape():
    text = """model Cantilever
      Ground ground;
      FlexibleBeam beam(length = 1 m, mass = 1 kg, S = 1e-4 m2, I = 1e-9 m4, E = 50e9 Pa);
      Fixed root(ground, beam.a);
    initial(state = steady);
    end Cantilever;"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.01)
    droop = run["beam.b.y"]
    # q L^4/(8 E I), of small deflections: with 2.5 % of the length, the beam is stiffer by the square of that
    assert droop[0] == pytest.approx(-9.81 / (8.0 * 50.0), rel=1e-3)
    assert droop == pytest.approx(droop[0], rel=1e-6)


def test_other_starts():
    """Step by step, about the start, and with values in its place."""
    scene = mbdsl.parse(SPRING)
    sim = mbdsl.Simulation(scene, step=1e-3)
    assert sim["slide.s"] == pytest.approx(REST, rel=1e-9)
    linear = mbdsl.linearise(scene, "start")
    assert linear.x0 == pytest.approx([REST, 0.0]) and not linear.notes
    run = mbdsl.simulate(scene, initial={"slide.s": 0.25})
    assert run["slide.s"][0] == pytest.approx(0.25)
    found = mbdsl.sweep(scene, {"m": [1.0, 2.0]}, "maxabs(slide.v)", workers=1, fresh=True)
    assert found["maxabs(slide.v)"] == pytest.approx(0.0, abs=1e-8)


def test_equals_a_start_on_request():
    """As with initial="static" of a model without the statement, bit for bit."""
    plain = mbdsl.parse(SPRING.replace("initial(state = steady);", ""))
    a, b = mbdsl.simulate(mbdsl.parse(SPRING)), mbdsl.simulate(plain, initial="static")
    assert np.array_equal(a.q, b.q) and np.array_equal(a.v, b.v)
    assert a.scene != plain and mbdsl.simulate(plain)["slide.s"][0] == pytest.approx(0.1)


def test_checkpoint(tmp_path):
    model, kept = tmp_path / "hanging.mbd", tmp_path / "run.ckpt"
    model.write_text(SPRING)
    run = mbdsl.simulate(model, checkpoint=mbdsl.Checkpoint(kept, every=0.0), step=1e-4)
    assert np.array_equal(mbdsl.resume(kept).q, run.q)


def test_an_unstable_start_is_left():
    """A force 10 N sin(s/m) pushes from s = 0, an equilibrium as well, to half a turn of it."""
    text = """model Slope
      Ground ground(g = 0);
      Body block(m = 1 kg, I = 1 kg.m2);
      Prismatic slide(ground, block.c);
      TranslationalSpringDamper spring(slide, force = 0 N - 10 N*sin(s/(1 m)));
    initial equation
      guess slide.s = 0 m;
    initial(state = steady);
    end Slope;"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.01)
    assert np.abs(run["slide.s"]) == pytest.approx(np.pi, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (("guess slide.s", "slide.s"), ModelError, "`slide.s` is fixed"),
        (("guess slide.s = 0.1 m", "slide.v = 1 m/s"), ModelError, "at rest"),
        (("steady", "moving"), ModelError, "expected steady or given"),
        (("state =", "stage ="), ModelError, "initial has no `stage`"),
        (("(state = steady)", "()"), SyntaxProblem, r"write `initial\(state = steady\);`"),
        (("(state = steady)", "(1 + 2)"), SyntaxProblem, "expected the state"),
    ],
)
def test_wrong_statements(change, kind, message):
    with pytest.raises(kind, match=message) as problem:
        mbdsl.parse(SPRING.replace(*change))
    assert problem.value.span is not None


def test_no_equilibrium():
    text = SPRING.replace("k = 100 N/m", "k = 0 N/m")
    with pytest.raises(EquilibriumError, match="block keeps moving"):
        mbdsl.simulate(mbdsl.parse(text))


def test_check_searches_for_the_equilibrium():
    """Without stiffness there is none."""
    text = str(mbdsl.check(mbdsl.parse(SPRING)))
    assert text.endswith("starts at the static equilibrium that it reaches from here")
    with pytest.raises(EquilibriumError, match="block keeps moving"):
        mbdsl.check(mbdsl.parse(SPRING.replace("k = 100 N/m", "k = 0 N/m")))
    assert str(mbdsl.check(mbdsl.parse(SPRING), quick=True)).endswith("(not searched)")


def test_static_means_steady():
    assert mbdsl.parse(SPRING.replace("= steady", "= static")).steady


def test_zero_velocities_fit():
    scene = mbdsl.parse(SPRING.replace("guess slide.s = 0.1 m;", "guess slide.s = 0.1 m;\n  slide.v = 0 m/s;"))
    assert scene.steady


def test_values_after_the_statement():
    """It begins a section of initial values, or stands within one; a later statement decides."""
    text = SPRING.replace("  guess slide.s = 0.1 m;\ninitial(state = steady);", "")
    text = text.replace("initial equation", "initial(state = steady);\n  guess slide.s = 0.1 m;")
    scene = mbdsl.parse(text)
    assert scene.steady and len(scene.initial) == 1
    derived = f"{SPRING}\nmodel Free\n  extends Hanging;\ninitial(state = given);\nend Free;"
    assert not mbdsl.parse(derived, model="Free").steady


def test_only_of_the_model_that_runs():
    text = f"{SPRING}\nmodel Two\n  inner Ground ground;\n  Hanging a;\nend Two;"
    text = text.replace("  Ground ground;", "  outer Ground ground;", 1)
    scene = mbdsl.parse(text, model="Two")
    assert not scene.steady
    assert "`initial(state = steady)` of `a` does not count here" in str(scene.warnings[0])


def test_builder():
    b = mbdsl.Builder("Hanging")
    ground = b.Ground("ground")
    block = b.Body("block", m=2.0, I=1.0)
    down = b.frame("down", ground, phi="-90 deg")
    slide = b.Prismatic("slide", down, block.c, phi0="90 deg")
    b.TranslationalSpringDamper("spring", down, block.c, k=100.0, c=1.0, s0=0.3)
    b.initial(slide.s, 0.1, fixed=False)
    b.initial(state="steady")
    assert b.scene().steady
    assert mbdsl.simulate(b.scene(), stop=0.01)["slide.s"] == pytest.approx(REST, rel=1e-9)
    b.initial(state="given")
    assert not b.scene().steady
    with pytest.raises(ModelError, match="expected steady or given"):
        b.initial(state="fast")
    with pytest.raises(UsageError, match="no target and no value"):
        b.initial(slide.s, 0.1, state="steady")
    with pytest.raises(UsageError, match="a target and a value"):
        b.initial(slide.s)


def test_commands(tmp_path, capsys):
    model = tmp_path / "hanging.mbd"
    model.write_text(SPRING)
    assert main(["check", str(model)]) == 0
    assert "starts at the static equilibrium" in capsys.readouterr().out
    assert main(["show", "--stage", "scene", str(model)]) == 0
    assert "state = steady" in capsys.readouterr().out
    assert main(["show", "--stage", "syntax", str(model)]) == 0
    assert "Initial mode=state target=state value=steady" in capsys.readouterr().out
    assert main(["simulate", str(model), "--output", str(tmp_path / "run.csv"), "--signals", "slide.s"]) == 0
    rows = np.genfromtxt(tmp_path / "run.csv", delimiter=",", skip_header=1)
    assert rows[:, 1] == pytest.approx(REST, rel=1e-9)
    assert main(["report", str(model), "--out", str(tmp_path / "report.html")]) == 0
    assert "steady" in (tmp_path / "report.html").read_text()
