"""Statements of Modelica: what every file of Dymola has is passed over, and the rest has a remedy that works."""

import re

import pytest

from mbdsl import parse
from mbdsl.errors import MbdslError

MODEL = """model M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
{}
end M;
"""
SPATIAL = MODEL.replace("model", "spatial model")


def error(text):
    with pytest.raises(MbdslError) as problem:
        parse(text)
    return problem.value


STATEMENTS = {
    "record": "  record Data\n    Real a = 1;\n  end Data;",
    "operator": "  operator f\n  end f;",
    "type": '  type Speed = Real(unit = "m/s");',
    "replaceable": "  replaceable Rod other(m = 1 kg);",
    "algorithm": "algorithm\n  x := 1;",
    "while": "equation\n  while time < 1 loop\n  end while;",
}


@pytest.mark.parametrize("model", [MODEL, SPATIAL], ids=["plane", "space"])
@pytest.mark.parametrize("word", STATEMENTS)
def test_a_statement_is_named_by_its_word(word, model):
    """Not the token behind it, where the grammar ends."""
    problem = error(model.format(STATEMENTS[word]))
    assert problem.message == f"`{word}` is not part of mbdsl"
    line = problem.span.text
    assert line[problem.span.column - 1 :].startswith(word) and problem.hint


@pytest.mark.parametrize("word", ["package P", "record R", "operator f", "encapsulated", 'type T = Real(unit = "m");'])
def test_a_statement_before_the_model(word):
    problem = error(f"{word}\n{MODEL.format('')}")
    assert problem.message == f"`{word.split()[0]}` is not part of mbdsl"
    assert problem.span.line == problem.span.column == 1 and problem.hint


def test_these_words_are_names():
    found = parse(MODEL.format("  Rod output(m = 1 kg, length = 1 m);\n  Revolute type(rod.b, output.a);"))
    assert {"output", "type"} <= set(found.components)
    problem = error(MODEL.format("  Rod output(m = 1 kg, length = 1 m);\ninitial equation\n  output.phi = 3 deg +;"))
    assert "`output` is not part" not in problem.message


@pytest.mark.parametrize(
    ("equations", "remedy"),
    [
        ("if time < 1 s then u = 0; else u = 1; end if;", "Real u = if time < 1 s then 0 else 1;"),
        ("if pin.phi < 1 then\n u = 0;\n elseif pin.w > 2 rad/s then u = 3; else u = 1; end if;", None),
        ("if time < 1 s then u = 0; v = 2; else v = 3; u = 1; end if;", None),
        ("u = 2*pin.phi;", "Real u = 2 * pin.phi;"),
        ("2*pin.phi = u;", "Real u = 2 * pin.phi;"),
        ("for i in 1:2 loop if time < 1 s then u = 0; else u = 2; end if; end for;", None),
    ],
)
def test_an_equation_of_a_variable_becomes_its_declaration(equations, remedy):
    hint = error(MODEL.format(f"  Real u;\nequation\n  {equations}")).hint
    (written,) = re.findall(r"declared, `(.*)`;", hint)
    assert remedy is None or written == remedy
    assert "u" in parse(MODEL.format(written)).variables


def test_an_if_with_connections_is_decided_at_the_start():
    text = "  Rod more(m = 1 kg, length = 1 m);\n  Revolute j;\nequation\n  if 1 < 2 then\n"
    text += "    connect(rod.b, j.frame_a);\n"
    assert "j" in parse(MODEL.format(f"{text}    connect(j.frame_b, more.a);\n  end if;")).components


# -- passed over -----------------------------------------------------------------------------------------------------

DYMOLA = """within MyLibrary.Examples;
model M "a pendulum"
  extends Modelica.Icons.Example;
  import Modelica.Units.SI;
  import Modelica.Mechanics.MultiBody.*;
  import C = Modelica.Constants;
  parameter SI.Mass m = 1 kg;
  Ground ground annotation (Placement(transformation(extent={{-10,-10},{10,10}})));
  Rod rod(m = m, length = 1 m);
  Revolute pin(ground, rod.a);
  annotation (
    Icon(graphics={Text(extent={{1,2},{3,4}}, textString="%name")}),
    Documentation(info="<html><p>It's a pendulum</p></html>"),
    uses(Modelica(version="4.0.0")),
    experiment(StopTime=1.5, __Dymola_NumberOfIntervals=5000, Tolerance=1e-6, __Dymola_Algorithm="Dassl"),
    __Dymola_experimentSetupOutput);
end M;
"""


def test_a_file_of_dymola_is_read_with_one_note():
    scene = parse(DYMOLA)
    assert (scene.experiment.stop, scene.experiment.tolerance) == (1.5, 1e-6)
    (note,) = scene.warnings
    assert note.severity == "note"
    for word in ("within MyLibrary.Examples", "import Modelica.Units.SI", "__Dymola_Algorithm"):
        assert f"`{word}`" in note.message
    assert note.span.line == 1


@pytest.mark.parametrize(
    "head", ["within ;", "within;", "import Modelica.Units.SI;", "import Modelica.Math.{sin, cos};"]
)
def test_heads_of_files(head):
    scene = parse(f"{head}\n{MODEL.format('')}")
    assert scene == parse(MODEL.format(""))
    assert [note.severity for note in scene.warnings] == ["note"]


