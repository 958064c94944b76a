"""The hard cases: answers are reproduced, the default method is right or gives the reason, and verdicts can fail.

``hard_page.py`` runs the whole matrix, which takes an hour; these tests run the cases that share a few structures.
"""

import importlib
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import hard_page
from hard_case import Check, Stop
from hard_page import HEAD
from hard_runs import POINTS, measure, read

from mbdsl import cli
from mbdsl.integrators import compiled

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "models" / "hard"
PAGE = ROOT / "docs" / "hard-cases.md"
CASES = read(FOLDER)
#: models on which the default method is tested here, grouped by structure; the page has all of them
HERE = (
    *("any_size", "mass_ratio", "light_link", "many_turns", "stiff_knee"),  # rods on pins
    *("folding_crank", "far_guesses", "over_fixed", "step_sizes"),  # slider cranks
    *("parallelogram", "flat_four_bar", "spare_rocker", "two_lengths", "beyond_reach"),
    *("stiff_mass", "two_time_scales", "rattle", "kinked_force", "step_force"),  # forces on points
    *("sign_friction", "pole", "out_of_domain"),
)
#: cases that take more than a second, or do not end
LONG = {
    *("two_time_scales: 1e+08 N/m by 10 N/m", "stiff_knee: k = 1e+07 N.m/rad", "stiff_knee: k = 1e+10 N.m/rad"),
    *("rattle: k = 1e+06 N/m", "pole"),
}
#: models whose answers take more than a second
SLOW_ANSWERS = {"stiff_knee", "bushing_joint", "million_steps", "stick_slip"}


@pytest.fixture(scope="module")
def answers():
    return importlib.import_module("answers")


def case(name):
    return next(c for c in CASES if str(c) == name or c.model.stem == name)


def test_every_model_has_answers(answers):
    names = {model.__name__ for model in answers.MODELS}
    assert names == {path.stem for path in FOLDER.glob("*.mbd")} == {path.stem for path in FOLDER.glob("*.json")}
    assert set(HERE) | SLOW_ANSWERS <= names


def numbers(found):
    """All numbers, and all other values, in order."""
    if isinstance(found, dict):
        found = [x for key in found for x in (key, found[key])]
    if isinstance(found, (list, tuple)):
        return [x for one in found for x in numbers(one)]
    return [found]


def test_answers_are_reproduced(answers):
    """The shipped answers are those that answers.py computes; DOP853 at 1e-13 loses some digits on sensitive
    motions."""
    for model in answers.MODELS:
        if model.__name__ in SLOW_ANSWERS:
            continue
        shipped = numbers(json.loads((FOLDER / f"{model.__name__}.json").read_text(encoding="utf-8")))
        again = numbers(json.loads(json.dumps(answers.said(model), default=float)))
        assert len(shipped) == len(again), model.__name__
        for a, b in zip(shipped, again, strict=True):
            assert a == (pytest.approx(b, rel=1e-8, abs=1e-9) if isinstance(b, float) else b), model.__name__


@pytest.mark.parametrize("one", [c for c in CASES if c.model.stem in HERE and str(c) not in LONG], ids=str)
def test_default_method(one):
    """Right, or with the error of the step, or stopped as expected."""
    starts = one.stops is None or one.stops.code != 3
    for tol in (False, True)[: 1 + starts]:
        cell = measure(one, "hht-si2", tol, budget=np.inf)
        assert cell is None or cell.verdict in ("right", "step") or one.model.stem == "sign_friction", str(cell)
        assert cell is None or cell.verdict != "WRONG", str(cell)


@pytest.mark.parametrize("step", ["1e-09 s", "1e-07 s", "1e-05 s"])
def test_reactions_of_index_3_at_tiny_steps(step):
    """Multipliers of index 3 are differences of positions over h^2: with 1 ns, rounding would give an error of 70 times
    the largest reaction. Reactions from the equations of accelerations do not have this error."""
    assert measure(case(f"step_sizes: 1000 steps of {step}"), "hht-i3", budget=np.inf).verdict == "right"


# -- verdicts can fail ----------------------------------------------------------------------------------------------


def wrong(name, method="hht-si2", tol=False, **changes):
    return measure(replace(case(name), **changes), method, tol, budget=np.inf)


