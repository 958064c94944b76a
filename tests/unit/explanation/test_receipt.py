"""``explain``: the effects that are in and out, their amounts and their shares of time; no time is asserted."""

import re
from pathlib import Path

import pytest

from mbdsl import Builder, cli
from mbdsl.errors import UsageError
from mbdsl.explanation.receipt import explain

MODELS = Path(__file__).parents[3] / "models"
#: model -> its effects except bodies; coordinates, constraints and nonholonomic ones: as written, as solved
FACTS = {
    "chain": ("joints, gravity", (24, 16, 0), (24, 16, 0)),
    "chaplygin_sleigh": ("nonholonomic rows", (3, 0, 1), (3, 0, 1)),
    "double_pendulum": (
        "joints, gravity, RotationalSpringDamper, velocity-dependent forces",
        (6, 4, 0),
        (6, 4, 0),
    ),
    "crank_ivp": ("joints, moving frames, flexibility, mass matrix", (12, 8, 0), (9, 5, 0)),
    "driven_crank": ("joints, moving frames, gravity", (8, 8, 0), (5, 5, 0)),
    "flexible_pendulum": ("joints, gravity, flexibility, mass matrix", (68, 2, 0), (68, 2, 0)),
    "flexible_slider_crank": ("joints, gravity, flexibility, mass matrix", (10, 5, 0), (10, 5, 0)),
    "four_bar": ("joints, gravity", (15, 14, 0), (15, 14, 0)),
    "hoist": ("joints, gravity, forces by expression, velocity-dependent forces", (9, 4, 0), (9, 4, 0)),
    "pendulum": ("joints, gravity", (2, 1, 0), (2, 1, 0)),
    "rolling_disc": ("joints, nonholonomic rows, gravity, SpringDamper", (3, 1, 1), (3, 1, 1)),
    "seven_body": ("joints, SpringDamper, forces by expression", (21, 20, 0), (21, 20, 0)),
    "slider_crank": ("joints, gravity, SpringDamper, velocity-dependent forces", (6, 5, 0), (6, 5, 0)),
    "spin_up_beam": ("joints, moving frames, flexibility, mass matrix", (12, 6, 0), (9, 3, 0)),
    "spring_mass": (
        "joints, gravity, TranslationalSpringDamper, velocity-dependent forces",
        (3, 2, 0),
        (3, 2, 0),
    ),
    "stick_slip_belt": (
        "joints, moving frames, gravity, SpringDamper, friction, forces that depend on reactions",
        (6, 5, 0),
        (3, 2, 0),
    ),
}


def entry(receipt, effect):
    (found,) = (e for e in receipt.entries if e.effect == effect)
    return found


def test_every_model_is_here():
    assert set(FACTS) == {path.stem for path in MODELS.glob("*.mbd")}


@pytest.mark.parametrize("name", FACTS)
def test_facts(name):
    effects, before, after = FACTS[name]
    found = explain(MODELS / f"{name}.mbd", measured=False)
    assert {e.effect for e in found.entries if e.present} == {"bodies", *effects.split(", ")}
    assert tuple(found.sizes[key] for key in ("n", "m", "p")) == tuple(zip(before, after, strict=True))
    assert found.parts == 1
    unknowns = [entry(found, effect).unknowns for effect in ("bodies", "joints", "nonholonomic rows")]
    assert unknowns == list(after)
    assert all(e.why for e in found.entries)
    assert all(e.share is None for e in found.entries) and found.step is None
    lines = str(found).splitlines()
    for e in found.entries:  # every one has its line
        assert any(line.startswith(f"{e.effect} ") and (" yes " if e.present else " no ") in line for line in lines)


def test_places_are_those_of_the_text():
    path = MODELS / "slider_crank.mbd"
    found, lines = explain(path, measured=False), path.read_text(encoding="utf-8").splitlines()
    for effect, name in (("bodies", "crank"), ("joints", "O"), ("SpringDamper", "spring"), ("gravity", "ground")):
        span = entry(found, effect).span
        assert lines[span.line - 1][span.column - 1 :].startswith(name)
        assert f"{span}" in str(found)


def test_kernels_are_those_of_the_emitted_code():
    found = explain(MODELS / "stick_slip_belt.mbd", measured=False)
    assert "prismatic.fill" in entry(found, "joints").kernels
    assert {"loops.laws", "expression_tape.run", "translational_spring_damper.curve"} <= set(
        entry(found, "friction").kernels
    )
    assert set(entry(found, "moving frames").kernels) == {"loops.carry", "expression_tape.run"}
    every = {kernel for e in found.entries for kernel in e.kernels if "." in kernel}
    assert not any(kernel.startswith(("loops.drive", "loops.gammas", "revolute")) for kernel in every)


