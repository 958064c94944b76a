"""The picture of a mechanism's graph as SVG, for a file of its own or for a page."""

from __future__ import annotations

import math

from mbdsl.mechanism.graph import GROUND
from mbdsl.messages import count, shortened
from mbdsl.plotting.escaping import escape
from mbdsl.viewing.structure import DRIVER, FORCE, JOINT, Link, Structure
from mbdsl.viewing.structure_layout import BOX, GAP, LETTERS, WIDTH, GraphPlace, PartLayout, caption, layout

MARGIN = 14.0
MARK = 8.0  #: radius of the symbol of a joint
LINE = 22.0  #: height of a line of the legend
BESIDE = 14.0  #: place of the name of a link relative to its symbol where layers are rows
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


#: names of colours -> on light paper, on dark paper
COLOURS = {
    "ink": ("#1f2328", "#e6e9ee"),
    "pale": ("#57606a", "#a3adb9"),
    "paper": ("#ffffff", "#15181d"),
    "shade": ("#eef0f3", "#262c35"),
    "wire": ("#4b5563", "#b6bfca"),
    "drive": ("#b3360a", "#ff9a5c"),
    "driven": ("#fdeadf", "#3d2718"),
    "force": ("#0072b2", "#56b4e9"),
    "loop": ("#6d3fb0", "#b99cf0"),
    "hot": ("#d81b60", "#ff5c93"),
    "weld": ("#dce9dc", "#25382b"),
}
RULES = """\
.graph text { font: 13px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: $ink; }
.graph .line { fill: none; stroke: $wire; stroke-width: 1.6; }
.graph .body { fill: $shade; stroke: $ink; stroke-width: 1.3; }
.graph .moved { fill: $driven; stroke: $drive; }
.graph .follows { stroke: $drive; stroke-dasharray: 5 3; }
.graph .ground { fill: $paper; stroke: none; }
.graph .hatch { fill: none; stroke: $pale; stroke-width: 1.2; }
.graph .hull { fill: $weld; stroke: none; }
.graph .band { fill: none; stroke: $weld; stroke-width: 26; stroke-linecap: round; }
.graph .joint { fill: $paper; stroke: $ink; stroke-width: 1.6; }
.graph .driver { fill: $drive; stroke: $drive; stroke-width: 1.6; stroke-linejoin: round; }
.graph .force { fill: none; stroke: $force; stroke-width: 1.7; stroke-linejoin: round; }
.graph .closing { stroke: $loop; stroke-width: 2; }
.graph .redundant { stroke: $hot; stroke-width: 2.4; }
.graph .line.joint, .graph .line.driver { fill: none; }
.graph .line.joint:not(.closing):not(.redundant) { stroke: $wire; }
.graph .line.force { stroke-dasharray: 4 3; stroke-width: 1.3; }
.graph text.name { font-weight: 600; paint-order: stroke; stroke: $paper; stroke-width: 3px; stroke-opacity: .75; }
.graph text.small { font-size: 11.5px; fill: $pale; }
.graph text.warn { fill: $hot; font-weight: 600; }
.graph text.number { font-size: 11.5px; font-weight: 700; fill: $loop; }
.graph text.part { font-weight: 600; fill: $pale; }
.graph text.legend { font-size: 12.5px; }
.graph text.inside { stroke: none; }
"""


def style(dark: bool = True) -> str:
    """The style sheet of the picture; ``dark``: also for dark paper, on screens."""
    light = RULES
    for name, (colour, _) in COLOURS.items():
        light = light.replace(f"${name};", f"{colour};")
    if not dark:
        return light
    rules = RULES
    for name in COLOURS:
        rules = rules.replace(f"${name};", f"var(--g-{name});")
    own = ["; ".join(f"--g-{name}: {pair[k]}" for name, pair in COLOURS.items()) for k in (0, 1)]
    return (
        f".graph {{ {own[0]}; }}\n@media screen and (prefers-color-scheme: dark) {{ .graph {{ {own[1]}; }} }}\n{rules}"
    )


def svg(structure: Structure, own: bool = True, key: str = "graph") -> str:
    """The picture as SVG.

    Parameters
    ----------
    structure : Structure
        The graph.
    own : bool, optional
        Whether it is a file of its own, with its style on white paper.
    key : str, optional
        Beginning of its ids.

    Returns
    -------
    str
        ``<svg>`` with title, and with a description in words.
    """
    shown = _Picture(structure)
    size = f'width="{shown.width:.0f}" viewBox="0 0 {shown.width:.0f} {shown.height:.0f}"'
    names = f'role="img" aria-labelledby="{key}-title {key}-desc"'
    head, paper = f'<svg class="graph" {size} {names}>', ()
    if own:
        space = f'xmlns="http://www.w3.org/2000/svg" height="{shown.height:.0f}"'
        head = f'<svg {space} class="graph" {size} {names}>'
        paper = (f"<style>\n{style(dark=False)}</style>", '<rect width="100%" height="100%" fill="#ffffff"/>')
    title = f'<title id="{key}-title">{escape(f"Graph of {structure.name}")}</title>'
    said = f'<desc id="{key}-desc">{escape(description(structure))}</desc>'
    return "\n".join((head, title, said, *paper, *shown.items, "</svg>\n"))


