"""Text on a terminal: wrapped at its width, coloured; in pipes and files unchanged."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mbdsl import cli
from mbdsl.errors import ModelError, Span
from mbdsl.messages import width
from mbdsl.plotting.terminal_text import coloured, columns, fitted, painted, wrapped

ROOT = Path(__file__).parents[3]
GOLDEN = ROOT / "tests" / "data" / "terminal"
LONG = "  Rod crank(m = 1 kg, length = 1 m); Rod rod(m = 1 kg, lenght = 2 m); Rod third(m = 1 kg, length = 1 m);"
MODEL = f"model M\n  Ground ground;\n{LONG}\nend M;\n"
ERROR = [
    "m.mbd:3:56: error: Rod `rod` has no parameter `lenght`",
    "    h = 1 m); Rod rod(m = 1 kg, lenght = 2 m); Rod third(m =",
    "                                ^^^^^^",
    "  = did you mean `length`?",
]


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    """Runs a command in a terminal of some columns, without colours; its output, or its errors if it has none."""

    def run(size, *argv):
        out, err = Terminal(), Terminal()
        monkeypatch.setenv("COLUMNS", str(size))
        monkeypatch.setenv("NO_COLOR", "1")
        monkeypatch.setattr(sys, "stdout", out)
        monkeypatch.setattr(sys, "stderr", err)
        cli.main(list(argv))
        return out.getvalue() or err.getvalue()  # errors may announce a compilation

    return run


# -- lines -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("line", "pieces"),
    [
        ("short", ["short"]),
        ("", [""]),
        (
            "warning: a text of some length that does not fit into forty columns",
            ["warning: a text of some length that does", "  not fit into forty columns"],
        ),
        ("  = a remedy of more than forty columns has", ["  = a remedy of more than forty columns", "    has"]),
        ("name  unit  a text below which it continues", ["name  unit  a text below which it", "            continues"]),
        # the last column begins too far to the right to continue there
        ("a text of thirty columns here:   and then more", ["a text of thirty columns here:   and", "  then more"]),
        ("  = try:  mbdsl simulate a-very-long-name-of-a-model.mbd", None),  # to be copied
        ("/a/path/that/is/longer/than/forty/columns/is/whole.csv", None),
    ],
)
def test_lines_are_wrapped_between_words(line, pieces):
    assert wrapped(line, 40) == (pieces or [line])


def test_what_is_painted():
    assert painted(["m.mbd:3:5: error: no `x`", "  here"]) == [
        "\x1b[1mm.mbd:3:5: \x1b[0m\x1b[1;31merror: \x1b[0mno `x`",
        "  here",
    ]
    assert painted(["warning: w"]) == ["\x1b[33mwarning: \x1b[0mw"]
    assert painted(["    \t ^^^"]) == ["\x1b[1;32m    \t ^^^\x1b[0m"]
    assert painted(["  = a", "    b"]) == ["\x1b[36m  = a\x1b[0m", "\x1b[36m    b\x1b[0m"]
    for line in ("    x = 1;  // error: none", "an error: none", "Crank: 5 steps", "  x^2"):
        assert painted([line]) == [line]


@pytest.mark.parametrize(
    ("terminal", "environment", "colours"),
    [
        (True, {}, True),
        (False, {}, False),
        (True, {"NO_COLOR": "1"}, False),
        (True, {"NO_COLOR": ""}, True),  # https://no-color.org: "when present and not an empty string"
        (True, {"TERM": "dumb"}, False),
        (False, {"FORCE_COLOR": "1"}, True),
        (False, {"FORCE_COLOR": "0"}, False),
        (True, {"TERM": "dumb", "FORCE_COLOR": "3"}, True),
        (True, {"NO_COLOR": "1", "FORCE_COLOR": "1"}, False),
    ],
)
def test_when_text_has_colours(terminal, environment, colours, monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in {"TERM": "xterm", **environment}.items():
        monkeypatch.setenv(name, value)
    assert coloured(Terminal() if terminal else io.StringIO()) is colours


def test_only_terminals_have_a_width(monkeypatch):
    monkeypatch.setenv("COLUMNS", "50")
    assert columns(io.StringIO()) is None
    assert columns(Terminal()) == 50
    monkeypatch.setenv("COLUMNS", "7")
    assert columns(Terminal()) == 40  # no text is readable in fewer


def test_a_column_of_a_table_is_wrapped():
    rows = [["a", "why", "n"], ["one", "because of several words", "1"]]
    # 21 columns without those of the others, "one" and "1", and of two gaps are 13
    assert fitted(rows, 21, 1) == [["a", "why", "n"], ["one", "because of", "1"], ["", "several words", ""]]


# -- messages --------------------------------------------------------------------------------------------------
def test_a_source_line_is_cut_to_the_width():
    column = LONG.index("lenght") + 1
    problem = ModelError("m", Span("m.mbd", 3, column, 6, LONG))
    for size in (40, 60, 80, 110, None):
        _, source, caret = problem.render(size).splitlines()
        assert width(source) <= (size or 200)
        assert source[caret.index("^") :].startswith("lenght")


def test_a_message_in_a_narrow_terminal(terminal, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("m.mbd").write_text(MODEL)
    assert terminal(60, "check", "m.mbd").splitlines() == ERROR
    long = terminal(60, "simulate", "m.mbd", "--stop", "2", "s")
    assert long.splitlines() == [
        "error: `2 s` after --stop is two words: the value ends at",
        "  the space",
        '  = write  --stop 2s  or  --stop "2 s"',
    ]


def test_a_pipe_gets_whole_messages(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.chdir(tmp_path)
    cli.main(["simulate", "m.mbd", "--stop", "2", "s"])
    assert capsys.readouterr().err.startswith("error: `2 s` after --stop is two words: the value ends at the space\n")


# -- commands --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("size", [60, 80])
@pytest.mark.parametrize("command", ["explain", "methods"])
def test_transcripts(command, size, terminal, monkeypatch):
    """What a person reads. The files were read by one, too."""
    monkeypatch.chdir(ROOT)
    words = ["explain", "models/slider_crank.mbd", "--no-time"] if command == "explain" else command.split()
    shown = terminal(size, *words)
    assert max(map(width, shown.splitlines())) <= size
    known = (GOLDEN / f"{command}-{size}.txt").read_text()
    assert shown.startswith(known) if command == "methods" else shown == known  # backends of other packages follow


@pytest.mark.parametrize("size", [60, 80])
def test_help_fits(size, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(size))
    parsers = [cli.make_parser()]
    for name in cli.commands():
        parsers.append(_commands(cli.make_parser(name))[name])
    parsers += [nested for parser in parsers[1:] for nested in _commands(parser).values()]
    assert len(parsers) > 20
    for parser in parsers:
        assert max(map(width, parser.format_help().splitlines())) <= size, parser.prog


def _commands(parser):
    return next((a.choices for a in parser._actions if isinstance(a.choices, dict)), {})


# -- a real terminal ---------------------------------------------------------------------------------------------
def in_terminal(folder, size, *argv, **environment):
    """The output of a command in a pseudo-terminal of some columns."""
    pty = pytest.importorskip("pty", reason="pseudo-terminals of POSIX")
    import fcntl
    import struct
    import termios

    own, other = pty.openpty()
    fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", 24, size, 0, 0))
    hidden = ("COLUMNS", "NO_COLOR", "FORCE_COLOR")
    kept = {name: value for name, value in os.environ.items() if name not in hidden}
    environment = {**kept, "TERM": "xterm", "PYTHONPATH": str(ROOT), **environment}
    words = [sys.executable, "-m", "mbdsl", *argv]
    done = subprocess.Popen(words, cwd=folder, stdin=other, stdout=other, stderr=other, env=environment)
    os.close(other)
    shown = b""
    try:
        while part := os.read(own, 65536):
            shown += part
    except OSError:  # Linux reports the end of a terminal as an error
        pass
    finally:
        os.close(own)
    assert done.wait(300) == 2
    return shown.decode().replace("\r\n", "\n").splitlines()


def test_colours_in_a_terminal(tmp_path):
    (tmp_path / "m.mbd").write_text(MODEL)
    _, source, caret, remedy = ERROR
    assert in_terminal(tmp_path, 60, "check", "m.mbd") == [
        "\x1b[1mm.mbd:3:56: \x1b[0m\x1b[1;31merror: \x1b[0mRod `rod` has no parameter `lenght`",
        source,
        f"\x1b[1;32m{caret}\x1b[0m",
        f"\x1b[36m{remedy}\x1b[0m",
    ]
    assert in_terminal(tmp_path, 60, "check", "m.mbd", NO_COLOR="1") == ERROR
    assert in_terminal(tmp_path, 60, "check", "m.mbd", TERM="dumb") == ERROR
