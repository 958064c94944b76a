"""Sweeps: values, measures, closed forms, stored runs, failures, and files that other packages read."""

import csv
import dataclasses
import io
import math
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import markdown
import numpy as np
import pandas
import pytest
from scipy.special import ellipk

import mbdsl
from mbdsl.errors import UsageError
from mbdsl.integrators import declared
from mbdsl.lang import parser
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.mechanism import graph
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.plotting.signal_panels import labelled
from mbdsl.studies import measures as measuring
from mbdsl.studies import runner as running
from mbdsl.studies import store as storing
from mbdsl.studies.measures import FUNCTIONS, Measure, read, split
from mbdsl.studies.store import Computed
from mbdsl.studies.sweep_results import Sweep
from mbdsl.studies.sweep_runs import PointRunner, SweepPoint
from mbdsl.studies.sweep_values import MOST, varied
from mbdsl.system import build

MODELS = Path(__file__).parents[3] / "models"
PENDULUM = MODELS / "pendulum.mbd"
RUN = {"step": 2e-3, "stop": 4.0}


def period(L, g=9.81):
    """The period of a pendulum released at 90 degrees (complete elliptic integral of the first kind, m = sin^2 45)."""
    return 4.0 * math.sqrt(L / g) * ellipk(0.5)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return tmp_path_factory.mktemp("runs")


@pytest.fixture(scope="module")
def lengths(store):
    """A sweep over the length of a pendulum; a rod without length is refused."""
    vary = {"L": "0:1:5"}
    measures = ["period(mass.x)", "amplitude(mass.y)", "max(rod.fy)", "time_of_max(rod.fy)"]
    return mbdsl.sweep(PENDULUM, vary, measures, store=store, workers=1, **RUN)


@pytest.fixture(scope="module")
def grid(store):
    vary = {"m": [1, 2], "L": "50, 100, 150 cm"}
    return mbdsl.sweep(PENDULUM, vary, "max(rod.fy), final(mass.x)", store=store, workers=1, **RUN)


# -- values ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "texts", "numbers", "unit"),
    [
        ("1:2:3", ("1", "1.5", "2"), (1.0, 1.5, 2.0), ""),
        ("0:0.3:4", ("0", "0.1", "0.2", "0.3"), (0.0, 0.1, 0.2, 0.3), ""),
        ("1:1000:4:log", ("1", "10", "100", "1000"), (1.0, 10.0, 100.0, 1000.0), ""),
        ("1:10:3 N/mm", ("1 N/mm", "5.5 N/mm", "10 N/mm"), (1.0, 5.5, 10.0), "N/mm"),
        ("1:100:3:log N/mm", ("1 N/mm", "10 N/mm", "100 N/mm"), (1.0, 10.0, 100.0), "N/mm"),
        ("500 mm:2 m:4", ("0.5 m", "1 m", "1.5 m", "2 m"), (0.5, 1.0, 1.5, 2.0), "m"),
        ("90:-90:3 deg", ("90 deg", "0 deg", "-90 deg"), (90.0, 0.0, -90.0), "deg"),
        ("-1:-100:3:log", ("-1", "-10", "-100"), (-1.0, -10.0, -100.0), ""),
        ("1, 2,5", ("1", "2", "5"), (1.0, 2.0, 5.0), ""),
        ("500mm, 1, 2 m", ("500mm", "1 m", "2 m"), (0.5, 1.0, 2.0), "m"),
        ("true,false", ("true", "false"), None, ""),
        ("{1, 2}, {3, 4}", ("{1, 2}", "{3, 4}"), None, ""),
        ("7", ("7",), (7.0,), ""),
    ],
)
def test_values(text, texts, numbers, unit):
    found = varied("p", text)
    assert (found.texts, found.numbers, found.unit) == (texts, numbers, unit)


