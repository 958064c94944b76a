"""The picture of a mechanism's graph as a list of lines, areas and texts, for SVG and for matplotlib."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mbdsl.mechanism.graph import GROUND
from mbdsl.messages import count
from mbdsl.viewing.structure import DRIVER, FORCE, JOINT, Link, Structure
from mbdsl.viewing.structure_layout import GAP, LETTERS, TURN, WIDTH, Block, Node, caption, layout, shortened

BOX = 40.0  #: height of a body [px]
MARGIN = 14.0
MARK = 8.0  #: radius of the symbol of a joint
LINE = 22.0  #: height of a line of the legend
#: class -> text of the legend, in its order
LEGEND = {
    "body": "body",
    "body moved": "body that drivers move: a function of time",
    "body follows": "body that follows from the constraints alone",
    "hull": "bodies solved as one",
    "joint": "joint",
    "joint closing": "joint that closes a loop, with the loop's number",
    "joint redundant": "joint with redundant constraints",
    "driver": "driver",
    "force": "force",
}


@dataclass(frozen=True)
class Item:
    """A line or area (``path``: commands of SVG with their numbers) or a text at (x, y); ``kind`` are its classes.

    ``title`` is the full text of what is shortened."""

    kind: str
    path: tuple[tuple[str, tuple[float, ...]], ...] = ()
    text: str = ""
    x: float = 0.0
    y: float = 0.0
    anchor: str = "middle"
    title: str = ""


@dataclass(frozen=True)
class Picture:
    """Items from the back to the front, and the size [px]."""

    items: list[Item]
    width: float
    height: float


def picture(structure: Structure) -> Picture:
    """The picture of a graph with its legend.

    Parameters
    ----------
    structure : Structure
        The graph.

    Returns
    -------
    Picture
    """
    blocks = layout(structure)
    width = max(max(block.x + block.width for block in blocks), 420.0) + 2 * MARGIN
    items: list[Item] = []
    for number, block in enumerate(blocks):
        for node in block.nodes:
            node.x, node.left, node.right = (v + block.x + MARGIN for v in (node.x, node.left, node.right))
            node.y += block.y + MARGIN
        if len(blocks) > 1:
            mobility = structure.parts[number].velocity_mobility
            title = f"part {number + 1}, mobility {mobility}"
            items.append(Item("part", text=title, x=block.x + MARGIN, y=block.y + MARGIN - 4.0, anchor="start"))
        items += _hulls(structure, block)
        items += [item for a, b in block.lines for item in _line(block.nodes[a], block.nodes[b])]
        for node in block.nodes:
            items += _node(structure, node)
    bottom = max(block.y + block.height for block in blocks) + MARGIN + 14.0
    legend, bottom = _legend({item.kind for item in items}, bottom, width)
    return Picture(items + legend, width, bottom + MARGIN)


def _box(x: float, y: float, width: float, height: float, r: float) -> tuple:
    """A rectangle with round corners about (x, y)."""
    a, b, c, d = x - width / 2, y - height / 2, x + width / 2, y + height / 2
    k = 0.448 * r  # a quarter of a circle as a cubic curve
    return (
        *(("M", (a + r, b)), ("L", (c - r, b)), ("C", (c - k, b, c, b + k, c, b + r)), ("L", (c, d - r))),
        *(("C", (c, d - k, c - k, d, c - r, d)), ("L", (a + r, d)), ("C", (a + k, d, a, d - k, a, d - r))),
        *(("L", (a, b + r)), ("C", (a, b + k, a + k, b, a + r, b)), ("Z", ())),
    )


def _disc(x: float, y: float, r: float) -> tuple:
    return _box(x, y, 2 * r, 2 * r, r)


# -- lines -------------------------------------------------------------------------------------------------------------
def _line(a: Node, b: Node) -> Iterator[Item]:
    a, b = sorted((a, b), key=lambda node: node.layer)
    link = a.link or b.link
    assert link is not None
    yield Item(f"line {_role(link)}", _way(a, b))


def _role(link: Link) -> str:
    """The classes of a link."""
    more = " redundant" if link.redundant else " closing" if link.loop else ""
    return link.role + (more if link.role == JOINT or link.redundant else "")


def _way(a: Node, b: Node) -> tuple:
    """From a node to one in the next column: level inside the columns, and curved between them."""
    if a.fold != b.fold:
        out = a.right if a.direction > 0 else a.left
        into = b.left if b.direction > 0 else b.right
        edge = max(out, into) if a.direction > 0 else min(out, into)
        turn = edge + a.direction * 1.2 * TURN
        return (
            *(("M", (a.x, a.y)), ("L", (edge, a.y)), ("C", (turn, a.y, turn, b.y, edge, b.y))),
            ("L", (b.x, b.y)),
        )
    start, end = (a.right, b.left) if a.direction > 0 else (a.left, b.right)
    half = (start + end) / 2
    return ("M", (a.x, a.y)), ("L", (start, a.y)), ("C", (half, a.y, half, b.y, end, b.y)), ("L", (b.x, b.y))


def _hulls(structure: Structure, block: Block) -> Iterator[Item]:
    """Pale bands around bodies that are solved as one."""

    def group(name: str) -> int:
        body = structure.bodies.get(name)
        return -1 if body is None or body.fixed else body.group

    for node in block.nodes:
        if node.what == "body" and group(node.name):
            yield Item("hull", _box(node.x, node.y, node.width + 16.0, BOX + 14.0, 12.0))
    for a, b in block.lines:
        link = block.nodes[a].link or block.nodes[b].link
        if link is not None and link.weld and group(link.a) == group(link.b) != 0:
            yield Item("hull band", _way(*sorted((block.nodes[a], block.nodes[b]), key=lambda node: node.layer)))


# -- nodes -------------------------------------------------------------------------------------------------------------
def _node(structure: Structure, node: Node) -> Iterator[Item]:
    if node.what == "ground":
        yield from _ground(structure, node)
    elif node.what == "body":
        body = structure.bodies[node.name]
        kind = "body moved" if body.moved else "body follows" if body.follows else "body"
        yield Item(kind, _box(node.x, node.y, node.width, BOX, 7.0), title=f"{body.kind} {body.name}")
        yield Item("name", text=shortened(node.name), x=node.x, y=node.y - 2.0)
        yield Item("small", text=shortened(caption(node, structure)), x=node.x, y=node.y + 13.0)
    else:
        yield from _link(structure, node)


def _ground(structure: Structure, node: Node) -> Iterator[Item]:
    a, b, y = node.x - node.width / 2, node.x + node.width / 2, node.y
    yield Item("ground", _box(node.x, y - 4.0, node.width, 28.0, 3.0), title=structure.ground)
    yield Item("name", text=shortened(structure.ground), x=node.x, y=y + 0.5)
    yield Item("hatch", _hatch(a, b, y + 10.0))


def _hatch(a: float, b: float, y: float, step: float = 9.0) -> tuple:
    number = max(2, round((b - a) / step))
    size = (b - a) / number
    strokes = [
        part
        for k in range(number)
        for part in (("M", (a + (k + 0.9) * size, y)), ("L", (a + (k + 0.3) * size, y + 8.0)))
    ]
    return ("M", (a, y)), ("L", (b, y)), *strokes


def _link(structure: Structure, node: Node) -> Iterator[Item]:
    link = node.link
    assert link is not None
    x, y, role = node.x, node.y, _role(link)
    title = f"{link.kind} {link.name}"
    if link.rows or link.velocity_rows:
        rows = [count(link.rows, "row")] if link.rows else []
        rows += [count(link.velocity_rows, "velocity-level row")] if link.velocity_rows else []
        title += f": {', '.join(rows)}"
    if link.loop:
        title += f"; {structure.loop_text(link.loop)}"
    if node.what == "grounded":
        end = x + node.direction * (node.width / 2 + GAP * 0.3)
        yield Item(f"line {role}", (("M", (x, y)), ("L", (end, y))))
        yield Item("hatch", tuple((c, _turned(p, end, y, node.direction)) for c, p in _hatch(-9.0, 9.0, 0.0, 6.0)))
    yield Item(role, _symbol(link, x, y), title=title)
    if link.loop:
        yield Item("number", text=str(link.loop), x=x, y=y + 4.0)
    yield Item("name", text=shortened(link.name), x=x, y=y - 14.0, title=link.name)
    below = "small warn" if link.redundant else "small"
    yield Item(below, text=shortened(caption(node, structure), LETTERS + 4), x=x, y=y + 23.0)


def _turned(p: tuple[float, ...], x: float, y: float, direction: int) -> tuple[float, ...]:
    """A point of a hatch, turned to that of a wall at (x, y)."""
    return (x + direction * p[1], y + p[0]) if p else p


def _symbol(link: Link, x: float, y: float) -> tuple:
    if link.role == FORCE:  # a coil
        points = [(x - 13.0 + 26.0 * k / 8, y + (0.0 if k in (0, 8) else -6.0 if k % 2 else 6.0)) for k in range(9)]
        return tuple(("M" if k == 0 else "L", point) for k, point in enumerate(points))
    if link.role == DRIVER:  # an arrow
        r = MARK + 1.5
        points = [(x + r * math.cos(u), y + r * math.sin(u)) for u in (0.0, 2.25, -2.25)]
        return (("M", points[0]), ("L", points[1]), ("L", points[2]), ("Z", ()))
    if link.weld:
        return _box(x, y, 2 * MARK - 2.0, 2 * MARK - 2.0, 1.0)
    return _disc(x, y, MARK)


# -- legend ------------------------------------------------------------------------------------------------------------
def _legend(kinds: set[str], top: float, width: float) -> tuple[list[Item], float]:
    """The samples and texts of the classes that occur, and the end of the last line."""
    items: list[Item] = []
    x, y = MARGIN, top + LINE
    for kind, text in LEGEND.items():
        if kind not in kinds:
            continue
        length = 46.0 + 6.4 * len(text)
        if x > MARGIN and x + length > min(width, WIDTH):
            x, y = MARGIN, y + LINE
        items += _sample(kind, x + 14.0, y - 4.0)
        items.append(Item("legend", text=text, x=x + 34.0, y=y, anchor="start"))
        x += length + 12.0
    return items, y


def _sample(kind: str, x: float, y: float) -> Iterator[Item]:
    role, _, more = kind.partition(" ")
    if role in ("body", "hull"):
        yield Item(kind, _box(x, y, 26.0, 14.0, 4.0))
        return
    redundant, loop = int(more == "redundant"), int(more == "closing")
    yield Item(f"line {kind}", (("M", (x - 14.0, y)), ("L", (x + 14.0, y))))
    yield Item(kind, _symbol(Link("", "", role, GROUND, GROUND, 1, 0, loop, redundant), x, y))
    if loop:
        yield Item("number", text="1", x=x, y=y + 4.0)
