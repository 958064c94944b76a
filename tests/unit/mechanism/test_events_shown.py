"""Events of a model as texts: counts, tables of notebooks, and `mbdsl show --stage scene`."""

import pytest

from mbdsl import parse
from mbdsl.cli._scene_text import describe
from mbdsl.mechanism.graph import build
from mbdsl.mechanism.scene_tables import whens

TEXT = """model M
  Ground ground; PointMass ball(m = 1 kg); PointContact floor(ground, ball, k = 1 kN/m, e = 0.5);
  discrete Real u(unit = "N", start = 2); Boolean on(start = true);
equation
  assert(ball.y > -3 m, "too low");
  when {sample(0, 0.5 s), initial()} then u = 3 N*time/(1 s);
  elsewhen ball.y < 1 m then reinit(ball.vy, 2 m/s); terminate("down"); end when;
  when terminal() then assert(on, "off", AssertionLevel.warning); end when;
end M;"""


@pytest.fixture(scope="module")
def scene():
    return parse(TEXT)


def test_each_branch_is_a_row(scene):
    """Not the number that the contact keeps of each touch."""
    found = {does: (condition, line) for condition, does, line in whens(scene)}
    assert found == {
        "u = (3.0*time)": ("sample(0, 0.5), initial()", "<text>:6"),
        'reinit(ball.vy, 2.0); terminate("down")': ("else (ball.c.y < 1.0)", "<text>:7"),
        "warn: `on` is false: off": ("terminal()", "<text>:8"),
        'assert(ball.y > (-3 m), "too low")': ("not((-3.0 < ball.c.y)), initial()", "<text>:5"),
    }
    assert build(scene).summary().splitlines()[0].endswith(", 3 when-equations")


def test_the_scene_lists_variables_and_events(scene):
    text = describe(scene)
    assert "\ndiscrete\n  Real u(start = 2.0) N\n" in text
    assert "\nevents\n  when " in text and "  // <text>:7\n" in text


def test_a_notebook_shows_them(scene):
    html = scene._repr_html_()
    rows = [part.count("<tr>") - 1 for part in html.split("<b>") if part.startswith(("Discrete", "Events"))]
    assert rows == [1, 4]
    assert "Events" not in parse("model M Ground g; PointMass b(m = 1 kg); FreeMotion f(g, b); end M;")._repr_html_()
