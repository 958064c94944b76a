"""The page of a report: its content against the trajectory and the files, its policy, and how a browser shows it."""

import hashlib
import html
import json
import re
from functools import partial

import numpy as np
import pytest

from mbdsl import parse
from mbdsl.errors import UsageError
from mbdsl.explanation.receipt import explain
from mbdsl.mechanism.graph import build
from mbdsl.reporting.highlighting import highlighted
from mbdsl.reporting.report import Report, report
from mbdsl.reporting.run_figures import CHANGE, balance, energy_figures
from mbdsl.viewing.motion import motion
from mbdsl.viewing.structure import structure
from mbdsl.viewing.svg_picture import HEIGHT, WIDTH, still

PENDULUM = """model Pendulum
  parameter Length L = 1 m;  // two lines
  Ground ground; PointMass mass(m = 1 kg); Distance rod(ground, mass, length = L);
initial equation
  mass.x = L; mass.vx = 0; guess mass.y = 0;
  annotation(experiment(StopTime = 0.5 s, Step = 10 ms)); end Pendulum;
"""
EVIL = "</script><script>alert(1)</script><!-- '\" \u202e"


def of(trajectory, **more):
    """A report without measured costs."""
    return Report(trajectory, structure(build(trajectory.scene), search=False), None, **more)


def section(text, key):
    return text.partition(f'<section id="{key}">')[2].partition("</section>")[0]


