"""Functions of a model: values against the expressions that they stand for, exact derivatives, units, and messages."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import MbdslError
from mbdsl.lang.stored_model import from_text, to_text

SQUARE = "function square\n  input Real x;\n  output Real y;\nalgorithm\n  y := x^2;\nend square;\n"
DRAG = """  function drag "of a ball in air"
    input Velocity v "through the air";
    input Real c(unit = "N.s2/m2") = 2;
    output Force f "resisting";
  protected
    Real a = abs(v);
    Real b;
  algorithm
    b := c*a;
    f := -b*v;
  end drag;
"""
MODEL = """model Ball
{inside}  Ground ground;
  PointMass ball(m = 1 kg);
  FreeMotion free(ground, ball);
  Force air(ball, fx = {law});
initial equation
  ball.vx = 3 m/s;
  annotation(experiment(StopTime = 1 s, Step = 1 ms));
end Ball;
"""


def model(law, before="", inside=""):
    return before + MODEL.replace("{law}", law).replace("{inside}", inside)


def law(text):
    return mbdsl.parse(text).components["air"].values["fx"]


def test_a_force_by_a_function_slows_a_ball():
    """m v' = -c v^2 gives v = v0/(1 + v0 c t/m)."""
    run = mbdsl.simulate(mbdsl.parse(model("drag(ball.vx)", inside=DRAG)), tol=1e-8, method="dop853")
    np.testing.assert_allclose(run["ball.vx"], 3.0 / (1.0 + 6.0 * run.t), rtol=1e-6)


@pytest.mark.parametrize(
    ("call", "written"),
    [
        ("drag(ball.vx)", "-2*abs(ball.vx)*ball.vx*1 N.s2/m2"),
        ("drag(ball.vx, 3)", "-3*abs(ball.vx)*ball.vx*1 N.s2/m2"),
        ("drag(c = 3, v = ball.vx)", "-3*abs(ball.vx)*ball.vx*1 N.s2/m2"),
        ("1 N*square(square(2*time/(1 s)))", "1 N*((2*time/(1 s))^2)^2"),
        ("-square(ball.vx)*1 kg/m", "-ball.vx^2*1 kg/m"),  # an input without a unit takes any
    ],
)
def test_a_call_is_what_it_stands_for(call, written):
    found, expected = (mbdsl.simulate(mbdsl.parse(model(x, SQUARE, DRAG))) for x in (call, written))
    np.testing.assert_array_equal(found["ball.vx"], expected["ball.vx"])


def test_derivatives_are_exact():
    """The tangent of the equations and that of the written expression are the same numbers."""
    run, other = (
        mbdsl.linearise(mbdsl.parse(model(x, SQUARE, DRAG)), at="start")
        for x in ("drag(ball.vx)", "-2*abs(ball.vx)*ball.vx*1 N.s2/m2")
    )
    np.testing.assert_array_equal(run.A, other.A)
    assert np.isclose(run.A, -12.0).any()  # d(-2 v^2)/dv at 3 m/s


def test_parameters_arrays_and_functions_of_functions():
    text = """function norm
  input Real r[:];
  output Real y;
algorithm
  y := sqrt(sum({square(x) for x in r}));
end norm;
"""
    scene = mbdsl.parse(model("F", SQUARE + text, "  parameter Force F = norm({3 N, 4 N});\n"))
    assert scene.parameters["F"].value == pytest.approx(5.0)


def test_functions_of_imported_files(tmp_path):
    (tmp_path / "lib.mbd").write_text(SQUARE)
    for line, name in (('import "lib.mbd";', "square"), ('import "lib.mbd" as lib;', "lib.square")):
        path = tmp_path / "ball.mbd"
        path.write_text(f"{line}\n" + model(f"1 N*{name}(3)"))
        scene = mbdsl.load(path, {"ball.m": f"{name}(2)*1 kg"})
        assert scene.components["ball"].values["m"] == 4.0
        assert from_text(to_text(scene)) == scene


