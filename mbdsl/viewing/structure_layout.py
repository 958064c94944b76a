"""Places of bodies, joints and forces in the picture of a mechanism's graph.

Bodies are in layers by their distance from the ground, and every joint and force has a place of its own in a layer
between them, so that labels overlap nothing. A line over several layers has a place in each of them. The barycentre
heuristic orders the layers with few crossings of lines (Sugiyama, Tagawa and Toda, IEEE Trans. Syst. Man Cybern. 11
(1981) 109). Layers are columns from left to right, or rows from top to bottom where columns would be too wide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from mbdsl.mechanism.graph import GROUND
from mbdsl.messages import shortened
from mbdsl.viewing.structure import Link, Structure

WIDTH = 900.0  #: of the picture, as far as layers allow [px]
STILL = 1.25  #: columns that are wider than the picture by this factor become rows
GAP, WIDEST_GAP, STEEP = 40.0, 140.0, 0.05  #: between layers: more for lines of great height
ROW = 64.0  #: between places in a column, and between layers that are rows
BOX = 40.0  #: height of a body
BETWEEN = 34.0  #: between two parts
LETTERS = 20  #: largest number of letters of a name
LETTER, SMALL = 7.6, 6.2  #: width of a letter of names and of kinds
HEAD = 22.0  #: space for the heading of a part
SWEEPS = 9
MOST = 4000  #: number of places above which lines pass layers without places in them


@dataclass
class GraphPlace:
    """A place of the picture: ``what`` is "ground", "body", "link", "grounded" (a link to a ground of its own) or
    "way" (of a line that passes a layer)."""

    what: str
    name: str
    layer: int
    link: Link | None = None
    width: float = 0.0
    x: float = 0.0
    y: float = 0.0
    reach: float = 0.0  #: half of the size of its layer


@dataclass
class PartLayout:
    """An independent part: nodes, lines between them by their numbers, and its size [px]; ``down``: layers are rows."""

    bodies: tuple[str, ...]
    nodes: list[GraphPlace] = field(default_factory=list)
    lines: list[tuple[int, int]] = field(default_factory=list)
    down: bool = False
    width: float = 0.0
    height: float = 0.0
    x: float = 0.0
    y: float = 0.0


def layout(structure: Structure) -> list[PartLayout]:
    """The parts of a mechanism with their places.

    Returns
    -------
    list of PartLayout
        Side by side, or one below the other.
    """
    owner = {body: k for k, part in enumerate(structure.parts) for body in part.bodies}
    links: list[list[Link]] = [[] for _ in structure.parts]
    for link in structure.links:
        links[owner.get(link.b, owner.get(link.a, 0))].append(link)
    blocks = [_block(structure, part.bodies, own) for part, own in zip(structure.parts, links, strict=True)]
    for block in blocks:
        layers = _ordered(block)
        _placed(block, layers)
        if block.width > STILL * WIDTH:
            wide, block.down = block.width, True
            _placed(block, layers)
            if block.width > wide:
                block.down = False
                _placed(block, layers)
    _pack(blocks)
    return blocks


def _block(structure: Structure, bodies: tuple[str, ...], links: Sequence[Link]) -> PartLayout:
    """The nodes and lines of a part, in the order of a walk through its tree."""
    block, number = PartLayout(bodies), dict[str, int]()

    def add(node: GraphPlace, *ends: int) -> int:
        label = node.name if node.what != "ground" else structure.ground
        size = LETTER * len(shortened(label, LETTERS))
        below = caption(node, structure)
        size = max(size, SMALL * len(shortened(below, LETTERS if node.what == "body" else LETTERS + 4)))
        node.width = max(62.0, size + 20.0) if node.what in ("body", "ground") else max(30.0, size)
        node.width *= node.what != "way"
        block.nodes.append(node)
        block.lines += [(end, len(block.nodes) - 1) for end in dict.fromkeys(ends)]
        return len(block.nodes) - 1

    number[GROUND] = add(GraphPlace("ground", GROUND, 0))
    children: dict[str, list[str]] = {GROUND: [], **{name: [] for name in bodies}}
    for name in bodies:
        parent = structure.parents[name]
        children[parent if parent in children else GROUND].append(name)
    pending = children[GROUND][::-1]
    while pending:
        name = pending.pop()
        number[name] = add(GraphPlace("body", name, 2 * structure.levels[name]))
        pending += children[name][::-1]
    for link in links:
        near, far = sorted((link.a, link.b), key=structure.levels.__getitem__)
        low, high = 2 * structure.levels[near], 2 * structure.levels[far]
        middle = low + 1 if high == low else high - 1
        if near == GROUND and high > 2:
            add(GraphPlace("grounded", link.name, high + 1, link), number[far])
            continue
        end = number[near]
        for layer in range(low + 1, middle) if len(block.nodes) + high - low < MOST else ():
            end = add(GraphPlace("way", "", layer, link), end)
        add(GraphPlace("link", link.name, middle, link), end, number[far])
    return block


def caption(node: GraphPlace, structure: Structure) -> str:
    """The text below the name of a body or below the symbol of a link."""
    if node.link is None:
        return structure.bodies[node.name].kind if node.what == "body" else ""
    if node.link.redundant:
        return f"redundant: {node.link.redundant} of {node.link.rows + node.link.velocity_rows}"
    return node.link.kind


def _ordered(block: PartLayout) -> list[list[int]]:
    """The nodes of each layer in their order: sweeps away from the ground and back, the last one away from it."""
    layers: list[list[int]] = [[] for _ in range(max(node.layer for node in block.nodes) + 1)]
    for k, node in enumerate(block.nodes):
        layers[node.layer].append(k)
    around, place = _around(block), {k: j for layer in layers for j, k in enumerate(layer)}
    for sweep in range(SWEEPS):
        sign = 1 if sweep % 2 == 0 else -1
        for layer in layers[::sign]:
            before = {
                k: [j for j in around[k] if sign * block.nodes[j].layer < sign * block.nodes[k].layer] for k in layer
            }
            mean = {k: sum(place[j] for j in own) / len(own) if own else place[k] for k, own in before.items()}
            layer.sort(key=lambda k: (mean[k], place[k]))
            place.update({k: j for j, k in enumerate(layer)})
    return layers


def _around(block: PartLayout) -> list[list[int]]:
    found: list[list[int]] = [[] for _ in block.nodes]
    for a, b in block.lines:
        found[a].append(b)
        found[b].append(a)
    return found


def _placed(block: PartLayout, layers: list[list[int]]) -> None:
    """Put the layers next to each other, and the nodes of a layer near their neighbours."""
    nodes, around = block.nodes, _around(block)
    apart = max(node.width for node in nodes) + 24.0 if block.down else ROW
    across = [0.0] * len(nodes)
    for layer in layers:
        for j, k in enumerate(layer):
            across[k] = apart * (j - (len(layer) - 1) / 2)
    for sweep in range(2 * SWEEPS):
        for layer in layers[:: 1 if sweep % 2 == 0 else -1]:
            wanted = [sum(across[j] for j in around[k]) / len(around[k]) if around[k] else across[k] for k in layer]
            for k, v in zip(layer, spread(wanted, apart), strict=True):
                across[k] = v
    steep = [0.0] * len(layers)
    for a, b in block.lines:
        steep[nodes[a].layer] = max(steep[nodes[a].layer], abs(across[a] - across[b]))
    low, at = min(across), 0.0
    for number, layer in enumerate(layers):
        size = BOX if block.down else max((nodes[k].width for k in layer), default=0.0)
        for k in layer:
            u, v = at + size / 2, across[k] - low + apart / 2
            nodes[k].x, nodes[k].y, nodes[k].reach = (
                (v, u + (ROW - BOX) / 2, size / 2) if block.down else (u, v, size / 2)
            )
        at += size + (ROW - BOX if block.down else min(WIDEST_GAP, max(GAP, STEEP * steep[number])))
    sizes = at - (0.0 if block.down else GAP), max(across) - low + apart
    block.width, block.height = sizes[::-1] if block.down else sizes


def spread(wanted: Sequence[float], apart: float) -> list[float]:
    """Places near the wanted ones, in this order and ``apart``: the mean of those pushed up and those pushed down."""
    up, down = list(wanted), list(wanted)
    for k in range(1, len(up)):
        up[k] = max(up[k], up[k - 1] + apart)
        down[-1 - k] = min(down[-1 - k], down[-k] - apart)
    return [(a + b) / 2 for a, b in zip(up, down, strict=True)]


def _pack(blocks: Sequence[PartLayout]) -> None:
    """Put parts next to each other as long as the picture is wide enough, then below."""
    x = y = height = 0.0
    head = HEAD if len(blocks) > 1 else 0.0
    for block in blocks:
        if x and x + block.width > STILL * WIDTH:
            x, y, height = 0.0, y + height + BETWEEN, 0.0
        block.x, block.y = x, y + head
        x += block.width + 2 * BETWEEN
        height = max(height, block.height + head)
