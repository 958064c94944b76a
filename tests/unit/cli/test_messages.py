"""Text of a model, a name or an argument reaches a terminal or a page as text, never as a command to it."""

import io
import sys
import unicodedata

import pytest

from mbdsl import parse
from mbdsl.cli import main
from mbdsl.cli._progress import Display
from mbdsl.errors import MbdslError, Span
from mbdsl.messages import visible
from mbdsl.plotting.figures import Figure, Page, Series, TextTable
from mbdsl.plotting.pages import html

ESCAPE, BIDI = "\x1b]0;owned\x07\x1b[2J", "\u202e"
#: categories of The Unicode Standard, table 4-4, that control or hide text: control, format, surrogates, line
#: separators
STEERING = {"Cc", "Cf", "Cs", "Zl", "Zp"}
MODEL = "model E {doc}\n  Ground ground;\n  Rod r(m = 1 kg, length = 1 m);\n  {line}\nend E;\n"


def harmless(text):
    return not [c for c in text if unicodedata.category(c) in STEERING and c not in "\n\t"]


def test_every_steering_character_is_escaped_and_no_letter_is():
    steering = [c for c in map(chr, range(sys.maxunicode + 1)) if unicodedata.category(c) in STEERING]
    assert len(steering) > 2000
    for c in steering:
        shown = visible(f"a{c}b", line=True)
        assert shown.isascii()
        assert shown.encode().decode("unicode_escape") == f"a{c}b"
    plain = "ÄÖ\u00a0漢字 e\u0301 µ·10⁻⁶ \U0001f600"
    assert visible(plain) is plain or visible(plain) == plain
    assert visible("a\n\tb") == "a\n\tb"
    assert visible("a\n\tb", line=True) == "a\\n\\tb"


@pytest.mark.parametrize(
    ("before", "columns"),
    [
        ("\x1b[2J", len(r"\x1b[2J")),
        (BIDI, len(r"\u202e")),
        ("漢字", 4),  # two columns each: UAX #11
        ("e\u0301", 1),
        ("\u00a0", 1),
        ("\U000e0041", len(r"\U000e0041")),
    ],
)
def test_the_caret_stands_under_its_word(before, columns):
    with pytest.raises(MbdslError) as caught:
        parse(MODEL.format(doc="", line=f"/*{before}*/ Rod x(foo = 1);"), "e.mbd")
    shown = caught.value.render()
    assert harmless(shown)
    _, _, caret, *_ = shown.splitlines()
    assert caret.index("^") == 4 + len("  /*") + columns + len("*/ Rod x(")
    assert caret.strip() == "^^^"


def test_an_error_cannot_forge_lines():
    problem = MbdslError("found `a\nerror: b`", Span("x\n.mbd", 1, 1, 1, "text"), "try\n  = c", (("n\nm", None),))
    assert problem.render().splitlines() == [
        r"x\n.mbd:1:1: error: found `a\nerror: b`",
        "    text",
        "    ^",
        r"note: n\nm",
        r"  = try\n  = c",
    ]


@pytest.mark.parametrize(
    "command",
    [
        ["check", "MODEL"],
        ["show", "--stage", "scene", "MODEL"],
        ["show", "--stage", "syntax", "MODEL"],
        ["check", "MODEL", "--set", f"q{ESCAPE}=3"],
        ["check", "MODEL", "--set", f"q={ESCAPE}"],
        ["check", f"no{ESCAPE}{BIDI}.mbd"],
        [f"{ESCAPE}{BIDI}"],
        ["check", f"--{ESCAPE}", "MODEL"],
        ["simulate", "MODEL", "--method", ESCAPE],
        ["simulate", "MODEL", "--output", f"r{BIDI}"],
        ["--debug", "check", f"no{ESCAPE}{BIDI}.mbd"],
    ],
)
def test_commands_show_no_control_characters(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    name = f"m{ESCAPE}{BIDI}.mbd".replace("/", "")
    text = MODEL.format(
        doc=f'"d{ESCAPE}{BIDI}"', line=f'parameter String s = "{ESCAPE}" "{BIDI}"; Fixed f(ground, r.a);'
    )
    (tmp_path / name).write_text(text, encoding="utf-8")
    main([name if word == "MODEL" else word for word in command])
    shown = capsys.readouterr()
    assert shown.out + shown.err
    assert harmless(shown.out + shown.err)


def test_progress_on_a_terminal():
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    line = Display(terminal)
    line.show(2.0, str, lambda block: f"reference of a{ESCAPE}{BIDI}\nb")
    line.close()
    shown = terminal.getvalue()
    assert shown.count("\r") == 3  # its own
    assert harmless(shown.replace("\r", ""))
    assert r"\x1b]0;owned\x07\x1b[2J\u202e\nb" in shown


def test_pages():
    text = f"a{ESCAPE}{BIDI}</script>&"
    series = Series(text, (1.0, 2.0), (1.0, 2.0))
    figure = Figure("key", text, text, text, (series,), note=text)
    table = TextTable(text, (text,), ((text,),), note=text)
    page = html(Page(text, (text,), (figure, table), ((text, text),)))
    assert harmless(page)
    assert page.count(r"\x1b") > 8
    assert f"{visible(ESCAPE)}\\u202e&lt;/script&gt;&amp;" in page