def test_what_was_done_beforehand():
    found = explain(MODELS / "driven_crank.mbd", measured=False)
    assert [(n.action, n.names, n.by) for n in found.notes] == [
        ("moved", ("crank",), ("O", "drive")),
        ("kinematic", ("rod", "slider"), ()),
    ]
    assert found.methods == ("kinematic",)
    shown = str(found)
    assert "moved: crank, by O, drive: its motion is a function of time (" in shown
    assert "none is left: their bodies are functions of time" in shown
    assert "merged, moved, split: nothing" not in shown
    assert "merged, moved, split: nothing" in str(explain(MODELS / "chain.mbd", measured=False))


def test_parts():
    b = Builder("Two")
    ground = b.Ground("ground")
    for name in "ab":
        rod = b.Rod(name, m=1.0, length=1.0)
        b.Revolute(f"pin_{name}", ground, rod.a)
    b.experiment(stop=1.0)
    found = explain(b)
    assert found.parts == 2 and "in 2 parts" in str(found)
    assert [n.action for n in found.notes] == ["split", "split"]
    assert found.remainder is None or 0.0 < found.remainder < 1.0  # None: other programs disturbed the measurement


def test_driven_by_itself():
    """A driven rod without attachments costs nothing: none of its frames is in any code."""
    b = Builder("Aside")
    ground, rod, driven = b.Ground("ground"), b.Rod("rod", m=1.0, length=1.0), b.Rod("driven", m=1.0, length=1.0)
    b.Revolute("A", ground, rod.a)
    b.RotationalDriver("d", b.Revolute("B", ground, driven.a), phi="1 rad/s*time")
    b.experiment(stop=1.0)
    found = explain(b, measured=False)
    assert [e.effect for e in found.entries if e.present] == ["bodies", "joints", "gravity"]
    assert not any(kernel.startswith("expression_tape") for e in found.entries for kernel in e.kernels)


def test_nothing_to_solve():
    b = Builder("Driven")
    ground, rod = b.Ground("ground"), b.Rod("rod", m=1.0, length=1.0)
    pin = b.Revolute("pin", ground, rod.a)
    b.RotationalDriver("d", pin, phi="1 rad/s*time")
    b.experiment(stop=1.0)
    found = explain(b)
    assert found.parts == 0 and found.step is None
    assert "everything is fixed, or moved by drivers" in str(found)


@pytest.mark.parametrize(
    "name", ["slider_crank", "seven_body", "stick_slip_belt", "rolling_disc", "driven_crank", "crank_ivp"]
)
def test_shares(name):
    """Each share is between 0 and 1; the rest belongs to the method. The sizes of the shares depend on the machine."""
    found = explain(MODELS / f"{name}.mbd")
    timed = {e.effect: e.share for e in found.entries if e.share is not None}
    assert found.step > 0.0
    assert all(0.0 <= share < 1.0 for share in timed.values())
    assert sum(timed.values()) + (found.remainder or 0.0) == pytest.approx(1.0)  # None if the machine is too busy
    assert all(e.present for e in found.entries if e.share is not None)
    # every part with code of its own has a share
    assert {e.effect for e in found.entries if any("." in kernel for kernel in e.kernels)} <= set(timed)
    assert re.search(r"\na step takes [\d.e+]+ us \([\w-]+, h = .* s\); ", str(found))


def test_method_decides_the_code():
    one, two = (entry(explain(MODELS / "chain.mbd", method=m, measured=False), "joints") for m in ("hht-i3", "hht-si2"))
    assert "loops.constraints" in one.kernels and "loops.constraints_with_mu" in two.kernels


def test_left_out_on_request():
    found = explain(MODELS / "stick_slip_belt.mbd", measured=False, without=("friction", "damping", "gravity"))
    for effect in ("friction", "velocity-dependent forces", "gravity"):
        assert (entry(found, effect).present, entry(found, effect).why) == (False, "left out on request")
    assert "left out on request: friction, of contact\n" in str(found)
    assert "left out on request: damping, of nothing: it has none" in str(found)


def test_friction_that_changes_no_motion():
    b = Builder("Held")
    ground = b.Ground("ground")
    far = b.frame("far", ground, r=(1.0, 0.0))
    one, two = b.Rod("one", m=1.0, length=1.0), b.Rod("two", m=1.0, length=1.0)
    b.Revolute("A", ground, one.a, mu=0.1, radius=0.01)
    b.Revolute("B", far, two.a)
    b.Revolute("C", one.b, two.b)
    b.initial(one.phi, 1.0, fixed=False)
    b.initial(two.phi, 2.1, fixed=False)
    b.experiment(stop=1.0)
    friction = entry(explain(b, measured=False), "friction")
    assert not friction.present and friction.why == "of A: it changes no motion"


