"""Arguments of Python functions: values with units, signals, initial values, and texts in place of paths."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import InitialisationError, IntegrationError, UsageError
from mbdsl.lang.given_values import value

MODEL = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
TEXT = MODEL.read_text(encoding="utf-8")
SHORT = {"stop": 0.02, "step": 1e-3}


def same(one, other):
    for x in ("t", "q", "v", "lam"):
        np.testing.assert_array_equal(getattr(one, x), getattr(other, x))


# -- values with units ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("given", "unit", "expected"),
    [
        ("10 ms", "s", 0.01),
        ("2min", "s", 120.0),
        ("0.5", "s", 0.5),
        (np.float32(0.5), "s", 0.5),
        (np.int64(2), "s", 2.0),
        ("180 deg", "rad", np.pi),
        ("1e-6", "1", 1e-6),
    ],
)
def test_values(given, unit, expected):
    assert value(given, unit, "x") == expected
    assert type(value(given, unit, "x")) is float


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("1 m", "x: `1 m` has the wrong unit: expected s, found m"),
        ("1 lightyear", "x: unknown unit `lightyear` in `1 lightyear`; expected s, or a multiple of it"),
        ("", "x: `` is not a number, with or without a unit, such as 1.5s"),
        (True, 'x: found True, expected a number in s, or a text such as "10 ms"'),
        ([1.0], 'x: found [1.0], expected a number in s, or a text such as "10 ms"'),
    ],
)
def test_wrong_values(given, message):
    with pytest.raises(UsageError) as caught:
        value(given, "s", "x")
    assert caught.value.message == message


def test_runs_with_texts_are_those_with_numbers():
    run = mbdsl.simulate(MODEL, start=0.01, stop=0.03, step=1e-3, interval=2e-3)
    same(run, mbdsl.simulate(MODEL, start="10 ms", stop="0.03s", step="1 ms", interval="2000 us"))
    same(run, mbdsl.simulate(MODEL, start="10 ms", stop="30ms", step="1 ms", times=[*run.t[1:-1], "0.03"]))
    tol = mbdsl.simulate(MODEL, stop=0.02, tol=1e-4)
    same(tol, mbdsl.simulate(MODEL, stop="20 ms", tol="1e-4"))
    simulation = mbdsl.Simulation(MODEL, step="1 ms", start="10 ms")
    simulation.step(20)
    np.testing.assert_array_equal(simulation.trajectory().q[-1], run.q[-1])


def test_texts_in_analyses_and_studies():
    assert mbdsl.static(MODEL, start="500 ms").t == 0.5
    assert mbdsl.eigen(MODEL, at="10 ms").t == mbdsl.eigen(MODEL, at=0.01).t == 0.01
    asked = mbdsl.study.Asked(steps=["1 ms", 5e-4], tols=["1e-5"], stop="2 s", budget="1 min")
    assert mbdsl.Checkpoint("a", every="2 min").every == 120.0
    assert (asked.steps, asked.tols, asked.stop, asked.budget) == ([1e-3, 5e-4], [1e-5], 2.0, 60.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mbdsl.simulate(MODEL, step="1 m"), "step: `1 m` has the wrong unit"),
        (lambda: mbdsl.simulate(MODEL, stop="2 kg"), "stop: `2 kg` has the wrong unit"),
        (lambda: mbdsl.simulate(MODEL, tol="1 s"), "tol: `1 s` has the wrong unit: expected no unit"),
        (lambda: mbdsl.simulate(MODEL, accuracy="x"), "accuracy: `x` is not a number"),
        (lambda: mbdsl.simulate(MODEL, accuracy=1e-3, budget="x"), "budget: `x` is not a number"),
        (lambda: mbdsl.simulate(MODEL, times=["1 m"]), "times: `1 m` has the wrong unit"),
        (lambda: mbdsl.Simulation(MODEL, step="1 m"), "step: `1 m` has the wrong unit"),
        (lambda: mbdsl.static(MODEL, start="1 m"), "start: `1 m` has the wrong unit"),
        (lambda: mbdsl.eigen(MODEL, at="1 m"), "at = '1 m': expected `static`, `start` or a time"),
        (lambda: mbdsl.linearise(MODEL, at="1 m"), "at = '1 m': expected `static`, `start` or a time"),
        (lambda: mbdsl.explain(MODEL, step="1 m"), "step: `1 m` has the wrong unit"),
        (lambda: mbdsl.study.effects(MODEL, "crank.phi", step="1 m"), "step: `1 m` has the wrong unit"),
        (lambda: mbdsl.recommend(MODEL, 1e-3, budget="1 m"), "budget: `1 m` has the wrong unit"),
        (lambda: mbdsl.study.Asked(steps="1 ms"), "steps: found '1 ms', expected a list"),
    ],
)
def test_wrong_dimensions_are_refused_before_the_run(call, message):
    with pytest.raises(UsageError) as caught:
        call()
    assert message in caught.value.message


# -- steps ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"step": 1e-3, "tol": 1e-4}, "found a step and a tolerance (tol), expected one of them"),
        ({"step": "1 ms", "accuracy": 1e-4}, "an accuracy finds its own step or tolerance"),
        ({"step": "3 s"}, "a step of 3 s is longer than the run, from 0 to 2 s"),
        ({"step": 0.2, "stop": "100 ms"}, "a step of 0.2 s is longer than the run, from 0 to 0.1 s"),
    ],
)
def test_steps_that_are_refused(given, message):
    with pytest.raises(UsageError) as caught:
        mbdsl.simulate(MODEL, **given)
    assert caught.value.message == message


@pytest.mark.parametrize("given", [["--step", "3s"], ["--step", "200ms", "--stop", "0.1s"]])
def test_the_command_line_refuses_a_step_beyond_the_run(given, tmp_path, capsys):
    assert main(["simulate", str(MODEL), *given, "--output", str(tmp_path / "a.csv")]) == 2
    assert "is longer than the run" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


# -- signals -------------------------------------------------------------------------------------------------------
def test_signals_are_those_of_the_result():
    run = mbdsl.simulate(MODEL, signals=["O.f?", "crank.phi"], **SHORT)
    assert run.names == ["time", "O.fx", "O.fy", "crank.phi"]
    whole = mbdsl.simulate(MODEL, **SHORT)
    for name in run.names:
        np.testing.assert_array_equal(run[name], whole[name])
    assert mbdsl.simulate(MODEL, signals="crank.phi", **SHORT).names == ["time", "crank.phi"]


def test_signals_are_checked_before_the_run(monkeypatch):
    monkeypatch.setattr("mbdsl.api.simulated", None)
    with pytest.raises(UsageError, match=r"there is no signal `crank\.ph`") as caught:
        mbdsl.simulate(MODEL, signals=["crank.ph"])
    assert "crank.phi" in caught.value.hint


def test_signals_of_a_run_that_fails():
    with pytest.raises(IntegrationError) as caught:
        mbdsl.simulate(MODEL.parent / "hard" / "beyond_reach.mbd", step="1 ms", stop=2.0, signals="*.phi")
    assert caught.value.trajectory.names[1].endswith(".phi")


# -- initial values ------------------------------------------------------------------------------------------------
def test_initial_values_are_those_of_initial_equations():
    """The same bits as those of a model with these lines."""
    lines = {"crank.phi = 0 deg": "crank.phi = 30 deg", "crank.w = 0 rad/s": "crank.w = 120 deg/s"}
    changed = TEXT
    for old, new in lines.items():
        assert old in changed
        changed = changed.replace(old, new)
    given = {"crank.phi": "30 deg", "crank.w": "120 deg/s"}
    expected = mbdsl.simulate(mbdsl.parse(changed), **SHORT)
    same(expected, mbdsl.simulate(MODEL, initial=given, **SHORT))
    same(expected, mbdsl.simulate(mbdsl.load(MODEL), initial=given, **SHORT))
    assert expected["crank.phi"][0] == pytest.approx(np.pi / 6, rel=1e-15)
    simulation = mbdsl.Simulation(MODEL, step=1e-3, initial=given)
    simulation.step(20)
    np.testing.assert_array_equal(simulation.trajectory().q[-1], expected.q[-1])


def test_guesses_and_rates():
    run = mbdsl.simulate(MODEL, initial={"guess": {"rod.phi": "170 deg"}, "der(crank.phi)": 2.0}, **SHORT)
    # the other way to assemble: the rod points backwards, from 0.3 m to -0.3 m; rates agree to the assembly's tolerance
    np.testing.assert_allclose(run["rod.phi"][0], np.pi, rtol=1e-9)
    np.testing.assert_allclose(run["crank.w"][0], 2.0, rtol=1e-9)


def test_a_run_continues_another():
    """Steps of a method without memory of earlier steps would be the same; here the start is of lower order."""
    first = mbdsl.simulate(MODEL, stop=0.1, step=2.5e-4)
    second = mbdsl.simulate(MODEL, start=0.1, stop=0.2, step=2.5e-4, initial=first)
    whole = mbdsl.simulate(MODEL, stop=0.2, step=2.5e-4)
    np.testing.assert_allclose(second.q[0], first.q[-1], atol=1e-9)  # the residual of Newton's iteration
    np.testing.assert_allclose(second.q[-1], whole.q[-1], atol=1e-7)  # h^2 = 6e-8
    other = mbdsl.simulate(MODEL, parameters={"m1": "6 kg"}, start=0.1, initial=first, stop=0.11, step=1e-3)
    np.testing.assert_allclose(other.q[0], first.q[-1], atol=1e-9)


@pytest.mark.parametrize(
    ("given", "message", "hint"),
    [
        ({"crank.ph": 1.0}, "initial: there is no signal `crank.ph`", "crank.phi"),
        ({"crank.phi": "1 m"}, "the initial value of `crank.phi`: `1 m` has the wrong unit: expected rad, found m", ""),
        ({"crank.phi": np.nan}, "the initial value of `crank.phi` is nan, expected a finite number", ""),
        ({"crank.phi": None}, "the initial value of `crank.phi`: found None, expected a number in rad", ""),
        ({"O.fx": 1.0}, "initial: `O.fx` depends on a reaction", "reactions follow from the motion"),
        ({"der(crank.w)": 1.0}, "initial: `der(crank.w)`: der() takes a position or an angle", ""),
        ({3: 1.0}, "initial: found 3, expected the name of a signal", ""),
        ({"guess": 3}, 'initial: found 3 for "guess", expected a mapping', ""),
        ("crank.phi = 3", "initial: found 'crank.phi = 3', expected a mapping", "crank.phi"),
    ],
)
def test_wrong_initial_values(given, message, hint):
    with pytest.raises(UsageError) as caught:
        mbdsl.simulate(MODEL, initial=given, **SHORT)
    assert message in caught.value.message
    assert hint in (caught.value.hint or "")


def test_initial_values_that_contradict():
    with pytest.raises(InitialisationError) as caught:
        mbdsl.simulate(MODEL, initial={"rod.phi": "30 deg"}, **SHORT)
    assert "rod.phi = 0.523599 is fixed" in caught.value.render()


def test_a_resumed_run_begins_at_its_initial_values(tmp_path):
    def stop_early(progress):
        raise KeyboardInterrupt

    from mbdsl.simulation.checkpoint import about

    for given in ({"crank.phi": "30 deg"}, mbdsl.simulate(MODEL, **SHORT)):
        path = tmp_path / "run.checkpoint"
        settings = {"stop": 0.5, "step": 1e-4, "initial": given}
        with pytest.raises(mbdsl.Interrupted):
            mbdsl.simulate(MODEL, **settings, checkpoint=path, progress=stop_early)
        assert about(path)["given"]["initial"]
        same(mbdsl.resume(path), mbdsl.simulate(MODEL, **settings))
        path.unlink()


# -- texts in place of paths ---------------------------------------------------------------------------------------
@pytest.mark.parametrize("text", [TEXT, "model P end P;", "model P ...", " partial model P\nend P;"])
@pytest.mark.parametrize("function", [mbdsl.simulate, mbdsl.load, mbdsl.static, mbdsl.Simulation])
def test_a_text_in_place_of_a_path(function, text):
    with pytest.raises(UsageError) as caught:
        function(text)
    assert caught.value.message == "found the text of a model, expected the path of a .mbd file"
    assert "mbdsl.parse(text)" in caught.value.hint


def test_a_path_in_place_of_a_text():
    for given in (str(MODEL), MODEL):
        with pytest.raises(UsageError, match="expected the text of a model") as caught:
            mbdsl.parse(given)
        assert "mbdsl.load(path)" in caught.value.hint


def test_a_missing_file_is_a_path():
    with pytest.raises(UsageError, match=r"there is no file `model of a crank\.mbd`"):
        mbdsl.load("model of a crank.mbd")
