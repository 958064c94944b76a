"""The language server over its protocol: a session of an editor with `mbdsl lsp`."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from mbdsl import parse
from mbdsl.elements import kinds
from mbdsl.errors import MbdslError
from mbdsl.mechanism.graph import build

ROOT = Path(__file__).parents[3]
CRANK = (ROOT / "models" / "slider_crank.mbd").read_text(encoding="utf-8")
ARM = """\
model Arm "an arm"
  parameter Length L = 1 m "its length";
  Frame root;
  Frame tip = rod.b;
  Rod rod(m = 1 kg, length = L);
  Revolute pin(root, rod.a);
end Arm;
"""
ROBOT = """\
import "arm.mbd" as parts;
// α β 😀 shoulder
model Robot
  Ground ground;
  /* 😀 */ parts.Arm upper(ground, L = 50 cm, rod(m = 3 kg));
  parts.Arm lower(upper.tip);
  Real x = upper.rod.b.x + 2*upper.L;
initial equation
  upper.pin.phi = 30 deg;
end Robot;
"""
#: as it is while the line with the mark is typed
TYPED = """\
model Typed
  parameter Mass mass = 3 kg "of the crank";
  Ground ground;
  Rod crank(m = mass, length = 0.3 m, frames(tip = {{0, 1 cm}}));
  Revolute pin(ground, crank.a);
  {}
  SpringDamper spring(ground, crank.tip, k = 2 N/m);
{}
end Typed;
"""


@pytest.fixture(scope="module")
def trusting(start):
    return start("--allow-imports", encodings=["utf-8"])


def typed(line, section=""):
    """The text with the incomplete line in its declarations, or in a section behind them."""
    return TYPED.format("", f"{section}\n  {line}") if section else TYPED.format(line, "")


# -- diagnostics ----------------------------------------------------------------------------------------------------
def test_errors_appear_and_disappear(client, editor):
    client.show("crank.mbd", CRANK)
    assert client.problems("crank.mbd") == []
    wrong = CRANK.replace("k = k,", "/* ü😀 */ kk = k,")
    client.show("crank.mbd", wrong)
    (problem,) = client.problems("crank.mbd")
    with pytest.raises(MbdslError) as caught:
        parse(wrong, "crank.mbd")
    assert problem["message"] == f"{caught.value.message}\n{caught.value.hint}"
    assert problem["severity"] == 1 and editor["cut"](wrong, problem["range"]) == "kk"
    client.show("crank.mbd", CRANK)
    assert client.problems("crank.mbd") == []


def test_several_errors_of_one_text(client, editor):
    """Of the syntax: two statements without an end. Of the model: those on which nothing else depends."""
    text = CRANK.replace("wall, rod.b, k", "wall, rod.b k").replace("0 deg;\n\n", "0 deg\n\n")
    client.show("crank.mbd", text)
    found = client.problems("crank.mbd")
    assert [problem["range"]["start"]["line"] for problem in found] == [21, 26]
    text = (
        CRANK.replace("k = k", "kk = k")
        .replace("crank.w =", "crank.ww =")
        .replace("guess rod.phi = 0 deg", "rod.phi = 1 kg")
    )
    client.show("crank.mbd", text)
    marked = [editor["cut"](text, problem["range"]) for problem in client.problems("crank.mbd")]
    assert marked == ["kk", "ww", "rod.phi = 1 kg"]


def test_warnings_and_errors_of_the_structure(client, editor):
    free = "model Free Ground ground; Rod rod(m = 1 kg, length = 1 m); {} end Free;"
    client.show("free.mbd", free.format(""))
    (problem,) = client.problems("free.mbd")
    scene = parse(free.format(""))
    with pytest.raises(MbdslError) as caught:
        build(scene)
    assert problem["message"].startswith(caught.value.message) and problem["severity"] == 1
    text = free.format("Revolute p(ground, rod.a); Torque t(p, tau = 0 N.m);")
    client.show("free.mbd", text)
    expected = build(parse(text)).warnings
    assert [p["message"].partition("\n")[0] for p in client.problems("free.mbd")] == [w.message for w in expected]


def test_unsaved_texts_of_imports_are_read(client, editor):
    """arm.mbd does not exist on the disk. An error in it is shown there and at the import."""
    client.show("robot.mbd", ROBOT)
    (problem,) = client.problems("robot.mbd")
    assert editor["cut"](ROBOT, problem["range"]) == '"arm.mbd"'
    client.show("arm.mbd", ARM)
    assert client.problems("robot.mbd") == []
    client.show("arm.mbd", ARM.replace("length = L", "length = LL"))
    (problem,) = client.problems("robot.mbd")
    assert editor["cut"](ROBOT, problem["range"]) == '"arm.mbd"'
    (place,) = problem["relatedInformation"]
    assert client.text_of(place["location"]) == "LL"
    client.show("arm.mbd", ARM)
    assert client.problems("robot.mbd") == []


def test_imports_from_outside_need_the_option(client, trusting):
    for session, count in ((client, 1), (trusting, 0)):
        (session.folder / "outside.mbd").write_text(ARM, encoding="utf-8")
        session.show("inner/robot.mbd", ROBOT.replace('"arm', '"../outside'))
        assert len(session.problems("inner/robot.mbd")) == count
        assert bool(session.ask("textDocument/definition", session.at("inner/robot.mbd", "Arm"))) is (count == 0)


# -- completion -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("line", "section", "expected"),
    [
        ("|", "", [*kinds(), "parameter", "Typed", "Mass", "equation"]),
        ("Rev|", "", ["Revolute"]),
        ("Rod rod(|", "", ["length", "m", "frames"]),
        ("Rod rod(m = 1 kg, |", "", ["length"]),
        ("Rod rod(m = |", "", ["mass", "sin", "pi"]),
        ("Rod rod(length = 3 |", "", ["m", "mm", "cm"]),
        ("Rod rod(length = 3 c|", "", ["cm"]),
        ("Body body(I = 3 kg.|", "", ["kg.m2"]),
        ("Revolute q(crank.|", "", ["a", "b", "c", "tip"]),
        ("Revolute q(ground, |", "", ["crank", "spring", "mu", "radius"]),
        ("Torque t(pin, tau = -2 N.m*pin.|", "", ["phi", "w", "fx"]),
        ("SpringDamper other(ground, crank.b, force = 3*|", "", ["s", "v", "mass"]),
        ("Table f(table = [0, 0; 1, 1], smoothness = |", "", ['"cubic"', '"monotone"']),
        ('Table f(smoothness = "|', "", ["cubic", "monotone"]),
        ("parameter |", "", ["Length", "Real"]),
        ("extends |", "", ["Typed"]),
        ("annotation(|", "", ["experiment"]),
        ("annotation(experiment(|", "", ["StopTime", "Step"]),
        ("annotation(experiment(StopTime = 2 |", "", ["s", "ms"]),
        ("connect(|", "equation", ["crank", "ground"]),
        ("con|", "equation", ["connect"]),
        ("when |", "equation", ["sample", "pre", "initial()", "crank", "time"]),
        ("when time > 1 then |", "equation", ["reinit", "terminate", "assert", "elsewhen", "end"]),
        ("when time > 1 then u = 2; |", "equation", ["reinit", "elsewhen"]),
        ("when time > 1 then u = pre(|", "equation", ["mass", "crank"]),
        ("when time > 1 then u = 2; end when; |", "equation", ["connect", "when", "assert"]),
        ("crank.|", "initial equation", ["phi", "w", "x"]),
        ("|", "initial equation", ["guess", "crank"]),
        ("crank.phi = 3 |", "initial equation", ["deg", "rad"]),
    ],
)
def test_completion_of_incomplete_texts(client, line, section, expected):
    assert set(expected) <= set(client.complete("typed.mbd", typed(line, section)))


def test_what_is_offered_first(client):
    """Required parameters, units of the dimension, frames behind a dot."""
    assert client.complete("typed.mbd", typed("Rod rod(|"))[:2] == ["length", "m"]
    assert client.complete("typed.mbd", typed("Body b(I = 2 |"))[0] == "kg.m2"
    assert client.complete("typed.mbd", typed("Revolute q(crank.|"))[:4] == ["a", "b", "c", "tip"]
    assert client.complete("typed.mbd", typed("Rod rod(m = 1, |"))[:1] == ["length"]
    assert "m" not in client.complete("typed.mbd", typed("Rod rod(m = 1, |"))


@pytest.mark.parametrize("line", ["// Rod |", 'Rod rod "|', "Rod |", "Rod rod(m = 3|", "/* Rod rod(| */"])
def test_nothing_is_offered_where_nothing_fits(client, line):
    assert client.complete("typed.mbd", typed(line)) == []


def test_proposals_have_documentation(client):
    client.show("typed.mbd", typed("Ro"))
    offset = client.texts["typed.mbd"].index("\n  Ro\n") + 5
    items = client.ask("textDocument/completion", client.place("typed.mbd", offset))["items"]
    rod = next(item for item in items if item["label"] == "Rod")
    assert kinds()["Rod"].doc in rod["documentation"]["value"] and "`length`" in rod["documentation"]["value"]
    assert client.text_of({"uri": client.uri("typed.mbd"), "range": rod["textEdit"]["range"]}) == "Ro"


def test_members_of_sub_models_of_other_files(client):
    client.show("arm.mbd", ARM)
    assert set(client.complete("robot.mbd", ROBOT.replace("upper.rod.b.x", "upper.|"))) == {
        "L",
        "root",
        "tip",
        "rod",
        "pin",
    }
    assert client.complete("robot.mbd", ROBOT.replace("parts.Arm lower", "parts.| lower")) == ["Arm"]
    assert client.complete("robot.mbd", ROBOT.replace("rod(m = 3 kg)", "rod(|)"))[:2] == ["length", "m"]


# -- hover ----------------------------------------------------------------------------------------------------------
def test_hover(client):
    client.show("crank.mbd", CRANK)
    client.problems("crank.mbd")

    def shown(word, number=0):
        return client.ask("textDocument/hover", client.at("crank.mbd", word, number))["contents"]["value"]

    assert kinds()["Revolute"].doc in shown("Revolute") and "| `mu` |" in shown("Revolute")
    assert "distance of the frames a and b" in shown("length = L1") and "crank.length`: 0.3 m" in shown("length = L1")
    assert "parameter Length L1 = 0.3 m" in shown("L1") and "length of the crank" in shown("L1")
    assert "Values: m = 3 kg, length = 0.3 m" in shown("crank.a")
    assert "1 N/m = 1 kg/s2" in shown("N/m") or "N/m" in shown("N/m")
    assert "initial equation" in shown("initial") and "StopTime" in shown("StopTime")
    client.show("crank.mbd", CRANK.replace("0.3 m ", "300 mm "))
    assert "300 mm = 0.3 m" in shown("mm")
    assert client.ask("textDocument/hover", client.at("crank.mbd", "is relaxed")) is None


# -- definition, references, rename ---------------------------------------------------------------------------------
def test_definitions_in_other_files(client):
    client.show("arm.mbd", ARM)
    client.show("robot.mbd", ROBOT)

    def target(word, number=0):
        (place,) = client.ask("textDocument/definition", client.at("robot.mbd", word, number))
        text = client.texts[place["uri"].rpartition("/")[2]].split("\n")[place["range"]["start"]["line"]]
        return place["uri"].rpartition("/")[2], text.strip(), client.text_of(place)

    assert target("Arm") == ("arm.mbd", ARM.split("\n")[0], "Arm")
    assert target("L =") == ("arm.mbd", ARM.split("\n")[1].strip(), "L")
    assert target("upper", 1)[1:] == (ROBOT.split("\n")[4].strip(), "upper")
    assert target("rod")[2] == "rod" and target("pin")[1].startswith("Revolute pin")
    assert target("tip")[1] == "Frame tip = rod.b;"
    assert target('"arm.mbd"')[:2] == ("arm.mbd", ARM.split("\n")[0])


def test_references(client):
    client.show("arm.mbd", ARM)
    client.show("robot.mbd", ROBOT)
    for declared, count in ((True, 4), (False, 3)):
        question = {**client.at("arm.mbd", "L ="), "context": {"includeDeclaration": declared}}
        found = client.ask("textDocument/references", question)
        assert len(found) == count and {client.text_of(place) for place in found} == {"L"}


def renamed(client, editor, name, word, new, number=0):
    """The texts of all open files after renaming."""
    question = {**client.at(name, word, number), "newName": new}
    changes = client.ask("textDocument/rename", question)["changes"]
    texts = dict(client.texts)
    for uri, edits in changes.items():
        texts[uri.rpartition("/")[2]] = editor["edited"](texts[uri.rpartition("/")[2]], edits)
    return texts


def test_rename_over_files_and_wide_characters(client, editor, tmp_path):
    """The renamed models are read as before, with the new names."""
    client.show("arm.mbd", ARM)
    client.show("robot.mbd", ROBOT)
    texts = renamed(client, editor, "arm.mbd", "rod.b", "bar")
    texts = {name: texts[name] for name in ("arm.mbd", "robot.mbd")}
    assert texts["arm.mbd"] == re.sub(r"\brod\b", "bar", ARM)
    assert texts["robot.mbd"] == re.sub(r"\brod\b", "bar", ROBOT)
    texts = renamed(client, editor, "robot.mbd", "upper.pin", "shoulder")
    assert texts["robot.mbd"] == ROBOT.replace("upper", "shoulder")  # not in the comment
    for name in ("arm.mbd", "robot.mbd"):
        (tmp_path / name).write_text(texts[name], encoding="utf-8")
    scene = parse(texts["robot.mbd"], str(tmp_path / "robot.mbd"))
    assert "shoulder.rod" in scene.components and scene.components["shoulder.rod"].values["length"] == 0.5


@pytest.mark.parametrize(
    ("word", "new"),
    [
        ("crank.a", "rod"),  # another component
        ("L1", "L2"),  # another parameter
        ("L1", "model"),
        ("L1", "1a"),
        ("L1", "a b"),
        ("L1", "time"),
        ("k =", "s"),  # a name of the component in a law
        ("squares", "crank"),
    ],
)
def test_names_that_collide_are_refused(client, word, new):
    text = CRANK.replace("s0 = 0.3 m", "force = k*(s - 0.3 m)").replace("k = k, c = c, ", "")
    client.show("crank.mbd", text.replace("initial", "  Real squares[2] = {i^2 for i in 1:2};\ninitial"))
    error = client.ask("textDocument/rename", {**client.at("crank.mbd", word), "newName": new}, error=True)
    assert error["message"] and "Traceback" not in str(error)


def test_words_of_the_language_cannot_be_renamed(client):
    client.show("crank.mbd", CRANK)
    assert (
        "belongs to the language"
        in client.ask("textDocument/prepareRename", client.at("crank.mbd", "length = L1"), error=True)["message"]
    )
    found = client.ask("textDocument/prepareRename", client.at("crank.mbd", "L1"))
    assert found["placeholder"] == "L1"


# -- sessions -------------------------------------------------------------------------------------------------------
def test_positions_in_the_encoding_of_the_editor(client, trusting):
    """The characters αβ😀 are 2 + 2 + 4 bytes of UTF-8, and 1 + 1 + 2 units of UTF-16, which is the default."""
    assert client.capabilities["positionEncoding"] == "utf-16"
    for session, units in ((client, 4), (trusting, 8)):
        session.show("a.mbd", "model A\n /*αβ😀*/ Rood g;\nend A;\n")
        (problem,) = session.problems("a.mbd")
        column = 1 + 2 + units + 2 + 1
        ends = {end: {"line": 1, "character": column + 4 * (end == "end")} for end in ("start", "end")}
        assert problem["range"] == ends


def test_broken_and_huge_texts_do_not_stop_the_server(start):
    """Each text is followed by questions, which are answered. One of them imports a file that is not text."""
    client = start()
    (client.folder / "data.mbd").write_bytes(bytes(range(256)))
    deep = "model A\n" + "for i in 1:2 loop\n" * 300 + "Rod r[i](m = " + "(" * 300
    for text in (
        *(
            "",
            "\0",
            "model",
            "end end end ;;; ((([[[{{{",
            '"' * 999,
            "/*" * 999,
            "\ud800 model A",
            "model A\r\rend A;\r",
        ),
        *(deep, "model A Real x = " + "-" * 5000 + "1; end A;", "model A parameter Real x[9999999] = {}; end A;"),
        *(
            "Rod r(m = 1);\n" * 3_000,
            'import "data.mbd"; model A Ground g; end A;',
            'import "."; model A Ground g; end A;',
        ),
    ):
        client.show("a.mbd", text)
        client.ask("textDocument/completion", client.place("a.mbd", len(text) // 2))
        client.ask("textDocument/hover", client.place("a.mbd", len(text)))
    client.show("a.mbd", CRANK)
    while client.problems("a.mbd"):  # those of the other texts
        pass
    assert client.close() == (0, "")


@pytest.mark.parametrize("length", ["abc", "99999999999999", "-5", "0", "", "1e3", "9" * 400, "²"])
def test_lengths_of_messages_that_cannot_be(start, length):
    """There is no place at which the next message would begin: the server ends and says why."""
    session = start()
    session.process.stdin.write(f"Content-Length: {length}\r\n\r\n{{}}".encode())
    session.process.stdin.flush()
    assert session.process.wait(300) == 1
    errors = session.ended()[1]
    assert errors.count("\n") == 1 and f"found `Content-Length: {length[:40]}`, expected a number of bytes" in errors


@pytest.mark.parametrize("content", [b"{}x", b"7", b"[]", b"[" * 100_000, b"\xff\xfe"])
def test_messages_that_are_none_do_not_stop_the_server(start, content):
    session = start()
    session.process.stdin.write(b"content-length:%d\r\n\r\n" % len(content) + content)
    session.show("a.mbd", "model A\n Rood g;\nend A;\n")
    assert len(session.problems("a.mbd")) == 1
    code, errors = session.close()
    assert code == 0 and errors.startswith("Unable to handle message: ") and errors.count("\n") == 1


def test_a_message_that_is_cut_ends_the_server(start):
    session = start()
    session.process.stdin.write(b"Content-Length: 100\r\n\r\n{}")
    assert session.ended() == (
        1,
        "the language server has ended: the connection ended after 2 of the 100 bytes of a message\n",
    )


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="the system does not list children of processes")
def test_many_open_documents(start):
    """One process checks them, one after the other, and the names of those that import nothing are not read."""
    session, names = start(), [f"m{k}.mbd" for k in range(40)]
    for k, name in enumerate(names):
        session.show(name, f"model M{k} {'Rood' if k % 2 else 'Ground'} g; end M{k};")
    waiting, most = {session.uri(name) for name in names}, 0
    children = Path(f"/proc/{session.process.pid}/task/{session.process.pid}/children")
    while waiting:
        found = session.diagnostics.get(timeout=300)
        waiting.discard(found["uri"])
        most = max(most, len(children.read_text().split()))
        k = int(re.search(r"m(\d+)\.mbd", found["uri"])[1])
        # a Ground alone is no mechanism
        assert ("Rood" in str(found["diagnostics"])) is (k % 2 == 1) and len(found["diagnostics"]) == 1
    assert most == 1
    assert session.close() == (0, "")


def test_a_check_that_is_killed_is_followed_by_others(start):
    """Also one that ends by itself: the warning says so, and the next text is checked."""
    session = start()
    session.show("a.mbd", "model A Ground g; end A;")
    session.problems("a.mbd")
    children = Path(f"/proc/{session.process.pid}/task/{session.process.pid}/children")
    if not children.exists():
        pytest.skip("the system does not list children of processes")
    os.kill(int(children.read_text().split()[0]), signal.SIGKILL)
    session.show("a.mbd", "model A Rood g; end A;")
    (problem,) = session.problems("a.mbd")
    session.show("a.mbd", "model A Rood g;  end A;")
    (problem,) = session.problems("a.mbd")
    assert "Rood" in problem["message"]


def test_a_connection_that_is_lost_ends_the_server(start):
    assert start().ended()[0] == 1


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_signals_end_the_server_while_its_input_is_open(start, default_signals):
    session = start()
    session.process.send_signal(signal.SIGTERM)
    assert session.process.wait(300) == 130
    session.ended()


def test_without_the_extra(tmp_path):
    """The message names the package and the command that installs it."""
    code = "import sys; sys.modules['pygls'] = None; from mbdsl.cli import main; sys.exit(main(['lsp']))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 2 and done.stdout == ""
    assert "needs the package `pygls`" in done.stderr and "pip install '.[editor]'" in done.stderr


SERVO = """model Servo
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  Current i(start = 2 A) "of the motor";
  Force z(start = 0 N);
  Torque motor(pin, tau = 1 N.m/A*i);
equation
  der(i) = (1 A - i)/(0.1 s);
  der(z) = (pin.fy - z)/(0.1 s);
end Servo;
"""


def test_states(client):
    client.show("servo.mbd", SERVO)
    assert client.problems("servo.mbd") == []

    def shown(line, name):
        place = client.place("servo.mbd", SERVO.index(line) + line.index(name))
        return client.ask("textDocument/hover", place)["contents"]["value"]

    text = shown("A*i);", "i")
    assert "Current i" in text and "of the motor" in text and "State: `der(i) = (1 A - i) / 0.1 s`" in text
    text = shown("- z)", "z")
    assert "Force z" in text and "State" in text
    items = client.complete("servo.mbd", SERVO.replace("- i)", "- |)"))
    assert {"i", "z", "der"} <= set(items)
