"""Peaks that outputs cut: a mass that drops on a stiff stop, whose largest force is known."""

import math
import pickle

import numpy as np
import pytest

import mbdsl
from mbdsl import cli
from mbdsl.simulation.cut_peaks import CutPeak

G, K, FALL = 9.81, 1e7, 1.0
CONTACT = math.sqrt(2.0 * FALL / G)  #: time of the contact, which lasts 1 ms
FORCE = G + math.sqrt(G**2 + 2.0 * K * G * FALL)  #: k s = m g + sqrt((m g)^2 + 2 k m g h), for m = 1 kg
PLANE = """model Bounce
  Ground ground; Frame up(ground.c, phi = 90 deg);
  Body ball(m = 1 kg, I = 1 kg.m2);
  Prismatic guide(up, ball.c, phi0 = -90 deg);
  TranslationalStop floor(guide, s_min = 0 m, k = 1e7 N/m);
initial equation guide.s = 1 m; guide.v = 0 m/s;
annotation(experiment(StopTime = 0.8 s)); end Bounce;"""
SPACE = PLANE.replace("model Bounce", "spatial model Bounce", 1).replace("I = 1 kg.m2", "I = {1, 1, 1} kg.m2")
SPACE = SPACE.replace("Frame up(ground.c, phi = 90 deg);", "").replace(
    "Prismatic guide(up, ball.c, phi0 = -90 deg)", "Prismatic guide(ground.c, ball.c, n = {0, 1, 0})"
)


@pytest.fixture(scope="module", params=["plane", "space"])
def scene(request):
    return mbdsl.parse(PLANE if request.param == "plane" else SPACE)


#: settings, and the relative error of the largest force; fixed steps have (omega h)^2/12 = 0.8 % of the stiffness
HOW = (
    ({"method": "radau5"}, 1e-6),
    ({"method": "dop853"}, 5e-6),  # a contact takes few steps
    ({"tol": 1e-5, "method": "hht-si2"}, 1e-5),
    ({"step": 1e-4}, 0.012),
)


@pytest.mark.parametrize(("how", "near"), HOW, ids=str)
def test_the_largest_force_of_an_impact(scene, how, near):
    run = mbdsl.simulate(scene, interval="7.9 ms", **how)
    assert np.abs(run["floor.force"]).max() < 0.5 * FORCE  # no output is within the contact, or near its middle
    (found,) = run.cut_peaks("floor.force")
    assert abs(found.value) == pytest.approx(FORCE, rel=near)
    # the largest depth, where g/w sin(w t) + v cos(w t) = 0
    w = math.sqrt(K)
    largest = CONTACT + (math.pi - math.atan(math.sqrt(2.0 * G * FALL) * w / G)) / w
    assert found.time == pytest.approx(largest, abs=1e-6 + 2.0 * near / w)
    assert (found.signal, found.unit, abs(found.shown)) == ("floor.force", "N", 0.0)
    assert str(found).startswith(
        f"floor.force is {found.value:.4g} N at t = {found.time:.6g} s, but the lowest output is 0 N"
    )
    (found,) = run.cut_peaks("ball.a")  # m a = F - m g
    assert found.value == pytest.approx(FORCE - G, rel=near)
    (found,) = run.cut_peaks("2*floor.force")
    assert abs(found.value) == pytest.approx(2.0 * FORCE, rel=near)


def test_what_has_no_cut_peaks(scene):
    """Positions are not cut; every step is shown; parts, copies without steps and smooth models know nothing."""
    run = mbdsl.simulate(scene, method="radau5", interval="7.9 ms")
    assert run.cut_peaks() == []
    assert run[0.0:0.4].cut_peaks("floor.force") == []
    assert len(run[0.4:0.5].cut_peaks("floor.force")) == 1
    assert pickle.loads(pickle.dumps(run)).cut_peaks("floor.force") == []
    assert mbdsl.simulate(scene, method="radau5", interval=0).cut_peaks("floor.force") == []
    text = "model P Ground ground; Body b(m = 1 kg, length = 1 m); Revolute A(ground, b.a); end P;"
    assert mbdsl.simulate(mbdsl.parse(text), stop=1.0, step=1e-3).cut_peaks("A.f") == []


def test_rounding_at_rest_is_no_peak():
    """A body that rests on two stops, where a run begins, moves by rounding only."""
    stops = "".join(f"TranslationalStop s{x}(ground.up, b.{x}, s_min = 0 m, k = 1e5 N/m);" for x in "ab")
    text = "model P Ground ground(frames(up = {0, 0, 70 deg})); Body b(m = 20 kg, I = 2 kg.m2, length = 1 m);"
    block = "TranslationalStop t(ground, b.b, s_max = 1 m, k = 1e5 N/m);"
    scene = mbdsl.parse(f"{text} {stops} {block} initial equation b.phi = -20 deg; end P;")
    assert mbdsl.simulate(scene, stop=2.0, initial="static").cut_peaks() == []


def test_texts():
    assert str(CutPeak("a.f", "N", -1234.5678, 0.25, -0.0)) == (
        "a.f is -1235 N at t = 0.25 s, but the lowest output is 0 N"
    )
    assert str(CutPeak("u", "", 2.0, 1.0, 1.5)) == "u is 2 at t = 1 s, but the highest output is 1.5"


def test_notes_of_the_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bounce.mbd").write_text(PLANE)
    words = ["--method", "radau5", "--interval", "7.9ms"]
    assert cli.main(["simulate", "bounce.mbd", *words, "--signals", "floor.force,guide.s"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("note: ")]
    assert len(lines) == 1 and lines[0].startswith("note: floor.force is -1.")
    assert lines[0].endswith("but the lowest output is 0 N (--interval 0 writes every step)")
    assert cli.main(["simulate", "bounce.mbd", *words, "--signals", "floor.force", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    found = mbdsl.plot("bounce.mbd", "floor.force", method="radau5", interval="7.9 ms")
    assert any(note.startswith("Between outputs: floor.force is -1.") for note in found.notes)
