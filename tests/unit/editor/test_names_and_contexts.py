"""Names, contexts and syntax trees of incomplete texts, without the protocol."""

import re
from pathlib import Path

import pytest

from mbdsl import parse
from mbdsl.editor import navigation
from mbdsl.editor.checking import check
from mbdsl.editor.completion import complete
from mbdsl.editor.hover import hover
from mbdsl.editor.library import LooseLibrary
from mbdsl.editor.names import NameIndex
from mbdsl.editor.positions import Places
from mbdsl.editor.repair import repaired
from mbdsl.editor.workspace import OpenFiles
from mbdsl.errors import Span, UsageError
from mbdsl.lang import lexer

ROOT = Path(__file__).parents[3]
CRANK = (ROOT / "models" / "slider_crank.mbd").read_text(encoding="utf-8")
ARMS = """\
model Arm
  parameter Length L = 1 m;
  Frame root;
  Body rod(m = 1 kg, I = 1 kg.m2, frames(near = {-L/2, 0}, far = {L/2, 0}));
  Revolute pin(root, rod.near);
  Frame tip = rod.far;
end Arm;

partial model Base
  parameter Integer N = 3;
  Ground ground;
end Base;

model Arms
  extends Base(N = 2);
  Arm arm[N](each L = 2 m, rod(m = {1, 2} kg));
  for i in 1:N loop
    RotationalSpringDamper spring[i](arm[i].pin, k = i*1 N.m/rad);
  end for;
  Table f(table = [0 s, 0 N.m; 1 s, 1 N.m]);
  Torque t(arm[1].pin, tau = f(time) - arm[1].L*(1 N)*sin(phi));
  Real squares[N] = {k^2 for k in 1:N};
equation
  connect(arm[1].root, ground);
  connect(arm[2].root, arm[1].tip);
initial equation
  for j in 1:N loop
    guess arm[j].pin.phi = j*10 deg;
  end for;
end Arms;
"""


# -- names ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("folder", ["models", "models/gallery"])
def test_every_name_in_the_models_is_known(folder):
    """The scene builder has accepted these models: each name denotes something."""
    for path in sorted((ROOT / folder).glob("*.mbd"))[:20]:
        text = path.read_text(encoding="utf-8")
        found = {o.start: o.end for o in NameIndex(LooseLibrary().add(text, str(path))).occurrences}
        covered = {at for start, end in found.items() for at in range(start, end)}
        names = [p for p in lexer.pieces(text) if p.kind == lexer.NAME]
        assert [p.text for p in names if p.start not in covered] == [], path


def test_names_of_modelica_are_known():
    """Frames, functions, kinds and constants by their names there; the scene builder accepts them."""
    text = """model A
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Modelica.Mechanics.MultiBody.Joints.Revolute pin(ground, rod.frame_a);
  Torque t(pin, tau = 1 N.m*Modelica.Math.sin(2*Modelica.Constants.pi*pin.a.x/(1 m)));
end A;
"""
    assert len(parse(text).components) == 4
    found = {text[o.start : o.end] for o in workspace(text).names("/nowhere/a.mbd").occurrences}
    assert {"frame_a", "Modelica.Math.sin", "Modelica.Constants.pi", "a"} <= found


def test_warnings_of_the_text_are_reported():
    """A damper without a stiffness, which Modelica's names of the parameters suggest by mistake."""
    text = CRANK.replace("k = k, c = c", "c = 5")
    expected = [w.message for w in parse(text).warnings]
    unused = "nothing uses the parameters `k`, `c`"  # which the replaced values used
    assert [p["message"] for p in check(text, "a.mbd")["problems"]] == [*expected, unused] != [unused]


def workspace(text):
    found = OpenFiles()
    found.open("/nowhere/a.mbd", text)
    return found


def renamed(text, offset, name):
    places = navigation.rename(workspace(text), "/nowhere/a.mbd", offset, name)
    for _, start, end in sorted(places, reverse=True):
        text = text[:start] + name + text[end:]
    return text