def test_outputs():
    wanted = ["rod.phi", "A.fx", "drive.tau", "rod.ax", "B.Phi[[]1]", "energy.total"]
    found = dict(explain(MODELS / "driven_crank.mbd", measured=False, signals=wanted).outputs)
    assert found["rod.phi"] == found["energy.total"] == "a formula of coordinates and velocities"
    assert (
        found["A.fx"] == found["drive.tau"] == ("reactions that are not unknowns: a linear solve at every output point")
    )
    assert found["rod.ax"].startswith("accelerations: ")
    assert found["B.Phi[1]"].startswith("residuals of constraints: ")
    solved = dict(explain(MODELS / "slider_crank.mbd", measured=False, signals=["O.fx"]).outputs)
    assert solved["O.fx"] == "a formula of the method's multipliers"
    add = dict(explain(MODELS / "slider_crank.mbd", measured=False, signals=["O.fx"], method="hht-add").outputs)
    assert add["O.fx"].startswith("reactions that are not unknowns")
    with pytest.raises(UsageError, match="no signal"):
        explain(MODELS / "slider_crank.mbd", measured=False, signals=["no.such"])


# -- from a shell ----------------------------------------------------------------------------------------------------


def say(capsys, *argv):
    return (cli.main([str(a) for a in argv]), *capsys.readouterr())


def test_explain_from_a_shell(capsys):
    code, out, _ = say(capsys, "explain", MODELS / "slider_crank.mbd", "--no-time", "--signals", "O.f?", "--set", "c=0")
    assert code == 0
    assert out.startswith("SliderCrank: 6 coordinates, 5 constraints\nsolved for: n = 6, m = 5, p = 0, in 1 part\n")
    assert "no force depends on velocities" in out and "\n  O.fy: a formula of the method's multipliers" in out
    assert "a step takes" not in out and "%" not in out
    code, _, err = say(capsys, "explain", MODELS / "slider_crank.mbd", "--no-time", "--method", "euler")
    assert code == 2 and "there is no method `euler`" in err


def test_show_prints_what_is_solved(capsys):
    path = MODELS / "driven_crank.mbd"
    code = say(capsys, "show", "--stage", "code", path)[1]
    assert "loops.carry(" in code and "loops.drive(" not in code
    system = say(capsys, "show", "--stage", "system", path)[1]
    assert system.startswith("moved: crank, by O, drive: its motion is a function of time (")
    assert "\nkinematic: rod, slider: " in system and "\nn = 5 coordinates, m = 5 " in system
    # the graph is that of the model as it was written
    assert "drive" in say(capsys, "show", "--stage", "graph", path)[1]


def test_show_prints_every_part(capsys, tmp_path):
    path = tmp_path / "two.mbd"
    path.write_text(
        "model Two Ground g; Rod a(m = 1 kg, length = 1 m); PointMass b(m = 1 kg); Revolute A(g, a.a);"
        "Distance B(g, b, length = 1 m); annotation(experiment(StopTime = 1 s)); end Two;",
        encoding="utf-8",
    )
    system = say(capsys, "show", "--stage", "system", path)[1]
    assert system.startswith("split: a: nothing joins it to the rest\nsplit: b: ")
    assert system.count("n = ") == 2 and "\npart 1 of 2\n" in system and "\npart 2 of 2\n" in system
    code = say(capsys, "show", "--stage", "code", path)[1]
    assert code.startswith('# part 1 of 2\n"""Emitted') and code.count("def evaluate(") == 2
    assert "distance" not in code.split("# part 2 of 2")[0]


def test_show_where_nothing_is_solved(capsys, tmp_path):
    path = tmp_path / "driven.mbd"
    path.write_text(
        "model Driven Ground g; Rod a(m = 1 kg, length = 1 m); Revolute A(g, a.a); RotationalDriver d(A, phi = 1 rad);"
        "annotation(experiment(StopTime = 1 s)); end Driven;",
        encoding="utf-8",
    )
    assert say(capsys, "show", "--stage", "code", path)[1] == "# nothing is left to be solved\n"
    assert say(capsys, "show", "--stage", "system", path)[1].startswith("moved: a, by A, d: ")


def test_bodies_that_turn_in_space_are_not_flexible():
    """A top has gyroscopic torques; a Geneva drive in space, which is solved in the plane, has none."""
    top = explain(MODELS / "space" / "heavy_top.mbd", measured=False)
    assert entry(top, "gyroscopic torques").why == "top"
    assert entry(top, "gyroscopic torques").present and not entry(top, "flexibility").present
    flat = explain(MODELS / "space" / "geneva_drive.mbd", measured=False)
    assert not entry(flat, "gyroscopic torques").present and not entry(flat, "flexibility").present
