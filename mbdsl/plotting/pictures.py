"""PNG and PDF files: the SVG of a picture drawn by matplotlib, the same bytes for the same picture.

The layout of a picture is written once, as SVG. This is the part of SVG and CSS that the package's own pictures
contain: paths of straight lines and cubic curves, rectangles, circles and texts, in groups and nested pictures; style
sheets whose selectors are an element, classes and ``:not(.class)``, of which the last part counts.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree

from mbdsl.plotting.picture_files import drawn
from mbdsl.storage.output_files import suffix_of, writing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

SUFFIXES = (".png", ".svg", ".pdf")
DPI = 150.0
INCH = 96.0  #: CSS pixels of an inch
LARGEST = 65_000.0  #: pixels of a PNG along one side: matplotlib draws less than 2^16
LETTERS = 0.92  #: size of the letters over that in the style sheet: those of DejaVu Sans are wider than usual
RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")
SELECTOR = re.compile(r"(\w*)((?:\.[\w-]+)*)((?::not\(\.[\w-]+\))*)")
COMMAND = re.compile(r"([MLHVhvlmCZz])|(-?(?:\d+\.?\d*|\.\d+)(?:e-?\d+)?)")
#: numbers of a command of a path
NUMBERS = {"M": 2, "m": 2, "L": 2, "l": 2, "H": 1, "h": 1, "V": 1, "v": 1, "C": 6}
SKIPPED = ("title", "desc", "style", "clipPath")
SIDES = {"start": "left", "middle": "center", "end": "right"}
#: properties that an element does not hand on to those within it
OWN = ("x", "y", "class", "d", "clip-path", "opacity", "visibility")


def draw(svg: str, path: str | os.PathLike, dpi: float = DPI, instead: str = ".svg and .html") -> None:
    """Write a picture to a file.

    Parameters
    ----------
    svg : str
        The picture.
    path : path
        The file; its suffix selects the format: .svg, or .png and .pdf, which require matplotlib.
    dpi : float, optional
        Pixels per inch of a PNG.
    instead : str, optional
        Formats that need no matplotlib, for the error message.

    Raises
    ------
    UsageError
        If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
    """
    suffix = suffix_of(path, SUFFIXES)
    content = svg.encode() if suffix == ".svg" else converted(svg, suffix, dpi, instead)
    with writing(Path(path)) as stream:
        stream.write(content)


def converted(svg: str, suffix: str, dpi: float = DPI, instead: str = ".svg and .html") -> bytes:
    """A picture as PNG or PDF.

    Parameters
    ----------
    svg, dpi, instead
        As for :func:`draw`.
    suffix : {".png", ".pdf"}
        The format.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    root = ElementTree.fromstring(svg)
    width, height = (float(x) for x in root.attrib["viewBox"].split()[2:])
    dpi = min(dpi, LARGEST * INCH / max(width, height))
    content = io.BytesIO()
    fonts = {"font.family": ["DejaVu Sans"]}  # a dependency of matplotlib
    with drawn(content, suffix, (width / INCH, height / INCH), dpi, fonts, instead) as figure:
        ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        ax.set(xlim=(0.0, width), ylim=(height, 0.0))
        ax.set_axis_off()
        given = {name: value for name, value in root.attrib.items() if name.startswith("stroke")}
        _Drawing(ax, root, (width, height)).children(root, given, (0.0, 0.0))
    return content.getvalue()


class _Rule(NamedTuple):
    """A rule of a style sheet."""

    tag: str
    classes: frozenset[str]
    without: frozenset[str]
    properties: dict[str, str]

    def fits(self, tag: str, classes: frozenset[str]) -> bool:
        return self.tag in ("", tag) and self.classes <= classes and not self.without & classes


def _rules(sheet: str) -> Iterator[_Rule]:
    for selectors, body in RULE.findall(sheet):
        properties = {name.strip(): value.strip() for name, _, value in (d.partition(":") for d in body.split(";"))}
        for selector in selectors.split(","):
            if (found := SELECTOR.fullmatch(selector.split()[-1])) is not None:
                without = re.findall(r"\(\.([\w-]+)", found[3])
                yield _Rule(found[1], frozenset(found[2].split(".")[1:]), frozenset(without), properties)