def test_values_of_python():
    assert varied("p", [1, 2.5, np.float64(4)]).texts == ("1", "2.5", "4")
    assert varied("p", np.linspace(0.0, 1.0, 3)).numbers == (0.0, 0.5, 1.0)
    assert varied("p", [True, np.bool_(False)]).texts == ("true", "false")
    assert varied("p", ["1 mm", "2 mm"]).unit == "mm"


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("1:2", "start:stop:count"),
        ("1:0.1:2.5", "not start:step:stop"),
        ("1:2:0", "whole number"),
        ("1:2:1", "at least two values"),
        ("0:1:3:log", "both above zero"),
        ("1:2:3:cubic", "expected log or lin"),
        ("1:2:3 Nm", "did you mean N.m"),
        ("1 kg:2 m:3", "wrong unit"),
        ("1,,2", "missing"),
        (",", "no value"),
        ("1,1.0,1", "given twice"),
        (f"1:2:{MOST + 1}", "too many"),
        ([], "no value"),
        ([1, "2 mm"], "to all, or to none"),
        ([math.nan], "not a value of a parameter"),
        ([[1]], "not a value of a parameter"),
    ],
)
def test_wrong_values(given, says):
    with pytest.raises(UsageError, match=r"^--vary p: ") as error:
        varied("p", given)
    assert says in error.value.message


# -- measures ----------------------------------------------------------------------------------------------------------


def test_measures_of_an_oscillation():
    """x = 2 + 3 sin(2 pi t/T) over eight periods, at uneven times."""
    T = 0.25
    t = np.sort(np.concatenate([np.linspace(0.0, 2.0, 4001), np.linspace(0.5, 0.7, 333)]))
    x = 2.0 + 3.0 * np.sin(2.0 * math.pi * t / T)
    expected = {"final": 2.0, "min": -1.0, "max": 5.0, "maxabs": 5.0, "mean": 2.0, "rms": math.sqrt(4.0 + 4.5)}
    expected |= {"amplitude": 3.0, "period": T}
    # 500 points a period: extrema are below by 3 (pi/500)^2/2 = 6e-5 at most, the trapezoidal rule is closer
    for name, value in expected.items():
        assert FUNCTIONS[name].value(t, x) == pytest.approx(value, abs=1e-4), name
    # an extremum of eight equal ones, which is at a quarter of a period
    for name, part in (("time_of_max", 0.25), ("time_of_min", 0.75)):
        assert FUNCTIONS[name].value(t, x) / T % 1.0 == pytest.approx(part, abs=0.01)
    alone = {key for key, f in FUNCTIONS.items() if f.of == "run" and f.form == "SIGNAL"}
    assert {*expected, "time_of_max", "time_of_min"} == alone


def test_a_measure_without_a_value():
    t = np.array([0.0, 1.0, 2.0])
    assert math.isnan(FUNCTIONS["period"].value(t, t))
    (measure,) = read(["max(mass.x)"], SignalNames(mbdsl.load(PENDULUM)))
    assert math.isnan(measure.value(t, np.array([0.0, math.nan, 1.0]))) and math.isnan(measure.value(t[:0], t[:0]))


def test_texts_of_measures():
    names = SignalNames(mbdsl.load(PENDULUM))
    found = read(split("max(mass.[xy]), mass.vx, period( mass.x ),max(mass.x)"), names)
    assert [labelled(str(m), m.unit) for m in found] == [
        *("max(mass.x) [m]", "max(mass.y) [m]", "final(mass.vx) [m/s]", "period(mass.x) [s]"),
    ]
    assert measuring.usual(names) == ["min(mass.x)", "max(mass.x)", "min(mass.y)", "max(mass.y)"]
    for text, says in [
        ("maximum(mass.x)", "did you mean `max`"),
        ("max(mass.z)", "mass.x"),
        ("max(mass.x", "functions: final"),
        ("max(min(mass.x))", "one signal"),
        ("__import__('os')", "__import__"),
    ]:
        with pytest.raises(UsageError) as error:
            read([text], names)
        assert says in error.value.render(), text