def test_names_of_models_may_be_words_of_functions():
    inside = "  parameter Real function = 2;\n  parameter Real output = 3;\n  parameter Real algorithm = 1;\n"
    mbdsl.parse(model("1 N*function*output*algorithm", inside=inside))


@pytest.mark.parametrize(
    ("body", "message", "hint"),
    [
        ("input Real x; output Real y; algorithm for i in 1:3 loop y := x; end for;", "has a loop", "one expression"),
        (
            "input Real x; output Real y; algorithm if x > 0 then y := x; else y := 0; end if;",
            "an `if` statement",
            "`if`",
        ),
        ("input Real x; output Real y; algorithm y := x; y := 2*x;", "`y` is assigned twice", "one expression"),
        ("input Real x; output Real y; algorithm x := 1; y := x;", "`x` is an input of the function", ""),
        ("input Real x; output Real y; algorithm z := x; y := z;", "has no output `z`", ""),
        ("input Real x; output Real y; algorithm", "`y` has no expression", "y := ...;"),
        ("input Real x; output Real y; protected Real a; algorithm y := x;", "`a` has no expression", ""),
        ("input Real x; algorithm", "has no output", "output Real y;"),
        ("input Real x; output Real y; algorithm y := x*time;", "a function has no time", "input Time t;"),
        ("input Real x; output Real y; algorithm y := der(x);", "a function has no derivatives", ""),
        ("input Real x; output Real y; output Real x; algorithm y := x;", "`x` is declared twice", ""),
        ("input Real x; output Real y; algorithm y = x", "", ""),
        ("input Real x; output Real y; algorithm y := k*x;", "unknown name `k`", ""),
        ("input Real x; output Real y; algorithm y := f(x);", "f() -> f()", ""),
        ("input Real x; output Real y; algorithm y := g(x);", "f() -> g() -> f()", ""),
        ("input Length x; output Real y; algorithm y := x;", "`x` of f(): found a velocity", ""),
        ("input Velocity x; output Length y; algorithm y := x;", "`y` of f(): found a velocity", ""),
        ("input Velosity x; output Real y; algorithm y := x;", "`Velosity` is not a type", ""),
        ("input Real x, k; output Real y; algorithm y := x;", "f() needs `k`", "f(x, k)"),
        ("output Real y; algorithm y := 1;", "f() takes 0 arguments, found 1", "f()"),
        ("input Real x[:]; output Real y; algorithm y := x[1];", "`x` of f(): found a single value", ""),
        ("input Real x; output Real y[2]; algorithm y := x;", "`y` of f(): found a single value", ""),
        ('input Real x(unit = "furlong"); output Real y; algorithm y := x;', "unknown unit `furlong`", ""),
    ],
)
def test_messages(body, message, hint):
    other = "function g input Real x; output Real y; algorithm y := f(x); end g;\n"
    text = other + f"function f {body} end f;\n" + model("f(ball.vx)*1 N.s/m")
    with pytest.raises(MbdslError) as problem:
        mbdsl.parse(text)
    assert message in str(problem.value)
    assert hint in (problem.value.hint or "")
    assert problem.value.span is not None


def test_the_call_is_named():
    with pytest.raises(MbdslError) as problem:
        mbdsl.parse(model("f(ball.vx)", "function f input Real x; output Force y; algorithm y := x; end f;\n"))
    assert "`y` of f(): found" in problem.value.message
    assert [(text, place.line) for text, place in problem.value.notes] == [("the function is called here", 6)]


def test_a_function_without_an_end():
    with pytest.raises(MbdslError, match=r"the function `square` is not closed"):
        mbdsl.parse(model("0 N", SQUARE.replace("end square", "end squar")))


@pytest.mark.parametrize(
    ("before", "message"),
    [
        (SQUARE * 2, "a second function `square` in this file"),
        (SQUARE.replace("square", "sin"), "`sin` is a function of the language"),
        ("", "no function is called `squar`"),
    ],
)
def test_names_of_functions(before, message):
    with pytest.raises(MbdslError) as problem:
        mbdsl.parse(model("1 N*squar(2)", before or SQUARE))
    assert message in problem.value.message
    assert before or "square" in problem.value.hint
