"""The graph of a mechanism in characters: a tree of bodies from the ground, and lists of loops and remarks."""

from __future__ import annotations

import textwrap

from mbdsl.mechanism.graph import GROUND
from mbdsl.messages import count, visible, width
from mbdsl.viewing.structure import DRIVER, EQUATION, FORCE, Link, Structure

COLUMNS = 80  #: of a pipe
LINES = {"fork": "├─ ", "last": "└─ ", "down": "│  ", "none": "   "}
ASCII = {"fork": "|- ", "last": "`- ", "down": "|  ", "none": "   "}
DEEPEST = 0.45  #: part of the columns that the lines of the tree may take
RESERVED = "├─└│"  #: characters that the encoding of the terminal needs, or ASCII is used


def text(structure: Structure, columns: int = COLUMNS, ascii_only: bool = False) -> str:
    """The graph as lines of text.

    Parameters
    ----------
    structure : Structure
        The graph.
    columns : int, optional
        Width of the terminal.
    ascii_only : bool, optional
        Whether to draw lines with ASCII characters.

    Returns
    -------
    str
        Counts, the tree, the loops, and remarks on drivers, merged bodies and redundant constraints.
    """
    tree = _Tree(structure, max(columns, 40), ASCII if ascii_only else LINES)
    summary = [line for found in structure.summary.split("\n") for line in _wrapped(found, columns)]
    parts = ["\n".join(summary), "\n".join(tree.lines())]
    loops = [structure.loop_text(k + 1) for k in range(len(structure.loops))]
    remarks = [line for found in (*loops, *structure.remarks) for line in _wrapped(found, columns)]
    return visible("\n\n".join(filter(None, (*parts, "\n".join(remarks)))))


def _wrapped(line: str, columns: int) -> list[str]:
    return textwrap.wrap(line, columns, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)


class _Tree:
    """The tree by which bodies are placed; joints that close loops and forces are leaves of it, at their first body."""

    def __init__(self, structure: Structure, columns: int, lines: dict[str, str]) -> None:
        self.structure, self.columns, self.lines_ = structure, columns, lines
        self.deepest = max(4, int(DEEPEST * columns / 3))
        self.children: dict[str, list[str]] = {GROUND: [], **{name: [] for name in structure.bodies}}
        for body in structure.bodies:
            self.children[structure.parents[body]].append(body)
        self.leaves: dict[str, list[Link]] = {name: [] for name in self.children}
        self.joints = {link.name: link for link in structure.links}
        self.reads: dict[str, str] = {}  #: state -> a body that its equation reads
        placed = set(structure.by.values())
        for link in structure.links:
            if link.kind == EQUATION:
                self.reads[link.a] = link.b or self.reads.get(link.a, "")
            elif link.name not in placed:
                self.leaves[self._deeper(link)].append(link)

    def _deeper(self, link: Link) -> str:
        """The body at which a link is listed: that which is further from the ground."""
        levels = self.structure.levels
        return link.a if levels[link.a] > levels[link.b] else link.b

    def lines(self) -> list[str]:
        found = [self.structure.ground]
        later: list[str] = []
        self._below(GROUND, found, later)
        for body in later:  # branches that go too deep continue below
            found += ["", f"{body} (continued)"]
            self._below(body, found, later)
        return found

    def _below(self, top: str, found: list[str], later: list[str]) -> None:
        pending = self._entries(top, "")
        while pending:
            prefix, last, entry = pending.pop()
            start = prefix + self.lines_["last" if last else "fork"]
            if isinstance(entry, Link):
                found.append(self._cut(start, self._leaf(entry, self._deeper(entry))))
                continue
            found.append(self._cut(start, self._body(entry)))
            inner = prefix + self.lines_["none" if last else "down"]
            more = self._entries(entry, inner)
            if more and len(inner) // 3 >= self.deepest:
                found.append(f"{inner}{self.lines_['last']}...")
                later.append(entry)
            else:
                pending += more

    def _entries(self, body: str, prefix: str) -> list[tuple[str, bool, str | Link]]:
        """The links and bodies below a body, in reverse order."""
        entries: list[str | Link] = [*self.leaves[body], *self.children[body]]
        return [(prefix, k == len(entries) - 1, entry) for k, entry in enumerate(entries)][::-1]

    def _body(self, name: str) -> str:
        joint = self.structure.by[name]
        body = self.structure.bodies[name]
        reads = f"  reads {self.reads[name]}" if self.reads.get(name) else ""
        none = f"  (state){reads}" if body.kind == "State" else "  (no joint leads to it)"
        by = f"  by {joint} ({self._about(self.joints[joint])})" if joint else none
        marks = [
            *(["moved by drivers"] if body.moved else ["follows"] if body.follows else []),
            *([f"solved as one, group {body.group}"] if body.group else []),
            *(["part of the ground"] if body.fixed else []),
        ]
        return f"{name}{by}{''.join(f'  [{mark}]' for mark in marks)}"

    def _leaf(self, link: Link, at: str) -> str:
        to = self.structure.label(link.other(at))
        sign = {FORCE: "~", DRIVER: ">"}.get(link.role, "o")
        loop = f"  [closes loop {link.loop}]" if link.loop else ""
        return f"{sign} {link.name} ({self._about(link)}) to {to}{loop}"

    def _about(self, link: Link) -> str:
        redundant = f", {count(link.redundant, 'row')} redundant" if link.redundant else ""
        return f"{link.kind}{redundant}"

    def _cut(self, start: str, line: str) -> str:
        whole = start + visible(line, line=True)
        return whole if width(whole) <= self.columns else whole[: self.columns - 3] + "..."
