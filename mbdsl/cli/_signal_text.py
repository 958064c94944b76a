"""The signals of a model as text: a table, or groups of components and frames that have the same signals."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, SensorKind
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.signal_meanings import meaning
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.plotting.terminal_text import text_width

ON_PORTS, SECTIONS = "what joints and forces exert", "sections of rods and beams"
PLACES = (BodyKind, JointKind, ForceKind, SensorKind)  #: the order of groups
COLUMNS = 80  #: if the output is not a terminal
INDEX = re.compile(r"\[(\d+)(?::\d+)?\]")
SLICE = re.compile(r"\[\d+:\d+\]")


class SignalRow(NamedTuple):
    """A signal: its full name, or in a group the part after the name of its owner."""

    signal: str
    unit: str
    meaning: str


def rows_of(names: SignalNames, chosen: Iterable[str]) -> list[SignalRow]:
    return [SignalRow(name, names.unit(name), meaning(names.scene, name)) for name in chosen]


def table(rows: Sequence[SignalRow], indent: str = "") -> str:
    """Three columns; the meaning is wrapped to the width of the terminal."""
    first, second = (max((len(row[k]) for row in rows), default=0) for k in (0, 1))
    lines = []
    for row in rows:
        head = f"{indent}{row.signal:{first}}  {row.unit:{second}}  "
        lines += _wrapped(head, row.meaning, len(head))
    return "\n".join(lines)


def grouped(scene: Scene, rows: Sequence[SignalRow], unlisted: Sequence[SignalRow] = ()) -> str:
    """Signals of the model, then of bodies, joints, forces and frames; owners with the same signals once.

    ``unlisted`` are those that only names and patterns with the names of their owners select.
    """
    of_model: list[SignalRow] = []
    owned: dict[str, list[SignalRow]] = {}
    for row in rows:
        owner, _, key = row.signal.rpartition(".")
        if owner in scene.components or owner in scene.frames or owner in scene.aliases:
            owned.setdefault(owner, []).append(row._replace(signal=key))
        else:
            of_model.append(row)
    alike: dict[tuple[int, str, tuple[SignalRow, ...]], list[str]] = {}
    for owner, own in owned.items():
        alike.setdefault((*_kind(scene, owner), tuple(own)), []).append(owner)
    lines = ["", "model", table(of_model, "  ")]
    for (_, kind, own), owners in sorted(alike.items(), key=lambda item: item[0][0]):
        lines += ["", *_wrapped(f"{kind}: ", ", ".join(ranges(owners)), 2), table(_joined(own), "  ")]
    lines += _unlisted(scene, unlisted)
    some = next((f"{owner}.{own[0].signal}" for owner, own in owned.items()), "")
    note = f"A full name has both parts, such as {some}." if some else ""
    if any(map(SLICE.search, lines)):
        note += " [1:3] stands for [1], [2], [3]; the pattern for all is [*]."
    return "\n".join([*_wrapped("", note, 0), *lines])


def _unlisted(scene: Scene, rows: Sequence[SignalRow]) -> list[str]:
    """Two groups: what elements exert on their frames, and sections; each owner once."""
    owned: dict[str, list[SignalRow]] = {}
    for row in rows:
        owner, _, key = row.signal.rpartition(".")
        owned.setdefault(owner, []).append(row._replace(signal=key))
    lines = []
    for title in (ON_PORTS, SECTIONS):
        owners = [x for x in owned if _is_port(scene, x) == (title == ON_PORTS)]
        if owners:
            lines += ["", *_wrapped(f"{title}, not among `*`: ", ", ".join(ranges(owners)), 2)]
            lines += [table(owned[owners[0]], "  ")]
    return lines


def _is_port(scene: Scene, name: str) -> bool:
    owner, _, port = name.rpartition(".")
    return owner in scene.components and port in scene.components[owner].ports


def _kind(scene: Scene, owner: str) -> tuple[int, str]:
    """Position of the group and its title."""
    if owner not in scene.components:
        return len(PLACES), "frames"
    kind = scene.components[owner].kind
    return PLACES.index(next(family for family in PLACES if isinstance(kind, family))), kind.name


def _joined(rows: Sequence[SignalRow]) -> list[SignalRow]:
    """``q[1]``, ``q[2]``, ... with the same unit and meaning as one row ``q[1:7]``."""
    alike: dict[tuple[str, str, str], list[str]] = {}
    for row in rows:
        alike.setdefault((INDEX.sub("", row.signal), row.unit, row.meaning), []).append(row.signal)
    return [SignalRow(name, unit, said) for (_, unit, said), names in alike.items() for name in ranges(names)]


def ranges(names: Iterable[str]) -> list[str]:
    """Names with consecutive indices as slices of the language: ``link[1:3].a`` for three names."""
    found = list(names)
    for place in range(max((len(INDEX.findall(name)) for name in found), default=0)):
        runs: dict[tuple[str, str | None], list[list[int]]] = {}
        for name in found:
            at = [*INDEX.finditer(name)]
            if place >= len(at):
                runs[(name, None)] = []
                continue
            number, ends = int(at[place][1]), (name[: at[place].start()], name[at[place].end() :])
            known = runs.setdefault(ends, [])
            if known and known[-1][1] == number - 1:
                known[-1][1] = number
            else:
                known.append([number, number])
        found = [text for ends, known in runs.items() for text in _slices(*ends, known)]
    return found


def _slices(before: str, after: str | None, runs: Sequence[Sequence[int]]) -> list[str]:
    if after is None:
        return [before]
    return [f"{before}[{a if a == b else f'{a}:{b}'}]{after}" for a, b in runs]


def _wrapped(head: str, text: str, indent: int) -> list[str]:
    width = text_width(COLUMNS)
    indent = indent if indent < width // 2 else 4
    options: dict[str, Any] = {"subsequent_indent": " " * indent, "break_long_words": False, "break_on_hyphens": False}
    return textwrap.wrap(head + text, max(40, width), **options) or [head.rstrip()]