def content(scene, old):
    """All values of a scene as text, with ``other`` instead of the name ``old``."""
    parts = [(c.name, c.kind.name, dict(c.values), dict(c.ports)) for c in scene.components.values()]
    whole = repr(
        (parts, scene.initial, scene.variables, scene.aliases, [(p.name, p.value) for p in scene.parameters.values()])
    )
    return re.sub(rf"\b{old}\b", "other", re.sub(r"span=Span\(.*?\)", "", whole))


@pytest.mark.parametrize("text", [CRANK, ARMS], ids=["crank", "arms"])
def test_a_model_with_another_name_is_the_same_model(text):
    """Each declared name in turn: the scene builder reads the same values, under the new name."""
    declared = [o for o in workspace(text).names("/nowhere/a.mbd").occurrences if o.declares]
    assert len(declared) > 15
    before = parse(text)
    for occurrence in declared:
        after = parse(renamed(text, occurrence.start, "other"))
        assert content(after, occurrence.symbol.name) == content(before, occurrence.symbol.name)


@pytest.mark.parametrize(
    ("text", "word", "new"),
    [
        (CRANK, "L1 =", "crank"),
        (ARMS, "near =", "far"),  # frames of one body
        (ARMS, "near =", "phi"),  # a signal
        (ARMS, "i in", "arm"),
        (ARMS, "arm[N]", "N"),  # inherited
        (ARMS, "N = 3", "arm"),  # of the model that inherits it
        (
            "model A parameter Real n = 2; parameter Real x[2] = {n*i for i in 1:2}; end A;",
            "n =",
            "i",
        ),  # a loop variable
        (ARMS, "Arm\n", "Base"),
        (ARMS, "Arm\n", "Rod"),
        (ARMS, "f(table", "sin"),  # a function that the same law uses
        ("model A parameter Length L = 2 m; parameter Real y = 3 m/L; end A;", "L =", "s"),  # 3 m/s is a unit
        ("model A parameter Mass L = 2 kg; parameter Real y = 3 N/g; end A;", "L =", "g"),  # two readings
        ("model A Ground g; B b; end A; model B outer Ground g; end B;", "g;", "h"),  # inner and outer
        ("model A parameter Length L = 2 m end A;", "L =", "s"),  # a syntax error
    ],
)
def test_a_new_name_with_another_meaning_is_refused(text, word, new):
    with pytest.raises(UsageError):
        renamed(text, text.index(word), new)


# -- incomplete texts -----------------------------------------------------------------------------------------------
def test_statements_without_errors_are_kept():
    text = """model A "with five errors"
  Ground ground;
  Rod crank(m = 1 kg, length =
  Rod rod(m = 1 kg length = 2 m);
  Revolute p(ground, crank.a)
  Revolute q(crank.b, rod.a);
  Spri
equation
  connect(a.
initial equation
  rod.phi = 3 deg;
end A;
"""
    found = repaired(text, "a.mbd")
    assert [item.name for item in found.file.models[0].items] == ["ground", "q"]
    assert len(found.file.models[0].initial) == 1
    lines = {problem.span.line for problem in found.problems}
    assert len(found.problems) >= 5 and {4, 5} <= lines
    assert len(found.text) == len(text)
    assert repaired(CRANK, "a.mbd").problems == ()


def test_a_model_without_an_end():
    found = repaired("model A Ground ground; Rod rod(m = 1, length = 1);", "a.mbd")
    assert [item.name for item in found.file.models[0].items] == ["ground", "rod"]
    assert len(found.problems) == 1


