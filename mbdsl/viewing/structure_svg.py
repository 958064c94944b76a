"""The picture of a mechanism's graph as SVG, for a file of its own or for a page."""

from __future__ import annotations

from mbdsl.plotting.escaping import escape
from mbdsl.viewing.structure import Structure
from mbdsl.viewing.structure_picture import Item, picture

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
.graph .body + text.name { stroke: none; }
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
    shown = picture(structure)
    size = f'width="{shown.width:.0f}" viewBox="0 0 {shown.width:.0f} {shown.height:.0f}"'
    names = f'role="img" aria-labelledby="{key}-title {key}-desc"'
    head = f'<svg class="graph" {size} {names}>'
    paper: list[str] = []
    if own:
        space = f'xmlns="http://www.w3.org/2000/svg" height="{shown.height:.0f}"'
        head = f'<svg {space} class="graph" {size} {names}>'
        paper = [f"<style>\n{style(dark=False)}</style>", '<rect width="100%" height="100%" fill="#ffffff"/>']
    return "\n".join(
        (
            head,
            f'<title id="{key}-title">{escape(f"Graph of {structure.name}")}</title>',
            f'<desc id="{key}-desc">{escape(description(structure))}</desc>',
            *paper,
            *(_item(item) for item in shown.items),
            "</svg>\n",
        )
    )


def description(structure: Structure) -> str:
    """The graph in words."""
    loops = [structure.loop_text(k + 1) for k in range(len(structure.loops))]
    return ". ".join([*structure.summary.splitlines(), *loops, *structure.remarks]) + "."


def _item(item: Item) -> str:
    title = f"<title>{escape(item.title)}</title>" if item.title else ""
    if item.path:
        return f'<path class="{item.kind}" d="{_path(item)}"' + (f">{title}</path>" if title else "/>")
    at = f'x="{item.x:.1f}" y="{item.y:.1f}"' + (f' text-anchor="{item.anchor}"' if item.anchor != "start" else "")
    return f'<text class="{item.kind}" {at}>{title}{escape(item.text)}</text>'


def _path(item: Item) -> str:
    return "".join(command + " ".join(f"{x:.1f}".removesuffix(".0") for x in numbers) for command, numbers in item.path)