def test_expressions_as_measures(store):
    """The tension is largest at the lowest point, 3 m g, and so is the speed: v^2 = 2 g L."""
    names = AskedSignals(mbdsl.load(PENDULUM))
    asked = "max(hypot(rod.fx, rod.fy)), max(rod.f), max(mass.v^2), maxabs(mass.m*mass.a), abs(mass.vx - 1 m/s)"
    found = read(split(asked), names)
    assert [m.unit for m in found] == ["N", "N", "m2/s2", "N", "m/s"]
    assert str(found[-1]) == "final(abs(mass.vx - 1 m/s))"
    runs = mbdsl.sweep(PENDULUM, {"m": [2.0, 3.0]}, asked, store=store, workers=1, **RUN)
    for text in ("max(hypot(rod.fx, rod.fy))", "max(rod.f)"):
        np.testing.assert_allclose(runs[text], 3.0 * 9.81 * np.array([2.0, 3.0]), rtol=2e-4)
    np.testing.assert_allclose(runs["max(mass.v^2)"], 2.0 * 9.81 * 1.0, rtol=2e-4)
    for text in ("max(rod.f) - min(rod.f)", "max(rod.fx, rod.fy)"):
        with pytest.raises(UsageError, match="one signal in the parentheses"):
            read([text], names)
    with pytest.raises(UsageError, match=r"no signal `rod\.fq`"):
        read(["max(hypot(rod.fx, rod.fq))"], names)


# -- runs --------------------------------------------------------------------------------------------------------------


def test_closed_forms(lengths):
    """Period, amplitude, and the force of the rod, which is 3 m g in the lowest position.

    The error of a step of 2 ms is 2e-5 of the period here; the force is sampled every 2 ms, up to 1 ms from its
    maximum, where it is lower by 3 m g (w t)^2/2 with w = 9 rad/s: 1e-4.
    """
    L = lengths["L"]
    assert L.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert lengths.unit("L") == "m" and lengths.unit("max(rod.fy)") == "N" and lengths.unit("period(mass.x)") == "s"
    assert lengths["period(mass.x)"][1:] == pytest.approx([period(x) for x in L[1:]], rel=2e-4)
    assert lengths["amplitude(mass.y)"][1:] == pytest.approx(L[1:] / 2.0, rel=2e-4)
    assert lengths["max(rod.fy)"][1:] == pytest.approx(3.0 * 9.81, rel=3e-4)
    quarters = lengths["time_of_max(rod.fy)"][1:] / [period(x) / 4.0 for x in L[1:]]
    assert quarters == pytest.approx(np.round(quarters), abs=0.03) and (np.round(quarters) % 2 == 1).all()


def test_a_run_that_fails_keeps_its_row(lengths):
    assert lengths.failed == [0] and len(lengths) == 5
    assert np.isnan(lengths["period(mass.x)"][0]) and "length" in lengths.reason(0)
    assert "1 of 5 runs failed" in str(lengths) and "L = 0 m: `length` of `rod` is 0" in str(lengths)


def test_rows_of_a_grid(grid):
    """All combinations, the last parameter fastest; the force is proportional to the mass, the motion independent."""
    assert grid["m"].tolist() == [1, 1, 1, 2, 2, 2] and grid["L"].tolist() == [50, 100, 150] * 2
    assert grid.unit("L") == "cm" and grid.unit("m") == "kg"
    force, x = grid.grid("max(rod.fy)"), grid.grid("final(mass.x)")
    assert force.shape == (2, 3)
    assert force[1] == pytest.approx(2.0 * force[0], rel=1e-9)
    assert x[1] == pytest.approx(x[0], abs=1e-9) and np.ptp(x[0]) > 0.1


