"""Plots in characters: dots read back and compared with the data, labels, legend, width, colour and encoding."""

import re

import numpy as np
import pytest

from mbdsl.messages import width
from mbdsl.plotting import characters
from mbdsl.plotting.characters import DOTS
from mbdsl.plotting.signal_plots import plot
from mbdsl.results.stored import of_columns

T = np.linspace(0.0, 4.0, 401)
COLUMNS = {"time": T, "a.x": np.sin(2 * T), "b.x": 0.5 * np.cos(2 * T), "a.phi": 3.0 * T}
ESCAPE = re.compile(r"\x1b\[\d+m")


GOLDEN = """\
r.csv
x [m]   a a.x   b b.x
 2┤⠦⢄⡀                              ⢀⡠⠴
  │  ⠈⠉⠒⠢⢄⣀                    ⣀⡠⠔a⠉⠁
  │        b⠒⠢⠤⣀          ⣀⠤⠔⠒⠉
  │             ⠉⠑⠢⠤⣀⣀⠤⠔⠊⠉
  │             ⣀⡠⠔⠒a⠉⠒⠢⢄b
  │        ⣀⠤⠔⠒⠉          ⠉⠒⠢⠤⣀
  │  ⢀a⠤⠔⠊⠉                    ⠉⠑⠢⠤⣀⡀
 0┤⠖⠊⠁                              ⠈⠑⠲
  └┬─────────────────┬────────────────┬
   0                 1                2
                 time [s]"""


def text(plot, *arguments, **named):
    return characters.text(plot.page(), *arguments, **named)


def made(patterns, columns=COLUMNS, **options):
    result = of_columns("r.csv", list(columns), lambda n: "rad" if n.endswith("phi") else "m", columns.__getitem__)
    return plot([result], patterns, **options)


def frame(lines):
    """(Rows inside the frame without labels, labels by row) of the first panel."""
    rows = [line for line in lines if "┤" in line or "│" in line]
    rows = rows[: next(k for k, line in enumerate(lines) if "└" in line) - lines.index(rows[0])]
    side = next(k for k, c in enumerate(rows[0]) if c in "┤│")
    return [row[side + 1 :] for row in rows], {k: row[:side].strip() for k, row in enumerate(rows) if row[side] == "┤"}


def dots(rows, size):
    """Coordinates of the braille dots, from the left and from the bottom, from 0 to 1."""
    found = []
    for j, row in enumerate(rows):
        for i, c in enumerate(row):
            if 0x2800 <= ord(c) < 0x2900:
                for y in range(4):
                    for x in range(2):
                        if (ord(c) - 0x2800) & DOTS[y][x]:
                            found.append(((2 * i + x + 0.5) / (2 * size), 1.0 - (4 * j + y + 0.5) / (4 * len(rows))))
    return np.array(found)


def test_dots_are_where_the_data_is():
    """Within one dot of a sine that is scaled by the labels of the axis."""
    lines = text(made(["a.x"])).splitlines()
    rows, labels = frame(lines)
    size = len(lines[next(k for k, line in enumerate(lines) if "└" in line)].split("└")[1])
    found = dots(rows, size)
    assert len({int(x * 2 * size) for x, _ in found}) == 2 * size  # every column
    heights = [1.0 - (k + 0.5) / len(rows) for k in labels]
    values = [float(label.replace("−", "-")) for label in labels.values()]
    per = (values[0] - values[-1]) / (heights[0] - heights[-1]) / len(rows)  # a row of characters
    slope, offset = np.polyfit(heights, values, 1)
    assert slope * found[:, 1] + offset == pytest.approx(np.sin(2 * 4.0 * found[:, 0]), abs=1.1 * per)


def test_golden():
    t = np.array([0.0, 1.0, 2.0])
    shown = text(made(["*"], {"time": t, "a.x": t, "b.x": 2.0 - t}), 40, 14)
    assert shown == GOLDEN


@pytest.mark.parametrize("columns", [40, 80, 133])
@pytest.mark.parametrize("ascii_only", [False, True])
def test_no_line_is_wider_than_the_terminal(columns, ascii_only):
    long = {"time": T, **{f"a_body_with_a_long_name[{k}].x": T * k for k in range(9)}}
    for found in (made(["*"]), made(["*"], long), made(["a.x"], spectrum=True), made(["a.x"], against="b.x")):
        for colour in (False, True):
            lines = ESCAPE.sub("", text(found, columns, 30, colour, ascii_only)).splitlines()
            assert max(map(width, lines)) <= columns
            assert all(line == line.rstrip() for line in lines)


def test_labels_title_and_units():
    lines = text(made(["*"])).splitlines()
    assert lines[0] == "r.csv"
    assert lines[1] == "x [m]   a a.x   b b.x"
    assert "a.phi [rad]" in lines
    assert lines[-1].strip() == "time [s]"
    assert lines[-2].split() == ["0", "1", "2", "3", "4"]
    assert sum("└" in line for line in lines) == 2


def test_curves_differ_without_colour_and_with_it():
    plain = text(made(["*.x"]))
    rows, _ = frame(plain.splitlines())
    assert {c for row in rows for c in row if c.isalpha()} == {"a", "b"}
    assert "\x1b" not in plain
    coloured = text(made(["*.x"]), colour=True)
    assert set(ESCAPE.findall(coloured)) == {"\x1b[36m", "\x1b[33m", "\x1b[0m"}
    legend = coloured.splitlines()[1]
    assert legend == "x [m]   \x1b[36m⠒⠒\x1b[0m a.x   \x1b[33m⠒⠒\x1b[0m b.x"
    assert not any(c.isalpha() for row in frame(ESCAPE.sub("", coloured).splitlines())[0] for c in row if c < "⠀")


def test_ascii():
    shown = text(made(["*"]), ascii_only=True)
    assert shown.isascii()
    assert set("ab*") <= set(shown)
    small = text(made(["a.x"], {"time": T, "a.x": 1e-7 * T}), ascii_only=True)
    assert "a.x [m] (ticks x 10-7)" in small


def test_a_second_result_is_dashed():
    results = [
        of_columns(f"{k}.csv", list(COLUMNS), lambda name: "m", {**COLUMNS, "a.x": T * k}.__getitem__) for k in (1, 2)
    ]
    coloured = text(plot(results, ["a.x"]), colour=True)
    assert set(ESCAPE.findall(coloured)) == {"\x1b[36m", "\x1b[0m"}  # one signal, one colour
    assert "⠒⠒\x1b[0m a.x, 1.csv" in coloured
    assert "⠂⠂\x1b[0m a.x, 2.csv" in coloured


def test_height():
    assert len(text(made(["*"]), lines=24).splitlines()) <= 24
    assert len(text(made(["*"]), lines=100).splitlines()) > 30


def test_control_characters_are_escaped():
    shown = text(made(["*"], {"time": T, "a\x1b[31m.x": T, "b.x": T}))
    assert "\x1b" not in shown
    assert "a\\x1b[31m.x" in shown


def test_gaps_and_single_points():
    gap = np.where((T > 1.0) & (T < 3.0), np.nan, 1.0 + T)
    rows, _ = frame(text(made(["a.x"], {"time": T, "a.x": gap})).splitlines())
    middle = [row[30:40].strip() for row in rows]
    assert middle == [""] * len(rows)
    assert any(c > "⠀" for c in text(made(["a.x"], {"time": T[:1], "a.x": T[:1]})))
