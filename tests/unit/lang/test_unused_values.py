"""Values that no expression of a model uses are named by ``check`` and by the language server, in one note."""

import pytest

from mbdsl import cli, parse
from mbdsl.editor.checking import check
from mbdsl.lang.mistakes import unused as unused_values

MODEL = """model M
  {}
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
end M;
"""


def unused(text):
    return [(note.message, note.span.line) for note in unused_values.find(parse(text))]


@pytest.mark.parametrize("spatial", ["", "spatial "])
def test_one_note_names_them(spatial):
    text = spatial + MODEL.format("parameter Mass m = 1 kg;\n  constant Real k = 2;\n  input Real u;\n  Real y = 3*k;")
    assert unused(text) == [("nothing uses the values `m`, `u`", 2)]  # of a modifier, `m = 1 kg` is another name
    assert unused(text.replace("3*k", "k*u")) == [("nothing uses the parameter `m`", 2)]


@pytest.mark.parametrize(
    "use",
    [
        "Real y = L;",
        "parameter Length twice = 2*L; Real y = twice;",
        "Frame tip(rod, r = {L, 0});",
        "Frame many[2](rod, r = {{i*L, 0} for i in 1:2});",
        "Force f(rod.b, fx = if L > 1 m then 2 N else 3 N);",
        "Frame tip(rod, r = {1, 0}) if L > 5 m;",
        "annotation(experiment(StopTime = L/(1 m/s)));",
        'equation assert(L > 0, "L");',
        "initial equation rod.x = L;",
    ],
)
def test_any_expression_uses_a_value(use):
    declared = "parameter Length L = 1 m;"
    equations = use if use.startswith(("equation", "initial")) else ""
    text = MODEL.format(declared + ("" if equations else use)).replace("end M", f"{equations}\nend M")
    assert unused(text) == []


def test_bases_and_sub_models():
    """A value of a base is used by what extends it, one of a sub-model also from outside."""
    text = """model Base
  parameter Length L = 1 m; parameter Length M = 1 m;
end Base;
model Arm
  extends Base;
  parameter Length q = 3 m; parameter Length p = 3 m;
  Frame foot; Rod rod(m = 1 kg, length = L); Revolute j(foot, rod.a);
end Arm;
model Other
  extends Base;
  Real y = M; parameter Real other = 1;
end Other;
model Whole
  Ground ground; Arm arm(foot = ground, p = 1 m); Real x = arm.q;
end Whole;"""
    assert unused(text) == [("nothing uses the parameters `p`, `M`", 6)]


def test_check_and_the_language_server_say_it(tmp_path, capsys):
    (tmp_path / "m.mbd").write_text(MODEL.format("parameter Real ratio = 1;"))
    assert cli.main(["check", str(tmp_path / "m.mbd")]) == 0
    assert "m.mbd:2:18: note: nothing uses the parameter `ratio`" in capsys.readouterr().err
    assert cli.main(["simulate", str(tmp_path / "m.mbd"), "--stop", "10ms", "--quiet"]) == 0
    assert "note" not in capsys.readouterr().err
    (problem,) = check(MODEL.format("parameter Real ratio = 1;"), "m.mbd")["problems"]
    assert "`ratio`" in problem["message"]