def test_completion_and_hover_answer_at_every_place():
    """While the text is typed from its beginning, and in its middle."""
    for end in range(0, len(CRANK), 29):
        for text in (CRANK[:end], CRANK[:end] + CRANK[end + 7 :]):
            names = workspace(text).names("/nowhere/a.mbd")
            start, items = complete(names.unit, end)
            assert 0 <= start <= end and all(item.label for item in items)
            assert not items or re.fullmatch(r"[A-Za-z_0-9µ./^()-]*", text[start:end])
            hover(names, end)


MACHINE = """model M
  Ground ground; Body b(m = 1 kg, I = 1 kg.m2); Prismatic rail(ground, b.c, mu = 0.2, sticks = true);
  Contact floor(gap = b.y, e = 0.5); Boolean on(start = true); discrete Real F(unit = "N", start = 0);
equation
  when {sample(0, 1 ms), edge(on), initial()} then F = pre(F) + 1 N; on = change(F);
  elsewhen b.y < 0 m then reinit(b.vy, 1 m/s); terminate("x"); assert(on, "y", AssertionLevel.warning); end when;
end M;
"""


def test_every_word_about_events_and_contacts_is_described():
    names = workspace(MACHINE).names("/nowhere/a.mbd")
    said = {
        "when": "Equations of an event",
        "elsewhen": "A further condition",
        "sample": "true at start + k period",
        "edge": "becomes true",
        "initial()": "true at the start",
        "pre(": "before the event",
        "change": "whether a discrete variable changes",
        "reinit": "a jump of a state",
        "terminate": "ends the run",
        "assert": "ends the run with this text",
        "AssertionLevel": "lets it go on",
        "discrete": "changes at events only",
        "Contact": "Rigid contact",
        "gap": "`Contact.gap`",
        "sticks": "`Prismatic.sticks`",
    }
    for word, text in said.items():
        found = hover(names, MACHINE.index(word))
        assert found is not None and text in found.text, word


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("Contact c(|);", {"gap", "e", "mu", "mu_s", "slip", "impacts"}),
        ("Prismatic p(ground, b.c, |);", {"mu", "sticks"}),
        ("Real q = floor.|;", {"active", "force", "friction", "impacts", "impulse", "sliding"}),
    ],
)
def test_parameters_and_signals_of_contacts_are_offered(line, expected):
    text = MACHINE.replace("equation", f"  {line}\nequation", 1)
    at = text.index("|")
    names = workspace(text.replace("|", "")).names("/nowhere/a.mbd")
    assert expected <= {item.label for item in complete(names.unit, at)[1]}


def test_a_very_long_text_is_not_searched_while_it_is_typed():
    """It takes some seconds to read, in which the editor would wait."""
    long = CRANK + "//" + "x" * 250_000
    assert workspace(long).names("/nowhere/a.mbd").occurrences == []
    assert complete(workspace(long).names("/nowhere/a.mbd").unit, 0)[1] != []


# -- places ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_places_in_a_text(encoding):
    """Against Python's own encoders, line by line; the places between \r and \n belong to no line."""
    text = "a α\r\n😀 b\n\rü\u2028c\n"
    places = Places(text, encoding)
    line, start = 0, 0
    for at, c in enumerate(text):
        size = len(text[start:at].encode(f"{encoding}{'-le' if encoding != 'utf-8' else ''}"))
        expected = (line, size // {"utf-8": 1, "utf-16": 2, "utf-32": 4}[encoding])
        if text[at - 1 : at + 1] != "\r\n":
            assert places.position(at) == expected
            assert places.offset(*expected) == at
        if c == "\n" or (c == "\r" and text[at + 1 : at + 2] != "\n"):
            line, start = line + 1, at + 1
    assert places.offset(0, 99) == 3 and places.offset(99, 0) == len(text)
    assert places.offset(-1, -1) == 0 and places.position(999) == (line, 0)


def test_places_of_messages():
    """Their lines end with a line feed only."""
    text = "a\rb\nc d\n"
    assert Places(text).of_span(Span("", 2, 3, 1)) == (6, 7)
    assert Places(text).of_span(Span("", 9, 1, 1)) == (8, 8)
