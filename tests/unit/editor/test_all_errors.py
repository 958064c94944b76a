"""All errors of a text that do not follow from each other, and no others."""

import pytest

from mbdsl.cli import main
from mbdsl.editor import all_errors
from mbdsl.lang.load import parse_text


def lines(text):
    """The lines of the errors, from 1."""
    problems, scene = all_errors.find(text, "a.mbd", lambda left: parse_text(left, "a.mbd"))
    assert (scene is None) == bool(problems)
    assert all(p.span.text == text.split("\n")[p.span.line - 1] for p in problems)
    return [p.span.line for p in problems]


MIXED = """model Top
  Ground ground;
  Rod one(m = 1 s, length = 1 m);
  Rod two(m = 1 kg, lenght = 1 m);
  Rod three(m = 1 kg, length = 1 m);
  Revolut pin(ground, three.a);
  Revolute next(one.b, two.a);
  Torque load(next, tau = 3*unknown);
  Torque wind(three, tau = 2 m);
  parameter Real k = nothing;
equation
  connect(three.q, ground);
initial equation
  three.phi = 3 m;
end Top;
"""


def test_errors_of_names_and_units():
    """Line 8 needs line 7, which needs lines 3 and 4; the other lines are independent."""
    assert lines(MIXED) == [3, 4, 6, 9, 10, 12, 14]


def test_errors_of_syntax_and_of_names():
    broken = MIXED.replace(
        "Torque wind(three, tau = 2 m);", "Torque wind(three tau = 2 N.m);\n  Force f(three.b, fx = wind);"
    )
    assert lines(broken) == [3, 4, 6, 9, 11, 13, 15]  # line 10 needs line 9


def test_a_ground_with_an_error_is_still_the_ground():
    """No error that the model has no ground, where a value of the ground is wrong."""
    bodies = "  Body b(m = 1 kg, I = 1 s);\n  Body c(m = 1 kg, I = 1 kg.m2);\n  Revolute pin(ground, c.c);\nend M;\n"
    assert lines(f"model M\n  Ground ground(g = 9.81*sin(6 deg));\n{bodies}") == [2, 3]
    assert lines(f"model M\n{bodies.replace('1 s', '1 kg.m2').replace('(ground', '(b.c')}") == [2]


def test_an_equation_with_an_error_still_gives_its_variable():
    """No error that a variable has no value, where its derivative or its value at an event is wrong."""
    text = """model M
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Revolute pin(ground, b.c);
  Real x, y = 2*x;
  Integer n, k[3](each start = 0);
  Torque load(pin, tau = n*x*1 N.m);
  Torque other(pin, tau = 1 m);
equation
  der(x) = 3 kg;
  when time > 1 m then n = 2; end when;
  when time > 1 s then
    k[n] = 2;
  end when;
end M;
"""
    assert lines(text) == [8, 10, 11]
    assert lines(text.replace("1 m then", "1 s then")) == [8, 10, 13]


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        (
            "  function f\n    input Real x;\n    output Real y;\n  algorithm\n    y = x +;\n  end f;\n  Foo z;\n",
            [6, 8],
        ),
        (
            "  function f\n    input Real x;\n    output Real y;\n  algorithm\n    for i in 1:3 loop\n      y := x;\n"
            "    end for;\n  end f;\n  Foo z;\n",
            [6, 10],
        ),
        ("  function f\n    input Real x;\n    output Real y;\n  algorithm\n    y := x;\n  end f;\n  Foo z;\n", [8]),
        ("  record R\n    Real a;\n  end R;\n", [2]),
        ("equation\n  when time > 1 then\n    reinit(x, 0);\n  end when;\n  Rod late(m = 1 kg);\n", [6]),
        ("equation\n  when time > 1 then\n    reinit(x, 0);\n  end whn;\n  v = 2;\n", [5, 6]),
        ("equation\n  v = 2;\n  when time > 1 then\n    reinit(x, 0);\n", [3, 6]),
        ("equation\n  if time < 1 then\n    u = 0;\n  else\n    u = 1;\n  end if;\n  v = 2;\n", [3, 8]),
        ("algorithm\n  x := 1;\n  if x > 2 then\n    y := 3;\n  end if;\nequation\n  v = 2;\n", [2, 8]),
        ("  for i in 1:n loop\n    Rod r[i](m = 1 kg, length = 1 m);\n  end for;\n  Foo x;\n", [2, 5]),
    ],
)
def test_a_block_is_one_error(block, expected):
    assert lines(f"model Top\n{block}end Top;\n") == expected


def test_a_package_and_its_models():
    assert lines("package P\nmodel Top\n  Ground g;\n  Foo x;\nend Top;\nend P;\n") == [1, 4]


def test_connections_to_what_is_left_out_are_no_errors():
    text = "model Top\n  Ground g;\n  Rod rod(m = 1 kg, length = 1 m);\n  Revolut pin;\n  Revolute next;\nequation\n"
    text += (
        "  connect(pin.frame_a, g);\n  connect(next.frame_a, pin.frame_b);\n  connect(next.frame_b, rod.a);\nend Top;\n"
    )
    assert lines(text) == [4]


def test_no_errors():
    assert lines("model Top\n  Ground g;\nend Top;\n") == []


@pytest.mark.parametrize("command", ["check", "simulate", "explain"])
def test_commands_show_all(command, tmp_path, capsys):
    file = tmp_path / "top.mbd"
    file.write_text(MIXED, encoding="utf-8")
    assert main([command, str(file)]) == 2
    shown = capsys.readouterr().err
    assert [int(line.split(":")[1]) for line in shown.splitlines() if ": error: " in line] == [3, 4, 6, 9, 10, 12, 14]


def test_an_override_that_is_wrong_is_the_only_error(tmp_path, capsys):
    file = tmp_path / "top.mbd"
    file.write_text("model Top\n  Ground g;\n  parameter Length L = 1 m;\nend Top;\n", encoding="utf-8")
    assert main(["check", str(file), "--set", "L=2kg"]) == 2
    assert capsys.readouterr().err.count("error:") == 1