def test_a_misspelt_setting_and_an_import_of_another_library_remain_errors():
    assert "no `Intervall`" in error(MODEL.format("  annotation(experiment(Intervall = 1));")).message
    assert "an import names a file" in error(f"import MyLibrary.Arm;\n{MODEL.format('')}").message


# -- remedies --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "declaration",
    [
        "Modelica.Mechanics.Rotational.Components.Damper x(d = 0.1);",
        "Modelica.Mechanics.Rotational.Components.Spring x(c = 30, phi_rel0 = 7);",
        "Modelica.Mechanics.MultiBody.Forces.Damper x(d = 0.1);",
        "Modelica.Mechanics.MultiBody.Forces.Spring x(c = 3, s_unstretched = 2);",
        "RotationalSpringDamper x(d = 0.1);",
        "RotationalSpringDamper x(c = 4, d = 0.1);",
        "SpringDamper x(d = 0.1);",
        "RigidBody x(mass = 3, Izz = 2);",
        "Body x(mass = 3, I = 2);",
    ],
)
def test_a_remedy_does_not_warn_about_itself(declaration):
    problem = error(
        MODEL.format(f"  {declaration}\nequation\n  connect(x.frame_a, rod.b); connect(x.frame_b, ground);")
    )
    (written,) = re.findall(r"write `(.*?)`", problem.hint)
    if not written.endswith(";"):  # the parameters of the same kind
        rest = ", I = 1 kg.m2" if declaration.startswith("Body") else ""
        written = f"{declaration.split('(')[0]}({written}{rest});"
    assert (
        parse(MODEL.format("  " + written.replace("x(", "x(rod.b, ground, " if "Spring" in written else "x("))).warnings
        == ()
    )


@pytest.mark.parametrize(
    ("kind", "right"),
    [
        ("IdealGear", "GearPair"),
        ("Modelica.Mechanics.Rotational.Components.IdealGear", "GearPair"),
        ("LossyGear", "GearPair"),
        ("IdealGearR2T", "RackAndPinion"),
        ("BearingFriction", "mu = "),
        ("ElastoGap", "TranslationalStop"),
        ("Modelica.Mechanics.Rotational.Sources.ConstantTorque", "Torque"),
        ("Modelica.Mechanics.MultiBody.Forces.WorldForceAndTorque", "Force"),
    ],
)
def test_kinds_of_machines_have_a_counterpart(kind, right):
    hint = error(MODEL.format(f"  {kind} x(ratio = 2);")).hint
    assert right in hint and "Integer" not in hint


def test_a_type_is_no_remedy_for_a_component():
    assert "Integer" not in error(MODEL.format("  IdealGrea x(ratio = 2);")).hint
    assert error(MODEL.format("  Reel x = 2;")).hint == "did you mean `Real`?"


@pytest.mark.parametrize(
    ("block", "statements"),
    [
        ("Modelica.Blocks.Continuous.Integrator x(k = 2, y_start = 3)", "Real x(start = 3); der(x) = 2*u/(1 s);"),
        ("Modelica.Blocks.Continuous.FirstOrder x(T = 0.1)", "Real x(start = 0); der(x) = (u - x)/(0.1 s);"),
        (
            "Modelica.Blocks.Continuous.PI x(k = 3, T = 0.1)",
            "Real x_x(start = 0), x = 3*(u + x_x); der(x_x) = u/(0.1 s);",
        ),
        ("Modelica.Blocks.Continuous.Derivative x(T = 0.1)", "Real x(start = 0); der(x) = (u - x)/(0.1 s);"),
        (
            "Modelica.Blocks.Discrete.Sampler x(samplePeriod = 0.1)",
            "discrete Real x(start = 0); when sample(0 s, 0.1 s) then x = u; end when;",
        ),
    ],
)
def test_blocks_with_a_memory_become_states(block, statements):
    hint = error(MODEL.format(f"  {block};")).hint
    written = re.findall(r"`([^`]*;)`", hint)
    assert " ".join(written) == statements
    declared = written[0].removeprefix("discrete ").split()[1].split("(")[0].rstrip(";")
    text = f"  Real u = sin(time*(1 rad/s));\n  {written[0]}\n  Torque t(pin, tau = 1 N.m*{declared});"
    assert parse(MODEL.format(f"{text}\nequation\n  {written[1]}")).warnings == ()


def test_a_controller_of_modelica_is_one_of_states():
    given = "k = 100, Ti = 0.1, Td = 0.02, yMax = 12, Ni = 0.2"
    hint = error(MODEL.format(f"  Modelica.Blocks.Continuous.LimPID c({given});")).hint
    variables, integral, derivative = re.findall(r"[^;`]+;", "".join(re.findall(r"`([^`]*;)`", hint)))[:3]
    written = variables.replace("... - ...", "0.3 - pin.phi")
    text = f"  {written}\n  Torque t(pin, tau = 1 N.m*c_y);\nequation\n  {integral}\n  {derivative}"
    assert parse(MODEL.format(text)).warnings == ()
