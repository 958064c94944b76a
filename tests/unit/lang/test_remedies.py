"""Remedies for what people write from habit: the text that they name is read, and means what was meant."""

import math
import re

import pytest

from mbdsl import parse
from mbdsl.cli import main
from mbdsl.errors import MbdslError

PLANE = """model M
  parameter Angle beta = 60 deg;
  Ground ground;
  Rod rod(m = 1 kg, length = 2 m);
  Revolute pin(ground, rod.a);
{}
end M;
"""
SPACE = """spatial model M
  Ground ground;
  Body rod(m = 1 kg, I = {{1, 2, 3}} kg.m2, frames(a = {{0, 0, 0}} m, b = {{1, 0, 0}} m));
  Revolute pin(ground, rod.a, n = {{0, 0, 1}});
{}
end M;
"""


def error(text):
    with pytest.raises(MbdslError) as problem:
        parse(text)
    return problem.value


@pytest.mark.parametrize(
    ("array", "remedy", "point"),
    [
        ("{0.5*cos(beta), 0} m", "{0.5 m * cos(beta), 0}", (0.25, 0.0)),
        ("{0.5*cos(beta)*2, sin(beta)} m", None, (0.5, math.sqrt(0.75))),
        ("{3 + 2*beta, 1} cm", None, (0.03 + 0.02 * math.pi / 3, 0.01)),
        ("{rod.length, 0.5} m", "{rod.length, 0.5 m}", (2.0, 0.5)),
        ("{cos(beta)/2, 0} mm", None, (0.00025, 0.0)),
    ],
)
def test_an_array_of_expressions_with_a_unit(array, remedy, point):
    """The unit moves to the elements; expected positions by hand."""
    problem = error(PLANE.format(f"  Frame tip(rod, r = {array});"))
    (written,) = re.findall(r"write `(.*)`", problem.hint)
    assert remedy is None or written == remedy
    tip = parse(PLANE.format(f"  Frame tip(rod, r = {written});")).frames["tip"]
    assert (tip.x, tip.y) == pytest.approx(point, rel=1e-15)


def test_a_matrix_with_a_unit_and_another_dimension():
    problem = error(PLANE.format("  parameter Length x[2, 2] = {{beta, 1}, {0, 2}} m;"))
    (written,) = re.findall(r"write `(.*)`", problem.hint)
    value = parse(PLANE.format(f"  parameter Length x[2, 2] = {written};")).parameters["x"].value
    assert value[0][0] == pytest.approx(math.pi / 3) and value[1] == (0.0, 2.0)
    assert "its own unit" in error(PLANE.format("  Frame tip(rod, r = {3 kg, 0} m);")).hint


@pytest.mark.parametrize("name", ["Ball", "BallJoint", "SphericalJoint"])
def test_ball_joints(name):
    declaration = f"  {name} j(ground, rod.b);"
    for text, right in ((SPACE, "Spherical"), (PLANE, "Revolute")):
        (written,) = re.findall(r"write `(.*)`", error(text.format(declaration)).hint)
        assert parse(text.format("  " + written)).components["j"].kind.name == right


@pytest.mark.parametrize(
    ("name", "own"), [("roll", "phi_x"), ("pitch", "phi_y"), ("yaw", "phi_z"), ("heading", "phi_z"), ("bank", "phi_x")]
)
def test_names_of_angles(name, own):
    assert f"`{own}`" in error(SPACE.format(f"  Real u = rod.{name};")).hint.replace(own, f"`{own}`")
    assert own in error(SPACE.format(f"initial equation\n  rod.{name} = 3 deg;")).hint


