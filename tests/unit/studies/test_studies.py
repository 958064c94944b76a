"""Results of studies: orders, energy, drift, times; and that a wrong method is detected."""

import json
import types
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import integrators, results
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.plotting.figures import Figure
from mbdsl.studies.cases import Case
from mbdsl.studies.convergence import convergence
from mbdsl.studies.drift import drift
from mbdsl.studies.energy import energy
from mbdsl.studies.error_measures import Error, error, quantities
from mbdsl.studies.runtime import runtime
from mbdsl.studies.store import Computed
from mbdsl.studies.survey import SurveyRow
from mbdsl.studies.work_precision import WorkPrecision, cheapest, front, work_precision

MODELS = Path(__file__).parents[3] / "models"
CRANK, PENDULUM = MODELS / "slider_crank.mbd", MODELS / "pendulum.mbd"
STEPS = [0.01 / 2**k for k in range(5)]


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """A store, so that references are computed once; half a second of motion."""
    return {"store": tmp_path_factory.mktemp("store"), "stop": 0.5, "workers": 1, "budget": 1e3}


@pytest.fixture(scope="module")
def study(given):
    return convergence(CRANK, methods=["hht-si2", "nstiff", "newmark"], steps=STEPS, signals=["A.fx"], **given)


def test_slopes_are_the_orders(study):
    for method, order in (("hht-si2", 2), ("nstiff", 2), ("newmark", 1)):
        for key in ("q", "v", "reactions", "A.fx"):
            found = study.fits[method][key]
            assert abs(found.slope - order) < 0.15 and found.count >= 4, (method, key, found)
        assert not [key for key in ("q", "v", "reactions") if study.verdict(method, key)]


def test_the_reference_is_right(study):
    """Compared with a run that is independent of both families from which it was made."""
    exact = mbdsl.simulate(CRANK, method="hht-add", step=2e-6, stop=0.5, interval=0.1)
    solution = study.survey.reference.solution
    for name in ("crank.phi", "rod.w"):
        there = solution[name][::10]
        # 4e-11 by hht-add at this step, far below the error bound of the reference
        assert np.abs(exact[name] - there).max() < 5e-10
    q = study.survey.quantity("q")
    assert 9.0 < study.survey.reference.digits(q) < 16.0


def test_errors_are_those_of_direct_runs(study):
    row = next(r for r in study.survey.rows if r.case == Case("hht-si2", step=0.005))
    run = mbdsl.simulate(CRANK, method="hht-si2", step=0.005, stop=0.5, interval=0.01)
    solution = study.survey.reference.solution
    D = np.abs(run["A.fx"] - solution["A.fx"])
    e = row.errors["A.fx"]
    assert (e.largest, e.end) == (pytest.approx(D.max(), rel=1e-9), pytest.approx(D[-1], rel=1e-9))
    assert e.scaled == pytest.approx(D.max() / np.ptp(solution["A.fx"]), rel=1e-9)
    size = run.system.tables.size
    D = [np.abs(run[n] - solution[n]).max() / (1.0 if "phi" in n else size) for n in run.default_names[:6]]
    assert row.errors["q"].scaled == pytest.approx(max(D), rel=1e-9)
    assert row.errors["Phi"].largest == max(np.abs(run[n]).max() for n in run.select(["*.Phi[*]"]))


def test_a_file_as_reference(study, given, tmp_path):
    solution = study.survey.reference.solution
    names = ["crank.phi", "rod.phi", "crank.w", "A.fx"]
    path = tmp_path / "exact.csv"
    results.write(path, {"time": solution.t, **{n: solution[n] for n in names}})
    other = convergence(CRANK, methods=["hht-si2"], steps=STEPS[:3], reference=path, signals=["A.fx"], **given)
    assert [q.key for q in other.survey.quantities] == ["q", "v", "reactions", "Phi", "dPhi", "A.fx"]
    known = {r.case: r.errors["A.fx"].largest for r in study.survey.rows}
    for row in other.survey.rows:
        assert row.errors["A.fx"].largest == pytest.approx(known[row.case], rel=1e-9)
    assert "its accuracy is not known" in str(other)
    at_end = tmp_path / "end.csv"
    results.write(at_end, {"time": solution.t[[0, -1]], **{n: solution[n][[0, -1]] for n in names}})
    end = convergence(CRANK, methods=["hht-si2"], steps=STEPS[:3], reference=at_end, **given)
    assert end.survey.rows[0].errors["q"].largest == end.survey.rows[0].errors["q"].end > 0.0
    assert "end.csv` (at 1 of 100 times, 3 of 12 positions and velocities)" in str(end)


