"""Plots of signals: positions read back from SVG, panels, looks, notes, files and errors."""

import re
import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np
import pytest

from mbdsl.errors import UsageError
from mbdsl.plotting.default_signals import default_signals
from mbdsl.plotting.signal_plots import plot
from mbdsl.results.stored import USUAL_UNITS, of_columns

SVG = "{http://www.w3.org/2000/svg}"
T = np.linspace(0.0, 5.0, 501)
COLUMNS = {
    "time": T,
    "crank.x": 0.3 * np.cos(3 * T),
    "crank.y": 0.3 * np.sin(3 * T),
    "crank.phi": 3 * T,
    "crank.vx": -0.9 * np.sin(3 * T),
    "slider.x": 0.9 + 0.2 * np.cos(3 * T),
    "slider.y": 0.0 * T,
    "pin.fx": 1e4 * np.sin(T),
}


def unit(name):
    return "N" if name.endswith("fx") else USUAL_UNITS.get(name.rpartition(".")[2], "")


def result(label="r.csv", columns=COLUMNS):
    return of_columns(label, list(columns), unit, columns.__getitem__)


def svg(plot):
    return plot._repr_svg_()


def panels(plot):
    """The inner pictures of the panels."""
    return [e for e in ET.fromstring(svg(plot)).iter(f"{SVG}svg") if e.get("role") == "img"]


def line(panel, k=0):
    """Points of the k-th curve [px]."""
    (group,) = [g for g in panel.iter(f"{SVG}g") if g.get("data-series") == str(k)]
    (path,) = [p for p in group if p.get("class") == "line"]
    return np.array([[float(v) for v in pair.split()] for pair in re.split("[ML]", path.get("d"))[1:]])


def number(text):
    return float(text.replace("−", "-"))


def ticks(panel):
    """(Pixels, values) of the labels of the horizontal and of the vertical axis."""
    found = {"middle": [], "end": []}
    for text in panel.iter(f"{SVG}text"):
        if text.get("class") == "tick":
            middle = text.get("text-anchor") == "middle"
            place = float(text.get("x")) if middle else float(text.get("y")) - 4.5
            found[text.get("text-anchor")].append((place, number(text.text)))
    return [np.array(found[key]).T for key in ("middle", "end")]


def scaled(pixels, axis):
    """Pixels as values, by the labels of an axis."""
    slope, offset = np.polyfit(axis[0], axis[1], 1)
    return slope * pixels + offset, abs(slope)


def test_positions_are_those_of_the_data():
    """Read off the picture with its own labels: all points within a pixel, at the times of the data."""
    (panel,) = panels(plot([result()], ["crank.x"]))
    x_axis, y_axis = ticks(panel)
    points = line(panel)
    t, per_x = scaled(points[:, 0], x_axis)
    x, per_y = scaled(points[:, 1], y_axis)
    assert (t.min(), t.max()) == (pytest.approx(0.0, abs=per_x), pytest.approx(5.0, abs=per_x))
    slope = 0.9 * per_x  # the largest velocity: rounding of the time
    assert x == pytest.approx(0.3 * np.cos(3 * t), abs=per_y + slope)
    # Between the points, the line is within a pixel of the motion.
    assert np.interp(T, t, x) == pytest.approx(COLUMNS["crank.x"], abs=per_y + slope)


def test_phase_plot():
    (panel,) = panels(plot([result()], ["crank.y"], against="crank.x"))
    x_axis, y_axis = ticks(panel)
    points = line(panel)
    (x, per_x), (y, per_y) = scaled(points[:, 0], x_axis), scaled(points[:, 1], y_axis)
    assert per_x == pytest.approx(per_y, rel=1e-3)  # both are lengths: a circle is a circle
    assert np.hypot(x, y) == pytest.approx(0.3, abs=per_x)


def test_one_panel_a_unit_with_a_shared_axis():
    found = plot([result()], ["*"])
    assert [p.y_label for p in found.panels] == ["length [m]", "crank.phi [rad]", "crank.vx [m/s]", "pin.fx [N]"]
    assert {p.x_label for p in found.panels} == {"time [s]"}
    assert {p.x_ends for p in found.panels} == {(0.0, 5.0)}
    pictures = panels(found)
    starts = [line(panel)[0, 0] for panel in pictures]
    ends = [line(panel)[-1, 0] for panel in pictures]
    assert (len(set(starts)), len(set(ends))) == (1, 1)
    assert [bool(len(ticks(panel)[0])) for panel in pictures] == [False, False, False, True]
    tops = [float(p.get("y")) for p in pictures]
    bottoms = [top + float(p.get("height")) for top, p in zip(tops, pictures, strict=True)]
    assert all(b <= a for a, b in zip(tops[1:], bottoms[:-1], strict=True))