def test_a_wrong_answer_is_found():
    """Values that are off by a hundredth, at one step or with one tolerance, are not an error of the step."""
    checks = tuple(replace(c, values=list(np.multiply(c.values, 1.01))) for c in case("any_size: 1 m").checks)
    for tol in (False, True):
        cell = wrong("any_size: 1 m", tol=tol, checks=checks)
        assert cell.verdict == "WRONG" and str(cell).startswith("WRONG ")


def test_an_error_of_the_step_is_none_of_these():
    cell = wrong("any_size: 1 m", step=0.1)
    assert cell.verdict == "step" and str(cell)[0] == "("


def test_energy_that_grows_is_found():
    grows = Check("energy.total", -9.81 / 4 - 0.1, grows=1e-3, within=1.0, scale=9.81 / 4)
    assert wrong("any_size: 1 m", checks=(grows,)).verdict == "WRONG"


def test_a_run_that_should_have_stopped_is_found():
    assert wrong("any_size: 1 m", checks=(), stops=Stop(4)).text == "ran to its end"


@pytest.mark.parametrize("stops", [Stop(3), Stop(4, ["a dragon"]), Stop(4, after=1.5), Stop(4, before=0.5)], ids=str)
def test_a_wrong_reason_is_found(stops):
    assert wrong("pole", stops=stops).verdict == "WRONG"


def test_a_run_that_takes_too_long_is_left():
    assert measure(case("million_steps"), "hht-si2", budget=1e-9).verdict == "slow"


# -- divergence, the program and the page ---------------------------------------------------------------------------


def test_divergence_is_told_and_results_are_kept(tmp_path, capsys):
    """Exit code 4, with the time, the equation by its name in the model, and a file with the results so far."""
    output = tmp_path / "pole.csv"
    argv = ("simulate", str(FOLDER / "pole.mbd"), "--stop", "2 s", "--step", "1ms", "--output", str(output))
    assert cli.main(argv) == 4
    said = capsys.readouterr().err
    assert "in the step to t = 0.99" in said and "equation of motion of mass.x" in said
    rows = np.genfromtxt(output, delimiter=",", names=True)
    t, x = rows["time"], rows["massx"]
    early = t < 0.9
    assert t[-1] > 0.98 and np.abs(x[early] * (1 - t[early]) - 1).max() < 1e-3
    assert output.with_name("pole.csv.incomplete").exists()


def test_the_program(tmp_path):
    page = tmp_path / "page.md"
    argv = (str(FOLDER), "--cases", "any_size: 1 m", "--methods", "hht-si2")
    assert hard_page.main(*argv, "--output", str(page)) == 0
    text = page.read_text(encoding="utf-8")
    assert text.startswith("# Hard cases") and "| any_size: 1 m | h = 0.001 s | 2.9e-05 |" in text
    assert "2 runs of hht-si2: 2 right" in text


def test_the_program_fails_where_a_run_is_wrong(tmp_path, capsys):
    said = json.loads((FOLDER / "any_size.json").read_text(encoding="utf-8"))
    said["cases"] = [{"name": "", "stop": 1.0, "step": 1e-3, "checks": [{"signal": "rod.phi", "values": 0.0}]}]
    (tmp_path / "any_size.json").write_text(json.dumps(said), encoding="utf-8")
    (tmp_path / "any_size.mbd").write_text((FOLDER / "any_size.mbd").read_text(encoding="utf-8"), encoding="utf-8")
    assert hard_page.main(str(tmp_path / "any_size.mbd"), "--methods", "hht-si2") == 4
    assert "wrong without an error message: any_size, h = 0.001 s, hht-si2" in capsys.readouterr().err


def test_the_page_shows_the_cases_that_there_are():
    """Made by ``hard_page.py --output docs/hard-cases.md``; numbers differ from machine to machine."""
    text = PAGE.read_text(encoding="utf-8")
    assert text.startswith(HEAD)
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    shown = [line.split(" | ")[0].removeprefix("| ") for line in lines if not line.startswith("| case")]
    assert len({str(c) for c in CASES}) == len(CASES)
    assert list(dict.fromkeys(shown)) == [str(c) for c in CASES]
    header = next(line for line in lines if line.startswith("| case"))
    assert set(re.findall(r"`([\w-]+)`", header)) <= set(compiled())


def test_every_group_of_the_issue_is_there():
    groups = sorted({int(c.group.split(".")[0]) for c in CASES})
    assert groups == list(range(1, 12))
    assert POINTS >= 100
