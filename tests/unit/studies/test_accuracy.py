"""Requested accuracies: recommended, reached, and verified."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import cli, results
from mbdsl.errors import InitialisationError, IntegrationError, ModelError, UsageError
from mbdsl.simulation.simulate import simulated
from mbdsl.studies import accuracy, cross_check, time_limits
from mbdsl.studies import ladder as ladders
from mbdsl.studies.cases import own_step, setting
from mbdsl.studies.ladder import Ladder, difference, observed
from mbdsl.studies.recommendation import recommend
from mbdsl.studies.scales import scales
from mbdsl.studies.verify import Verification, agree, verify

MODELS = Path(__file__).parents[3] / "models"
CRANK = MODELS / "slider_crank.mbd"
pytestmark = pytest.mark.usefixtures("work_clock")
SIX = ["newmark", "hht-i3", "nstiff", "nstiff-si2", "hht-add", "hht-si2"]


@pytest.fixture(scope="module")
def exact():
    """``exact(interval)``: the slider crank over half a second, to 1e-10 (hht-add, h = 4 us)."""
    return lambda interval=None: mbdsl.simulate(CRANK, method="hht-add", step=4e-6, stop=0.5, interval=interval)


# -- reached ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wanted", [1e-3, 1e-5, 1e-7])
def test_the_error_is_what_was_asked_for(wanted, exact):
    found = mbdsl.simulate(CRANK, accuracy=wanted, stop=0.5, budget=1e3)
    attained = difference(found, exact())
    said = found.stats["accuracy"]
    assert attained <= wanted
    # an estimate from two steps is as good as the errors are asymptotic; the reference itself is accurate to 1e-10
    assert attained / 2.0 < said["estimated"] + 1e-10
    assert said["estimated"] <= wanted
    assert said["asked"] == wanted and said["checked by"] and len(said["runs"]) >= 4


def test_the_method_asked_for(exact):
    found = mbdsl.simulate(CRANK, accuracy=1e-4, method="newmark", stop=0.5, options={"gamma": 0.7})
    assert found.stats["method"] == "newmark"
    assert difference(found, exact()) <= 1e-4
    every = mbdsl.simulate(CRANK, accuracy=1e-3, stop=0.05, interval=0.0)
    assert len(every.t) == every.stats["steps"] + 1


def test_what_cannot_be_reached():
    with pytest.raises(
        IntegrationError, match=r"an accuracy of 1e-13 cannot be reached: hht-i3: .*1e-13|stays at"
    ) as no:
        mbdsl.simulate(CRANK, accuracy=1e-13, stop=0.01, method="hht-i3")
    assert no.value.exit_code == 4


def test_wrong_models_are_told_as_such(tmp_path):
    path = tmp_path / "wrong.mbd"
    text = (MODELS / "pendulum.mbd").read_text(encoding="utf-8")
    path.write_text(text.replace("guess mass.x = -L", "mass.x = -2 * L"), encoding="utf-8")
    with pytest.raises(InitialisationError, match="rod is violated"):
        mbdsl.simulate(path, accuracy=1e-3)
    with pytest.raises(InitialisationError, match="rod is violated"):
        recommend(path, 1e-3, store=tmp_path)
    loose = "  Rod other(m = 1 kg, length = 1 m);\n"
    path.write_text(text.replace("  PointMass", loose + "  PointMass"), encoding="utf-8")
    with pytest.raises(ModelError, match="no path to ground"):
        mbdsl.simulate(path, accuracy=1e-3)
    with pytest.raises(UsageError, match="has no parameter rho"):
        mbdsl.simulate(CRANK, accuracy=1e-3, stop=0.1, method="hht-si2", options={"rho": 0.5})


@pytest.mark.parametrize(
    ("wanted", "methods"),
    [(1e-4, {"hht-si2", "radau5", "dop853"}), (1e-9, {"hht-si2", "radau5", "radau9", "radau13", "dop853"})],
)
def test_the_methods_that_are_compared(wanted, methods):
    """Orders 9 and 13 only for small errors, where they take less time than order 5."""
    found = accuracy._ladders(mbdsl.load(CRANK), wanted, None, {})
    assert {ladder.method for ladder in found} == methods
    step = own_step(setting(mbdsl.load(CRANK), None))
    assert all(ladder.sizes == [2.0 * step, step] for ladder in found if ladder.fixed)


def test_options_of_one_method_are_not_those_of_its_check():
    found = mbdsl.simulate(CRANK, accuracy=1e-4, method="hht-si2", stop=0.1, options={"alpha": -0.1})
    checked = found.stats["accuracy"]["checked by"]
    assert re.match(r"(radau5|dop853) --tol, tol = 0\.0001: differs by ", checked)


TOP = """
model Top
  Ground ground(g = 0);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c);
  TranslationalSpringDamper law(rail, k = -25 N/m);
  {}