def test_what_the_reference_does_not_tell_is_no_point(study):
    survey = replace(study.survey, reference=replace(study.survey.reference, _floors={}))
    q = survey.quantity("q")
    floor = next(r for r in survey.rows if r.case == Case("hht-si2", step=STEPS[3])).errors["q"].scaled
    survey.reference._floors["q"] = Error(floor, floor, floor, floor)
    coarse = type(study)(survey)
    figure = next(f for f in coarse.figures() if f.key == "q")
    assert figure.floors == [(floor, "the references differ")]
    drawn = next(s for s in figure.series if s.name == "hht-si2")
    assert [np.isfinite(y) for y in drawn.y] == [True, True, True, True, False]
    assert coarse.fits["hht-si2"]["q"] is None or coarse.fits["hht-si2"]["q"].low > STEPS[3]
    assert survey.reference.digits(q) == pytest.approx(-np.log10(floor))


def test_lines_of_the_orders_are_drawn(study):
    """In the same figure as the compared points; guide lines do not change the axes."""
    figure = next(f for f in study.figures() if f.key == "v")
    guides = {s.name: s for s in figure.series if s.style == "guide"}
    assert list(guides) == ["order 1", "order 2"]
    for name, order, method in (("order 1", 1, "newmark"), ("order 2", 2, "nstiff")):
        x, y = np.array(guides[name].x), np.array(guides[name].y)
        assert np.diff(np.log(y)) / np.diff(np.log(x)) == pytest.approx(order)
        points = next(s for s in figure.series if s.name == method)
        assert 1.0 < y[0] / points.y[0] < 3.0 and list(x) == list(points.x)
    assert not [s for f in study.figures() if f.key == "Phi" for s in f.series if s.style == "guide"]


def test_what_the_reference_does_not_tell_is_as_exact_as_that(study):
    """A case whose error is below the reference's resolution meets every target above it, and is not left out."""
    rows = [replace(row, seconds=[1.0 / row.case.step]) for row in study.survey.rows if row.case.method == "hht-si2"]
    survey = replace(study.survey, rows=rows, reference=replace(study.survey.reference, _floors={}))
    floor = rows[2].errors["q"].scaled * 1.5
    survey.reference._floors["q"] = Error(floor, floor, floor, floor)
    found = WorkPrecision(survey)
    assert [row.errors["q"].scaled for row in found.points("q")] == [
        *(row.errors["q"].scaled for row in rows[:2]), *[floor] * 3
    ]  # fmt: skip
    assert [row.case for row in found.front("q")] == [row.case for row in rows[:3]]
    assert [row[5].startswith("(") for row in found.tables()[-1].rows] == [False, False, True, True, True]
    figure = next(f for f in found.figures() if f.key == "q")
    assert list(next(s for s in figure.series if s.name == "the references differ").x) == [floor, floor]
    assert next(s for s in figure.series if s.name == "hht-si2").x[-1] == floor
    survey.reference._floors["q"] = Error(1e-14, 1e-14, 1e-14, 1e-14)  # further left than any point
    figure = next(f for f in found.figures() if f.key == "q")
    assert "the references differ" not in [s.name for s in figure.series]


def test_failures_stay_in_the_picture(given):
    found = convergence(CRANK, methods=["hht-i3"], steps=[0.5, *STEPS[:3]], **{**given, "stop": 2.0})
    figure = next(f for f in found.figures() if f.key == "q")
    (outcome,) = figure.outcomes
    assert (outcome.name, outcome.x) == ("hht-i3", 0.5) and outcome.text
    assert "failed" in str(found) and f"hht-i3, h = 0.5 s: {outcome.text}" in found.summary()


