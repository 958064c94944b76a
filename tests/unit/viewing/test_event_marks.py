"""Marks of events in plots and on the time line of the player, at times in closed form."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators.event_list import EventGroup
from mbdsl.plotting.signal_panels import with_events
from mbdsl.results.stored import open_result
from mbdsl.simulation.event_marks import APART, TICKS, Mark
from mbdsl.simulation.stored_events import of_meta, text_of
from mbdsl.viewing.signals import signals
from mbdsl.viewing.stored_result import stored_trajectory

BALL = """model M
  Ground ground;
  PointMass ball(m = 1 kg);
  Contact floor(gap = ball.y, e = 0.8);
  Integer n(start = 0);
initial equation
  ball.x = 0 m; ball.vx = 0 m/s; ball.y = 1 m; ball.vy = 0 m/s;
equation
  when sample(0, {period}) then n = pre(n) + 1; end when;
end M;"""
FIRST = np.sqrt(2 / 9.81)
#: all impacts, up to rest at FIRST (1 + e)/(1 - e)
HITS = FIRST * (1 + 2 * np.concatenate([[0], np.cumsum(0.8 ** np.arange(1, 60))]))
REST = FIRST * 1.8 / 0.2


@pytest.fixture(scope="module")
def run():
    return mbdsl.simulate(mbdsl.parse(BALL.format(period="0.5 s")), stop=5.0, method="hht-si2")


def test_events_of_contacts_are_listed(run):
    hits = [x.t for x in run.events if x.kind == "impact"]
    assert hits[:20] == pytest.approx(HITS[:20], abs=1e-9)
    assert [x.t for x in run.events if x.kind == "contact"] == pytest.approx([REST], abs=1e-6)
    assert run.stats["kinds of events"] == {"impact": len(hits), "sample": 11, "contact": 1}
    assert {x.span.line for x in run.events if x.kind == "impact"} == {4}


def test_a_joint_that_stops_and_slides_is_listed():
    """mu_s m g = 5 N holds a force of 4.5 N/s."""
    model = mbdsl.parse(
        "model M Ground g(g = 10 m/s2); Body b(m = 1 kg, I = 1 kg.m2); "
        "Prismatic rail(g, b.c, mu = 0.4, mu_s = 0.5, sticks = true); Force f(b.c, fx = 4.5 N*time/(1 s)); "
        "initial equation rail.s = 0 m; rail.v = 0 m/s; end M;"
    )
    run = mbdsl.simulate(model, stop=2.0, step=1e-2, method="hht-si2")
    slips = [x.t for x in run.events if x.kind == "slip"]
    assert slips == pytest.approx([5 / 4.5], abs=1e-8)


def test_marks_are_few_and_lines_of_plots_are_at_their_times(run):
    marks, unmarked = run.event_marks(0.0, 5.0)
    assert unmarked == 0 and [x.kind for x in marks[:3]] == ["sample", "impact", "sample"]
    impacts = [x for x in marks if x.kind == "impact"]
    assert np.diff([x.t for x in impacts]).min() >= 5.0 * APART
    assert sum(x.events for x in impacts) == run.stats["kinds of events"]["impact"]
    assert impacts[-1].text == f"{impacts[-1].events} × impact of floor, line 4"
    plot = run.plot(["ball.y", "ball.vy"])
    for panel in plot.panels:
        lines = {series.name: series for series in panel.series if series.style == "guide"}
        assert set(lines) == {"impact (line 4)", "contact (line 4)", "sample (line 9)"}
        impacts = lines["impact (line 4)"]
        assert impacts.x[0] == impacts.x[1] == pytest.approx(FIRST, abs=1e-9)
    assert not any(s.style == "guide" for p in run.plot("ball.vy", against="ball.y").panels for s in p.series)


@pytest.mark.parametrize(("count", "name"), [(1, "when (line 1)"), (3, "when (lines 1, 2, 3)"), (4, "when")])
def test_a_legend_names_the_lines_of_few_events(run, count, name):
    found = [Mark(0.1 * k, "when", 1, f"when, line {k}", f"{k}") for k in range(1, count + 1)]
    result = SimpleNamespace(events=lambda start, stop: (found, 0))
    figures, _ = with_events(run.plot("ball.y").panels[:1], [result], ["run"])
    assert [x.name for x in figures[0].series if x.style == "guide"][-1] == name


def test_results_with_the_same_label_keep_their_marks(run):
    results = [SimpleNamespace(events=lambda start, stop, t=t: ([Mark(t, "when", 1, "", "3")], 0)) for t in (0.1, 0.2)]
    figures, _ = with_events(run.plot("ball.y").panels[:1], results, ["run", "run"])
    (marks,) = [x for x in figures[0].series if x.name == "when (line 3), run"]
    assert marks.x[::3] == [0.1, 0.2]


def test_many_ticks_are_left_out_and_said():
    run = mbdsl.simulate(mbdsl.parse(BALL.format(period="1 ms")), stop=1.0, method="hht-si2", step=1e-3)
    marks, unmarked = run.event_marks(0.0, 1.0)
    assert unmarked == 1001 > TICKS and {x.kind for x in marks} == {"impact"}
    assert "1001 ticks of clocks are not marked." in run.plot("ball.y").notes


def test_the_time_line_has_marks_and_a_key_goes_to_them(run, browser, tmp_path):
    run.animate(tmp_path / "page.html")
    browser.open(tmp_path / "page.html")
    browser.value("play(false); seek(0.1); 0")
    place = "[...document.querySelectorAll('#line i')].map((x) => [x.title, x.style.left])"
    marks = browser.value(place)
    assert len(marks) == len(run.event_marks(0.0, 5.0)[0])
    title, left = marks[1]
    assert title.startswith("impact of floor, line 4, t = 0.451524 s")
    assert float(left.removeprefix("calc(").split("%")[0]) == pytest.approx(100 * FIRST / 5.0, abs=1e-3)
    for expected in (FIRST, 0.5, 1.0, HITS[1]):
        browser.key("e", 69, "e")
        assert browser.state()["time"] == pytest.approx(expected, abs=1e-6)
    assert browser.value("document.body.classList.contains('with-events')")
    assert "impact of floor, line 4" in browser.value("noted().map((note) => [note].flat()[0])")


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".mat", ".nc"])
def test_result_files_keep_events(run, suffix, tmp_path):
    """Marks of plots and of the player made from a file are those of the run; those of earlier results are gone."""
    file = tmp_path / f"run{suffix}"
    run.save(file)
    opened = open_result(file)
    plot = mbdsl.plot(str(file), signals="ball.y")
    lines = {series.name: series.x for series in plot.panels[0].series if series.style == "guide"}
    own = {series.name: series.x for series in run.plot("ball.y").panels[0].series if series.style == "guide"}
    assert set(lines) == set(own) == {"impact (line 4)", "contact (line 4)", "sample (line 9)"}
    assert all(np.allclose(lines[name], own[name], 1e-13, 0.0, equal_nan=True) for name in own)
    stored, _ = stored_trajectory(file, run.scene)
    assert [x[1:2] + x[3:] for x in stored.events] == [x[1:2] + x[3:] for x in run.events]
    assert [x.t for x in stored.events] == pytest.approx([x.t for x in run.events], rel=1e-14)
    assert [x.line for x in stored.events] == [x.line for x in run.events]
    assert stored.event_marks(0.0, 5.0)[0][-1].text == run.event_marks(0.0, 5.0)[0][-1].text
    mbdsl.results.write(file, {"time": np.linspace(0.0, 1.0, 5), "ball.y": np.zeros(5)})
    assert of_meta(open_result(file).layout.meta) == [] and opened.layout.meta["events"]
    assert [x.name for x in tmp_path.iterdir()] == [file.name]


def test_events_beside_another_table_are_not_its_own(run, tmp_path):
    run.save(tmp_path / "run.csv")
    (tmp_path / "run.csv").write_text("time,a.y\n0.0,1.0\n1.0,2.0\n")
    assert "events" not in open_result(tmp_path / "run.csv").layout.meta


@pytest.mark.parametrize("text", ["[", "3", "[[1]]", '[["a", "", null, [[1e300, 0, 1]]]]', '[["a", "", ["f"], [1]]]'])
def test_damaged_events_are_none(text):
    assert of_meta({"events": text}) == []


def test_ticks_of_a_clock_need_three_numbers_in_a_file():
    ticks = np.arange(100_001) * 0.001
    text = text_of([EventGroup("sample", None, ticks)])
    assert len(text) < 80
    assert np.abs(of_meta({"events": text})[0].times - ticks).max() < 1e-12


def test_a_pickled_run_keeps_its_events(run):
    assert pickle.loads(pickle.dumps(run)).events == run.events


def test_files_and_tables_have_discrete_variables(run, tmp_path):
    """As they do states; but studies have no errors of them, as of motions. The page has each signal once."""
    run.save(tmp_path / "run.csv")
    assert (tmp_path / "run.csv").read_text().splitlines()[0] == "time,ball.x,ball.y,ball.vx,ball.vy,n"
    assert [*run.to_pandas()] == run.default_names == ["ball.x", "ball.y", "ball.vx", "ball.vy", "n"]
    assert "n" not in run.motion_names
    assert "impact, 11 sample, 1 contact</p>" in run._repr_html_()
    shown = [x.name for x in signals(run, None).signals]
    assert "n" in shown and len({*shown}) == len(shown)
    assert [x.name for x in signals(run, ["n", "ball.y"]).signals if x.held] == ["n"]


def test_an_impact_at_the_start_is_listed():
    """A ball that leaves the floor at e v: it is back after 2 e v/g."""
    text = BALL.format(period="9 s").replace("ball.y = 1 m; ball.vy = 0 m/s;", "ball.y = 0 m; ball.vy = -5 m/s;")
    run = mbdsl.simulate(mbdsl.parse(text), stop=1.0, method="hht-si2", step=0.01)
    assert [x.t for x in run.events if x.kind == "impact"] == pytest.approx([0.0, 2 * 0.8 * 5 / 9.81], abs=1e-9)