@pytest.mark.parametrize(
    ("declaration", "values"),
    [
        ("Torque t(rod.a, tau = {3, 0, 0} N.m);", {"tau": 3.0, "n": (1.0, 0.0, 0.0)}),
        ("Torque t(rod.a, torque = {0, 2, 0} N.m);", {"tau": 2.0, "n": (0.0, 1.0, 0.0)}),
        ("Force t(rod.a, f = {1, 0, 4} N);", {"fx": 1.0, "fy": 0.0, "fz": 4.0}),
        ("Force t(rod.a, fx = {1, 2, 3} N);", {"fx": 1.0, "fy": 2.0, "fz": 3.0}),
        ("Force t(rod.a, F = {1, 0, 0});", {"fx": 1.0, "fy": 0.0, "fz": 0.0}),
    ],
)
def test_vectors_of_forces_become_components(declaration, values):
    (written,) = re.findall(r"`(.*)`", error(SPACE.format(f"  {declaration}")).hint)
    found = parse(SPACE.format(f"  {declaration.split('(')[0]}(rod.a, {written});")).components["t"].values
    for name, x in values.items():
        assert getattr(found[name], "value", found[name]) == x


def test_vectors_of_forces_in_the_plane():
    assert "`fx = 1 N, fy = 2 N`" in error(PLANE.format("  Force t(rod.b, force = {1, 2} N);")).hint
    assert "`tau = 3 N.m`" in error(PLANE.format("  Torque t(pin, tau = {0, 0, 3} N.m);")).hint


@pytest.mark.parametrize(
    ("frames", "remedy"),
    [
        ("a = {0, 0, 1} m, n = {0, 1, 0}", "a(r = {0, 0, 1} m, n = {0, 1, 0}, phi = ...)"),
        ("a = {0, 0, 1} m, n = {0, 1, 0}, phi = 90 deg", "a(r = {0, 0, 1} m, n = {0, 1, 0}, phi = 90 deg)"),
        ("a = {0, 0, 1} m, angles = {0, 0, 1}", "a(r = {0, 0, 1} m, angles = {0, 0, 1})"),
        ("r = {0, 0, 1} m, phi = 1 rad", "tip(r = {0, 0, 1} m, phi = 1 rad)"),
    ],
)
def test_parameters_of_a_frame_beside_it(frames, remedy):
    problem = error(SPACE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, frames({frames}));"))
    assert "belongs to one" in problem.message and problem.hint == f"write `frames({remedy})`"
    if "..." not in remedy:
        parse(SPACE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, frames({remedy}));"))


def test_an_angle_of_a_frame_in_the_plane():
    problem = error(PLANE.format("  Body x(m = 1 kg, I = 1 kg.m2, frames(a = {1, 2} m, phi = 90 deg));"))
    (written,) = re.findall(r"write `(.*)`", problem.hint)
    found = parse(PLANE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, {written});")).frames["x.a"]
    assert (found.x, found.y, found.phi) == pytest.approx((1.0, 2.0, math.pi / 2))


@pytest.mark.parametrize("frames", ["n = {0, 1, 0}", "a = {0, 0, 0} m, n = {0, 1, 0} m", "n = {1, 0, 0} m"])
def test_frames_may_have_these_names(frames):
    assert "x.n" in parse(SPACE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, frames({frames}));")).frames


def test_an_input_is_set_by_its_start():
    text = PLANE.format("  input Torque u;\n  Torque t(pin, tau = u);")
    with pytest.raises(MbdslError) as problem:
        parse(text, overrides={"u": 3.0})
    (written,) = re.findall(r"`(u.*)`", problem.value.hint)
    name, _, value = written.partition("=")
    assert parse(text, overrides={name: value}).inputs["u"].start == 3.0


def test_an_input_with_a_value_takes_another_one_and_no_start():
    text = PLANE.format("  input Torque u = 2 N.m;\n  Torque t(pin, tau = u);")
    assert parse(text, overrides={"u": "3 N.m"}).components["t"].values["tau"].value == 3.0
    with pytest.raises(MbdslError, match="has a value and takes no start"):
        parse(text, overrides={"u.start": 3.0})


MACHINE = """model M
  Ground ground;
  Rod rod(m = 1 kg, length = 2 m);
  Revolute pin(ground, rod.a);
  Integer n(start = 0);
  Real y(start = 0), y_rate(start = 0);
equation
{}
end M;
"""


