"""Declarations of commands: their help, and a table of their options that reads as their help does.

    @model method step tol
    result RESULT  a result file
    --signals PATTERN,...  signals to write; default: all
    --view {iso,front}  of a model in space; default: iso
    --out FILE ...  a file to write; repeatable
    --quiet  print errors only
    | --verbose  print more details

Two blanks precede the help, and lines that are indented further continue it. ``@`` names options that several commands
have: those of ``SHARED``, and those of a run. A name without ``--`` is an argument. An option without a placeholder is
a flag, one with a list in braces takes one of these values, one in brackets may stand without a value. "..." after a
blank marks what may be repeated, and "|" what excludes the option before it. "{results}" in a help stands for the
suffixes of result files.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Mapping
from itertools import zip_longest
from keyword import iskeyword
from typing import Any, NamedTuple

from mbdsl.cli import _values as values
from mbdsl.simulation.run_options import NOT_NEGATIVE, OPTIONS, POSITIVE, TOLERANCE

ENTRY = re.compile(r"(\| )?((?:--[\w-]+, )*--[\w-]+|\w+)(?: (\{\S+\}|[^\s-]\S*))?( \.\.\.)?  (\S.*)", re.DOTALL)
START = re.compile(r"\n(?=\S)")
#: a table of options in a page: its beginning, the names of the options, and its end
MARKED = re.compile(r"(<!-- options: ([\w ]+) -->\n).*?(<!-- end of options -->)", re.DOTALL)
EXCLUDES = ("tol", "accuracy")  #: options of a run that exclude the one before them
PARSERS = {POSITIVE: values.positive_seconds, NOT_NEGATIVE: values.interval_seconds, TOLERANCE: values.tolerance}
SHOWN = 'show values in these units, each for its quantity: "deg, rpm, kN, mm"'
#: options that several commands have, those of a run among them
SHARED = {
    **{
        name: f"{'| ' if name in EXCLUDES else ''}--{name} {option.metavar}".rstrip() + f"  {option.text}"
        for name, option in OPTIONS.items()
    },
    "model": "model MODEL  the model's file (.mbd)\n@changes",
    "changes": """
@model_name
--set NAME=VALUE ...  override a parameter, repeatable; with units: --set "k=120 N/mm"
@without
@contacts
--allow-imports  let the model import files from outside its folder; for models that you trust
""",
    "model_name": """
--model NAME  the model to use in a file with several; default: the one with the name of the file, else the last
""",
    "method_and_option": """
@method
--option NAME=X ...  parameter of the method, repeatable; `mbdsl methods` lists them, most as --NAME X
""",
    "methods": "--methods NAME,...  integrators, or Python files (NAME.py); default: all",
    "at": """
--at STATE  static: the equilibrium that `mbdsl static` finds (default); start: the initial state with its velocities;
    a time such as 1.5s: the state of a simulation at that time; "pin.phi=80 deg,...": the initial state with these
    values
""",
    "units": f"--units UNIT,...  {SHOWN}; default: the model's",
    "units_of_file": f"""
--units [UNIT,...]  {SHOWN}; a .csv file has these units and names them in its second row. Without a list: SI units in
    a second row
""",
    "runs": """
--after T  ignore values before this time
--output FILE ...  table (.csv, .md, .tex), picture (.svg, .png, .pdf) or page with both (.html); repeatable
@method_and_option step tol start
--stop T  stop time; default: the model's
--interval DT  output interval; default (stop - start)/2000; 0: every step
--at STATE  state about which modes are computed: static (default), start, a time, or values such as "pin.phi=80 deg",
    as for `mbdsl eigen`
