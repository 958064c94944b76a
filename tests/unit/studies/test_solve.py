"""Solve: closed forms of runs, equilibria and modes, errors that contain the truth, roots of functions, messages."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk

import mbdsl
from mbdsl import cli
from mbdsl.errors import UsageError
from mbdsl.studies import solution
from mbdsl.studies import solve as solving
from mbdsl.studies.measures import Measure
from mbdsl.studies.solution import Condition
from mbdsl.studies.store import Computed
from mbdsl.studies.sweep_values import interval

PENDULUM = Path(__file__).parents[3] / "models" / "pendulum.mbd"
LENGTH = 9.81 * (3.0 / (4.0 * ellipk(0.5))) ** 2  #: of a pendulum with a period of 3 s, released at 90 degrees
MASS = """
model Scale
  parameter Mass m = 2 kg;
  parameter TranslationalSpringConstant k = 1 N/mm;
  parameter Real zeta = 0.1;
  Ground ground(frames(up = {0 m, 0 m, 90 deg}));
  PointMass load(m = m);
  Prismatic guide(ground.up, load);
  SpringDamper spring(ground, load, k = k, c = 2*zeta*sqrt(k*m), s0 = 1 m);
initial equation
  load.y = -1 m;
end Scale;
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return tmp_path_factory.mktemp("runs")


@pytest.fixture
def scale(tmp_path):
    path = tmp_path / "scale.mbd"
    path.write_text(MASS)
    return path


def test_a_measure_that_is_zero_is_shown_as_zero(store):
    """A lift exp(b) carries a weight of 2 at b = ln 2, and leaves rounding; the text has the required value."""
    model = """model Zero
      parameter Real b = 0;
      Ground ground(g = 1);
      PointMass mass(m = 2 kg);
      Prismatic guide(ground, mass);
      TranslationalSpringDamper spring(guide, k = 1 N/m);
      Force lift(mass, fy = exp(b)*1 N);
    end Zero;"""
    found = mbdsl.solve(mbdsl.parse(model), {"b": "-1:1.3"}, "static(guide.fy) = 0 mN", store=store, workers=1)
    assert abs(found["b"] - math.log(2.0)) < 1e-7
    assert "where static(guide.fy) = 0 mN\n" in str(found)


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", [{"step": 1e-2}, {"tol": 1e-4, "interval": 0.02}])
def test_the_period_of_a_pendulum_with_an_error_that_contains_the_truth(how, store):
    found = mbdsl.solve(
        PENDULUM, {"L": "1000:2000 mm"}, "period(mass.x) = 3 s", stop=4.0, store=store, workers=1, **how
    )
    assert len(found.answers) == 1
    assert abs(found["L"] - 1e3 * LENGTH) < found.error("L") < 10.0


def test_two_values_of_two_measures(store):
    """The largest force of a pendulum that is released at 90 degrees is 3 m g."""
    vary = {"L": "1:2 m", "m": (0.1, "4 kg")}
    asked = ["period(mass.x) = 3 s", "max(rod.fy) = 0.1 kN"]
    found = mbdsl.solve(PENDULUM, vary, asked, stop=4.0, step=5e-3, store=store, workers=1)
    assert abs(found["L"] - LENGTH) < found.error("L") < 1e-2
    assert abs(found["m"] - 100.0 / (3.0 * 9.81)) < found.error("m") < 1e-2
    assert "max(rod.fy) = 0.1 kN" in str(found)


@pytest.mark.parametrize(
    ("name", "within", "condition", "value"),
    [
        ("k", "0.1:100:log N/mm", "static(load.y) = -1010 mm", 2.0 * 9.81 / 10.0),  # m g/k, in N/mm
        ("m", "1:10 kg", "static(spring.force) = 49.05 N", 5.0),
        ("m", (1.0, 10.0), "frequency(1) = 2 Hz", 1000.0 / (4.0 * math.pi) ** 2),
        ("zeta", "0:0.9", "damped_frequency(1) = 3 Hz", math.sqrt(1.0 - (6.0 * math.pi) ** 2 / 500.0)),
    ],
)
def test_equilibria_and_modes(name, within, condition, value, scale, store):
    found = mbdsl.solve(scale, {name: within}, condition, store=store, workers=1)
    assert found[name] == pytest.approx(value, rel=1e-5)
    assert not [run.stats for run in found.sweep.runs if "steps" in run.stats]  # no simulation
    assert condition in str(found)


def test_an_equilibrium_and_a_mode_together(scale, store):
    found = mbdsl.solve(scale, {"m": "1:10 kg", "k": "0.2:5 N/mm"},
                        ["static(spring.force) = 49.05 N", "frequency(1) = 2 Hz"], store=store, workers=1)  # fmt: skip
    assert found["m"] == pytest.approx(5.0, rel=1e-6)
    assert found["k"] == pytest.approx(5.0 * (4.0 * math.pi) ** 2 / 1000.0, rel=1e-6)


