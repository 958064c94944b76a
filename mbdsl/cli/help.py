"""mbdsl help: the help of a command, or of a topic: units, kinds, a kind, effects."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Callable

from mbdsl.cli._options import Command
from mbdsl.errors import UsageError
from mbdsl.messages import did_you_mean
from mbdsl.plotting.terminal_text import text_width

COLUMNS = 80


def run(args: argparse.Namespace) -> int:
    from mbdsl.cli import commands, main
    from mbdsl.elements import kinds

    if not args.words:
        code = main([])
        print(f"\ntopics of `mbdsl help TOPIC`: {', '.join(TOPICS)}, or a kind such as Revolute")
        return code
    word, *further = args.words
    if word in commands():
        return main([word, *further, "--help"])
    if further:
        raise UsageError(f"there is no command `{word}`", hint=did_you_mean(word, commands(), "commands"))
    if word in TOPICS:
        print(TOPICS[word]())
    elif word in kinds() or word in kinds(spatial=True):
        from mbdsl.cli._kind_text import kind_text

        if word in kinds():
            print(kind_text(kinds()[word]))
        if word in kinds(spatial=True):
            before = "\n" if word in kinds() else ""
            print(f"{before}in models in space, `spatial model Name ... end Name;`\n")
            print(kind_text(kinds(spatial=True)[word]))
    else:
        known = [*commands(), *TOPICS, *kinds(), *kinds(spatial=True)]
        listed = f"topics: {', '.join(TOPICS)}; `mbdsl help` lists the commands, `mbdsl help kinds` the kinds"
        raise UsageError(f"there is no command, topic or kind `{word}`", hint=did_you_mean(word, known) or listed)
    return 0


def _units() -> str:
    from mbdsl.lang import units

    prefixed, plain = ", ".join(units._PREFIXED), ", ".join(units._PLAIN)
    return "\n\n".join(
        textwrap.fill(text, text_width(COLUMNS), break_on_hyphens=False)
        for text in (
            "A unit follows its number: 3 kg, 0.3 m, 100 N/m, 5 N.s/m, 270 deg, 30 rpm, 9.81 m/s2 or 9.81 m/s^2. It "
            "contains no blanks; factors are joined by . and /. On the command line, the blank after the number may "
            'be left out: --step 1ms, --set "k=120 N/mm". A number without a unit is in SI units.',
            f"with the prefixes {', '.join(units._PREFIX)}: {prefixed}",
            f"without prefixes: {plain}",
        )
    )


def _kinds() -> str:
    from mbdsl.elements import kinds
    from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, SensorKind

    families = {"bodies": BodyKind, "joints and drivers": JointKind, "forces": ForceKind, "sensors": SensorKind}
    known = {**kinds(spatial=True), **kinds()}
    groups = {title: [k for k in known.values() if isinstance(k, family)] for title, family in families.items()}
    only = {**dict.fromkeys(kinds(spatial=True), " (in space only)"), **dict.fromkeys(kinds(), " (in the plane only)")}
    only |= dict.fromkeys(set(kinds()) & set(kinds(spatial=True)), "")
    wide = max(map(len, known)) + 2
    lines = []
    for title, found in groups.items():
        lines += [title]
        for kind in sorted(found, key=lambda kind: kind.name):
            lines += textwrap.wrap(
                f"  {kind.name:{wide}}{kind.doc}{only[kind.name]}",
                text_width(COLUMNS),
                subsequent_indent=" " * (wide + 2),
            )
        lines += [""]
    return "\n".join([*lines, "`mbdsl help KIND` lists parameters and signals."])


def _effects() -> str:
    from mbdsl.elements.declaration import EFFECTS

    return textwrap.fill(
        f"Effects of a model: {', '.join(EFFECTS)}. --without EFFECT,... leaves effects out, `mbdsl explain MODEL` "
        "lists those of a model with causes and costs, and `mbdsl study effects` measures the change of a signal.",
        text_width(COLUMNS),
    )


TOPICS: dict[str, Callable[[], str]] = {"units": _units, "kinds": _kinds, "effects": _effects}
COMMAND = Command(
    "show the help of a command or a topic",
    "Show the help of a command, as `mbdsl COMMAND --help` does, or of a topic: "
    f"{', '.join(TOPICS)}, or a kind such as Revolute. Without an argument, list the commands.",
    """
    words COMMAND|TOPIC ...  a command (study energy), a topic, a kind
    """,
)