@units
--limit S  time limit of a run
@fresh
""",
    "table": "--table FILE  write the tables, too: .md, .tex, or .csv (one row per run, all digits)",
    "size": "--size WxH  of a film or picture [px]; default 640x400",
    "fresh": "--fresh  compute everything again",
    "reference": "--reference FILE  a result file; default auto: methods of two families",
    "quiet": "--quiet  print errors and warnings only",
    "talk": "@quiet\n| --verbose  print more details",
}
#: further arguments of ``add_argument`` by the names of options; a command may have others
ARGUMENTS: dict[str, dict[str, Any]] = {
    **{name: {"type": PARSERS.get(o.within, values.seconds)} for name, o in OPTIONS.items() if o.unit},
    "model": {"dest": "model_name"},
    "set": {"type": values.assignment},
    "option": {"type": values.assignment},
    "without": {"type": values.effects, "default": ()},
    "methods": {"type": values.names},
    "at": {"type": values.state, "default": "static"},
    "units": {"type": values.display_units},
    "size": {"type": values.size},
    "reference": {"default": "auto"},
    "after": {"type": values.seconds},
    "limit": {"type": values.positive_seconds},
}


class OptionEntry(NamedTuple):
    """An option or argument of a table."""

    excludes: bool  #: whether it excludes the one before it
    flags: list[str]  #: or the name of an argument
    given: dict[str, Any]  #: arguments of ``add_argument``


class Command:
    """A command: what it does in the list of commands and in its own help, and its options.

    ``more`` has, by the names of options, the parser of the value or further arguments of ``add_argument``. ``kinds``
    are commands of this command.
    """

    def __init__(
        self, help: str, description: str, table: str = "", kinds: Mapping[str, Command] | None = None, **more: Any
    ) -> None:
        self.help, self.description, self.table, self.kinds, self.more = help, description, table, kinds, more

    def register(self, subparsers: Any, name: str) -> argparse.ArgumentParser:
        """Add the parser of this command."""
        parser = subparsers.add_parser(name, help=self.help, description=with_suffixes(self.description))
        add(parser, self.table, **self.more)
        if self.kinds is not None:
            inner = parser.add_subparsers(title="studies", metavar="KIND", dest="kind", required=True)
            for kind, command in self.kinds.items():
                command.register(inner, kind)
        return parser


def add(parser: argparse.ArgumentParser, table: str, **more: Any) -> None:
    """Add the options of a table to a parser; ``more`` as for a :class:`Command`."""
    known = list(entries(table))
    into: Any = parser
    for entry, following in zip_longest(known, known[1:]):
        if not entry.excludes:
            grouped = following is not None and following.excludes
            into = parser.add_mutually_exclusive_group() if grouped else parser
        name = entry.flags[0].removeprefix("--").replace("-", "_")
        own = more.pop(f"{name}_" if iskeyword(name) else name, {})
        usual = ARGUMENTS.get(name, {}) if entry.flags[0].startswith("--") else {}
        into.add_argument(*entry.flags, **entry.given | usual | (own if isinstance(own, dict) else {"type": own}))
    assert not more, f"no options of the table: {', '.join(more)}"


def entries(table: str) -> Iterator[OptionEntry]:
    """The options of a table in their order, shared ones included."""
    lines = [line for line in table.splitlines() if line.strip()]
    indent = min((len(line) - len(line.lstrip()) for line in lines), default=0)
    for text in START.split("\n".join(line[indent:] for line in lines)) if lines else ():
        if text.startswith("@"):
            for name in text[1:].split():
                yield from entries(SHARED[name])
        else:
            yield _entry(text)


def _entry(text: str) -> OptionEntry:
    found = ENTRY.fullmatch(text)
    assert found is not None, f"no option: {text!r}"
    excludes, flags, metavar, repeated, help_ = found.groups()
    option = flags.startswith("--")
    given: dict[str, Any] = {"help": with_suffixes(" ".join(help_.split()))}
    if metavar is None:
        given["action"] = "store_true"
    elif metavar.startswith("{"):
        given["choices"] = tuple(metavar[1:-1].split(","))
    elif metavar.startswith("["):
        given |= {"metavar": metavar[1:-1], "nargs": "?", "const": ""}
    else:
        given["metavar"] = metavar
    if repeated:
        given |= {"action": "append", "default": []} if option else {"nargs": "*"}
    return OptionEntry(bool(excludes), flags.split(", "), given)


def with_suffixes(text: str) -> str:
    """A text with the suffixes of result files."""
    if "{results}" not in text:
        return text
    from mbdsl.results import formats

    return text.replace("{results}", ", ".join(formats()))


def insert(page: str) -> str:
    """The text of a page with tables of shared options between its markers."""

    def table(marked: re.Match) -> str:
        rows = [
            f"| `{' '.join([*x.flags, x.given.get('metavar', '')]).strip()}` | {x.given['help']} |"
            for x in entries(f"@{marked[2]}")
        ]
        return "\n".join([marked[1], "| option | |", "|---|---|", *rows, "", marked[3]])

    return MARKED.sub(table, page)
