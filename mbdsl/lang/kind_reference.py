"""The reference of all kinds as Markdown, generated from their declarations: part of docs/language.md, docs/space.md.

``python -m mbdsl.lang.kind_reference docs/language.md`` writes it into the page, between its two markers.
"""

from __future__ import annotations

import sys
from pathlib import Path

from mbdsl.elements import kinds
from mbdsl.elements.declaration import REQUIRED, Parameter
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, Kind, SensorKind

#: the pages of models in the plane and in space
PAGES = {False: "language.md", True: "space.md"}
END = "<!-- end of kinds -->"
_TITLES = (("Bodies", BodyKind), ("Joints and drivers", JointKind), ("Forces", ForceKind), ("Sensors", SensorKind))


def begin(spatial: bool) -> str:
    """The first marker of a page."""
    return f"<!-- kinds: made by `python -m mbdsl.lang.kind_reference docs/{PAGES[spatial]}` -->"


def reference(spatial: bool = False) -> str:
    """Tables of parameters and signals of every kind, by family; of models in the plane or in space."""
    parts = [begin(spatial)]
    for title, family in _TITLES:
        parts.append(f"### {title}")
        parts += [of_kind(kind) for kind in kinds(spatial).values() if isinstance(kind, family)]
    return "\n\n".join([*parts, END]) + "\n"


def of_kind(kind: Kind) -> str:
    """Description, frames, parameters and signals of a kind."""
    lines = [f"#### `{kind.name}`", "", kind.doc, ""]
    if kind.ports:
        ports = [f"`{p}`" + (" (may be left out)" if p in kind.optional_ports else "") for p in kind.ports]
        lines += [f"Frames: {', '.join(ports)}.", ""]
    if kind.parameters:
        lines += ["| parameter | unit | default | |", "|---|---|---|---|"]
        lines += [f"| `{p.name}` | {unit_of(p)} | {default_of(p)} | {notes(kind, p)} |" for p in kind.parameters]
        lines.append("")
    reactions, friction = (kind.reaction, kind.resistance) if isinstance(kind, JointKind) else ((), ())
    listed = [*kind.signals, *(x for x in kind.outputs if x.name not in reactions), *friction]
    if listed:
        lines += ["| signal | unit | |", "|---|---|---|"]
        lines += [f"| `{x.name}` | {x.unit} | {x.doc} |" for x in listed]
        lines.append("")
    if reactions:
        names = ", ".join(f"`{r}`" for r in reactions)
        lines += [f"Reaction on `frame_b`: {names}.", ""]
    return "\n".join(lines).rstrip()


def unit_of(p: Parameter) -> str:
    """The unit of a parameter."""
    return p.unit or ("any" if p.law else "")


def default_of(p: Parameter) -> str:
    """The default of a parameter, in SI units."""
    if p.default is REQUIRED:
        return "required"
    if p.default is None or p.default == ():
        return "-"
    if isinstance(p.default, tuple):
        return "{" + ", ".join(f"{x:g}" for x in p.default) + "}"
    if isinstance(p.default, bool):
        return "true" if p.default else "false"
    return f"{p.default:g}" if isinstance(p.default, float) else f'"{p.default}"' if p.choices else str(p.default)


def notes(kind: Kind, p: Parameter) -> str:
    """What a parameter means, and what its values may be."""
    found = [p.doc] if p.doc else []
    if p.law:
        driven = isinstance(kind, JointKind) and kind.driver == p.name
        coupled = dict(kind.functions) if isinstance(kind, JointKind) else {}
        if p.name in coupled:
            arguments = ", ".join(f"`{name}`" for name in coupled[p.name])
            found.append(f"an expression of {arguments}, parameters and tables")
        elif p.name in kind.coupled:
            found.append("may be an expression of positions")
        else:
            found.append("without signals and inputs" if driven else "may be an expression in time and signals")
    if p.positive:
        found.append("positive")
    elif p.minimum is not None:
        found.append(f"at least {p.minimum:g}")
    if p.choices:
        found.append("one of " + ", ".join(f'"{c}"' for c in p.choices))
    return "; ".join(found)


def insert(page: str) -> str:
    """The text of a page with the reference between its markers."""
    spatial = begin(True) in page
    before, _, rest = page.partition(begin(spatial))
    _, _, after = rest.partition(END + "\n")
    return before + reference(spatial) + after


if __name__ == "__main__":
    target = Path(sys.argv[1])
    target.write_text(insert(target.read_text(encoding="utf-8")), encoding="utf-8")