def test_no_legend_covers_a_frame():
    """Texts of legends are above the frame of their panel and below that of the panel above, and do not overlap."""
    names = [f"a_long_name_of_a_body_{k}.x" for k in range(9)]
    columns = {"time": T, **{name: T + k for k, name in enumerate(names)}, "b.phi": T, "c.phi": T}
    root = ET.fromstring(svg(plot([result(columns=columns)], ["*"])))
    frames = []
    for panel in [e for e in root if e.tag == f"{SVG}svg"]:
        (rect,) = panel.iter(f"{SVG}rect")
        top = float(panel.get("y")) + float(rect.get("y"))
        frames.append((top, top + float(rect.get("height"))))
    texts = [e for e in root if e.tag == f"{SVG}text" and e.get("class") is None]
    assert sorted(e.text for e in texts) == sorted(columns)[:-1]
    rows = {}
    for e in texts:
        y = float(e.get("y"))
        assert not any(top - 2.0 < y < bottom + 10.0 for top, bottom in frames)
        rows.setdefault(y, []).append((float(e.get("x")), float(e.get("x")) + 6.8 * len(e.text)))
    for row in rows.values():
        row.sort()
        assert row[-1][1] <= 860.0
        assert all(a[1] + 34.0 <= b[0] for a, b in pairwise(row))


def test_several_results():
    other = {**COLUMNS, "crank.x": 1.1 * COLUMNS["crank.x"]}
    other.pop("slider.x")
    found = plot([result("runs/a.csv"), result("runs/b.csv", other)], ["*.x"])
    names = [s.name for s in found.panels[0].series]
    assert names == ["crank.x, a.csv", "slider.x, a.csv", "crank.x, b.csv"]
    one, two, three = (found.looks[name] for name in names)
    assert one.light == three.light != two.light
    assert one.dash == two.dash == ()
    assert three.dash != ()
    assert found.title == "a.csv, b.csv"
    assert "Not in b.csv: slider.x." in found.notes


def test_files_of_one_name_have_their_folders():
    found = plot([result("one/r.csv"), result("two/r.csv")], ["crank.x"])
    assert [s.name for s in found.panels[0].series] == ["crank.x, one/r.csv", "crank.x, two/r.csv"]


def test_difference():
    other = {**COLUMNS, "crank.x": COLUMNS["crank.x"] + 0.02 * T}
    found = plot([result("a.csv"), result("b.csv", other)], ["crank.x"], difference=True)
    assert found.title == "b.csv − a.csv"
    assert found.notes == ()
    assert found.panels[0].series[0].y == pytest.approx(0.02 * T, abs=1e-15)
    thinned = {name: values[::2] for name, values in other.items()}
    found = plot([result("a.csv"), result("b.csv", thinned)], ["crank.x", "pin.fx"], difference=True)
    text = "b.csv is interpolated to the times of a.csv by cubic Hermite polynomials (crank.x) and linearly (pin.fx)."
    assert text in found.notes


def test_spectrum():
    t = np.arange(4000) * 0.005
    columns = {"time": t, "a.x": 0.3 * np.sin(2 * np.pi * 2.0 * t), "b.x": 0.1 * np.sin(2 * np.pi * 5.0 * t)}
    found = plot([result(columns=columns)], ["*"], spectrum=True)
    (panel,) = found.panels
    assert panel.x_label == "frequency [Hz]"
    for series, (frequency, amplitude) in zip(panel.series, ((2.0, 0.3), (5.0, 0.1)), strict=True):
        k = int(np.argmax(series.y))
        assert (series.x[k], series.y[k]) == (pytest.approx(frequency), pytest.approx(amplitude))
    assert 5.0 < panel.x_ends[1] < 20.0  # instead of 100 Hz
    assert any("Hann" in note for note in found.notes)