class _Drawing:
    """The elements of a picture in axes of matplotlib whose units are those of the picture."""

    def __init__(self, ax: Axes, root: ElementTree.Element, size: tuple[float, float]) -> None:
        self.ax, self.order, self.size = ax, 1, size
        sheet = "".join(e.text or "" for e in root.iter() if _tag(e) == "style")
        # of rules that fit, the one with the most classes counts, then the last one
        rules = enumerate(_rules(sheet))
        self.rules = [rule for _, rule in sorted(rules, key=lambda r: (len(r[1].classes) + len(r[1].without), r[0]))]
        self.clips = {e.attrib["id"]: e[0].attrib for e in root.iter() if _tag(e) == "clipPath"}

    def children(self, parent: ElementTree.Element, given: Mapping[str, str], at: tuple[float, float]) -> None:
        """Draw what is within an element, with the properties that it hands on, relative to a point."""
        for element in parent:
            tag = _tag(element)
            if tag in SKIPPED or element.get("visibility") == "hidden":
                continue
            p = {name: value for name, value in given.items() if name not in OWN} | element.attrib
            classes = frozenset(p.get("class", "").split())
            for rule in self.rules:
                if rule.fits(tag, classes):
                    p |= rule.properties
            self.order += 1
            if tag == "text":
                self.text(element, p, at)
            elif tag in ("g", "svg"):
                x, y = (float(p.get(name, 0.0)) for name in ("x", "y")) if tag == "svg" else (0.0, 0.0)
                self.children(element, p, (at[0] + x, at[1] + y))
            else:
                self.shape(tag, p, at)

    def shape(self, tag: str, p: Mapping[str, str], at: tuple[float, float]) -> None:
        """A path, rectangle or circle; lengths may be parts of the size of the picture."""
        from matplotlib.patches import Circle, PathPatch, Rectangle
        from matplotlib.path import Path as Outline

        width = float(p.get("stroke-width", 1.0))
        look: dict[str, Any] = dict(
            facecolor=_colour(p, "fill", "#000000"),
            edgecolor=_colour(p, "stroke", "none"),
            linewidth=width * 72.0 / INCH,
            capstyle=p.get("stroke-linecap", "butt"),
            joinstyle=p.get("stroke-linejoin", "miter"),
            zorder=self.order,
        )

        def number(name: str, whole: float = 0.0) -> float:
            text = p.get(name, "0")
            return whole * float(text[:-1]) / 100.0 if text.endswith("%") else float(text)

        patch: Patch
        if tag == "rect":
            corner = at[0] + number("x"), at[1] + number("y")
            patch = Rectangle(corner, number("width", self.size[0]), number("height", self.size[1]), **look)
        elif tag == "circle":
            patch = Circle((at[0] + number("cx"), at[1] + number("cy")), number("r"), **look)
        else:
            points, codes = _points(p["d"])
            if not points:
                return
            patch = PathPatch(Outline([(at[0] + x, at[1] + y) for x, y in points], codes), **look)
        if dash := p.get("stroke-dasharray"):
            patch.set_linestyle((0, [float(x) / width for x in dash.split()]))
        self.ax.add_patch(patch)
        if clip := p.get("clip-path"):
            x, y, w, h = (float(self.clips[clip[5:-1]][name]) for name in ("x", "y", "width", "height"))
            patch.set_clip_path(Rectangle((at[0] + x, at[1] + y), w, h, transform=self.ax.transData))

    def text(self, element: ElementTree.Element, p: Mapping[str, str], at: tuple[float, float]) -> None:
        """A text; a title within it is not drawn."""
        from matplotlib.patheffects import withStroke

        text = (element.text or "") + "".join(child.tail or "" for child in element)
        size = float(re.sub("px.*", "", p.get("font-size", p.get("font", "13px")))) * LETTERS
        if longest := p.get("textLength"):
            size *= float(longest) / (7.2 * len(text))
        weight = "bold" if float(p.get("font-weight", 400)) >= 600 else "normal"
        x, y, side = at[0] + float(p["x"]), at[1] + float(p["y"]), SIDES[p.get("text-anchor", "start")]
        halo: dict[str, Any] = {}
        if p.get("stroke", "none") != "none":
            halo["path_effects"] = [withStroke(linewidth=float(p["stroke-width"].removesuffix("px")) * 0.75,
                                               foreground=p["stroke"])]  # fmt: skip
        level = "center" if p.get("dominant-baseline") == "central" else "baseline"
        self.ax.text(x, y, text, fontsize=size * 72.0 / INCH, ha=side, va=level, weight=weight,
                     color=_colour(p, "fill", "#000000"), zorder=self.order, **halo)  # fmt: skip


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _colour(p: Mapping[str, str], name: str, default: str) -> Any:
    """The colour of an area or a line, with its opacity."""
    colour = p.get(name, default)
    if colour == "currentColor":
        colour = p.get("color", "#000000")
    return "none" if colour == "none" else (colour, float(p.get(f"{name}-opacity", 1.0)) * float(p.get("opacity", 1.0)))


def _points(words: str) -> tuple[list[tuple[float, float]], list[int]]:
    """The points of a path and their codes in matplotlib: 1 moves, 2 is a line, 4 a cubic curve, 79 closes."""
    points: list[tuple[float, float]] = []
    codes: list[int] = []
    x = y = x0 = y0 = 0.0
    tokens = COMMAND.findall(words)
    k, command = 0, "M"
    while k < len(tokens):
        if tokens[k][0]:
            command, k = tokens[k][0], k + 1
        if command in "Zz":
            x, y = x0, y0
            points.append((x, y))
            codes.append(79)
            continue
        n = [float(number) for _, number in tokens[k : k + NUMBERS[command]]]
        k += len(n)
        if command == "C":
            points += [(n[0], n[1]), (n[2], n[3])]
            codes += [4, 4]
            x, y = n[4:]
        elif command in "Hh":
            x = n[0] + x * (command == "h")
        elif command in "Vv":
            y = n[0] + y * (command == "v")
        else:
            x, y = n[0] + x * command.islower(), n[1] + y * command.islower()
        if command in "Mm":
            x0, y0 = x, y
        elif command in "hl" and points and (x, y) == points[-1]:
            x += 0.01  # a dot: matplotlib leaves out lines without a length
        points.append((x, y))
        codes.append({"M": 1, "m": 1, "C": 4}.get(command, 2))
        command = {"M": "L", "m": "l"}.get(command, command)
    return points, codes