@pytest.mark.parametrize(
    ("wrong", "part", "right"),
    [
        ("when edge(pin.phi > 1) then n = 1; end when;", "when edge(pin.phi > 1) then", "when pin.phi > 1 then"),
        ("when pin.phi == 1 then n = 1; end when;", "pin.phi == 1", "pin.phi >= 1"),
        ("when n = 1 then n = 2; end when;", "=", "=="),
        (
            "when pin.phi > 1 then reinit(pin.w, -pre(pin.w)); end when;",
            "pre(pin.w)",
            "pin.w",
        ),
        (
            "reinit(pin.w, 0);",
            "reinit(pin.w, 0);",
            "when condition then reinit(pin.w, 0); end when;",
        ),
        (
            "if initial() then n = 3; end if;",
            "if initial() then n = 3; end if;",
            "when initial() then n = 3; end when;",
        ),
        (
            "if sample(0, 0.1) then n = 3; end if;",
            "if sample(0, 0.1) then n = 3; end if;",
            "when sample(0, 0.1) then n = 3; end when;",
        ),
        (
            "if pin.phi > 1 then der(y) = 1/(1 s); else der(y) = -y/(1 s); end if;",
            "if pin.phi > 1 then der(y) = 1/(1 s); else der(y) = -y/(1 s); end if;",
            "der(y) = if pin.phi > 1 then 1 / 1 s else -(y / 1 s);",
        ),
        (
            "if pin.phi > 1 then when time > 2 s then n = 1; end when; end if;",
            "if pin.phi > 1 then when time > 2 s then n = 1; end when; end if;",
            "when (pin.phi > 1) and (time > 2 s) then",
        ),
    ],
)
def test_advice_about_events_is_accepted(wrong, part, right):
    """The advice names the text, and the model with it is read; what it leaves to the user is filled in."""
    problem = error(MACHINE.format(wrong))
    assert f"`{right}`" in problem.hint
    text = wrong.replace(part, right, 1).replace("condition", "time > 1 s")
    text += " n = 1; end when;" if text.endswith("then") else ""
    assert parse(MACHINE.format(text)).events or "der(y)" in right


@pytest.mark.parametrize("call", ["sample(0 s, 0.1 s)", "initial()", "terminal()"])
def test_laws_that_are_true_at_an_event_only_are_refused(call):
    """Such a law would never act; a variable that a `when` sets does, and conditions may have a name."""
    law = MACHINE.format("der(y) = if {} then 1/(1 s) else 0/(1 s);")
    problem = error(law.format(call))
    assert "it would have no effect" in str(problem) and problem.span.line == law[: law.index("der(y)")].count("\n") + 1
    written = call if "sample" not in call else "sample(start, period)"
    assert f"`when {written} then x = ...; end when;`" in problem.hint
    right = f"when {call} then n = 1; end when; der(y) = if n > 0 then 1/(1 s) else 0/(1 s);"
    assert parse(MACHINE.format(right)).events


def test_advice_about_blocks_with_memory_is_accepted():
    """The text of each block is read, with an input u in its place."""
    blocks = ("Logical.Hysteresis b(uLow = 0, uHigh = 1)", "Discrete.UnitDelay b(samplePeriod = 0.1, y_start = 2)")
    blocks += ("Discrete.ZeroOrderHold b(samplePeriod = 0.1, startTime = 0.5)",)
    for block in blocks:
        declared, when = re.findall(r"`(.*?)`", error(PLANE.format(f"  Modelica.Blocks.{block};")).hint)
        scene = parse(PLANE.format(f"  Real u = pin.phi;\n  {declared}\nequation\n  {when}"))
        assert "b" in scene.events.variables and scene.events.whens


def test_one_error_about_a_block_whose_beginning_is_wrong(tmp_path, capsys):
    """Its inner statements and its end are no errors of their own."""
    for beginning in ("when pin.phi > 1 rad", "when pin.phi = 1 then", "when pin.phi > 1 && time > 1 s then"):
        (tmp_path / "m.mbd").write_text(MACHINE.format(f"  {beginning}\n    n = 1;\n  end when;"))
        assert main(["check", str(tmp_path / "m.mbd")]) == 2
        assert capsys.readouterr().err.count("error:") == 1
