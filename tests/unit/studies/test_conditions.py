"""Measures with conditions: times, counts and values of a throw and of an oscillation against their closed forms."""

import math

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.studies import conditions, measures
from mbdsl.studies.conditions import StudyCondition

THROW = """
model Throw
  parameter Velocity v = 10 m/s;
  Ground ground;
  PointMass ball(m = 1 kg);
  FreeMotion free(ground, ball);
initial equation
  ball.x = 0 m;
  ball.y = 0 m;
  ball.vx = 3 m/s;
  ball.vy = v;
  annotation(experiment(StopTime = 2 s, Step = 1 ms));
end Throw;
"""
V, G = 10.0, 9.81
UP, DOWN = ((V + sign * math.sqrt(V**2 - 2.0 * G * 4.0)) / G for sign in (-1, 1))  #: times at a height of 4 m


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "throw.mbd"
    file.write_text(THROW)
    return file


@pytest.mark.parametrize(
    ("measure", "value", "unit"),
    [
        ("time_when(ball.y > 4 m)", UP, "s"),
        ("time_when(ball.y >= 4 m, first)", UP, "s"),
        ("time_when(ball.y > 4 m, last)", DOWN, "s"),
        ("time_when(ball.y > 4 m, count)", 1.0, ""),
        ("time_when(4 m < ball.y and ball.vy < 0)", V / G, "s"),
        ("time_when(not ball.y < 4 m or ball.x > 6 m - 1 m, last)", 2.0, "s"),
        ("time_when(ball.y > 400 cm or ball.x > 4 m, count)", 1.0, ""),
        ("time_when(ball.y > 4 m or ball.x > 5.5 m, count)", 2.0, ""),
        ("time_when(hypot(ball.vx, ball.vy) < 5 m/s)", (V - 4.0) / G, "s"),
        ("time_when(time > 1.5 s)", 1.5, "s"),
        ("time_when(ball.y < 1 m)", 0.0, "s"),  # it holds at the start
        ("time_when(ball.y < 1 m, count)", 2.0, ""),
        ("at(ball.x, ball.y > 4 m)", 3.0 * UP, "m"),
        ("at(ball.vy, ball.y > 4 m, last)", -math.sqrt(V**2 - 8.0 * G), "m/s"),
        ("at(ball.y, 500 ms)", 0.5 * V - G / 8.0, "m"),
        ("at(ball.x + ball.y, 1 s)", 3.0 + V - G / 2.0, "m"),
        ("at_max(ball.x, ball.y)", 3.0 * V / G, "m"),
        ("at_min(ball.y, abs(ball.x - 3 m))", V - G / 2.0, "m"),
        ("at_max(abs(ball.vy), ball.x)", 2.0 * G - V, "m/s"),
        ("max(ball.x*ball.vx)", 18.0, "m2/s"),
    ],
)
def test_a_throw(measure, value, unit, path, tmp_path):
    found = mbdsl.sweep(path, {"v": "10"}, measure, store=tmp_path / "runs", workers=1)
    (name,) = map(str, found.measures)
    # outputs at 1 ms: an apex is met within half of it; crossings are interpolated
    assert found[name][0] == pytest.approx(value, abs=2e-3 if measure.startswith("at_m") else 2e-6)
    assert found.unit(name) == unit
    assert name.replace(" ", "") == measure.replace(" ", "")


def test_patterns_give_several(path, tmp_path):
    found = mbdsl.sweep(path, {"v": "10"}, "at(ball.v?, ball.y > 4 m), max(ball.y)", store=tmp_path / "runs", workers=1)
    assert [str(m) for m in found.measures] == ["at(ball.vx, ball.y > 4 m)", "at(ball.vy, ball.y > 4 m)", "max(ball.y)"]