def test_paired_parameters(store, grid):
    found = mbdsl.sweep(
        PENDULUM, {"m": [1, 2], "L": "50, 150 cm"}, "max(rod.fy), final(mass.x)", paired=True, store=store, **RUN
    )
    assert found.found == 2  # these combinations were run as part of the grid
    rows = [0, 5]
    assert found["final(mass.x)"].tolist() == grid["final(mass.x)"][rows].tolist()
    with pytest.raises(UsageError, match="no grid"):
        found.grid("final(mass.x)")
    with pytest.raises(UsageError, match="same number of values"):
        mbdsl.sweep(PENDULUM, {"m": [1, 2], "L": "1,2,3"}, paired=True, store=store)


def test_after(store):
    """The mass starts at -L with the largest distance; after a quarter of the period it is on the other side."""
    T = period(1.0)
    given = {"measures": "min(mass.x), final(mass.x)", "store": store, "step": 2e-3, "stop": T / 2, "workers": 1}
    whole = mbdsl.sweep(PENDULUM, {"L": [1.0]}, **given)
    later = mbdsl.sweep(PENDULUM, {"L": [1.0]}, after=T / 4, **given)
    assert whole["min(mass.x)"][0] == pytest.approx(-1.0) and later["min(mass.x)"][0] == pytest.approx(0.0, abs=0.01)
    assert whole["final(mass.x)"] == later["final(mass.x)"]


def test_times_with_units(store):
    vary, measures = {"L": [1.0]}, "max(mass.x)"
    plain = mbdsl.sweep(PENDULUM, vary, measures, after=1.0, interval=0.1, store=store, workers=1, **RUN)
    texts = {"after": "1 s", "interval": "100 ms", "step": "2 ms", "stop": "4000 ms", "limit": "1 min"}
    found = mbdsl.sweep(PENDULUM, vary, measures, store=store, workers=1, **texts)
    np.testing.assert_array_equal(found["max(mass.x)"], plain["max(mass.x)"])
    with pytest.raises(UsageError, match="stop: `2 m` has the wrong unit: expected s, found m"):
        mbdsl.sweep(PENDULUM, vary, measures, store=store, stop="2 m")


def test_parameters_share_compiled_code():
    """The name of compiled code is a digest of it."""
    names = set()
    for changes in ({}, {"L": 2.0}, {"L": 0.3, "m": 4.0, "g": 0.0}):
        scene = mbdsl.load(PENDULUM, changes)
        names.add(build(scene, graph.build(scene)).module_name(declared("hht-si2").sets))
    assert len(names) == 1


def test_signals_that_only_some_points_have(tmp_path, monkeypatch):
    """The number of links is a parameter; the runs themselves are replaced."""
    monkeypatch.setattr(PointRunner, "runs", lambda self, points: _blank(self.setting, points))
    vary = {"N": "1:3:3"}
    found = mbdsl.sweep(MODELS / "chain.mbd", vary, "final(link[3].phi)", store=tmp_path)
    assert str(found.measures[0]) == "final(link[3].phi)" and len(found) == 3
    with pytest.raises(UsageError, match="there is no signal"):
        mbdsl.sweep(MODELS / "chain.mbd", vary, "final(link[4].phi)", store=tmp_path)


def _blank(of, points):
    return {point: Computed(point, stats={"values": {str(m): math.nan for m in of.measures}}) for point in points}


def test_an_interrupted_sweep_continues(tmp_path):
    asked = (PENDULUM, {"L": "1:2:5"}, "final(mass.x)")
    given = {"step": 5e-3, "stop": 0.5, "workers": 1, "store": tmp_path}
    kept = []

    def interrupt(progress):
        kept.append(progress.kept)
        if progress.done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mbdsl.sweep(*asked, tell=interrupt, **given)
    again = mbdsl.sweep(*asked, **given)
    assert kept[-1] == again.found == 3
    assert mbdsl.sweep(*asked, **given).found == 5
    fresh = mbdsl.sweep(*asked, fresh=True, **given)
    assert fresh.found == 0 and fresh["final(mass.x)"].tolist() == again["final(mass.x)"].tolist()