initial equation
  rail.s = 0 m;
  rail.v = 0 m/s;
  annotation(experiment(StopTime = 4 s));
end Top;
"""


def test_rounding_that_the_motion_amplifies_counts():
    """At rest at the top: all methods agree that nothing moves, but an error eps in the position grows to eps cosh(5
    T)."""
    least = np.finfo(float).eps * np.cosh(5.0 * 4.0)
    found = mbdsl.simulate(mbdsl.parse(TOP.format("")), accuracy=1e-4)
    assert least < found.stats["accuracy"]["estimated"] < 1e3 * least
    assert found.stats["accuracy"]["by"] == "rounding, as the motion amplifies it"
    heavy = "Body c(m = 1e9 kg, I = 1 kg.m2); Prismatic other(ground, c.c);"  # a part of its own
    for more in ("", heavy):
        with pytest.raises(IntegrationError, match="the motion amplifies rounding to an error of about") as no:
            mbdsl.simulate(mbdsl.parse(TOP.format(more)), accuracy=1e-9)
        assert no.value.exit_code == 4 and no.value.trajectory.status == "failed"


def test_a_motion_that_goes_far_is_as_large_as_its_way():
    """From 1 nm to 0.24 m in 4 s: with fixed steps, too, errors are relative to the distance travelled."""
    scene = mbdsl.parse(TOP.format("").replace("rail.s = 0 m", "rail.s = 1 nm"))
    found = mbdsl.simulate(scene, method="radau5", step=1e-2)
    assert found.system.tables.size == pytest.approx(1e-9 * np.cosh(5.0 * 4.0), rel=1e-4)


@pytest.fixture
def judged(monkeypatch):
    """``judged(off)``: radau5 is asked for 1e-4, others are off by ``off(method, k)`` rad in their run number k."""

    def reach(off, **given):
        count = dict[str, int]()

        def simulate(*args, method, **more):
            found = simulated(*args, method=method, **more)
            if method != "radau5":
                count[method] = count.get(method, 0) + 1
                found.q = found.q + off(method, count[method])
            return found

        monkeypatch.setattr(time_limits, "simulated", simulate)
        precise = ["radau5", "scipy-dop853"]
        monkeypatch.setattr(cross_check, "precise", lambda spatial: precise)  # others are of order 2, and quick
        return mbdsl.simulate(CRANK, accuracy=1e-4, method="radau5", stop=0.1, **{"budget": 1e3, **given})

    return reach


def test_methods_that_contradict_each_other(judged):
    with pytest.raises(IntegrationError, match=r"contradict each other: radau5.* of .*e-0\d.* by 1\.0e-02") as no:
        judged(lambda method, k: 0.006)  # the mechanism's size is 0.6 m
    found = no.value.trajectory
    assert no.value.exit_code == 4 and found.status == "failed"
    assert found.stats["accuracy"]["estimated"] == pytest.approx(0.01, rel=0.1)
    assert found.stats["accuracy"]["checked by"] is None


def test_one_that_is_wrong_is_outvoted(judged):
    found = judged(lambda method, k: 0.01 * (method == "scipy-dop853"))
    stated = found.stats["accuracy"]
    assert found.status == "done" and stated["estimated"] <= 1e-4
    assert "against scipy-dop853" in stated["checked by"] and not stated["checked by"].startswith("scipy-dop853")


def test_one_that_errs_much_does_not_judge(judged):
    """No other method has an error estimate below 1e-4: the result rests on its own runs, and the stats say so."""
    found = judged(lambda method, k: 0.01 + 0.01 * (k % 2))
    stated = found.stats["accuracy"]
    assert (
        found.status == "done" and stated["checked by"] is None and "scipy-dop853 differs by" in stated["not checked"]
    )
    exact = mbdsl.simulate(CRANK, method="hht-add", step=4e-6, stop=0.1)
    attained = difference(found, exact)
    assert attained <= 1e-4 and attained / 10.0 < stated["estimated"] < 1e-4


def test_checks_have_a_budget(judged):
    stated = judged(lambda method, k: 0.0, budget=1e-9).stats["accuracy"]
    assert stated["checked by"] is None and "there was no time left" in stated["not checked"]


def test_ctrl_c_keeps_what_there_is(judged):
    seen = []

    def progress(p):
        if seen:
            raise KeyboardInterrupt

    def judge(method, k):
        seen.append(method)
        return 0.0

    with pytest.raises(mbdsl.Interrupted) as stopped:
        judged(judge, progress=progress)
    found = stopped.value.trajectory
    assert found.status == "interrupted" and len(found.t) == 501  # the run that was to be checked, whole


@pytest.mark.parametrize("p", [-0.2, 0.5, 1.0, 2.0, 5.0])
def test_an_estimate_follows_from_differences_that_were_seen(p, monkeypatch):
    """Solutions x(h) with errors of order p, different from the order of the method; with order -0.2 they do not
    converge."""
    errors = {h: h**p for h in (0.1, 0.05, 0.02)}
    monkeypatch.setattr(ladders, "difference", lambda one, other: abs(errors[one] - errors[other]))
    ladder = Ladder("radau5", True, [])
    for h in errors:
        ladder.add(lambda case: case.step, h)
    differ = abs(errors[0.05] - errors[0.02])
    if p > 0.0:
        assert errors[0.02] / 2.0 < ladder.estimate < 2.0 * errors[0.02] and ladder.estimates[0] >= errors[0.05] / 2.5
    else:
        assert differ <= ladder.estimate <= 3.0 * differ


def test_wrong_arguments():
    with pytest.raises(UsageError, match="finds its own step"):
        mbdsl.simulate(CRANK, accuracy=1e-3, step=1e-3)
    with pytest.raises(UsageError, match="between 0 and 1"):
        mbdsl.simulate(CRANK, accuracy=2.0)
    with pytest.raises(UsageError, match="no method"):
        mbdsl.simulate(CRANK, accuracy=1e-3, method="hht")


def test_the_order_that_is_observed():
    for p in (0.5, 1.0, 2.0, 5.0):
        h = np.array([0.1, 0.05, 0.003])
        assert observed(h.tolist(), (-np.diff(h**p)).tolist()) == pytest.approx(p, rel=1e-9)
    assert observed([0.1, 0.05, 0.025], [1.0, 2.0]) == pytest.approx(0.1)  # it does not converge


# -- recommended -----------------------------------------------------------------------------------------------------


def test_recommended_is_exact_enough(tmp_path, exact):
    found = recommend(CRANK, 1e-5, stop=0.5, store=tmp_path, methods=SIX, repeats=1)
    for choice in found.choices:
        how = {"method": choice.case.method, "step": choice.case.step, "tol": choice.case.tol}
        run = mbdsl.simulate(CRANK, **how, stop=0.5, interval=0.005)
        assert difference(run, exact(0.005)) == pytest.approx(choice.error, rel=1e-3)
        assert choice.error <= 1e-5
    # the fastest one is searched until longer steps would gain little, others as long as they may become the fastest
    assert found.best.error > 2.5e-6
    assert [c.time for c in found.choices] == sorted(c.time for c in found.choices)
    command = shlex.split(found.command)
    assert command[:3] == ["mbdsl", "simulate", str(CRANK)]
    assert cli.main([*command[1:], "--output", str(tmp_path / "a.csv"), "--quiet"]) == 0


def test_quick_methods_are_compared_whatever_slow_ones_take(tmp_path, exact):
    """With methods of order 2 this error takes some 100,000 steps, and the whole budget of time."""
    methods = ["hht-si2", "radau5"]
    found = recommend(CRANK, 1e-8, stop=0.5, store=tmp_path, methods=methods, repeats=1, budget=1.0)
    best = found.best.case
    assert best.method == "radau5"
    run = mbdsl.simulate(CRANK, method="radau5", step=best.step, tol=best.tol, stop=0.5)
    assert difference(run, exact()) <= 3e-8
    assert {name.split()[0] for name, _ in found.others} | {c.case.method for c in found.choices} == set(methods)


def test_recommended_for_a_signal(tmp_path):
    found = recommend(CRANK, "1 %", "A.fx", stop=0.5, store=tmp_path, methods=["hht-si2", "newmark"], repeats=1)
    fx = mbdsl.simulate(CRANK, method="radau5", tol=1e-10, stop=0.5, interval=0.005)["A.fx"]  # as the study looks
    assert found.error == pytest.approx(0.01 * np.ptp(fx), rel=1e-8)
    assert found.unit == "N" and "in A.fx" in str(found)
    assert all(c.error <= found.error for c in found.choices)
    with pytest.raises(UsageError, match=r"no signal `A[.]z`"):
        recommend(CRANK, 1e-3, "A.z", stop=0.1, store=tmp_path)


def test_recommended_by_a_file(tmp_path, exact):
    one = exact(1e-3)
    path = tmp_path / "exact.csv"
    keep = {"store": tmp_path, "methods": ["hht-si2"], "repeats": 1, "reference": path}
    results.write(path, one.to_dict())
    found = recommend(CRANK, 1e-4, stop=0.5, **keep)
    assert str(found.reference) == "`exact.csv`, unchecked" and 2.5e-5 < found.choices[0].error <= 1e-4
    # a calibrated run of half a second takes so much longer that it may be left out
    assert {c.case.series for c in found.choices} | {name for name, _ in found.others} == {"hht-si2", "hht-si2 --tol"}
    with pytest.raises(UsageError, match=r"ends at 0\.5 s, the study at 2 s"):
        recommend(CRANK, 1e-4, **keep)
    results.write(path, {"time": one.t, **{name: one[name] * np.nan for name in one.default_names}})
    with pytest.raises(UsageError, match="has no numbers"):
        recommend(CRANK, 1e-4, stop=0.5, **keep)
    results.write(path, {"time": one.t, "A.fx": one["A.fx"]})
    with pytest.raises(UsageError, match="has no positions and velocities"):
        recommend(CRANK, 1e-4, stop=0.5, **keep)


def test_what_nobody_can_tell_is_not_recommended(tmp_path):
    with pytest.raises(IntegrationError, match="cannot be resolved: references agree"):
        recommend(CRANK, 1e-15, stop=0.02, store=tmp_path, methods=["hht-si2"])


# -- verified --------------------------------------------------------------------------------------------------------


def test_digits():
    one = mbdsl.simulate(CRANK, stop=0.5, step=1e-3)
    found = verify(one, ["crank.phi", "A.fx", "B.fx"])
    assert (found.method, found.step) == ("nstiff-si2", 5e-4)
    other = mbdsl.simulate(CRANK, method="nstiff-si2", step=5e-4, stop=0.5)
    digits = {a.signal: a.digits for a in found.agreements}
    for name in ("crank.phi", "A.fx"):
        differ = np.abs(one[name] - other[name]).max() / np.ptp(one[name])
        assert digits[name] == pytest.approx(-np.log10(differ))
    assert digits["B.fx"] == 16.0  # it vanishes in both
    assert [a.signal for a in found.agreements] == sorted(digits, key=digits.__getitem__)
    assert not found.doubtful and found.facts()["run"]["steps"] == 1000


def test_what_is_at_rest_is_no_doubt():
    """A velocity of rounding size, compared with one of a metre a second."""
    one = mbdsl.simulate(CRANK, stop=0.5, step=1e-3)
    other = mbdsl.simulate(CRANK, stop=0.5, step=1e-3, method="nstiff-si2")
    found = {a.signal: a for a in agree(one, other, ["crank.vx", "crank.a.vx"])}
    assert np.ptp(one["crank.a.vx"]) < 1e-9 and found["crank.a.vx"].digits > 3.0


@pytest.mark.parametrize("step", [1e-3, 1e-6])
def test_rounding_is_no_difference(step):
    """Of a crank whose guide takes no force along it: residuals, forces that vanish, and energy that is conserved.

    Each is tested alone, as no other signal then gives a scale.
    """
    one = mbdsl.simulate(CRANK, stop=100 * step, step=step)
    for name in ("B.fx", "A.Phi[1]", "B.dPhi[1]", "crank.a.vx", "crank.a.x"):
        (found,) = verify(one, [name]).agreements
        assert found.digits > 3.0, found
    coarse = mbdsl.simulate(CRANK, stop=0.5, step=0.02)
    (found,) = verify(coarse, ["A.fx"]).agreements
    assert found.digits < 3.0  # a difference above rounding is still reported


def test_a_second_run_has_a_budget():
    one = mbdsl.simulate(CRANK, stop=2.0, tol=1e-7)
    found = verify(one, ["crank.phi"], budget=1e-9)
    assert not found.agreements and "no time left" in found.problem and "--budget" in found.problem
    # with fixed steps, the common times can be compared
    late = mbdsl.simulate(CRANK, stop=2.0, step=2e-5, interval=0.01)
    found = verify(late, ["crank.phi"], budget=0.01)
    assert found.agreements[0].digits > 5.0 and 0.0 < found.until < 2.0 and "only" in str(found)
    assert found.facts()["until"] == found.until and found.facts()["problem"]


@pytest.mark.parametrize("how", [{}, {"tol": 1e-6}, {"method": "radau5", "tol": 1e-9}, {"method": "scipy-dop853"}])
def test_every_step_is_verified_at_its_own_time(how):
    """Controlled steps of two runs have no common times, and are too long to interpolate between them."""
    names = ["crank.phi", "crank.w", "B.s"]
    even, every = (mbdsl.simulate(CRANK, **how, stop=0.1, interval=interval) for interval in (None, 0.0))
    digits = [{a.signal: a.digits for a in verify(one, names).agreements} for one in (even, every)]
    assert np.ptp(np.diff(every.t)) > 1e-3 * every.t[1] or not how
    for name in names:
        assert digits[1][name] > digits[0][name] - 0.5 > 3.0


def test_an_interval_that_the_model_says_is_verified(tmp_path):
    text = CRANK.read_text(encoding="utf-8").replace("experiment(", "experiment(Interval = 0, ")
    model = tmp_path / "every.mbd"
    model.write_text(text, encoding="utf-8")
    one = mbdsl.simulate(model, tol=1e-5, stop=0.1)
    assert np.ptp(np.diff(one.t)) > 0.0 and verify(one, ["crank.phi"]).agreements[0].digits > 4.0


def test_output_at_given_times():
    even = mbdsl.simulate(CRANK, stop=0.1, step=1e-3, interval=1e-3)
    few = mbdsl.simulate(CRANK, stop=0.1, step=1e-3, times=even.t[[3, 7, 50, 100]])
    assert np.array_equal(few.t, even.t[[0, 3, 7, 50, 100]])
    assert np.abs(few["rod.phi"] - even["rod.phi"][[0, 3, 7, 50, 100]]).max() < 1e-15
    for wrong in ([], [0.05], [0.05, 0.05, 0.1], [0.0, 0.1], [0.05, np.nan, 0.1]):
        with pytest.raises(UsageError, match=r"after the start, 0 s, and up to the stop time, 0\.1 s"):
            mbdsl.simulate(CRANK, stop=0.1, times=wrong)
    with pytest.raises(UsageError, match="evenly spaced output times"):
        mbdsl.simulate(CRANK, stop=0.1, accuracy=1e-3, times=[0.1])


class Known:
    """A run of one signal."""

    def __init__(self, x, t=(0.0, 1.0, 2.0)):
        self.t, self.x = np.array(t), np.array(x, float)

    def __getitem__(self, name):
        return self.x

    def unit(self, name):
        return "N"

    def find_events(self):
        return []


def test_what_has_no_value_does_not_agree():
    nan = np.nan
    for one, other, digits, differ in (
        ([0, 1, 2], [nan, nan, nan], 0.0, np.inf),
        ([0, 1, 2], [0, nan, 2], 0.0, np.inf),
        ([0, nan, 2], [0, 1, 2], 0.0, np.inf),
        ([nan, nan, nan], [nan, nan, nan], 0.0, nan),
        ([0, nan, 2], [0, nan, 2], 16.0, 0.0),
        ([0, nan, 2], [0, nan, 2.002], 3.0, 0.002),
    ):
        (found,) = agree(Known(one), Known(other), ["A.fx"])
        assert found.digits == pytest.approx(digits) and found.difference == pytest.approx(differ, nan_ok=True)
        stated = str(Verification("radau5", None, 1e-6, (found,)))
        assert ("no value" in stated) == np.isnan(differ) and ("in one run alone" in stated) == np.isinf(differ)
    with pytest.raises(AssertionError):
        agree(Known([0, 1, 2]), Known([0, 1, 2], (0.0, 1.1, 2.0)), ["A.fx"])


def test_a_second_run_that_fails_is_told():
    one = mbdsl.simulate(MODELS / "pendulum.mbd", stop=0.1, step=1e-3)
    one.stats["h"] = 1e-20  # a step that no method can take
    found = verify(one, ["mass.x"])
    assert "too small" in found.problem and str(found).startswith("not verified: nstiff-si2")


# -- from a shell ----------------------------------------------------------------------------------------------------


def test_simulate_from_a_shell(say, tmp_path):
    import json

    argv = ("simulate", CRANK, "--stop", "0.1s", "--output", "a.csv", "--stats", "a.json")
    code, out, err = say(*argv, "--accuracy", "1e-4", "--verify")
    assert code == 0 and "warning" not in err
    # the machine decides which method is the cheapest, and so which one verifies it
    assert "accuracy 0.0001: estimated error " in out and "\nverified by " in out
    stats = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert stats["accuracy"]["asked"] == 1e-4 and min(stats["verify"]["digits"].values()) > 3.0
    code, out, err = say(*argv[:3], "2s", *argv[4:], "--step", "40ms", "--verify")
    assert code == 0 and "signals agree to fewer than 3 digits" in err
    code, _, err = say(*argv, "--accuracy", "1e-4", "--step", "1ms")
    assert code == 2 and "not allowed with argument" in err


def test_ctrl_c_while_it_is_verified(say, tmp_path, monkeypatch):
    import json

    from mbdsl.studies import verify as second

    def interrupted(*args, **given):
        raise KeyboardInterrupt

    monkeypatch.setattr(second, "limited", interrupted)
    argv = ("simulate", CRANK, "--stop", "0.1s", "--output", "a.csv", "--stats", "a.json", "--verify")
    code, out, err = say(*argv)
    assert code == 130 and "501 rows" in out and "not verified: interrupted" in err
    columns, meta = results.read(tmp_path / "a.csv")
    assert meta["complete"] and len(columns["time"]) == 501
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["verify"]["problem"] == "interrupted"


def test_recommend_from_a_shell(say):
    argv = ("recommend", CRANK, "--stop", "0.1s", "--methods", "hht-si2,nstiff-si2", "--repeats", "1")
    code, out, _ = say(*argv, "--error", "1e-4")
    assert code == 0 and out.startswith("SliderCrank: an error of 0.0001 in positions and velocities, scaled\n")
    assert "cheapest here:  mbdsl simulate" in out and "--stop 0.1" in out
    # after a second of work, a line of progress comes first
    code, _, err = say(*argv, "--error", "1s", "--signal", "B.s")
    assert code == 2 and err.splitlines()[-1].startswith("error: the error asked for: `1s` has the wrong unit")
    code, _, err = say(*argv, "--error", "-1")
    assert code == 2 and err.splitlines()[-1].startswith("error: the error asked for = -1 leaves no room")


def test_studies_from_a_shell(say, tmp_path, monkeypatch):
    argv = ("study", "convergence", CRANK, "--stop", "0.1s", "--methods", "hht-si2", "--steps", "4ms,2ms,1ms")
    code, out, _ = say(*argv, "--pictures", "none", "--signals", "A.*")
    assert code == 0 and "\nslider_crank-convergence: convergence.csv, convergence.json, convergence.html\n" in out
    assert max(map(len, out.split("\n\nReference")[0].splitlines())) <= 100
    (tmp_path / "file").write_text("")
    for more, stated in (
        (("--output", "file"), "it is a file"),
        (("--output", "no/where"), "there is no folder `no`"),
        (("--steps", "1m"), "expected s, found m"),
        (("--methods", "hht-i4"), "no method `hht-i4`"),
        (("--tols", "1e-4", "--steps", "1ms", "--reference", "none.csv"), "cannot read `none.csv`"),
        (("--pictures", "png,bmp"), "unknown suffix `bmp`\n  = known suffixes are png, svg, pdf; none, "),
    ):
        code, out, err = say(*argv, *more)
        assert code == 2 and stated in err and out == "", err
    Path("slider_crank-convergence/convergence-q.svg").mkdir()
    code, _, err = say(*argv, "--pictures", "svg")
    assert code == 2 and "convergence-q.svg`: Is a directory" in err
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    code, out, err = say(*argv, "--quiet")
    assert code == 0 and out == "" and "'.[plot]'" in err and Path("slider_crank-convergence/convergence.html").exists()
    code, out, err = say(*argv, "--pictures", "png")
    assert code == 2 and out == "" and "'.[plot]'" in err


def test_what_cannot_be_written_is_told_before_the_work(say, monkeypatch):
    from mbdsl.lang import load

    monkeypatch.setattr(load, "load", None)  # refused before anything is read
    Path("file").touch()  # a folder that cannot be written
    for argv in (("study", "convergence", CRANK), ("study", "convergence", CRANK, "--methods", "hht-si2")):
        code, _, err = say(*argv, "--output", "file/folder")
        assert code == 2 and err.startswith("error: cannot write into `file/folder`: ")
    code, _, err = say("simulate", CRANK, "--output", "file/results.csv")
    assert code == 2 and err.startswith("error: cannot write `file/results.csv`: ")


def test_digits_of_a_small_part_are_those_of_its_own_range():
    """A resonator of 1 nm beside a rod of 1 m: 20 % of its amplitude is less than a digit."""
    text = """model Scales
      Ground ground;
      Rod rod(m = 1 kg, length = 1 m);
      Revolute pin(ground, rod.a);
      Body mems(m = 1e-12 kg, I = 1e-24 kg.m2);
      Prismatic rail(ground, mems.c);
      TranslationalSpringDamper k(rail, k = 1e-8 N/m);
    initial equation
      rod.phi = -60 deg; rail.s = 1 nm; rail.v = 0 m/s;
      annotation(experiment(StopTime = 1 s));
    end Scales;"""
    run = mbdsl.simulate(mbdsl.parse(text), method="dop853", tol=1e-9)
    other = mbdsl.simulate(mbdsl.parse(text), method="dop853", tol=1e-9)
    other._known["rail.s"] = other["rail.s"] * np.where(other.t > 0.5, 1.2, 1.0)
    found = {a.signal: a.digits for a in agree(run, other, ["rail.s", "rod.x", "pin.phi"], 1.0, scales(run, 1e-3))}
    assert found["rail.s"] == pytest.approx(1.0, abs=0.15) and min(found["rod.x"], found["pin.phi"]) == 16.0
