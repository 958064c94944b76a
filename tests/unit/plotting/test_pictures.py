"""PNG and SVG by matplotlib: written, reproducible, and robust against all input. Warnings are errors here."""

import math
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from mbdsl.errors import UsageError
from mbdsl.plotting.figures import Figure, Outcome, Series
from mbdsl.plotting.pictures import draw

pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install 'mbdsl[plot]'")
NAN = math.nan


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_same_bytes_each_time_whatever_a_users_style(tmp_path, suffix, work_precision):
    import matplotlib

    draw(work_precision, tmp_path / f"a{suffix}")
    with matplotlib.rc_context({"axes.facecolor": "red", "font.size": 30, "svg.hashsalt": None, "text.usetex": True}):
        draw(work_precision, tmp_path / f"b{suffix}")
    written = (tmp_path / f"a{suffix}").read_bytes()
    assert written == (tmp_path / f"b{suffix}").read_bytes()
    assert written.startswith(b"\x89PNG" if suffix == ".png" else b"<?xml")


def test_size_of_a_png(tmp_path, energy):
    draw(energy, tmp_path / "a.png", size=(6.0, 4.0), dpi=100.0)
    header = (tmp_path / "a.png").read_bytes()[16:24]
    assert (int.from_bytes(header[:4], "big"), int.from_bytes(header[4:], "big")) == (600, 400)


def test_global_state_is_left_alone(tmp_path, drift):
    import matplotlib

    before = dict(matplotlib.rcParams)
    loaded = "matplotlib.pyplot" in sys.modules
    draw(drift, tmp_path / "a.svg")
    assert dict(matplotlib.rcParams) == before
    assert ("matplotlib.pyplot" in sys.modules) == loaded
    ElementTree.parse(tmp_path / "a.svg")


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
    draw(figure, tmp_path / "a.svg")
    ElementTree.parse(tmp_path / "a.svg")


def test_refused(tmp_path, energy, monkeypatch):
    with pytest.raises(UsageError, match=r"unknown suffix `\.gif`"):
        draw(energy, tmp_path / "a.gif")
    with pytest.raises(UsageError, match="cannot write"):
        draw(energy, tmp_path / "none" / "a.png")
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match="matplotlib") as refused:
        draw(energy, tmp_path / "a.png")
    assert refused.value.hint == "in the folder of mbdsl: pip install '.[plot]'"