def test_errors_over_tolerances(given):
    found = convergence(CRANK, methods=["scipy-dop853"], tols=[1e-4, 1e-6, 1e-8], **given)
    e = [row.errors["q"].scaled for row in found.survey.rows]
    # the tolerance limits the attained error; DOP853 may be far better if its longest step decides
    assert all(0.0 < x < 3.0 * row.case.tol for row, x in zip(found.survey.rows, e, strict=True))
    assert [f.key for f in found.figures()][:2] == ["q-tol", "v-tol"]
    guide = found.figures()[0].series[-1]
    assert guide.style == "guide" and list(guide.x) == list(guide.y)
    with_steps = convergence(CRANK, methods=["scipy-dop853", "newmark"], steps=STEPS[:2], **given)
    assert with_steps.survey.refused == [("scipy-dop853", "it has no fixed steps")]
    assert "scipy-dop853 is left out: it has no fixed steps." in str(with_steps)


# -- wrong methods ---------------------------------------------------------------------------------------------------


@pytest.fixture
def register(monkeypatch):
    """``register(name, method, **changes)``: a method by another name, with another declaration, on compiled code."""

    def add(name, method, **changes):
        module = integrators.modules()[method]
        declaration = replace(module.METHOD, name=name, **changes)
        known = types.ModuleType(module.__name__)
        vars(known).update(vars(module), METHOD=declaration)
        monkeypatch.setitem(integrators.modules(), name, known)

    return add


def test_a_dropped_order_shows(register, given):
    """gamma off by 0.05 leaves a method that converges with order 1."""
    coefficients = integrators.modules()["hht-si2"].METHOD.coefficients

    def off(options):
        beta, gamma, *others = coefficients(options)
        return (beta, gamma + 0.05, *others)

    register("off", "hht-si2", coefficients=off)
    found = convergence(CRANK, methods=["off"], steps=STEPS, **given)
    line = found.fits["off"]["v"]
    assert line.slope == pytest.approx(1.0, abs=line.uncertainty) and line.uncertainty < 0.05
    assert found.verdict("off", "v") == "below its order 2"
    assert "off: " in str(found) and "v below its order 2" in str(found)


def test_a_wrong_sign_shows(register, given):
    """With the wrong sign of alpha in the equation of motion: order 1, another slope than declared."""
    coefficients = integrators.modules()["hht-si2"].METHOD.coefficients

    def off(options):
        beta, gamma, alpha, *others = coefficients(options)
        return (beta, gamma, -alpha, *others)

    register("signs", "hht-si2", coefficients=off)
    found = convergence(CRANK, methods=["signs"], steps=STEPS, **given)
    assert found.verdict("signs", "v") == "below its order 2"


def test_a_method_of_other_equations_shows(register, given):
    """beta and gamma of h/2 in place of h: it converges, but not to the solution."""
    coefficients = integrators.modules()["hht-si2"].METHOD.coefficients

    def off(options):
        beta, gamma, *others = coefficients(options)
        return (beta, gamma / 2.0, *others)

    register("half", "hht-si2", coefficients=off)
    found = convergence(CRANK, methods=["half"], steps=STEPS, **given)
    assert found.verdict("half", "v") != ""


# -- the other studies -----------------------------------------------------------------------------------------------


def tends_to(order, errors):
    """Slopes between neighbours, of h^p (c_1 + c_2 h + c_3 h^2): they are off by terms of h, which extrapolation takes
    out, and then of h^2. The smallest and the largest slope."""
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    off = 2.0 * slopes[1:] - slopes[:-1] - order
    assert (np.abs(off[1:]) < np.abs(off[:-1]) / 2.0).all() and abs(off[-1]) < 1e-3
    return slopes.min(), slopes.max()


def test_energy_where_it_is_conserved(given):
    found = energy(PENDULUM, methods=["hht-si2", "newmark"], steps=STEPS, **given)
    assert found.conserved and "Energy is conserved" in str(found)
    rows = found.survey.series()
    least, most = tends_to(1.0, [found.mean(row) for row in rows["newmark"]])
    assert least < found.slope(rows["newmark"]).slope < most
    line = found.slope(rows["hht-si2"])
    assert line.slope == pytest.approx(2.0, abs=line.uncertainty + 0.005)
    run = mbdsl.simulate(PENDULUM, method="newmark", step=STEPS[0], stop=0.5, interval=0.01)
    E = run["energy.total"]
    e = np.abs(E - E[0])
    assert found.mean(rows["newmark"][0]) == pytest.approx((e[1:] + e[:-1]).mean() / 2.0, rel=1e-9)
    assert np.array(found.figures()[0].series[1].y)[-1] < 0.0  # it loses energy


