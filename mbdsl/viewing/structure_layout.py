"""Places of bodies, joints and forces in the picture of a mechanism's graph.

Bodies are in columns by their distance from the ground, and every joint and force has a place of its own in a column
between them, so that labels overlap nothing. Distances are found by breadth-first search, so that each joint connects
neighbouring columns and no line crosses a column. (A force between distant bodies is shown at both.) The barycentre
heuristic orders the columns with few crossings of lines (Sugiyama, Tagawa and Toda, IEEE Trans. Syst. Man Cybern. 11
(1981) 109), and the heights
minimise the squared distances of neighbours by isotonic regression. A long row of columns is folded like a serpent.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence
from dataclasses import dataclass, field

from mbdsl.mechanism.graph import GROUND
from mbdsl.viewing.structure import Link, Structure

WIDTH = 900.0  #: of the picture, as far as columns allow [px]
STILL = 1.25  #: a picture that is wider by this factor is not folded
GAP, WIDEST_GAP, STEEP = 40.0, 140.0, 0.05  #: between columns: more for lines of great height
ROW = 64.0  #: between places in a column
BETWEEN = 34.0  #: between two folds, and between two parts
TURN = 30.0  #: space for lines that turn into the next fold
LETTERS = 20  #: largest number of letters of a name
LETTER, SMALL = 7.6, 6.2  #: width of a letter of names and of kinds
HEAD = 22.0  #: space for the heading of a part
SWEEPS = 8
LEAF = 0.02  #: weight of a force at the end of a line in the choice of heights, relative to others
MANY = 4000  #: number of lines from which their crossings are not counted


@dataclass
class Node:
    """A place of the picture: ``what`` is "ground", "body", "link", "grounded" (a link to a ground of its own) or
    "reference" (one of the two places of a link between distant bodies, with the name of the ``other``)."""

    what: str
    name: str
    layer: int
    link: Link | None = None
    other: str = ""
    width: float = 0.0
    x: float = 0.0
    y: float = 0.0
    direction: int = 1  #: of its fold: 1 from left to right, -1 back
    fold: int = 0
    left: float = 0.0  #: ends of its column
    right: float = 0.0


@dataclass
class Block:
    """An independent part: nodes, lines between them by their numbers, and its size [px]; y from its top."""

    bodies: tuple[str, ...]
    nodes: list[Node] = field(default_factory=list)
    lines: list[tuple[int, int]] = field(default_factory=list)
    width: float = 0.0
    height: float = 0.0
    x: float = 0.0
    y: float = 0.0


def shortened(text: str, letters: int = LETTERS) -> str:
    """The beginning and the end of a long name."""
    if len(text) <= letters:
        return text
    half = (letters - 1) // 2
    return f"{text[: letters - 1 - half]}…{text[-half:]}"


def layout(structure: Structure) -> list[Block]:
    """The parts of a mechanism with their places.

    Parameters
    ----------
    structure : Structure
        Bodies and links.

    Returns
    -------
    list of Block
        Side by side, or one below the other.
    """
    owner = {body: k for k, part in enumerate(structure.parts) for body in part.bodies}
    links: list[list[Link]] = [[] for _ in structure.parts]
    for link in structure.links:
        links[owner.get(link.b, owner.get(link.a, 0))].append(link)
    blocks = []
    for part, own in zip(structure.parts, links, strict=True):
        block = _block(structure, part.bodies, own)
        layers = _ordered(block)
        _heights(block, layers)
        _fold(block, layers)
        blocks.append(block)
    _pack(blocks)
    return blocks


def _block(structure: Structure, bodies: tuple[str, ...], links: Sequence[Link]) -> Block:
    """The nodes and lines of a part, in the order of a walk through its tree."""
    block, number = Block(bodies), dict[str, int]()

    def add(node: Node, *ends: str) -> None:
        label = node.name if node.what != "ground" else structure.ground
        size = LETTER * len(shortened(label))
        below = caption(node, structure)
        size = max(size, SMALL * len(shortened(below, LETTERS if node.what == "body" else LETTERS + 4)))
        node.width = max(62.0, size + 20.0) if node.what in ("body", "ground") else max(30.0, size)
        block.nodes.append(node)
        block.lines += [(number[end], len(block.nodes) - 1) for end in dict.fromkeys(ends)]

    def body(name: str) -> None:
        number[name] = len(block.nodes)
        add(Node("body" if name else "ground", name, 2 * structure.levels[name]))

    body(GROUND)
    children: dict[str, list[str]] = {GROUND: [], **{name: [] for name in bodies}}
    for name in bodies:
        parent = structure.parents[name]
        children[parent if parent in children else GROUND].append(name)
    pending = children[GROUND][::-1]
    while pending:
        name = pending.pop()
        body(name)
        pending += children[name][::-1]
    for link in links:
        a, b = structure.levels[link.a], structure.levels[link.b]
        if abs(a - b) <= 1:
            add(Node("link", link.name, a + b if a != b else 2 * a + 1, link), link.a, link.b)
        elif GROUND in (link.a, link.b):
            add(Node("grounded", link.name, 2 * max(a, b) + 1, link), link.a or link.b)
        else:
            for end in (link.a, link.b):
                add(Node("reference", link.name, 2 * structure.levels[end] + 1, link, link.other(end)), end)
    return block


def caption(node: Node, structure: Structure) -> str:
    """The text below the name of a body or below the symbol of a link."""
    if node.link is None:
        return structure.bodies[node.name].kind if node.what == "body" else ""
    if node.link.redundant:
        return f"redundant: {node.link.redundant} of {node.link.rows + node.link.velocity_rows}"
    if node.what == "reference":
        return f"to {structure.label(node.other)}"
    return node.link.kind


def _ordered(block: Block) -> list[list[int]]:
    """The nodes of each column from the top."""
    layers: list[list[int]] = [[] for _ in range(max(node.layer for node in block.nodes) + 1)]
    for k, node in enumerate(block.nodes):
        layers[node.layer].append(k)
    around = _around(block)
    place = {k: j for column in layers for j, k in enumerate(column)}
    for column in layers[1::2]:  # links stand where their bodies are
        _sort(column, around, place)
    best = [list(column) for column in layers]
    least = _crossings(block, place) if len(block.lines) < MANY else 0
    for sweep in range(SWEEPS if least else 0):
        for column in layers if sweep % 2 == 0 else layers[::-1]:
            _sort(column, around, place)
        found = _crossings(block, place)
        if found < least:
            best, least = [list(column) for column in layers], found
    return best


def _around(block: Block) -> list[list[int]]:
    found: list[list[int]] = [[] for _ in block.nodes]
    for a, b in block.lines:
        found[a].append(b)
        found[b].append(a)
    return found


def _sort(column: list[int], around: list[list[int]], place: dict[int, int]) -> None:
    """Sort a column by the mean places of the neighbours, and update the places."""
    mean = {k: sum(place[j] for j in around[k]) / len(around[k]) if around[k] else place[k] for k in column}
    column.sort(key=lambda k: (mean[k], place[k]))
    place.update({k: j for j, k in enumerate(column)})


def _crossings(block: Block, place: dict[int, int]) -> int:
    """Number of crossings of lines between columns."""
    gaps: dict[int, list[tuple[int, int]]] = {}
    for a, b in block.lines:
        first, then = sorted((a, b), key=lambda k: block.nodes[k].layer)
        gaps.setdefault(block.nodes[first].layer, []).append((place[first], place[then]))
    total = 0
    for lines in gaps.values():
        passed: list[int] = []
        for _, right in sorted(lines):
            total += len(passed) - bisect_right(passed, right)
            insort(passed, right)
    return total


def _heights(block: Block, layers: list[list[int]]) -> None:
    """Heights at which neighbours are close to each other, at least a row apart in a column."""
    around = _around(block)
    for column in layers:
        for j, k in enumerate(column):
            block.nodes[k].y = ROW * (j - (len(column) - 1) / 2)
    for sweep in range(2 * SWEEPS):
        for column in layers if sweep % 2 == 0 else layers[::-1]:
            wanted = [
                sum(block.nodes[j].y for j in around[k]) / len(around[k]) if around[k] else block.nodes[k].y
                for k in column
            ]
            weights = [1.0 if len(around[k]) > 1 or block.nodes[k].what == "body" else LEAF for k in column]
            for k, y in zip(column, spread(wanted, ROW, weights), strict=True):
                block.nodes[k].y = y


def spread(wanted: Sequence[float], apart: float, weights: Sequence[float]) -> list[float]:
    """The heights closest to the wanted ones in the sense of weighted least squares, in this order and ``apart``.

    Isotonic regression by pooling adjacent violators (Ayer et al., Ann. Math. Stat. 26 (1955) 641).
    """
    pools: list[tuple[float, float, int]] = []  # mean, weight, number
    for j, (y, weight) in enumerate(zip(wanted, weights, strict=True)):
        mean, number = y - apart * j, 1
        while pools and pools[-1][0] > mean:
            other, more, count = pools.pop()
            mean, weight, number = (mean * weight + other * more) / (weight + more), weight + more, number + count
        pools.append((mean, weight, number))
    flat = [mean for mean, _, number in pools for _ in range(number)]
    return [y + apart * j for j, y in enumerate(flat)]


def _fold(block: Block, layers: list[list[int]]) -> None:
    """Put the columns next to each other, in folds that are not wider than the picture."""
    widths = [max((block.nodes[k].width for k in column), default=0.0) for column in layers]
    gaps = _gaps(block, len(layers))
    folds = _folds(widths, gaps, WIDTH if sum(widths) + sum(gaps) > STILL * WIDTH else STILL * WIDTH)
    if len(folds) > 1:  # of about the same width
        even = max((sum(widths) + sum(gaps)) / len(folds), *widths)
        narrower = (_folds(widths, gaps, even * (1.0 + 0.03 * part)) for part in range(1, 40))
        folds = next((found for found in narrower if len(found) <= len(folds)), folds)
    widest = max(sum(widths[k] + gaps[k] for k in fold) - gaps[fold[-1]] for fold in folds)
    margin = TURN if len(folds) > 1 else 0.0
    top = 0.0
    for number, fold in enumerate(folds):
        inside = [block.nodes[k] for layer in fold for k in layers[layer]]
        low, high = min(node.y for node in inside), max(node.y for node in inside)
        x = margin
        for layer in fold:
            for k in layers[layer]:
                node = block.nodes[k]
                node.fold, node.direction, node.y = number, 1 - 2 * (number % 2), node.y - low + top + ROW / 2
                ends = x, x + widths[layer]
                node.left, node.right = ends if node.direction > 0 else (2 * margin + widest - e for e in ends[::-1])
                node.x = (node.left + node.right) / 2
            x += widths[layer] + gaps[layer]
        top += high - low + ROW + BETWEEN
    block.width, block.height = widest + 2 * margin, top - BETWEEN


def _gaps(block: Block, number: int) -> list[float]:
    """The space after each column."""
    heights = [0.0] * number
    for a, b in block.lines:
        first, then = sorted((block.nodes[a], block.nodes[b]), key=lambda node: node.layer)
        heights[first.layer] = max(heights[first.layer], abs(then.y - first.y))
    return [min(WIDEST_GAP, max(GAP, STEEP * height)) for height in heights]


def _folds(widths: Sequence[float], gaps: Sequence[float], limit: float) -> list[list[int]]:
    folds: list[list[int]] = [[]]
    used = 0.0
    for layer, width in enumerate(widths):
        if folds[-1] and used + width > limit:
            folds.append([])
            used = 0.0
        folds[-1].append(layer)
        used += width + gaps[layer]
    return folds


def _pack(blocks: Sequence[Block]) -> None:
    """Put parts next to each other as long as the picture is wide enough, then below."""
    x = y = height = 0.0
    head = HEAD if len(blocks) > 1 else 0.0
    for block in blocks:
        if x and x + block.width > WIDTH + 2 * TURN:
            x, y, height = 0.0, y + height + BETWEEN, 0.0
        block.x, block.y = x, y + head
        x += block.width + 2 * BETWEEN
        height = max(height, block.height + head)
