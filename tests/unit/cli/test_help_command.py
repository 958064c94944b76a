"""`mbdsl help`, and docs/command-line.md, which lists all commands."""

import re
import shlex
from pathlib import Path

import pytest

from mbdsl import cli
from mbdsl.cli.help import TOPICS
from mbdsl.elements import kinds
from mbdsl.simulation.run_options import OPTIONS

PAGE = (Path(__file__).parents[3] / "docs" / "command-line.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `(\w+)` \| (.*?) \| `(mbdsl .*?)` \|$", PAGE, re.MULTILINE)


def parsers():
    """Command -> its parser, with all its options, and its line in the list of commands."""
    found = {}
    for name in cli.commands():
        (action,) = cli.make_parser(name)._subparsers._group_actions
        lines = {choice.dest: choice.help for choice in action._choices_actions}
        found[name] = action.choices[name], lines[name]
    return found


PARSERS = parsers()


def test_the_page_lists_every_command_with_its_line():
    assert {name: line for name, line, _ in ROWS} == {name: line for name, (_, line) in PARSERS.items()}


@pytest.mark.parametrize(("name", "example"), [(name, example) for name, _, example in ROWS])
def test_examples_of_the_page_are_read(name, example):
    """Every word of an example is an argument of its command; models and results need not exist."""
    words = shlex.split(example)
    assert words[:2] == ["mbdsl", name]
    args, rest = PARSERS[name][0].parse_known_args(words[2:])
    assert rest == [] and args is not None


def test_the_page_lists_the_options_of_all_commands_that_read_a_model_and_of_a_run():
    """As `signals` has the first, which has one option of its own, and `simulate` both."""
    every = {
        name: {(a.option_strings[0], a.metavar): a.help for a in PARSERS[name][0]._actions if a.option_strings}
        for name in ("signals", "simulate")
    }
    listed = re.findall(r"^\| `(--[\w-]+)(?: (.+?))?` \| (.*) \|$", PAGE, re.MULTILINE)
    found = {(name, metavar or None): text for name, metavar, text in listed}
    own = {key: text for key, text in every["signals"].items() if key[0] not in ("-h", "--format", "--debug")}
    assert found.items() >= own.items() and found.items() <= every["simulate"].items()
    assert {f"--{name}" for name in OPTIONS} <= {name for name, _ in found}


def test_the_exit_codes_of_the_page_are_those_of_the_errors():
    from mbdsl import errors

    listed = {int(code) for code in re.findall(r"^\| (\d+) \|", PAGE, re.MULTILINE)}
    codes = {x.exit_code for x in vars(errors).values() if isinstance(x, type) and hasattr(x, "exit_code")}
    assert listed == {0, 1, cli.INTERRUPTED, *codes}


# -- mbdsl help -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("words", [["check"], ["study", "energy"], ["help"], ["methods"]])
def test_help_of_a_command_is_that_of_its_option(say, words):
    assert say("help", *words) == say(*words, "--help")
    assert say("help", *words)[1].startswith(f"usage: mbdsl {' '.join(words)} ")


def test_help_alone_lists_commands_and_topics(say):
    code, out, err = say("help")
    assert (code, err) == (0, "")
    assert out == say()[1] + "\ntopics of `mbdsl help TOPIC`: units, kinds, effects, or a kind such as Revolute\n"


def test_units_and_prefixes_are_those_of_the_language(say):
    from mbdsl.lang.units import _PLAIN, _PREFIX, _PREFIXED

    out = " ".join(say("help", "units")[1].split())
    assert f"with the prefixes {', '.join(_PREFIX)}: {', '.join(_PREFIXED)}" in out
    assert out.endswith(f"without prefixes: {', '.join(_PLAIN)}")


def test_all_kinds_are_listed_and_described(say):
    listed = say("help", "kinds")[1]
    names = re.findall(r"^  (\w+) ", listed, re.MULTILINE)
    assert len(names) == len(set(names)) and set(names) == {*kinds(), *kinds(spatial=True)}
    for name in names:
        code, out, _ = say("help", name)
        plane, mark, space = out.partition("in models in space, `spatial model Name ... end Name;`\n\n")
        assert code == 0 and max(map(len, out.splitlines())) <= 80
        assert bool(mark) == (name in kinds(spatial=True))
        for text, known in ((plane, kinds()), (space, kinds(spatial=True))):
            if name not in known:
                assert not text
                continue
            assert text.startswith(f"{name}: ")
            shown = set(re.findall(r"^  (\w+) ", text, re.MULTILINE))
            assert {x.name for x in (*known[name].parameters, *known[name].signals)} <= shown


def test_kinds_of_one_dimension_are_marked(say):
    listed = say("help", "kinds")[1]
    entries = dict(re.findall(r"^  (\w+) ((?:.+\n)(?: {6,}.*\n)*)", listed, re.MULTILINE))
    flat = {name: " ".join(text.split()) for name, text in entries.items()}
    assert flat["Spherical"].endswith("(in space only)") and flat["Box"].endswith("(in space only)")
    assert flat["FlexibleBeam"].endswith("(in the plane only)")
    assert "only)" not in flat["Revolute"] and "only)" not in flat["Force"]


def test_a_kind_in_the_plane_and_in_space(say):
    """A hinge has an axis in space only, a force its z component."""
    for name, of_space in (("Revolute", "n"), ("RotationalDriver", "n"), ("Force", "fz")):
        plane, _, space = say("help", name)[1].partition("in models in space")
        assert not re.search(rf"^  {of_space} ", plane, re.MULTILINE)
        assert re.search(rf"^  {of_space} ", space, re.MULTILINE)


def test_a_kind(say):
    """A transcript."""
    expected = """\
PointOnLine: A pin in a slot: the origin of frame_b stays on the x axis of
frame_a.
"""
    assert say("help", "PointOnLine")[1].startswith(expected)
    assert "  k          N/m    0        stiffness\n" in say("help", "SpringDamper")[1]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["Revolut"], "error: there is no command, topic or kind `Revolut`\n  = did you mean `Revolute` or "),
        (["Sphericl"], "error: there is no command, topic or kind `Sphericl`\n  = did you mean `Spherical`"),
        (["unit"], "error: there is no command, topic or kind `unit`\n  = did you mean `units`"),
        (
            ["xyzzy"],
            "error: there is no command, topic or kind `xyzzy`\n  = topics: units, kinds, effects; `mbdsl help`",
        ),
        (["simulat", "x"], "error: there is no command `simulat`\n  = did you mean `simulate`?\n"),
    ],
)
def test_unknown_words(say, words, message):
    code, out, err = say("help", *words)
    assert (code, out) == (2, "") and err.startswith(message)


def test_topics_fit_a_terminal(say):
    for topic in TOPICS:
        assert max(map(len, say("help", topic)[1].splitlines())) <= 80