def test_default_signals():
    found = plot([result()])
    assert [s.name for p in found.panels for s in p.series] == ["crank.x", "crank.y", "slider.x", "crank.phi"]
    assert any("slider.y" in note for note in found.notes)  # constant
    assert any("--signals" in note for note in found.notes)
    bodies = [f"link[{k}].{key}" for k in range(9) for key in ("x", "y", "phi", "vx")]
    assert default_signals(bodies) == [f"link[{k}].{key}" for k in range(3) for key in ("x", "y", "phi")]
    assert default_signals(["a.x", "a.y", "joint.phi", "b.x", "b.y"]) == ["a.x", "a.y", "b.x", "b.y"]
    assert default_signals(["a.x", "a.y", "b.x", "b.ax", "c.x", "c.y"]) == ["b.x"]
    assert default_signals(["a.phi", "b.phi", "b.w"]) == ["a.phi", "b.phi"]
    assert default_signals([f"u{k}" for k in range(9)]) == [f"u{k}" for k in range(6)]
    still = {"time": T, "a.x": 0.0 * T}
    assert [s.name for s in plot([result(columns=still)]).panels[0].series] == ["a.x"]


def test_long_results_keep_their_extremes():
    t = np.linspace(0.0, 10.0, 60_000)
    y = np.sin(50.0 * t)
    y[34_567] = 7.0
    found = plot([result(columns={"time": t, "a.x": y})], ["a.x"])
    (series,) = found.panels[0].series
    assert len(series.x) < 20_000
    assert (max(series.y), series.x[int(np.argmax(series.y))]) == (7.0, t[34_567])
    assert any(note.startswith("60\u202f000 rows") for note in found.notes)
    _, y_axis = ticks(panels(found)[0])
    value, per = scaled(line(panels(found)[0])[:, 1], y_axis)
    assert value.max() == pytest.approx(7.0, abs=per)


def test_times_of_other_programs_may_go_back():
    t = np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(0.5, 1.5, 50)])
    (series,) = plot([result(columns={"time": t, "a.x": t})], ["a.x"]).panels[0].series
    assert series.x == t.tolist()


def test_errors():
    cases = [
        (([result()], ["crnak.x"]), {}, "no signal named `crnak.x` in r.csv\n  = did you mean `crank.x`"),
        (([result()], ["*.z"]), {}, "no signal that matches `\\*.z`"),
        (([result()], ["crank.x"]), {"against": "crank.z"}, "no signal named `crank.z`"),
        (([result()], ["crank.x"]), {"against": "crank.x"}, "no signal to plot"),
        (([result()],), {"difference": True}, "needs two results"),
        (([result()],), {"against": "crank.x", "spectrum": True}, "against the frequency"),
        (([result(columns={"time": T[:0], "a.x": T[:0]})],), {}, "r.csv has no rows"),
        (([result(columns={"time": T})],), {}, "no signal to plot"),
    ]
    for arguments, named, message in cases:
        with pytest.raises(UsageError, match=message):
            plot(*arguments, **named)
    with pytest.raises(UsageError, match="no column `time`"):
        result(columns={"t": T})
    other = of_columns("s.csv", list(COLUMNS), lambda name: "deg", COLUMNS.__getitem__)
    with pytest.raises(UsageError, match=r"`crank.phi` has the unit rad in r.csv and deg in s.csv"):
        plot([result(), other], ["crank.phi"])


@pytest.mark.parametrize(
    ("suffix", "start"), [(".svg", b"<svg "), (".html", b"<!DOCTYPE html>"), (".png", b"\x89PNG"), (".pdf", b"%PDF")]
)
def test_files(tmp_path, suffix, start):
    paths = [tmp_path / f"{name}{suffix}" for name in "ab"]
    found = plot([result(), result("s.csv")], ["crank.x", "pin.fx"])
    for path in paths:
        found.save(path)
        assert path.read_bytes().startswith(start)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with pytest.raises(UsageError, match=r"unknown suffix `.gif`"):
        found.save(tmp_path / "a.gif")


def test_the_page_shares_its_axis_and_shows_values():
    from mbdsl.plotting import pages

    text = pages.html(plot([result()], ["crank.phi", "pin.fx"]).page())
    rects = re.findall(r'<clipPath id="[^"]+"><rect x="([\d.]+)" y="[\d.]+" width="([\d.]+)"', text)
    assert len(rects) == 4  # each panel for wide and for narrow windows
    assert rects[0] == rects[2] and rects[1] == rects[3]
    assert all(float(x) + float(width) < full for (x, width), full in zip(rects, [860.0, 400.0] * 2, strict=True))
    assert '"names":["crank.phi"]' in text
    assert "default-src &#x27;none&#x27;" in text


def test_names_are_only_text():
    evil = "</text><script>alert(1)</script>.x"
    text = svg(plot([result(columns={"time": T, evil: T, "b.x": T})], ["*"]))
    assert "<script>" not in text
    assert evil in [e.text for e in ET.fromstring(text).iter(f"{SVG}text")]