def test_stored_runs_are_those_of_the_same_model_and_measures(tmp_path):
    copy = tmp_path / "copy.mbd"
    copy.write_text(PENDULUM.read_text(encoding="utf-8"), encoding="utf-8")
    vary, given = {"L": [1.0]}, {"step": 5e-3, "stop": 0.1, "workers": 1, "store": tmp_path / "runs"}
    assert mbdsl.sweep(copy, vary, "mass.x", **given).found == 0
    assert mbdsl.sweep(copy, vary, "mass.x", **given).found == 1
    assert mbdsl.sweep(copy, {"L": ["100 cm"]}, "mass.x", **given).found == 0
    assert mbdsl.sweep(copy, vary, "mass.y", **given).found == 0
    assert mbdsl.sweep(copy, vary, "mass.x", parameters={"m": 2}, **given).found == 0
    assert mbdsl.sweep(copy, vary, "mass.x", after=0.05, **given).found == 0
    assert mbdsl.sweep(copy, vary, "mass.x", **{**given, "stop": 0.2}).found == 0
    assert mbdsl.sweep(copy, vary, "mass.x", method="hht-i3", **given).found == 0
    copy.write_text(PENDULUM.read_text(encoding="utf-8").replace("9.81", "9.80"), encoding="utf-8")
    assert mbdsl.sweep(copy, vary, "mass.x", **given).found == 0


def test_several_processes(tmp_path, monkeypatch, lengths):
    monkeypatch.setattr(running, "ALONE", -1.0)
    names = [str(m) for m in lengths.measures]
    found = mbdsl.sweep(PENDULUM, {"L": "0:1:5"}, names, store=tmp_path, workers=2, **RUN)
    assert found.found == 0
    for name in names:
        np.testing.assert_array_equal(found[name], lengths[name])
    assert found.reason(0) == lengths.reason(0)


def test_a_run_beyond_the_limit_is_not_stored(tmp_path):
    """The step of 1 us takes several seconds."""
    asked = {"step": 1e-6, "stop": 10.0, "limit": 0.2, "workers": 1, "store": tmp_path, "interval": 0.1}
    found = mbdsl.sweep(PENDULUM, {"L": [1.0]}, "mass.x", **asked)
    assert found.failed == [0] and found.reason(0) == "not finished within 0.2 s"
    assert not list(tmp_path.glob("*.npz"))


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (("--vary", "Lx=1:2:3"), 2, "did you mean `L`?"),
        (("--vary", "L=1:2:3", "--vary", "L=4"), 2, "varied twice"),
        (("--vary", "L=1:2:3", "--set", "L=1"), 2, "set and varied"),
        (("--vary", "L=1:2:1000", "--vary", "m=1:2:1000"), 2, "1000 x 1000 = 1000000 runs are too many"),
        (("--vary", "L=1:2:3", "--measure", "max(mass.z)"), 2, "there is no signal `mass.z`"),
        (("--vary", "L=1:2:3", "--output", "a.xls"), 2, "known suffixes are .md"),
        (("--vary", "L=1:2:3", "--method", "hht"), 2, "did you mean"),
        (("--vary", "L=1:2:3", "--after", "9s"), 2, "the runs end at 4 s"),
        (("--vary", "L=-1:-2:3"), 2, "it must be positive"),
        (("--vary", "L=1:2:3 kg"), 2, "expected a length"),
        ((), 2, "--vary"),
    ],
)
def test_wrong_commands(say, arguments, code, says):
    found, _, err = say("sweep", PENDULUM, "--step", "2ms", "--stop", "4s", *arguments)
    assert found == code and says in err