def test_energy_where_it_is_not(given):
    found = energy(CRANK, methods=["hht-si2"], steps=STEPS, **given)
    assert not found.conserved
    least, most = tends_to(2.0, [found.mean(row) for row in found.survey.rows])
    assert least < found.slope(found.survey.rows).slope < most
    found.floor = found.mean(found.survey.rows[2])
    cells = [row[2:5] for row in found.tables()[0].rows]
    assert [cell[0][0] == "(" for cell in cells] == [False, False, False, True, True]
    assert [cell[2][0] == "(" for cell in cells] == [cell[1][0] == "(" for cell in cells]
    path = given["store"] / "few.csv"
    results.write(path, {"time": np.linspace(0.0, 0.5, 11), "crank.phi": np.zeros(11)})
    with pytest.raises(UsageError, match="has no energies"):
        energy(CRANK, methods=["hht-si2"], steps=STEPS[:1], reference=path, **given)


def test_drift(given):
    found = drift(CRANK, methods=["hht-i3", "hht-si2"], steps=STEPS, **given)
    rows = found.survey.series()
    assert max(r.errors["dPhi"].largest for r in rows["hht-si2"]) < 1e-9  # 8e-12 of the speed, which is 4 m/s
    violations = [r.errors["dPhi"].largest for r in rows["hht-i3"]]
    assert violations[-1] > 1e-6
    assert np.log2(violations[-2] / violations[-1]) == pytest.approx(2.0, abs=1e-3)  # the next term has h^4
    assert [f.key for f in found.figures()] == ["Phi-time", "Phi", "dPhi-time", "dPhi"]
    with pytest.raises(IntegrationError, match="no run was completed"):
        drift(CRANK, methods=["hht-i3"], steps=[0.5], **{**given, "stop": 2.0})
    # nothing is compared, so no differences are reported; pictures have the units of the table
    assert [q.key for q in found.survey.quantities] == ["Phi", "dPhi"]
    assert not {"q", "v scaled", "reactions", "energy"} & {name for record in found.records() for name in record}
    figure = next(f for f in found.figures() if f.key == "dPhi")
    assert figure.y_label == "largest over time [m/s, rad/s]"
    assert next(s for s in figure.series if s.name == "hht-i3").y == violations


def test_drift_of_what_has_no_constraints(given, tmp_path):
    free = tmp_path / "free.mbd"
    lines = ("Ground ground(g = 9.81)", "Body block(m = 1 kg, I = 0.01 kg.m2)", "FreeMotion free(ground, block.c)")
    free.write_text(f"model Free {'; '.join(lines)}; end Free;")
    with pytest.raises(UsageError, match="Free has no constraints that a motion could leave"):
        drift(free, methods=["hht-si2"], **given)


def test_runtime(given):
    found = runtime(CRANK, methods=["hht-i3", "hht-si2"], repeats=3, **given)
    assert [len(r.seconds) for r in found.survey.rows] == [3, 3]
    base, other = found.survey.rows
    assert found.ratios(base) == [1.0, 1.0, 1.0]
    assert found.ratios(other) == [a / b for a, b in zip(other.seconds, base.seconds, strict=True)]
    record = found.records()[1]
    assert record["seconds a step"] * 500 == pytest.approx(record["seconds a simulated second"] / 2.0)


def timed(method, size, e, *seconds):
    return SurveyRow(
        Case(method, step=size), Computed(Case(method, step=size)), {"q": Error(e, e, e, e)}, list(seconds)
    )


