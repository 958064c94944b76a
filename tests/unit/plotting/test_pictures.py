"""PNG and SVG by matplotlib: written, reproducible, and robust against all input. Warnings are errors here."""

import math
import re
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from mbdsl.errors import UsageError
from mbdsl.plotting import pictures
from mbdsl.plotting.figures import Figure, Outcome, Series
from mbdsl.plotting.sheets import sheet

pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install 'mbdsl[plot]'")
NAN = math.nan


def draw(figure, path, **given):
    pictures.draw(sheet(figure.title, [figure]), path, **given)


@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_the_same_bytes_each_time_whatever_a_users_style(tmp_path, suffix, work_precision):
    import matplotlib

    draw(work_precision, tmp_path / f"a{suffix}")
    with matplotlib.rc_context({"axes.facecolor": "red", "font.size": 30, "svg.hashsalt": None, "text.usetex": True}):
        draw(work_precision, tmp_path / f"b{suffix}")
    written = (tmp_path / f"a{suffix}").read_bytes()
    assert written == (tmp_path / f"b{suffix}").read_bytes()
    assert written.startswith(b"\x89PNG" if suffix == ".png" else b"%PDF")


def test_size_of_a_png(tmp_path, energy):
    draw(energy, tmp_path / "a.png", dpi=192.0)
    header = (tmp_path / "a.png").read_bytes()[16:24]
    width, height = map(float, re.search('viewBox="0 0 ([0-9.]+) ([0-9.]+)"', sheet(energy.title, [energy])).groups())
    assert (int.from_bytes(header[:4], "big"), int.from_bytes(header[4:], "big")) == (2 * width, 2 * height)


def test_global_state_is_left_alone(tmp_path, drift):
    import matplotlib

    before = dict(matplotlib.rcParams)
    loaded = "matplotlib.pyplot" in sys.modules
    draw(drift, tmp_path / "a.pdf")
    assert dict(matplotlib.rcParams) == before
    assert ("matplotlib.pyplot" in sys.modules) == loaded


ODD = {
    "nothing": [],
    "empty": [Series("a", [], [])],
    "nan": [Series("a", [NAN, NAN], [NAN, NAN], [NAN, NAN], [NAN, NAN]), Series("b", [1.0], [NAN], style="line")],
    "a point": [Series("a", [1.0], [2.0], [1.5], [2.5])],
    "zero": [Series("a", [0.0, 1e-3, 1e-2], [1.0, 0.0, 2.0], [0.0, 0.0, 0.0], [2.0, 2.0, 3.0])],
    "close": [Series("a", [1.0, 1.0 + 1e-12], [3.0, 3.0 + 4e-16])],
    "equal": [Series("a", [2.0, 2.0], [7.0, 7.0], style="line")],
    "huge": [Series("a", [1e-320, 1.0], [1e305, 1e299]), Series("b", [1.0, math.inf], [1.0, -math.inf])],
    "arrays": [Series("a", np.geomspace(1, 9, 300), np.ones(300), np.ones(300), np.ones(300), style="marks")],
    "guides": [Series("order 2", [1.0, 2.0], [1.0, 4.0], style="guide"), Series("", [1.0], [1.0], style="front")],
    "names": [Series("$x_{_$ " * 30, [1.0, 2.0], [1.0, 2.0]), Series("_hidden", [1.0], [2.0])],
}


@pytest.mark.parametrize(("log", "equal"), [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("kind", ODD)
def test_odd_figures(tmp_path, kind, log, equal):
    outcomes = [Outcome("a", 1e-2, "diverged"), Outcome("c", None, "refused " * 30), Outcome("a", 0.0, "singular")]
    floors = [(1e-9, "rounding"), (0.0, "nothing"), (NAN, "?"), (2e-9, "reference")]
    figure = Figure("k", "T" * 150, "x [s]", "y $", ODD[kind], log, log, outcomes, floors, equal)
    for suffix in ("svg", "png"):
        draw(figure, tmp_path / f"a.{suffix}")
    ElementTree.parse(tmp_path / "a.svg")


def test_pixels_are_where_the_elements_are(tmp_path):
    """Rectangles, circles, lines and curves by absolute and relative commands, in groups, with classes and a clip."""
    shapes = (
        '<g class="blue"><path class="area" d="M10 10h20v10H10z"/></g>'
        '<svg x="50" y="5" viewBox="0 0 9 9"><circle cx="10" cy="10" r="8" fill="#ff0000"/></svg>'
        '<clipPath id="left"><rect x="0" y="40" width="20" height="20"/></clipPath>'
        '<rect x="10" y="40" width="30" height="20" fill="#00ff00" clip-path="url(#left)"/>'
        '<path class="line thin" stroke="#0000ff" d="M60 60C60 40 80 40 80 60l10 0m-40 15L90 75"/>'
    )
    style = ".area { fill: currentColor; } .blue { color: #0000ff; } .line:not(.thin) { stroke: none; }"
    style += " .x .line, .line { fill: none; stroke-width: 4; }"
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 80"><style>{style}</style>{shapes}</svg>'
    pictures.draw(text, tmp_path / "a.png", dpi=96.0)
    image = pytest.importorskip("PIL.Image").open(tmp_path / "a.png").convert("RGB")
    white, red, green, blue = (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255)
    expected = {(20, 15): blue, (35, 15): white, (60, 15): red, (66, 15): red, (66, 22): white, (15, 50): green}
    expected |= {(25, 50): white, (70, 45): blue, (70, 55): white, (85, 60): blue, (65, 75): blue, (45, 75): white}
    assert {at: image.getpixel(at) for at in expected} == expected


def test_refused(tmp_path, energy, monkeypatch):
    with pytest.raises(UsageError, match=r"unknown suffix `\.gif`"):
        draw(energy, tmp_path / "a.gif")
    with pytest.raises(UsageError, match="cannot write"):
        draw(energy, tmp_path / "none" / "a.png")
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match="matplotlib") as refused:
        draw(energy, tmp_path / "a.png")
    assert refused.value.hint.startswith("in the folder of mbdsl: pip install '.[plot]'")