def test_command(say, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    arguments = ("sweep", PENDULUM, "--vary", "L=0:1:3", "--step", "5ms", "--stop", "0.5s", "--measure", "mass.x")
    code, out, err = say(*arguments, "--output", "out.csv", "--output", "out.svg")
    assert code == 4 and "1 of 3 runs failed" in out and "out.csv: 3 runs\nout.svg: 3 runs" in out
    assert "<svg" in (tmp_path / "out.svg").read_text(encoding="utf-8")
    assert max(map(len, out.splitlines())) <= 100
    code, out, err = say(*arguments, "--quiet")
    assert (code, out) == (4, "") and "1 of 3 runs failed" in err
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out.csv").read_text(encoding="utf-8"))))
    assert [row["L [m]"] for row in rows] == ["0.0", "0.5", "1.0"]
    assert rows[0]["final(mass.x) [m]"] == "" and "must be positive" in rows[0]["outcome"]
    assert rows[2]["outcome"] == "done"


def test_a_long_table_is_shortened_and_a_wide_one_continued(grid):
    text = grid.text(width=40, most=4)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 40 and "... 2 rows" in text
    assert sum(line.split()[:1] == ["m"] for line in lines) == 2  # both blocks begin with the parameters


# -- files -------------------------------------------------------------------------------------------------------------


def test_pandas_reads_the_csv(grid, lengths, tmp_path):
    grid.save(tmp_path / "a.csv")
    read = pandas.read_csv(tmp_path / "a.csv", dtype=str)  # versions of pandas read numbers with different rounding
    assert [float(x) for x in read["max(rod.fy) [N]"]] == grid["max(rod.fy)"].tolist()
    assert [float(x) for x in read["L [cm]"]] == grid["L"].tolist() and set(read["outcome"]) == {"done"}
    data = grid.to_pandas()
    assert list(data.columns) == list(read.columns) and data["L [cm]"].tolist() == grid["L"].tolist()
    lengths.save(tmp_path / "b.csv")
    assert pandas.read_csv(tmp_path / "b.csv")["period(mass.x) [s]"].isna().tolist() == [True] + 4 * [False]


def test_python_markdown_reads_the_table(lengths, tmp_path):
    lengths.save(tmp_path / "a.md")
    html = markdown.markdown((tmp_path / "a.md").read_text(encoding="utf-8"), extensions=["tables"])
    table = _table(html)
    assert list(table.columns)[:2] == ["L [m]", "period(mass.x) [s]"]
    assert [float(x) for x in table["period(mass.x) [s]"][1:]] == pytest.approx(lengths["period(mass.x)"][1:], rel=1e-5)
    assert "max(rod.fy) [N]" in table.columns and "<em>" not in html


def _table(html):
    root = ET.fromstring(f"<x>{html}</x>")
    heads = ["".join(cell.itertext()) for cell in root.iter("th")]
    rows = [["".join(cell.itertext()) for cell in row.iter("td")] for row in root.iter("tr")]
    return pandas.DataFrame([row for row in rows if row], columns=heads)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="LaTeX is not installed")
def test_latex_compiles(lengths, grid, tmp_path):
    for name, sweep in (("a", lengths), ("b", grid)):
        sweep.save(tmp_path / f"{name}.tex")
    main = r"\documentclass{article}\begin{document}\input{a.tex}\par\input{b.tex}\end{document}"
    (tmp_path / "main.tex").write_text(main, encoding="utf-8")
    command = ("pdflatex", "-interaction=nonstopmode", "-halt-on-error", "main.tex")
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout[-2000:]


def test_pictures(lengths, grid, tmp_path):
    for suffix in (".svg", ".png", ".pdf", ".html"):
        lengths.save(tmp_path / f"curves{suffix}")
    grid.save(tmp_path / "family.svg")
    for name in ("curves", "family"):
        assert "L [" in "".join(ET.parse(tmp_path / f"{name}.svg").getroot().itertext())
    pdf = (tmp_path / "curves.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-") and b"/FontFile2" in pdf and b"/Type3" not in pdf  # TrueType, embedded
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")
    figure = lengths.plot().panels[0]
    assert (figure.series[0].x, figure.y_label) == ([0.0, 0.25, 0.5, 0.75, 1.0], "period(mass.x) [s]")
    assert [outcome.x for outcome in figure.outcomes] == [0.0]
    family = grid.plot().panels[0]
    assert [series.name for series in family.series] == ["m = 1 kg", "m = 2 kg"] and family.x_label == "L [cm]"
    assert family.series[1].y == pytest.approx(2.0 * np.array(family.series[0].y))