def test_what_never_happens_is_said(path, tmp_path):
    asked = ["time_when(ball.y > 6 m)", "at(ball.y, 3 s)", "time_when(ball.y > 6 m, count)"]
    found = mbdsl.sweep(path, {"v": [10, 12]}, asked, store=tmp_path / "runs", workers=1)
    assert math.isnan(found[asked[0]][0])
    assert found[asked[0]][1] == pytest.approx((12.0 - math.sqrt(144.0 - 12.0 * G)) / G, abs=1e-5)
    assert found[asked[2]].tolist() == [0.0, 1.0]
    text = " ".join(str(found).split())
    assert f"{asked[0]} has no value at v = 10 m/s: the condition never holds" in text
    assert f"{asked[1]} has no value at v = 10 m/s and 1 more: the time is outside of the run" in text


def test_the_speed_for_a_time(path, tmp_path):
    """v = h/t + g t/2 to be at 4 m after 0.5 s."""
    asked = "time_when(ball.y >= 4 m) = 500 ms"
    found = mbdsl.solve(path, {"v": "9:20 m/s"}, asked, store=tmp_path / "runs", workers=1)
    assert abs(found["v"] - (8.0 + G / 4.0)) < max(found.error("v"), 1e-5)
    with pytest.raises(
        UsageError, match=r"no run of the range gives a value; v = 1 m/s: .*, the condition never holds"
    ):
        mbdsl.solve(path, {"v": "1:2 m/s"}, asked, store=tmp_path / "runs", workers=1)


@pytest.mark.parametrize(
    ("text", "spans"),
    [
        ("a > 0.25", [(0.5, 1.5)]),
        ("a < 0.25", [(0.0, 0.5), (1.5, 3.0)]),
        ("a > 0.25 and b > 0.25", [(1.25, 1.5)]),  # between two outputs
        ("not (a > 0.25 and b > 0.25)", [(0.0, 1.25), (1.5, 3.0)]),
        ("a > 0.25 or a <= 0.25", [(0.0, 3.0)]),
        ("a > 2", []),
        ("a <= 2", [(0.0, 3.0)]),
    ],
)
def test_spans_of_lines(text, spans):
    """a = 0, 0.5, 0, 0.25 and b = 0, 0, 1, 1 at 0, 1, 2, 3, linear between."""
    a, b = np.array([0.0, 0.5, 0.0, 0.25]), np.array([0.0, 0.0, 1.0, 1.0])

    class Names:
        def select(self, names):
            return names

    when = conditions.read(text, Names())
    assert isinstance(when, StudyCondition)
    found = when.spans(np.arange(4.0), [eval(x, {"a": a, "b": b}) for x in when.differences])
    np.testing.assert_allclose(found, np.reshape(spans, (-1, 2)))


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        ("time_when(ball.y)", "found `ball.y`, expected a comparison by <, <=, > or >="),
        ("time_when(ball.y == 4 m)", "found `ball.y == 4 m`, expected a comparison"),
        ("time_when(ball.y > 4 s)", "ball.y"),
        ("time_when(ball.z > 4 m)", "there is no signal `ball.z`"),
        ("time_when(ball.y > 4 m, often)", "expected time_when(CONDITION[, first|last|count])"),
        ("time_when()", "is not a measure"),
        ("at(ball.y)", "expected at(SIGNAL, TIME|CONDITION[, first|last])"),
        ("at(ball.y, 3 m)", "at: `3 m` has the wrong unit"),
        ("at(ball.y, ball.x > 1 m, count)", "expected at(SIGNAL, TIME|CONDITION[, first|last])"),
        ("at_max(ball.y)", "expected at_max(SIGNAL, OTHER)"),
        ("at_max(ball.y, ball.v?)", "the second argument is one signal"),
        ("at_max(ball.y, ball.q)", "there is no signal"),
        ("time_whne(ball.y > 4 m)", "there is no measure `time_whne`"),
        ("time_when(ball.y > )", "is not a condition"),
    ],
)
def test_messages(measure, message):
    names = AskedSignals(mbdsl.parse(THROW))
    with pytest.raises(UsageError) as problem:
        measures.read([measure], names)
    assert message in problem.value.message
