"""The reference: a file of the user, a missing reference, and the effect of its NaN values on errors."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import results
from mbdsl.errors import InitialisationError, IntegrationError, ModelError, UsageError
from mbdsl.studies import reference_solution
from mbdsl.studies.cases import setting
from mbdsl.studies.convergence import convergence
from mbdsl.studies.drift import drift
from mbdsl.studies.energy import energy
from mbdsl.studies.error_measures import ErrorQuantity, error
from mbdsl.studies.recommendation import recommend
from mbdsl.studies.reference_solution import ReferenceSolution, automatic, file_points, from_file
from mbdsl.studies.runner import Runner
from mbdsl.studies.runtime import runtime
from mbdsl.studies.store import OUT_OF_TIME, Computed, Store
from mbdsl.studies.work_precision import work_precision

MODELS = Path(__file__).parents[3] / "models"
CRANK, PENDULUM = MODELS / "slider_crank.mbd", MODELS / "pendulum.mbd"


@pytest.fixture
def runner(tmp_path):
    """``runner(stop, points)`` of the slider crank."""
    return lambda stop=0.5, points=100: Runner(setting(CRANK, stop, points=points), Store(tmp_path), budget=1.0)


def test_a_file_that_is_no_reference(runner, tmp_path):
    solution = mbdsl.simulate(CRANK, stop=0.5, interval=0.01)
    path = tmp_path / "wrong.csv"
    columns = {n: solution[n] for n in ("time", "crank.phi", "rod.w", "A.fx")}

    def refused(expected, of=None, signals=(), **changed):
        results.write(path, {**columns, **changed})
        with pytest.raises(UsageError, match=expected):
            from_file(path, of or runner(points=50), signals)

    gap = columns["A.fx"].copy()
    gap[7] = np.nan
    refused(r"no numbers \(nan\) in crank.phi", **{"crank.phi": gap})
    refused(r"no numbers \(nan\) in A.fx", **{"A.fx": gap * np.nan})
    refused("no signal `A.fy`", signals=["crank.phi", "A.fy"])
    refused("no signal `A.P", signals=["A.Phi*"])
    refused("no signal `a`", signals=["a"])
    refused(r"ends at 0.5 s, the study at 2 s\n.*--stop 0.5", runner(2.0))
    refused(r"no values at the stop time, 0.4567 s\n.*--stop 0.45", runner(0.4567))
    refused("its times are not ascending", time=-columns["time"])
    refused("its times are not ascending", time=columns["time"] * np.nan)
    for rows, expected in ((slice(0), "has no rows"), (slice(5), "ends at 0.04 s")):
        results.write(path, {n: x[rows] for n, x in columns.items()})
        with pytest.raises(UsageError, match=expected):
            from_file(path, runner())
    results.write(path, {"time": columns["time"], "mass.x": columns["rod.w"]})
    with pytest.raises(UsageError, match=r"has no signal of SliderCrank: it has time, mass\.x"):
        from_file(path, runner())

    results.write(path, {**columns, "A.fx": gap})
    found = from_file(path, runner(points=50), ["A.f*"])
    assert str(found).startswith(
        "`wrong.csv` (2 of 12 positions and velocities, without A.fy, A.f, at some times without A.fx)"
    )
    assert len(found.solution.t) == 51 and np.isnan(found.solution["A.fx"][7])


def test_points_of_a_file_as_reference(runner, tmp_path):
    """The number follows from the times, whatever numbers these are divided by."""
    path = tmp_path / "exact.csv"
    for count, points in ((1, 100), (2, 2), (10, 10), (101, 101), (200, 200), (500, 125), (502, 251), (503, 503)):
        t = np.linspace(0.0, 0.5, count + 1)
        results.write(path, {"time": t, "crank.phi": t})
        assert file_points(path, runner().setting) == points
        found = from_file(path, runner(points=points))
        assert len(found.solution.t) == (points if count > 1 else 1) + 1
    results.write(path, {"time": t[:0], "crank.phi": t[:0]})
    assert file_points(path, runner().setting) == 100


class Known(dict):
    """Signals at three times."""

    t = np.array([0.0, 1.0, 2.0])
    find_events = staticmethod(list)  # without events


def test_no_number_is_no_small_error():
    nan, inf = np.nan, np.inf
    q = ErrorQuantity("q", "positions", "m", ("x", "y"), (2.0, 2.0))
    still = [0.0, 0.0, 0.0]
    for x, reference, largest, end in (
        ([0.0, 1.0, 3.0], [0.0, 0.0, 2.0], 1.0, 1.0),
        ([0.0, nan, 2.0], [0.0, 0.0, 2.0], inf, 0.0),
        ([nan, nan, nan], [0.0, 0.0, 2.0], inf, inf),
        ([0.0, 7.0, 3.0], [0.0, nan, 2.0], 1.0, 1.0),
        ([0.0, 7.0, 3.0], [nan, nan, nan], inf, inf),
        ([nan, nan, nan], [nan, nan, nan], inf, inf),
        ([0.5, 0.0, nan], [0.0, 0.0, nan], 0.5, nan),
    ):
        one, other = Known(x=np.array(x), y=np.array(x)), Known(x=np.array(reference), y=np.array(reference))
        e = error(q, one, other)
        assert (e.largest, e.scaled) == (largest, 2.0 * largest)
        assert (e.end, e.scaled_end) == pytest.approx((end, 2.0 * end), nan_ok=True)
    one["x"] = other["x"] = np.array(still)
    assert error(q, one, other).largest == 0.5  # the value of y
    itself = ErrorQuantity("Phi", "constraints", "m", ("x",), (1.0,), True)
    assert error(itself, Known(x=np.array([0.0, nan, 1.0])), Known()).largest == inf
    reference = ReferenceSolution(other, "one", Known(x=np.array([nan] * 3), y=np.array(still)), "another")
    assert reference.floor(q).scaled == inf and reference.digits(q) == 0.0


@pytest.mark.parametrize("study", [convergence, drift, energy, runtime, work_precision])
def test_wrong_models_are_told_as_such(study, tmp_path):
    path = tmp_path / "wrong.mbd"
    loose = "  Rod other(m = 1 kg, length = 1 m);\n"
    text = PENDULUM.read_text(encoding="utf-8")
    for wrong, problem, expected in (
        (text.replace("  PointMass", loose + "  PointMass"), ModelError, "no path to ground"),
        (text.replace("guess mass.x = -L", "mass.x = -2 * L"), InitialisationError, "rod is violated"),
    ):
        path.write_text(wrong, encoding="utf-8")
        with pytest.raises(problem, match=expected):
            study(path, store=tmp_path, methods=["hht-si2"])


def test_why_there_is_no_reference(runner, monkeypatch):
    for why, hint in (("it stumbled", "give one: --reference FILE"), (OUT_OF_TIME, "--budget")):
        monkeypatch.setattr(
            Runner, "compute", lambda self, cases, *_, why=why, **__: {c: Computed(c, problem=why) for c in cases}
        )
        with pytest.raises(IntegrationError, match="no reference solution was found: radau5, ") as no:
            automatic(runner(), ["hht-i3"], None)
        assert no.value.message.count(why) == 1 and hint in no.value.hint


def test_runs_that_pass_over_a_pulse_are_no_reference(tmp_path):
    """Runs of two methods with fixed steps agree to the last bit where both miss the pulse."""
    text = """model Pulse
      Ground ground(g = 0);
      Body b(m = 1 kg, I = 1 kg.m2);
      Prismatic rail(ground, b.c);
      Force push(b.c, fx = if time > 0.23456 s and time < 0.234561 s then 1e6 N else 0 N);
      annotation(experiment(StopTime = 1));
    end Pulse;"""
    path = tmp_path / "pulse.mbd"
    path.write_text(text)
    runner = Runner(setting(path, 1.0, points=100), Store(tmp_path), budget=20.0)
    _, run = reference_solution._extrapolated(runner, "hht-si2", 1e-3)
    assert "pass over a peak" in run.problem


def test_runs_that_pass_over_a_pulse_are_not_recommended(tmp_path):
    """A driven mechanism is exact at the ends of all steps, but outputs between them would miss the pulse."""
    path = tmp_path / "pulse.mbd"
    path.write_text("""model Driven
      Ground ground(g = 0);
      Rod crank(m = 1 kg, length = 0.3 m), rod(m = 1 kg, length = 0.6 m);
      Revolute O(ground, crank.a), A(crank.b, rod.a);
      PointOnLine B(ground, rod.b);
      RotationalDriver drive(O, phi = 2 rad/s*time + 0.2*exp(-((time - 0.5137 s)/(5 ms))^2));
      annotation(experiment(StopTime = 10));
    end Driven;""")
    best = recommend(path, 1e-4, store=tmp_path, methods=["hht-i3"], repeats=1, budget=20.0).best.case
    run = mbdsl.simulate(path, method=best.method, step=best.step, tol=best.tol, interval=1e-3)
    phi = 2.0 * run.t + 0.2 * np.exp(-(((run.t - 0.5137) / 5e-3) ** 2))
    exact = -np.arcsin(0.5 * np.sin(phi))  # both ends of the rod, from the crank's end to the line
    assert np.abs(run["rod.phi"] - exact).max() < 3e-4