def test_a_map_has_the_values_of_the_grid(tmp_path):
    """Two parameters with more values than a frame has curves."""
    vary = [varied("a", "1:9:9"), varied("b", "1:1000:10:log"), varied("c", "5,6")]
    indices = [(i, j, k) for i in range(9) for j in range(10) for k in range(2)]
    values = [vary[0].numbers[i] + 100.0 * vary[2].numbers[k] + math.log10(vary[1].numbers[j]) for i, j, k in indices]
    case = SweepPoint("hht-si2")
    runs = [Computed(case, stats={"values": {"max(x)": value}}) for value in values]
    runs[3] = Computed(case, problem="it failed")
    found = Sweep("M", vary, [Measure("max", "x", "m")], indices, runs)
    plot = found.plot()
    assert [m.title for m in plot.panels] == ["c = 5", "c = 6"]
    shown = plot.panels[1]
    assert (shown.x_label, shown.y_label, shown.cells.label, shown.y_log) == ("a", "b", "max(x) [m]", True)
    z = np.array(shown.cells.z)
    assert z.shape == (10, 9) and np.isnan(z).sum() == 1 and np.isnan(z[1, 0])
    assert z[9, 8] == pytest.approx(9.0 + 600.0 + 3.0)
    for suffix in (".svg", ".pdf", ".html"):
        plot.save(tmp_path / f"map{suffix}")
    root = ET.parse(tmp_path / "map.svg").getroot()
    assert "map of max(x) [m] over a and b, c = 6" in str(plot) and "max(x) [m]" in repr(plot)
    texts = list(root.itertext())
    assert texts.count("max(x) [m]") == 2 and "no value" in texts and "10²" in texts
    assert b"/FontFile2" in (tmp_path / "map.pdf").read_bytes()


def test_a_file_with_several_models(tmp_path):
    """The model with the name of the file is not the last one, and workers find it by its name."""
    text = PENDULUM.read_text(encoding="utf-8")
    path = tmp_path / "pendulum.mbd"
    path.write_text(text + text.replace("Pendulum", "Other").replace("9.81", "1.62"), encoding="utf-8")
    found = mbdsl.sweep(path, {"L": [1.0]}, "max(rod.fy)", store=tmp_path / "runs", workers=1, **RUN)
    assert found.name == "Pendulum" and found["max(rod.fy)"] == pytest.approx(3.0 * 9.81, rel=3e-4)


@pytest.mark.parametrize(
    ("arguments", "says", "remedy"),
    [
        (([{"L": 1}, {"L": 2}],), "vary: found", "{'L': [1, 2]}"),
        (([{"L": 1, "m": 3}, {"L": 2, "m": 4}],), "vary: found", "{'L': [1, 2], 'm': [3, 4]}, paired=True"),
        ((3,), "vary: found 3", "by name"),
        (({"L": 3},), "found 3, expected values", "0.5,1,2"),
        (({"L": {"a": 1}},), "expected values", "0.5,1,2"),
        (({"L": [1, 2]}, max), "expected a text", "max(pin.fx)"),
        (({"L": [1, 2]}, ["max(mass.x)", len]), "expected a text", "max(pin.fx)"),
    ],
)
def test_other_arguments_are_errors_with_a_remedy(arguments, says, remedy):
    with pytest.raises(UsageError) as problem:
        mbdsl.sweep(PENDULUM, *arguments)
    assert says in problem.value.message and remedy in problem.value.hint