def test_front_and_the_cheapest():
    rows = [
        timed("hht-i3", 4.0, 1e-2, 1.0, 1.2, 0.9),
        timed("hht-i3", 2.0, 1e-3, 2.0),
        timed("hht-i3", 1.0, 1e-4, 4.0),
        timed("hht-si2", 4.0, 2e-3, 1.5),
        timed("hht-si2", 2.0, 5e-4, 3.0),
        timed("nstiff", 4.0, 2e-2, 1.1),  # beaten in both error and time
    ]
    assert [(r.case.method, r.case.step) for r in front(rows, "q")] == [
        ("hht-i3", 4.0),
        ("hht-si2", 4.0),
        ("hht-i3", 2.0),
        ("hht-si2", 2.0),
        ("hht-i3", 1.0),
    ]
    assert [r.case.method for r in cheapest(rows, "q", 2e-3)] == ["hht-si2", "hht-i3"]
    assert [r.case.method for r in cheapest(rows, "q", 1e-5)] == []


def test_work_precision(given, tmp_path):
    two = {**given, "stop": 2.0}
    found = work_precision(CRANK, methods=["hht-i3", "hht-si2"], steps=[0.5, *STEPS[:3]], repeats=2, **two)
    assert {len(r.seconds) for r in found.survey.rows if r.run.done} == {2}
    assert found.summary()[0].startswith("Least time for an error in positions: ")
    assert "medians of 2 rounds" in found.summary()[2]
    short = replace(found.survey.rows[-1], seconds=found.survey.rows[-1].seconds[:1])
    asked = replace(found.survey.asked, repeats=9)
    fewer = type(found)(replace(found.survey, asked=asked, rows=[*found.survey.rows[:-1], short]))
    assert "medians of 1 to 2 rounds" in fewer.summary()[2]
    best = found.front("q")
    assert best == sorted(best, key=lambda r: -r.errors["q"].scaled)
    figure = next(f for f in found.figures() if f.key == "q")
    assert {s.style for s in figure.series if s.name == "least time"} <= {"front"}
    assert "hht-i3" in {o.name for o in figure.outcomes}
    paths = found.write(tmp_path / "out", pictures=())
    assert [p.name for p in paths] == ["work-precision.csv", "work-precision.json", "work-precision.html"]
    said = json.loads(paths[1].read_text(encoding="utf-8"))
    assert said["model text"]["files"]["slider_crank.mbd"] == CRANK.read_text(encoding="utf-8")
    assert said["versions"]["mbdsl"] == mbdsl.__version__ and said["machine"]["processor"]
    assert said["steps"] == [0.5, *STEPS[:3]] and said["rows"][0]["outcome"] != "done"
    lines = paths[0].read_text(encoding="utf-8").splitlines()
    assert len(lines) == 9 and lines[0].startswith("method,step,tol,outcome,steps,")
    page = paths[2].read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and "SliderCrank: work-precision" in page


def test_pictures_are_drawn(study, tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    only = [f for f in study.figures() if f.key == "q"]
    monkeypatch.setattr(study, "figures", lambda: only)
    paths = study.write(tmp_path, pictures=["svg"])
    assert [p.name for p in paths][3:] == ["convergence-q.svg"] and isinstance(only[0], Figure)


def test_tables_fit_a_terminal(study):
    assert max(map(len, str(study).split("\n\nReference")[0].splitlines())) <= 100


def test_angles_and_lengths_are_scaled():
    run = mbdsl.simulate(CRANK, stop=0.05, interval=0.05)
    found = {q.key: dict(zip(q.signals, q.weights, strict=True)) for q in quantities(run, run, ["B.s"])}
    assert found["q"]["crank.phi"] == 1.0 and found["q"]["crank.x"] == pytest.approx(1.0 / 0.6)
    assert found["B.s"]["B.s"] == pytest.approx(1.0 / np.ptp(run["B.s"]))
    largest = max(np.abs(run[n]).max() for n in found["reactions"])
    assert set(found["reactions"].values()) == {1.0 / largest}
    assert error(quantities(run, run)[0], run, run) == Error(0.0, 0.0, 0.0, 0.0)


def test_wrong_arguments():
    for wrong, expected in (
        ({"methods": ["hht-si3"]}, "no method `hht-si3`"),
        ({"methods": []}, "needs a method"),
        ({"repeats": 0}, "repeats = 0"),
        ({"budget": 0.0}, "leaves no time"),
        ({"signals": ["crank.fi"]}, "no signal `crank.fi`"),
    ):
        with pytest.raises(UsageError, match=expected):
            convergence(CRANK, **{"methods": ["hht-si2"], "steps": STEPS[:1], "stop": 0.05, **wrong})