def test_sweeps_measure_equilibria_and_modes(scale, store):
    found = mbdsl.sweep(scale, {"m": [1, 4]}, "static(spring.force), frequency(1), damping(1), frequency(2)",
                        store=store, workers=1)  # fmt: skip
    np.testing.assert_allclose(found["static(spring.force)"], [9.81, 39.24])
    np.testing.assert_allclose(found["frequency(1)"], np.sqrt(1000.0 / np.array([1.0, 4.0])) / (2.0 * math.pi))
    np.testing.assert_allclose(found["damping(1)"], 0.1)
    assert np.isnan(found["frequency(2)"]).all()  # there is one mode
    assert [found.unit(str(m)) for m in found.measures] == ["N", "Hz", "", "Hz"]


# -- roots -------------------------------------------------------------------------------------------------------------


class Given(solving._Runs):
    """Runs whose measures are those of functions; nan is a run that has failed."""

    def __init__(self, functions, *ranges):
        self.functions, self.done, self.calls = functions, {}, 0
        self.ranges = [interval(f"x{k}", given) for k, given in enumerate(ranges)]
        self.measures = [Measure("final", f"s{k}", "m") for k in range(len(functions))]

    def __call__(self, *us):
        for x in map(self.values, us):
            if x not in self.done:
                self.calls += 1
                values = {str(m): f(*x) for m, f in zip(self.measures, self.functions, strict=True)}
                lost = any(map(math.isnan, values.values()))
                self.done[x] = Computed(None, stats={"values": values}, problem="it fell over" if lost else "")
        return np.array([[f(*self.values(u)) for f in self.functions] for u in us])


def one(function, target, within):
    runs = Given([function], within)
    found, notes = solving._one(runs, np.array([target]), [Condition(runs.measures[0], target, "m")])
    return sorted(runs.values(u)[0] for u in found), notes, runs


@pytest.mark.parametrize(
    ("function", "target", "within", "roots"),
    [
        (lambda x: x**3, 8.0, "0:10", [2.0]),
        (lambda x: x, 0.0, "0:1", [0.0]),  # at an end
        (lambda x: x, 0.5, "0:1", [0.5]),  # at a point of the scan
        (math.cos, 0.0, "0:6", [math.pi / 2, 3 * math.pi / 2]),
        (lambda x: math.log(x), math.log(30.0), "1:1e6:log", [30.0]),
        (lambda x: (x - 0.34) ** 2, 1e-4, "0:1", [0.33, 0.35]),  # both between two points of the scan
    ],
)
def test_roots(function, target, within, roots):
    found, notes, runs = one(function, target, within)
    np.testing.assert_allclose(found, roots, rtol=1e-6, atol=1e-8)
    assert notes == []
    assert runs.calls < 45


def test_a_jump_is_no_answer():
    found, notes, _ = one(lambda x: math.copysign(1.0, x - 0.42), 0.3, "0:1")
    assert found == []
    assert len(notes) == 1
    assert re.fullmatch(r"final\(s0\) jumps over 0.3 m at x0 = 0.42", notes[0])


def test_a_root_among_runs_that_fail():
    found, notes, _ = one(lambda x: math.nan if 0.41 < x < 0.43 else x - 0.42, 0.0, "0:1")
    assert found == []
    assert notes == ["runs fail between x0 = 0.4 and x0 = 0.5, where final(s0) = 0 m is passed"]


@pytest.mark.parametrize("start", [0.05, 0.5, 0.93])
def test_two_roots_of_a_pair_of_functions(start):
    """A circle and a line through its centre, from a grid that does not contain the answer."""
    runs = Given([math.hypot, lambda x, y: y - math.tan(start) * x], "0.1:2", "0.1:2")
    target = np.array([1.0, 0.0])
    found, _ = solving._two(runs, target, [])
    expected = (math.cos(start), math.sin(start))
    if min(expected) < 0.1:
        assert found == []
    else:
        np.testing.assert_allclose(runs.values(found[0]), expected, rtol=1e-6)


# -- without an answer, and messages -----------------------------------------------------------------------------------


def test_what_was_reached(tmp_path, capfd):
    words = ["solve", str(PENDULUM), "--vary", "L=1:2m", "--for", "max(mass.vx) = 36 km/h", "--stop", "4s"]
    assert cli.main([*words, "--output", str(tmp_path / "runs.csv")]) == 4
    out, err = capfd.readouterr()
    assert "no answer for max(mass.vx) = 36 km/h from L = 1 m to 2 m" in err
    slow, fast = (3.6 * math.sqrt(2.0 * 9.81 * length) for length in (1.0, 2.0))
    reached = re.search(r"is from (\S+) km/h \(L = 1 m\) to (\S+) km/h \(L = 2 m\)", err)
    assert [float(x) for x in reached.groups()] == pytest.approx([slow, fast], rel=1e-4)
    assert "runs.csv: 11 runs" in out
    assert len((tmp_path / "runs.csv").read_text().splitlines()) == 12


def test_a_measure_that_does_not_depend_on_the_parameter(store):
    found = mbdsl.solve(PENDULUM, {"m": (1, 2)}, "frequency(1) = 9 Hz", store=store, workers=1)
    assert f"frequency(1) is {math.sqrt(9.81) / (2.0 * math.pi):.6g} Hz at all of these values" in str(found)