def builder():
    b = mbdsl.Builder("Pendulum")
    L = b.parameter("L", "1 m")
    b.Ground("ground")
    b.PointMass("mass", m="1 kg")
    b.Distance("rod", "ground.c", "mass.c", length=L)
    b.initial("mass.x", L)
    b.initial("mass.y", 0)
    return b


@pytest.mark.parametrize("made", [builder, lambda: builder().scene(), lambda: mbdsl.parse(PENDULUM.read_text())])
@pytest.mark.parametrize("workers", [1, 2])
def test_a_sweep_takes_what_simulate_takes(made, workers, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "ALONE", 0.0)
    asked = {"store": tmp_path, "workers": workers, **RUN}
    found = mbdsl.sweep(made(), {"L": [0.4, 0.6, 0.8]}, "period(mass.x)", **asked)
    np.testing.assert_allclose(found["period(mass.x)"], [period(L) for L in (0.4, 0.6, 0.8)], rtol=1e-4)
    assert mbdsl.sweep(made(), {"L": [0.6, 0.9]}, "period(mass.x)", **asked).found == 1


def test_a_scene_keeps_its_own_parameters(tmp_path):
    """And scenes that differ in what their parameters act on do not share runs."""
    asked = {"store": tmp_path, "workers": 1, **RUN}
    scene = mbdsl.load(PENDULUM, {"g": 1.62})
    found = mbdsl.sweep(scene, {"L": [0.2]}, "period(mass.x)", **asked)
    np.testing.assert_allclose(found["period(mass.x)"], [period(0.2, 1.62)], rtol=1e-4)
    other = builder()
    other.Distance("rod", "ground.c", "mass.c", length="1 m", replace=True)
    assert mbdsl.sweep(builder(), {"L": [1.0]}, "min(mass.y)", **asked).found == 0
    assert mbdsl.sweep(other, {"L": [1.0]}, "min(mass.y)", **asked).found == 0


def test_what_cannot_be_swept():
    bare = dataclasses.replace(mbdsl.load(PENDULUM), doc="")  # no origin
    with pytest.raises(UsageError, match="made neither from a text nor by a Builder"):
        mbdsl.sweep(bare, {"L": [1.0]}, "mass.x", **RUN)
    with pytest.raises(UsageError, match="a path, a Scene or a Builder"):
        mbdsl.sweep(3, {"L": [1.0]}, "mass.x", **RUN)


@pytest.mark.parametrize("given", [{"parameters": [1]}, {"options": [1]}, {"without": 3}, {"method": len}])
def test_keyword_arguments_of_a_wrong_type(given):
    for run in (lambda: mbdsl.sweep(PENDULUM, {"L": [1, 2]}, **given), lambda: mbdsl.simulate(PENDULUM, **given)):
        with pytest.raises(mbdsl.MbdslError, match="found"):
            run()


@pytest.mark.parametrize("fresh", [True, False])
def test_sources_are_read_once_and_not_for_every_run(tmp_path, monkeypatch, fresh):
    """The files of the method for the keys of stored runs, and the text of the model: both take longer than a run."""
    methods, texts = [], []

    def names_of(modules):
        methods.append(modules)
        return found(modules)

    def tokens(source):
        texts.append(source.text)
        return read_tokens(source)

    found, read_tokens = storing.names_of, parser.tokenize
    monkeypatch.setattr(storing, "names_of", names_of)
    monkeypatch.setattr(parser, "tokenize", tokens)
    model = tmp_path / "short_pendulum.mbd"
    model.write_text(PENDULUM.read_text() + "\n// read by this test only\n")
    mbdsl.sweep(model, {"L": "1:2:6"}, store=tmp_path, workers=1, step=0.01, stop=0.02, fresh=fresh)
    assert len(methods) == 1
    assert sum("read by this test only" in text for text in texts) == 1
    scene = mbdsl.load(model)
    for length in (1.25, 1.75):  # the same model again, in another way
        assert scene.changed({"L": length}).parameters["L"].value == length
    assert sum("read by this test only" in text for text in texts) == 1
