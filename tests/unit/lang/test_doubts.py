"""Warnings about values that are probably not as intended; no shipped model has one."""

from pathlib import Path

import pytest

from mbdsl import Builder, load, parse
from mbdsl.cli import main

ROOT = Path(__file__).parents[3]
MODELS = sorted((ROOT / "models").rglob("*.mbd"))
MODEL = """model M
  Ground world;
  Rod rod(m = 2 kg, length = 1 m);
  Revolute pin(world, rod.a);
  {}
end M;
"""


def warnings(text):
    return [warning.message for warning in parse(MODEL.format(text)).warnings]


#: models with published data that are not as a user would intend them: model -> number of warnings
PUBLISHED = {"haug_four_link": 3}


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_no_shipped_model_has_a_warning(path):
    assert len(load(path, allow_imports=True).warnings) == PUBLISHED.get(path.stem, 0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("initial equation pin.phi = 30;", "the initial value of `pin.phi` is 30 rad"),
        ("initial equation guess pin.phi = -6.3;", "the initial value of `pin.phi` is -6.3 rad"),
        ("parameter a = 45; initial equation pin.phi = a;", "the initial value of `pin.phi` is 45 rad"),
        ("parameter Angle a = 45;", "`a` is 45 rad"),
        ('parameter Real a(unit = "rad") = 45;', "`a` is 45 rad"),
        ("Frame tip(rod, phi = 90);", "`phi` of `tip` is 90 rad"),
        ("Rod r(m = 1, length = 1, frames(tip = {0, 0, 90}));", "phi of frame `tip` of `r` is 90 rad"),
        ("RotationalDriver d(pin, phi = 90);", "`phi` of `d` is 90 rad"),
        ("RotationalSpringDamper s(pin, k = 1, phi0 = 90);", "`phi0` of `s` is 90 rad"),
        ("Torque t(pin, tau = 2 N.m*cos(60));", "the argument of cos() is 60 rad"),
        ("Real y(start = 3);", "nothing determines `y`: it keeps its start value"),
        (
            "Integer k(start = 1), n[3](each start = 0);\nequation\n  when time > 1 s then n[k] = 1; end when;",
            "nothing determines `k`",
        ),
        ("parameter Real pi = 3;", "`pi` hides the constant pi, and differs from it by 0.14"),
        ("Frame pi(rod);", "`pi` hides the constant pi"),
        ("SpringDamper s(world, rod.b, c = 100);", "SpringDamper `s` has a damping constant c and no stiffness k"),
        ("parameter c0 = 5; RotationalSpringDamper s(pin, c = c0);", "RotationalSpringDamper `s` has a damping"),
        ("parameter Length s = 1 m; SpringDamper d(world, rod.b, force = 3 N/m*s);", "`s` in the law of `d` is"),
        ("parameter AngularVelocity w = 1; Torque t(pin, tau = 3 N.m.s/rad*w);", "`w` in the law of `t` is the value"),
    ],
)
def test_warned(text, message):
    (found,) = warnings(text)
    assert found.startswith(message)


@pytest.mark.parametrize(
    ("before", "what"),
    [
        ("PointMass p(m = 1); FreeMotion f(world, p)", "`f`"),
        ("parameter Real a = 1", "`a`"),
        (
            "PointMass p(m = 1); FreeMotion f; equation connect(f.frame_a, world); connect(f.frame_b, p)",
            "the connection",
        ),
    ],
)
def test_an_experiment_without_the_semicolon_before_it(before, what):
    """With the semicolon it is that of the model, and there is no warning."""
    note = "annotation(experiment(StopTime = 2 s))"
    scene = parse(MODEL.format(f"{before} {note};"))
    (found,) = scene.warnings
    assert found.message == f"this `experiment` has no effect: its annotation belongs to {what}, not to the model"
    assert found.hint == "is a `;` missing before `annotation`?"
    line = MODEL.format(f"{before} {note};").splitlines()[found.span.line - 1]
    assert line[found.span.column - 1 :].startswith("experiment(") and scene.experiment.stop is None
    right = parse(MODEL.format(f"{before}; {note};"))
    assert right.warnings == () and right.experiment.stop == 2.0


@pytest.mark.parametrize(
    "text",
    [
        "initial equation pin.phi = 6.28; pin.w = 300;",
        "initial equation pin.phi = 20*pi;",
        "initial equation pin.phi = 390 deg;",
        "initial equation pin.phi = 30 rad;",
        'parameter Real a(unit = "deg") = 45;',
        "RotationalDriver d(pin, phi = 30*time);",
        "Torque t(pin, tau = 2 N.m*sin(300*time));",
        "constant Real pi = Modelica.Constants.pi;",
        "parameter Real pi = 3.14159265358979;",
        "RotationalSpringDamper s(pin, c = 0.1 N.m.s/rad);",
        "SpringDamper s(world, rod.b, k = 0, c = 10);",
        "parameter Length s = 1 m; SpringDamper d(world, rod.b, force = 3 N/m*d.s);",
        "parameter Mass s = 1 kg; SpringDamper d(world, rod.b, force = 3 N/kg*s);",
        "parameter AngularVelocity w = 1 rad/s; RotationalDriver d(pin, phi = w*time);",
    ],
)
def test_not_warned(text):
    assert warnings(text) == []


SCREW = """spatial model M
  Ground ground;
  Body nut(m = 1 kg, I = {{1, 1, 1}} kg.m2);
  {}
end M;
"""


@pytest.mark.parametrize(
    ("pitch", "of_a_turn"),
    [("5 mm/rev", "0.005 m"), ("-5 mm/rev", "-0.005 m"), ("2 mm/deg", "0.72 m"), ("1 m/rad", "6.28319 m")],
)
def test_a_pitch_per_angle(pitch, of_a_turn):
    """The remedy is the displacement of 360 deg, and has no warning itself."""
    (found,) = parse(SCREW.format(f"Screw s(ground, nut.c, pitch = {pitch});")).warnings
    assert found.message.startswith("the pitch of `s` is a length per angle")
    assert found.hint.endswith(f"write `pitch = {of_a_turn}`")
    assert found.span.column == len("  Screw s(ground, nut.c, pitch = ") + 1
    assert not parse(SCREW.format(f"Screw s(ground, nut.c, pitch = {of_a_turn});")).warnings


def test_a_pitch_per_angle_in_a_parameter():
    (found,) = parse(SCREW.format("parameter Real p = 5 mm/rev; Screw s(ground, nut.c, pitch = p);")).warnings
    assert found.hint.endswith("write `pitch = 0.005 m`")


def test_elements_of_an_array_are_warned_about_once():
    found = warnings(
        "Rod link[5](each m = 1, each length = 1); RotationalSpringDamper s[5](world, link.a, each c = 3);"
    )
    assert len(found) == 1


def test_numbers_of_python_are_not_doubted():
    b = Builder("P")
    rod = b.Rod("rod", m=1.0, length=1.0)
    b.Revolute("pin", b.Ground("world"), rod.a)
    b.initial(rod.phi, 30.0)
    assert b.scene().warnings == ()


def test_the_commands_print_warnings(tmp_path, capsys):
    path = tmp_path / "m.mbd"
    path.write_text(MODEL.format("initial equation pin.phi = 30;"))
    assert main(["check", str(path)]) == 0
    shown = capsys.readouterr()
    assert "warning: the initial value of `pin.phi` is 30 rad" in shown.err
    assert "= write `30 deg`; if radians are meant, `30 rad`" in shown.err
    assert "warning" not in shown.out