def test_models_of_python(store):
    scene = mbdsl.load(PENDULUM)
    found = mbdsl.solve(scene, {"L": (0.1, 2)}, "frequency(1) = 1 Hz", store=store, workers=1)
    assert found["L"] == pytest.approx(9.81 / (2.0 * math.pi) ** 2, rel=1e-6)


def test_no_answer_of_two(store):
    found = mbdsl.solve(PENDULUM, {"L": (1, 2), "m": (1, 2)}, ["static(rod.fy) = 9.81 N", "frequency(1) = 9 Hz"],
                        store=store, workers=1)  # fmt: skip
    assert not found
    closest = 9.81 / (2.0 * math.pi * math.sqrt(9.81))
    assert f"closest: static(rod.fy) = 9.81 N and frequency(1) = {closest:.6g} Hz (L = 1 m, m = 1 kg)" in str(found)
    with pytest.raises(UsageError, match="no answer for static"):
        found["L"]


@pytest.mark.parametrize(
    ("vary", "conditions", "message", "hint"),
    [
        ({"L": "1:2"}, "max(mass.x)", "`max(mass.x)` is not a condition", "a condition is an equation"),
        ({"L": "1:2"}, "max(mass.x) < 1 m", "`max(mass.x) < 1 m` is not a condition", "a condition is an equation"),
        ({"L": "1:2"}, "max(mass.x) <= 1 m", "`max(mass.x) <= 1 m` is not a condition", "a condition is an equation"),
        ({"L": "1:2"}, "max(mass.x) = 1 kg", "max(mass.x): `1 kg` has the wrong unit: expected m", "max(mass.x) = 2 m"),
        ({"L": "1:2"}, "largest(mass.x) = 1", "there is no measure `largest`", ""),
        ({"L": "1:2"}, "max(mas.x) = 1", "mas.x", "mass.x"),
        ({"L": "1:2"}, "max(mass.?) = 1", "1 condition with 5 measures", "one signal of its own"),
        ({"L": "1:2"}, "frequency(x) = 1 Hz", "expected the number of a mode", "frequency(1)"),
        ({"L": "1:2"}, "frequency(1) = 30 rpm", "`30 rpm` has the wrong unit: one turn in a second is 1 Hz", "= 2 Hz"),
        ({"L": "1:2"}, "max(der(mass.x)) = 30 rpm", "max(der(mass.x))", ""),
        ({"L": "1:2"}, "frequency(0) = 1 Hz", "expected the number of a mode", "frequency(1)"),
        ({"L": "1:2", "m": "1:2"}, "max(mass.x) = 1", "2 parameters and 1 condition", ""),
        ({}, "max(mass.x) = 1", "0 parameters and 1 condition", ""),
        ({"L": "1:2:11"}, "max(mass.x) = 1", "`1:2:11` is not a range: expected start:stop", "m=100:1000 kg"),
        ({"L": "1"}, "max(mass.x) = 1", "`1` is not a range: expected start:stop", ""),
        ({"L": [1, 2, 3]}, "max(mass.x) = 1", "expected the two ends of a range", ""),
        ({"L": (1, 1)}, "max(mass.x) = 1", "both ends of the range are 1", ""),
        ({"L": "0:1:log"}, "max(mass.x) = 1", "both above zero", ""),
        ({"L": "1:2 kilo"}, "max(mass.x) = 1", "unknown unit `kilo`", ""),
        ({"Q": "1:2"}, "max(mass.x) = 1", "no parameter `Q`", ""),
        ({"L": "-2:-1"}, "max(mass.x) = 1", "`length` of `rod` is -2", ""),
    ],
)
def test_messages(vary, conditions, message, hint, store):
    with pytest.raises(mbdsl.MbdslError) as problem:
        mbdsl.solve(PENDULUM, vary, conditions, store=store, workers=1, stop=1.0)
    assert message in problem.value.message
    assert hint in (problem.value.hint or "")


def test_no_run_gives_a_value(scale, store):
    with pytest.raises(UsageError, match=r"no run of the range gives a value; m = 1 kg: frequency\(3\) has no value"):
        mbdsl.solve(scale, {"m": "1:2 kg"}, "frequency(3) = 1 Hz", store=store, workers=1)


def test_a_value_without_its_range(capfd):
    assert cli.main(["solve", str(PENDULUM), "--vary", "L", "--for", "max(mass.x) = 1"]) == 2
    assert "--vary: found `L`, expected NAME=START:STOP" in capfd.readouterr().err


def test_the_digits_that_an_error_leaves():
    assert solution._with_error(431.7243, 0.03, "kg") == "431.72 kg +- 0.03 kg"
    assert solution._with_error(0.0, 0.1, "") == "0 +- 0.1"
    assert solution._with_error(1.0, math.nan, "m") == "1 m (error not known)"


def test_conditions_show_the_unit_that_was_given():
    condition = Condition(Measure("max", "w", "rad/s"), math.pi, "rpm")
    assert str(condition) == "max(w) = 30 rpm"
    assert str(replace(condition, unit="rad/s")) == "max(w) = 3.14159 rad/s"