def description(structure: Structure) -> str:
    """The graph in words."""
    loops = [structure.loop_text(k + 1) for k in range(len(structure.loops))]
    return ". ".join([*structure.summary.splitlines(), *loops, *structure.remarks]) + "."


class _Picture:
    """The elements of the picture from the back to the front, and its size [px]."""

    def __init__(self, structure: Structure) -> None:
        self.structure, self.items, self.kinds = structure, list[str](), set[str]()
        blocks = layout(structure)
        self.width = max(max(block.x + block.width for block in blocks), 420.0) + 2 * MARGIN
        for number, block in enumerate(blocks):
            for node in block.nodes:
                node.x, node.y = node.x + block.x + MARGIN, node.y + block.y + MARGIN
            if len(blocks) > 1:
                part = f"part {number + 1}, mobility {structure.parts[number].velocity_mobility}"
                self.text("part", part, block.x + MARGIN, block.y + MARGIN - 4.0, "start")
            self.hulls(block)
            for a, b in block.lines:
                link = block.nodes[a].link or block.nodes[b].link
                assert link is not None
                self.path(f"line {_role(link)}", _way(block, a, b))
            for node in block.nodes:
                if node.what == "ground":
                    self.ground(node)
                elif node.what == "body":
                    self.body(node)
                elif node.what != "way":
                    self.link(node, block.down)
        self.height = self.legend(max(block.y + block.height for block in blocks) + MARGIN + 14.0) + MARGIN

    def path(self, kind: str, path: str, title: str = "") -> None:
        """A line or area of some classes; ``title`` is the full text of what is shortened."""
        self.kinds.add(kind)
        end = f"><title>{escape(title)}</title></path>" if title else "/>"
        self.items.append(f'<path class="{kind}" d="{path}"{end}')

    def text(self, kind: str, text: str, x: float, y: float, anchor: str = "middle", title: str = "") -> None:
        more = f"<title>{escape(title)}</title>" if title else ""
        side = f' text-anchor="{anchor}"' if anchor != "start" else ""
        self.items.append(f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}"{side}>{more}{escape(text)}</text>')

    def hulls(self, block: PartLayout) -> None:
        """Pale bands around bodies that are solved as one."""

        def group(name: str) -> int:
            body = self.structure.bodies.get(name)
            return -1 if body is None or body.fixed else body.group

        for node in block.nodes:
            if node.what == "body" and group(node.name):
                self.path("hull", _box(node.x, node.y, node.width + 16.0, BOX + 14.0, 12.0))
        for a, b in block.lines:
            link = block.nodes[a].link or block.nodes[b].link
            if link is not None and link.weld and group(link.a) == group(link.b) != 0:
                self.path("hull band", _way(block, a, b))

    def body(self, node: GraphPlace) -> None:
        body = self.structure.bodies[node.name]
        kind = "body moved" if body.moved else "body follows" if body.follows else "body"
        self.path(kind, _box(node.x, node.y, node.width, BOX, 7.0), f"{body.kind} {body.name}")
        self.text("name inside", shortened(node.name, LETTERS), node.x, node.y - 2.0)
        self.text("small", shortened(caption(node, self.structure), LETTERS), node.x, node.y + 13.0)

    def ground(self, node: GraphPlace) -> None:
        name, half = self.structure.ground, node.width / 2
        self.path("ground", _box(node.x, node.y - 4.0, node.width, 28.0, 3.0), name)
        self.text("name", shortened(name, LETTERS), node.x, node.y + 0.5)
        self.path("hatch", _hatch(node.x - half, node.y + 10.0, node.x + half, node.y + 10.0))

    def link(self, node: GraphPlace, down: bool) -> None:
        link, x, y = node.link, node.x, node.y
        assert link is not None
        role, title = _role(link), f"{link.kind} {link.name}"
        if link.rows or link.velocity_rows:
            rows = [count(link.rows, "row")] if link.rows else []
            rows += [count(link.velocity_rows, "velocity-level row")] if link.velocity_rows else []
            title += f": {', '.join(rows)}"
        if link.loop:
            title += f"; {self.structure.loop_text(link.loop)}"
        if node.what == "grounded":  # a wall beyond it
            u, v = (0.0, 18.0) if down else (node.width / 2 + GAP * 0.3, 0.0)
            self.path(f"line {role}", f"M{x:.1f} {y:.1f}L{x + u:.1f} {y + v:.1f}")
            a, b = ((-9.0, 0.0), (9.0, 0.0)) if down else ((0.0, 9.0), (0.0, -9.0))
            self.path("hatch", _hatch(x + u + a[0], y + v + a[1], x + u + b[0], y + v + b[1], 6.0))
        self.path(role, _symbol(link, x, y), title)
        if link.loop:
            self.text("number", str(link.loop), x, y + 4.0)
        below, said = "small warn" if link.redundant else "small", shortened(caption(node, self.structure), LETTERS + 4)
        if down:
            self.text("name", shortened(link.name, LETTERS), x + BESIDE, y - 1.0, "start", link.name)
            self.text(below, said, x + BESIDE, y + 12.0, "start")
        else:
            self.text("name", shortened(link.name, LETTERS), x, y - 14.0, title=link.name)
            self.text(below, said, x, y + 23.0)

    def legend(self, top: float) -> float:
        """The samples and texts of the classes that occur; returns the end of the last line."""
        x, y, kinds = MARGIN, top + LINE, set(self.kinds)
        for kind, text in LEGEND.items():
            if kind not in kinds:
                continue
            length = 46.0 + 6.4 * len(text)
            if x > MARGIN and x + length > min(self.width, WIDTH):
                x, y = MARGIN, y + LINE
            self.sample(kind, x + 14.0, y - 4.0)
            self.text("legend", text, x + 34.0, y, "start")
            x += length + 12.0
        return y

    def sample(self, kind: str, x: float, y: float) -> None:
        role, _, more = kind.partition(" ")
        if role in ("body", "hull"):
            self.path(kind, _box(x, y, 26.0, 14.0, 4.0))
            return
        self.path(f"line {kind}", f"M{x - 14.0:.1f} {y:.1f}H{x + 14.0:.1f}")
        self.path(kind, _symbol(Link("", "", role, GROUND, GROUND, 1), x, y))
        if more == "closing":
            self.text("number", "1", x, y + 4.0)


