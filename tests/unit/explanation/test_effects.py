"""Effects left out by option, in the text, by the Builder and from a shell; and the change that leaving them out
makes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import Builder
from mbdsl.elements.declaration import EFFECTS
from mbdsl.errors import ModelError, UsageError
from mbdsl.expressions.printing import text
from mbdsl.studies.effects import effects

MODELS = Path(__file__).parents[3] / "models"
CRANK, BELT = MODELS / "slider_crank.mbd", MODELS / "stick_slip_belt.mbd"
FLEXIBLE = MODELS / "flexible_slider_crank.mbd"
ALL = """
model All "every effect that can be left out"
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Rod tip(m = 1 kg, length = 0.5 m);
  Revolute pin(ground, rod.a, mu = 0.2, radius = 1 cm);
  Revolute knee(rod.b, tip.a);
  RotationalSpringDamper linear(pin, k = 2 N.m/rad, c = 0.1 N.m.s/rad);
  RotationalSpringDamper law(knee, torque = 1 N.m*phi + 2 N.m.s*w);
  Torque torque(tip.c, tau = -3 N.m.s*tip.w);
initial equation
  pin.phi = 0.5 rad;
  annotation(experiment(StopTime = 0.2 s{more}));
end All;
"""


def parsed(more=""):
    return mbdsl.parse(ALL.replace("{more}", more))


# -- leaving out -----------------------------------------------------------------------------------------------------


def test_what_is_left_out_is_the_same_as_what_was_never_said():
    for effect, changes in {
        "friction": [("mu = 0.2, radius = 1 cm", "mu = 0, radius = 1 cm")],
        "damping": [(", c = 0.1 N.m.s/rad", ""), (" + 2 N.m.s*w", "")],
        "gravity": [("Ground ground;", "Ground ground(g = 0);")],
    }.items():
        written = ALL.replace("{more}", "")
        for former, new in changes:
            assert former in written
            written = written.replace(former, new)
        a = mbdsl.simulate(parsed(f', Without = "{effect}"'))
        b, whole = mbdsl.simulate(mbdsl.parse(written)), mbdsl.simulate(parsed())
        assert np.array_equal(a.q, b.q), effect
        assert not np.allclose(a.q, whole.q, atol=1e-6), effect


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "nstiff-si2", "hht-add"])
def test_without_flexibility_a_beam_is_a_rod(method):
    """To the last bit: coordinates, code and numbers are those of a rigid rod."""
    written = FLEXIBLE.read_text(encoding="utf-8")
    before, beam, after = written.partition("  FlexibleBeam rod(")
    assert beam
    rod = mbdsl.parse(before + "  Rod rod(m = m2, length = L2);" + after.partition(";")[2])
    runs = [
        mbdsl.simulate(FLEXIBLE, without="flexibility", method=method, stop=0.3),
        mbdsl.simulate(FLEXIBLE, parameters={"modes": 0}, method=method, stop=0.3),
    ]
    rigid = mbdsl.simulate(rod, method=method, stop=0.3)
    for run in runs:
        for found, expected in ((run.q, rigid.q), (run.v, rigid.v), (run.lam, rigid.lam)):
            assert np.array_equal(found, expected)
        for signal in ("rod.phi", "rod.b.x", "A.fx", "energy.total"):
            assert np.array_equal(run[signal], rigid[signal])
    bends = mbdsl.simulate(FLEXIBLE, method=method, stop=0.3)
    assert bends.q.shape[1] == rigid.q.shape[1] + 4
    assert 1e-9 < np.abs(bends["rod.phi"] - rigid["rod.phi"]).max() < 1e-3
    assert mbdsl.load(FLEXIBLE, without="flexibility").without == {"flexibility": ("rod",)}


def test_rotary_inertia_stays_without_flexibility():
    text = FLEXIBLE.read_text(encoding="utf-8").replace("E = 200 GPa", "E = 200 GPa, rotary = 0.02 kg.m")
    rod = mbdsl.parse(text.replace("modes = 4", "modes = 0")).components["rod"]
    assert rod.kind.table(rod.values) == pytest.approx((0.9, 0.9, 0.9 * 0.6**2 / 12 + 0.02 * 0.6), rel=1e-15)


def test_scenes_know_who_lacks_what():
    assert parsed().without == {}
    found = parsed(', Without = {"gravity", "damping", "friction", "flexibility"}').without
    assert found == {"gravity": ("ground",), "damping": ("linear", "law"), "friction": ("pin",), "flexibility": ()}


def test_laws_of_dampers_lose_what_they_say_of_velocities():
    scene = parsed(', Without = "damping"')
    assert "w" not in text(scene.components["law"].values["torque"])
    assert scene.components["linear"].values["c"] == 0.0 and scene.components["linear"].values["k"] == 2.0
    # an applied torque is not a damper
    assert scene.components["torque"].values["tau"] == parsed().components["torque"].values["tau"]


def test_by_builder_load_simulate_and_text():
    built = Builder("B")
    ground, rod = built.Ground("ground"), built.Rod("rod", m=1.0, length=1.0)
    built.Revolute("pin", ground, rod.a)
    built.experiment(stop=1.0, without=("gravity",))
    assert built.scene().components["ground"].values["g"] == 0.0
    assert built.scene().without == {"gravity": ("ground",)}
    assert mbdsl.load(CRANK, without="gravity").without == {"gravity": ("ground",)}  # one is enough
    a = mbdsl.simulate(CRANK, without=["gravity"], stop=0.1)
    b = mbdsl.simulate(CRANK, parameters={"g": 0.0}, stop=0.1)
    assert np.array_equal(a.q, b.q)


def test_a_request_adds_to_what_the_model_says(tmp_path):
    path = tmp_path / "all.mbd"
    path.write_text(ALL.replace("{more}", ', Without = "damping"'), encoding="utf-8")
    assert set(mbdsl.load(path, without=("gravity",)).without) == {"damping", "gravity"}
    assert set(mbdsl.load(path, without=("damping",)).without) == {"damping"}


def test_wrong_effects():
    with pytest.raises(ModelError, match="no effect `frictoin`") as wrong:
        mbdsl.load(CRANK, without=("frictoin",))
    assert wrong.value.hint == "did you mean `friction`?"
    with pytest.raises(ModelError, match="no effect `x`"):
        Builder("B").experiment(without=("x",))
    assembled = replace(parsed())  # it could differ from the text
    with pytest.raises(UsageError, match="made neither from a text nor by a Builder"):
        mbdsl.simulate(assembled, without=("damping",))


def test_from_a_shell(say):
    assert say("simulate", CRANK, "--without", "damping, gravity", "--output", "a.csv", "--stop", "0.1s")[0] == 0
    columns, _ = mbdsl.results.read("a.csv")
    alone = mbdsl.simulate(CRANK, without=("damping", "gravity"), stop=0.1)
    assert np.array_equal(columns["crank.phi"], alone["crank.phi"])
    code, out, err = say("simulate", CRANK, "--without", "drag")
    assert (code, out) == (2, "")
    assert err == f"error: there is no effect `drag` to leave out\n  = there are: {', '.join(EFFECTS)}\n"
    _, out, _ = say("show", CRANK, "--stage", "scene", "--without", "damping,friction")
    assert "without\n  damping: spring\n  friction: nothing has it\n" in out
    code, _, err = say("show", CRANK, "--stage", "syntax", "--without", "damping")
    assert code == 2 and "--without changes no syntax" in err


@pytest.mark.parametrize("general", [[], ["--general"]])
def test_general_from_a_shell(say, general):
    assert say("simulate", MODELS / "pendulum.mbd", "--stop", "0.1s", "--output", "a.csv", *general)[0] == 0
    same = mbdsl.simulate(MODELS / "pendulum.mbd", stop=0.1, general=not general)
    assert np.array_equal(mbdsl.results.read("a.csv")[0]["mass.x"], same["mass.x"])


# -- studies of effects ----------------------------------------------------------------------------------------------


def test_changes_are_those_of_direct_runs():
    study = effects(CRANK, "crank.phi", stop=0.5, repeats=1, step=1e-3)
    whole = mbdsl.simulate(CRANK, stop=0.5, step=1e-3)["crank.phi"]
    assert [row.effects for row in study.rows] == [("damping",), ("gravity",)]
    assert study.absent == ("friction", "flexibility", "contact")
    for row in study.rows:
        other = mbdsl.simulate(CRANK, stop=0.5, step=1e-3, without=row.effects)["crank.phi"]
        assert row.change == np.abs(other - whole).max() > 0.0
        assert row.time > 0.0
    assert (study.low, study.high, study.unit) == (whole.min(), whole.max(), "rad")
    assert study.tol is study.together is study.dispensable is None


def test_error_of_the_step():
    """Known from half the step: of order 2."""
    one, two = (effects(CRANK, "crank.phi", stop=0.5, repeats=1, step=step).error for step in (2e-3, 1e-3))
    assert 1.85 < np.log2(one / two) < 2.15
    fine = mbdsl.simulate(CRANK, stop=0.5, step=1e-5)["crank.phi"]
    assert two == pytest.approx(np.abs(mbdsl.simulate(CRANK, stop=0.5, step=1e-3)["crank.phi"] - fine).max(), rel=1e-3)


def weak(tmp_path, interval="10 ms"):
    """Gravity drives the motion; friction and damping hardly matter, each alone less than both together."""
    path = tmp_path / "weak.mbd"
    path.write_text(
        "model Weak Ground ground; Rod rod(m = 1 kg, length = 1 m);"
        "Revolute pin(ground, rod.a, mu = 1e-4, radius = 1 cm);"
        "RotationalSpringDamper d(pin, c = 1e-5 N.m.s/rad);"
        f"annotation(experiment(StopTime = 0.5 s, Step = 1 ms, Interval = {interval})); end Weak;",
        encoding="utf-8",
    )
    return path


def test_dispensable_together(tmp_path):
    path = weak(tmp_path)
    alone = {row.effects[0]: row.change for row in effects(path, "rod.phi", repeats=1).rows}
    small, large = sorted((alone["friction"], alone["damping"]))
    both = effects(path, "rod.phi", tol=0.1, repeats=1)
    assert both.dispensable is not None and set(both.dispensable) == {"friction", "damping"}
    assert both.together.change > large  # both take energy
    # each of them alone could be left out, but not both: the smaller one is left out
    between = (large + both.together.change) / 2
    one = effects(path, "rod.phi", tol=between, repeats=1)
    assert one.dispensable == (min(alone, key=alone.get),)
    assert effects(path, "rod.phi", tol=small / 2, repeats=1).dispensable == ()
    assert "it does not need: " in str(both) and "the result needs: gravity\n" in str(both)


def test_tolerances(tmp_path):
    path = weak(tmp_path)
    extent = np.ptp(mbdsl.simulate(path)["rod.b.y"])
    for tol, wanted in ((1e-3, 1e-3), ("1mm", 1e-3), ("1 mm", 1e-3), ("1%", 0.01 * extent), (" 5 % ", 0.05 * extent)):
        assert effects(path, "rod.b.y", tol=tol, repeats=1).tol == pytest.approx(wanted, rel=1e-12)
    for tol, message in (
        ("1 kg", "wrong unit: expected m, found kg"),
        ("much", "`much` is not a number"),
        ("x%", "`x` is not a number"),
        (0.0, "leaves no room"),
        ("-1 %", "leaves no room"),
    ):
        with pytest.raises(UsageError, match="tol") as wrong:
            effects(path, "rod.b.y", tol=tol, repeats=1)
        assert message in str(wrong.value)


def test_every_step_in_output(tmp_path):
    """If the model writes every step, half the step would give twice as many points."""
    study = effects(weak(tmp_path, "0 s"), "rod.phi", repeats=1)
    assert study.error == pytest.approx(effects(weak(tmp_path, "1 ms"), "rod.phi", repeats=1).error)


def test_signals_that_go_with_an_effect():
    study = effects(BELT, "contact.friction", stop=0.1, repeats=1, tol="1 %")
    (row,) = (row for row in study.rows if row.effects == ("friction",))
    assert row.change is None and "friction                 it has no such signal\n" in str(study)
    assert "friction" not in study.dispensable


def test_what_the_model_leaves_out_stays_out():
    study = effects(CRANK, "crank.phi", stop=0.1, repeats=1, without=("damping",))
    assert [row.effects for row in study.rows] == [("gravity",)]
    assert "damping" not in study.absent


def test_a_run_that_fails_is_a_row(tmp_path):
    """The rod falls faster than the parts below its root; without gravity, this difference becomes negative."""
    path = tmp_path / "falls.mbd"
    path.write_text(
        "model Falls Ground ground; Rod rod(m = 1 kg, length = 1 m); Revolute pin(ground, rod.a);"
        "Torque t(rod.c, tau = 1e-3 N.m*sqrt(0.01 rad - rod.phi - 0.1 rad/s*time));"
        "initial equation rod.phi = 0 rad; annotation(experiment(StopTime = 0.5 s)); end Falls;",
        encoding="utf-8",
    )
    study = effects(path, "rod.phi", repeats=1)
    (row,) = study.rows
    assert row.effects == ("gravity",) and row.change is None
    assert "gravity                  does not run: " in str(study)


def test_study_from_a_shell(say):
    code, out, _ = say("study", "effects", CRANK, "--signal", "B.s", "--tol", "1mm", "--repeats", 1, "--stop", "0.1s")
    assert code == 0
    assert out.startswith("SliderCrank: B.s from ")
    assert "\nnot in the scene: friction, flexibility, contact\n" in out
    assert "within 0.001 m, the result needs: " in out
    for argv, message in (
        (["--signal", "B.x"], "there is no signal `B.x`"),
        (["--signal", "B.s", "--tol", "1s"], "tol: `1s` has the wrong unit: expected m, found s"),
        (["--signal", "B.s", "--without", "drag"], "there is no effect `drag`"),
        (["--signal", "B.s", "--repeats", "0"], "repeats = 0: a time needs one run or more"),
    ):
        code, _, err = say("study", "effects", CRANK, "--stop", "0.1s", *argv)
        assert code == 2 and message in err, err