def number(text):
    """A number of the page, such as −5.2·10⁻⁵."""
    return float(text.translate(str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")).replace("·10", "e"))


@pytest.fixture(scope="module")
def page(slider_crank, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "crank.html"
    of(slider_crank, command="mbdsl report slider_crank.mbd").save(path)
    return path


def test_the_page_loads_nothing(page):
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"https?://(?!www\.w3\.org)|@import|url\((?!#)|\beval\b|new Function|style=| on\w+=\"", text)
    assert not re.search(r'<(?:link|img|base|object)|<\w+[^>]* src="', text)
    ids = re.findall(r'<[^>]* id="([^"]+)"', re.sub(r'srcdoc="[^"]*"', "", text))
    assert len(ids) == len(set(ids))
    assert set(re.findall(r"<a href=#(\w+)>", text)) <= set(ids)


def test_signals_are_those_of_the_trajectory(page, slider_crank):
    """The values under the cursor, as the page stores them, are those of the trajectory to their four digits."""
    text = section(page.read_text(encoding="utf-8"), "signals")
    found = {}
    for data in map(json.loads, re.findall(r'<script type="application/json">(.*?)</script>', text)):
        found |= dict(zip(data["names"], data["points"], strict=True))
    assert set(found) == {"O.phi", "A.phi", "B.s", "B.phi"}
    for name, points in found.items():
        assert len(points) > 50
        t, y = np.array([[number(x) for x in point[2:4]] for point in points]).T
        expected = np.interp(t, slider_crank.t, slider_crank[name])
        assert np.abs(y - expected).max() < 2e-3 * np.abs(expected).max()


def test_the_model_is_on_the_page_word_by_word(page, slider_crank):
    (source,) = slider_crank.scene.files.values()
    text = section(page.read_text(encoding="utf-8"), "model")
    code = re.search(r'<pre class="code">(.*?)</pre>', text, re.DOTALL)[1]
    assert html.unescape(re.sub("<[^>]+>", "", code)) == source.rstrip("\n")
    digest = hashlib.sha256(source.encode()).hexdigest()
    assert digest in section(page.read_text(encoding="utf-8"), "repeat")
    states = b"".join(x.astype("<f8").tobytes() for x in (slider_crank.t, slider_crank.q, slider_crank.v))
    assert hashlib.sha256(states).hexdigest() in section(page.read_text(encoding="utf-8"), "repeat")


def test_words_of_a_model_are_marked():
    text = 'model A "a // text" /* one\n two */ Ground g(g = 9.81 m/s2); // last\n'
    text += "  parameter Real x[2] = {1, 2} mm; end A;\n"
    found = highlighted(text)
    marked = [(kind, html.unescape(word)) for kind, word in re.findall(r'<span class="(\w)">(.*?)</span>', found)]
    assert marked == [
        *(("k", "model"), ("s", '"a // text"'), ("c", "/* one"), ("c", " two */"), ("e", "Ground")),
        *(("n", "9.81"), ("u", "m/s2"), ("c", "// last"), ("k", "parameter"), ("n", "2"), ("n", "1"), ("n", "2")),
        *(("u", "mm"), ("k", "end")),
    ]
    assert html.unescape(re.sub("<[^>]+>", "", found)) == text.rstrip("\n")
    assert found.count("\n") == 2


def test_energy_is_conserved_or_its_sinks_are_named(trajectory_of, slider_crank):
    """Free fall from rest: y = -g t^2/2 conserves energy; the slider crank has a damper."""
    scene = parse("model A Ground ground(g = 9.81); PointMass m(m = 2 kg); FreeMotion free(ground, m); end A;")
    t = np.linspace(0.0, 1.0, 11)
    fall = trajectory_of(scene, t, {"m": np.column_stack([0 * t, -9.81 * t**2 / 2])})
    fall.v[:] = np.column_stack([0 * t, -9.81 * t])
    assert balance(fall).startswith("No component adds or removes energy")
    energy, drift = energy_figures(fall)
    assert [s.name.rpartition(".")[2] for s in energy.series] == ["kinetic", "potential", "total"]
    np.testing.assert_allclose(energy.series[0].y, 9.81**2 * t**2, atol=1e-12)
    np.testing.assert_allclose(drift.series[0].y, 0.0, atol=1e-12)
    assert drift.series[0].name == CHANGE
    assert balance(slider_crank).endswith("Energy is added or removed by spring.")


def test_the_picture_is_where_the_mechanism_is(trajectory_of):
    """A mass at the corners of a square: four circles at its corners, and their centre is the middle."""
    scene = parse("model A Ground ground(g = 0); PointMass m(m = 1 kg); FreeMotion free(ground, m); end A;")
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    moving = motion(trajectory_of(scene, np.arange(4.0), {"m": corners}))
    found = re.findall(r'<circle [^>]*cx="([\d.]+)" cy="([\d.]+)"', still(moving, 0, "a", "title", (1, 2, 3)))
    places = np.array(found, float)[[3, 0, 1, 2]]
    side = places[1, 0] - places[0, 0]
    assert side > 0.5 * HEIGHT
    np.testing.assert_allclose(places - places[0], corners / 2 * (side, -side), atol=0.011)
    np.testing.assert_allclose(places.mean(axis=0), (WIDTH / 2, HEIGHT / 2), atol=0.011)


def test_annotated_shapes_are_drawn(trajectory_of):
    """A disc of 0.5 m that travels 2 m: its outline is half as wide as the way of its centre."""
    shape = "annotation(Shape(Circle(radius = 0.5 m)))"
    scene = parse(f"model A Ground g(g = 0); PointMass m(m = 1 kg) {shape}; FreeMotion free(g, m); end A;")
    moving = motion(trajectory_of(scene, np.arange(2.0), {"m": np.array([[0.0, 0.0], [2.0, 0.0]])}))
    ways = re.findall(r'<path fill="#[^"]*"[^>]* d="([^"]*)"', still(moving, 0, "a", "title", (1,)))
    later, first = (np.array([float(x.split()[0]) for x in re.split("[MLZ]+", way) if x]) for way in ways)
    assert np.ptp(first) == pytest.approx((later.mean() - first.mean()) / 2, abs=0.1)
    assert first.min() > 0.0 and later.max() < WIDTH


def test_a_hostile_model(trajectory_of):
    doc = json.dumps(EVIL, ensure_ascii=False)
    scene = parse(f"model A {doc} Ground ground; PointMass m(m = 1 kg); FreeMotion f(ground, m); end A;")
    text = of(trajectory_of(scene, [0.0, 1.0], {"m": np.zeros((2, 2))}), command=EVIL).html
    assert "<script>alert" not in text and "\u202e" not in text
    assert text.count("<script>") == 1


def test_states_that_are_not_numbers(trajectory_of, slider_crank):
    """A run that failed is reported, with its message and gaps in its curves."""
    broken = trajectory_of(slider_crank.scene, [0.0, 1.0, 2.0], {"crank": np.full((3, 3), np.nan)})
    broken.stats["status"], broken.message = "failed", "the step became too small"
    text = of(broken).html
    assert "Status: failed. the step became too small" in text
    assert not re.search(r"\bnan\b", section(text, "mechanism") + section(text, "signals") + section(text, "drift"))


def test_an_empty_run_and_another_suffix(trajectory_of, slider_crank, tmp_path):
    with pytest.raises(UsageError, match="the trajectory is empty"):
        report(trajectory_of(slider_crank.scene, [], {}))
    with pytest.raises(UsageError, match=r"`.*a\.pdf` does not end with \.html"):
        of(slider_crank).save(tmp_path / "a.pdf")


def test_the_page_in_a_browser(browser, page, slider_crank):
    """The animation in the page plays under the page's policy, and nothing is loaded or said, at three widths."""
    for width, scheme in ((400, "light"), (800, "dark"), (1400, "light")):
        browser.open(page, width, 900, scheme)
        assert browser.said == [] and browser.loaded == [page.as_uri()]
        assert browser.value("document.documentElement.scrollWidth") == width
        paper = browser.value("getComputedStyle(document.body).backgroundColor")
        assert paper == ("rgb(21, 24, 29)" if scheme == "dark" else "rgb(255, 255, 255)")
        sizes = browser.value(
            "[...document.querySelectorAll('section > *')].map((e) => e.getBoundingClientRect().right)"
        )
        assert max(sizes) <= width
    inside = [t for t in browser.send("Target.getTargets")["targetInfos"] if t["type"] == "iframe"]
    session = browser.send("Target.attachToTarget", targetId=inside[-1]["targetId"], flatten=True)["sessionId"]
    outside, browser.session = browser.session, session
    try:
        browser.send("Runtime.enable"), browser.send("Log.enable")
        name, speeds = browser.value(
            "[document.querySelector('h1').textContent, document.getElementById('speed').options.length]"
        )  # both are written by the page's script
        assert name == "SliderCrank" and speeds > 3
        assert browser.said == []
    finally:
        browser.session = outside


def test_the_page_on_paper(browser, page):
    browser.open(page, 720, 900)
    try:
        browser.send("Emulation.setEmulatedMedia", media="print", features=[])
        hidden = browser.value("getComputedStyle(document.querySelector('.frame')).display")
        wide = browser.value("Math.max(...[...document.querySelectorAll('svg, pre, table')].map((e) => e.scrollWidth))")
        assert hidden == "none" and wide <= 720
    finally:
        browser.send("Emulation.setEmulatedMedia", media="screen", features=[])


def test_the_command(say, tmp_path, monkeypatch):
    """The page of a model has its run's numbers, and the printed command writes the page again."""
    (tmp_path / "pendulum.mbd").write_text(PENDULUM)
    monkeypatch.setattr("mbdsl.reporting.report.explain", partial(explain, measured=False))
    code, out, err = say("report", "pendulum.mbd", "--set", "L=2 m", "--eigen", "--step", "5 ms", "--quiet")
    assert (code, out) == (0, ""), err
    text = (tmp_path / "pendulum-report.html").read_text(encoding="utf-8")
    command = "mbdsl report pendulum.mbd --set 'L=2 m' --step=0.005 --eigen"
    assert html.escape(command) in section(text, "repeat")
    (frequency,) = re.findall(
        r'<th scope="row" class="number">1</th><td class="number">([\d.]+)<', section(text, "modes")
    )
    assert float(frequency) == pytest.approx(np.sqrt(9.81 / 2.0) / (2.0 * np.pi), rel=1e-5)
    assert '<th scope="row">steps</th><td class="number">100</td>' in section(text, "run")
    assert "gravity" in section(text, "effects")
    assert text.count("<iframe") == 2
    assert section(text, "modes").count('<svg class="still"') == 1
    assert say("report", "pendulum.mbd", "--at", "start")[0] == 2
    code, _, err = say("report", "pendulum.mbd", "--out", "pendulum.mbd")
    assert code == 2 and "does not end with .html" in err
    assert (tmp_path / "pendulum.mbd").read_text() == PENDULUM


LOSES = """model M Ground ground; PointMass ball(m = 1 kg); {} Real x(start = 1);
equation der(x) = -x/(1 s); {} end M;"""


@pytest.mark.parametrize(
    ("element", "equation", "by"),
    [
        ("Contact floor(gap = ball.y, e = 0.8);", "", "removed by floor."),
        ("PointContact floor(ground, ball, e = 0.8);", "", "removed by floor.contact."),
        ("Contact floor(gap = ball.y, e = 1);", "", "No component adds"),
        (
            "FreeMotion free(ground, ball);",
            "when ball.y < 0 m then reinit(ball.vy, 1 m/s); end when;",
            "reinit(ball.vy).",
        ),
    ],
)
def test_impacts_and_reinit_change_the_energy_and_states_do_not(trajectory_of, element, equation, by):
    t = np.linspace(0.0, 1.0, 3)
    run = trajectory_of(parse(LOSES.format(element, equation)), t, {"ball": np.column_stack([t, 1.0 - t])})
    assert by in balance(run) and "der(x)" not in balance(run)


def test_the_run_lists_its_events(slider_crank):
    stats = slider_crank.stats | {"kinds of events": {"impact": 3, "when": 1}, "terminated": "done", "events": 5}
    run = slider_crank[:]
    run.stats = stats
    text = of(run).html
    assert "3 impact, 1 when" in text and "ended by terminate" in text