def _role(link: Link) -> str:
    """The classes of a link."""
    more = " redundant" if link.redundant else " closing" if link.loop else ""
    return link.role + (more if link.role == JOINT or link.redundant else "")


def _way(block: PartLayout, first: int, second: int) -> str:
    """From a node to one in the next layer: straight inside the layers, and curved between them."""
    a, b = sorted((block.nodes[first], block.nodes[second]), key=lambda node: node.layer)
    (u, v), (w, z) = ((n.y, n.x) if block.down else (n.x, n.y) for n in (a, b))
    start, end = u + a.reach, w - b.reach
    half = (start + end) / 2
    points = ((u, v), (start, v), (half, v), (half, z), (end, z), (w, z))
    said = [f"{q:.1f} {p:.1f}" if block.down else f"{p:.1f} {q:.1f}" for p, q in points]
    return f"M{said[0]}L{said[1]}C{' '.join(said[2:5])}L{said[5]}"


def _box(x: float, y: float, width: float, height: float, r: float) -> str:
    """A rectangle with round corners about (x, y)."""
    a, b, c, d = x - width / 2, y - height / 2, x + width / 2, y + height / 2
    k = 0.448 * r  # a quarter of a circle as a cubic curve
    corners = (
        f"M{a + r:.1f} {b:.1f}H{c - r:.1f}C{c - k:.1f} {b:.1f} {c:.1f} {b + k:.1f} {c:.1f} {b + r:.1f}",
        f"V{d - r:.1f}C{c:.1f} {d - k:.1f} {c - k:.1f} {d:.1f} {c - r:.1f} {d:.1f}",
        f"H{a + r:.1f}C{a + k:.1f} {d:.1f} {a:.1f} {d - k:.1f} {a:.1f} {d - r:.1f}",
        f"V{b + r:.1f}C{a:.1f} {b + k:.1f} {a + k:.1f} {b:.1f} {a + r:.1f} {b:.1f}Z",
    )
    return "".join(corners)


def _hatch(x: float, y: float, x2: float, y2: float, step: float = 9.0) -> str:
    """A wall from one point to another, with strokes to the right of the way."""
    size = math.hypot(x2 - x, y2 - y)
    number = max(2, round(size / step))
    u, v = (x2 - x) / number, (y2 - y) / number
    n, m = -8.0 * (y2 - y) / size, 8.0 * (x2 - x) / size
    strokes = (
        f"M{x + (k + 0.9) * u:.1f} {y + (k + 0.9) * v:.1f}L{x + (k + 0.3) * u + n:.1f} {y + (k + 0.3) * v + m:.1f}"
        for k in range(number)
    )
    return f"M{x:.1f} {y:.1f}L{x2:.1f} {y2:.1f}{''.join(strokes)}"


def _symbol(link: Link, x: float, y: float) -> str:
    if link.role == FORCE:  # a coil
        points = [(x - 13.0 + 26.0 * k / 8, y + (0.0 if k in (0, 8) else -6.0 if k % 2 else 6.0)) for k in range(9)]
    elif link.role == DRIVER:  # an arrow
        r = MARK + 1.5
        points = [(x + r * math.cos(u), y + r * math.sin(u)) for u in (0.0, 2.25, -2.25)]
    elif link.weld:
        return _box(x, y, 2 * MARK - 2.0, 2 * MARK - 2.0, 1.0)
    else:
        return _box(x, y, 2 * MARK, 2 * MARK, MARK)
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points) + ("Z" if link.role == DRIVER else "")
