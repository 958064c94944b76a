"""Output of a study: the command that repeats it, the model's text, rounds of timing, and the stored runs."""

import json
import math
import shlex
from pathlib import Path

import pytest

from mbdsl import load, results, simulate
from mbdsl.studies import runner as running
from mbdsl.studies.cases import Case
from mbdsl.studies.drift import drift
from mbdsl.studies.recommendation import Recommendation, RecommendedCase, recommend
from mbdsl.studies.reference_solution import ReferenceSolution
from mbdsl.studies.runtime import runtime

MODELS = Path(__file__).parents[3] / "models"
CRANK = MODELS / "slider_crank.mbd"


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """No run is in the store, and all run in this process."""
    monkeypatch.setattr("mbdsl.studies.store._default", lambda: tmp_path / "studies")
    monkeypatch.setattr(running, "ALONE", math.inf)


def facts(folder):
    (path,) = Path(folder).glob("*.json")
    return json.loads(path.read_text(encoding="utf-8"))


# -- the command -----------------------------------------------------------------------------------------------------


def runs_the_same(say, kind, *argv):
    """Run a study, then the command that it prints: the facts of both, which must be the same."""
    code, _, err = say("study", kind, *argv, "--pictures", "none", "--output", "first")
    assert code == 0, err
    first = facts("first")
    words = shlex.split(first["command"])
    assert words[0] == "mbdsl"
    code, _, err = say(*words[1:], "--pictures", "none", "--output", "second")
    assert code == 0, err
    second = facts("second")
    same = ("command", "study", "model", "stop", "output points", "cases", "parameters", "without", "repeats", "budget")
    assert {key: second[key] for key in same} == {key: first[key] for key in same}
    return words, first


def test_the_command_of_what_was_chosen_by_the_study(say):
    """With neither steps nor tolerances given, the command has neither: they would not be chosen in the same way."""
    words, found = runs_the_same(say, "drift", CRANK, "--stop", "0.1s", "--methods", "newmark,scipy-dop853")
    assert not {"--steps", "--tols", "--repeats"} & set(words)
    assert [len(sizes) for sizes in found["cases"].values()] == [4, 3] and len(found["rows"]) == 7


def test_the_command_says_all_that_was_asked(say, tmp_path):
    path = tmp_path / "it's mine" / "slider crank.mbd"
    path.parent.mkdir()
    path.write_text(CRANK.read_text(encoding="utf-8"), encoding="utf-8")
    exact = simulate(CRANK, method="hht-add", step=1e-5, stop=0.1, interval=1e-3, parameters={"c": "4 N.s/m"})
    names = ("crank.phi", "crank.w", "A.fx", "B.s")
    results.write("exact results.csv", {"time": exact.t, **{name: exact[name] for name in names}})
    argv = (path, "--methods", "hht-i3,newmark", "--steps", "4ms,2ms", "--tols", "1e-4", "--set", "c=4 N.s/m")
    argv += ("--stop", "0.1s", "--signals", "A.f[xy],B.s", "--reference", "exact results.csv", "--budget", "50s")
    words, found = runs_the_same(say, "work-precision", *argv, "--repeats", "1", "--without", "friction")
    assert words[3] == str(path) and words[words.index("--set") + 1] == "c=4 N.s/m"
    assert words[words.index("--reference") + 1] == "exact results.csv"
    assert found["cases"]["newmark"] == [4e-3, 2e-3] and found["repeats"] == 1 and found["budget"] == 50.0


def test_a_model_of_a_program_has_no_command(tmp_path):
    found = drift(load(CRANK), methods=["hht-si2"], steps=[2e-3], stop=0.02, store=tmp_path)
    assert found.command() == "none: the model is not from a file"


def test_what_is_recommended_is_quoted():
    case = Case("hht-si2", step=1e-3, options=(("alpha", -0.1),))
    extra = ("--set", "k=120 N/mm", "--stop", "0.5")
    found = Recommendation(
        "M", "my model.mbd", "q", 1e-3, "", (RecommendedCase(case, 1e-4, [1.0]),), (), ReferenceSolution.none(), extra
    )
    words = ["--method", "hht-si2", "--alpha", "-0.1", "--step", "0.001"]
    assert shlex.split(found.command) == ["mbdsl", "simulate", "my model.mbd", *words, *extra]


def test_times_of_different_kinds_are_not_compared(monkeypatch, tmp_path):
    """If the budget did not suffice to time all found runs, the times of the search are used for all."""
    asked = {"methods": ["hht-si2", "newmark"], "stop": 0.1, "repeats": 2, "store": tmp_path}
    assert not recommend(CRANK, 1e-2, **asked).note
    monkeypatch.setattr(running.Runner, "time", lambda self, cases, *how: {cases[0]: [1e-9] * 2})
    found = recommend(CRANK, 1e-2, **asked)
    assert {len(choice.seconds) for choice in found.choices} == {1} and found.best.time > 1e-9
    assert "times are of one run each, as the budget of 120 s was spent" in str(found)


# -- the model's text ------------------------------------------------------------------------------------------------


def test_the_text_is_that_which_was_run(tmp_path):
    """Files may be edited before the report is written; and two of them may have the same name."""
    names = ["main.mbd", "a/parts.mbd", "b/parts.mbd"]
    text = CRANK.read_text(encoding="utf-8")
    said = {
        names[0]: 'import "a/parts.mbd";\nimport "b/parts.mbd";\n' + text.replace("SliderCrank", "Main"),
        names[1]: "model One\n  parameter Real x = 1;\nend One;\n",
        names[2]: "model Two\n  parameter Real x = 2;\nend Two;\n",
    }
    for name, content in said.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content, encoding="utf-8")
    found = drift(tmp_path / names[0], methods=["hht-si2"], steps=[2e-3], stop=0.02, store=tmp_path / "store")
    for name in names:
        (tmp_path / name).write_text("edited", encoding="utf-8")
    found.write(tmp_path / "out", pictures=())
    assert facts(tmp_path / "out")["model text"]["files"] == said
    page = (tmp_path / "out" / "drift.html").read_text(encoding="utf-8")
    assert "model Two" in page and "edited" not in page


# -- rounds, and stored runs -----------------------------------------------------------------------------------------


def test_rounds_are_those_that_were_done(tmp_path):
    asked = {"methods": ["hht-i3", "hht-si2"], "stop": 0.1, "store": tmp_path}
    assert "medians of 2 rounds in which" in str(runtime(CRANK, repeats=2, **asked))
    none = runtime(CRANK, repeats=3, budget=1e-9, **asked)
    assert "medians" not in str(none) and str(none).count("not timed") == 3
    assert "2 cases were not timed, as the budget of 1e-09 s was spent." in none.summary()
    some = runtime(CRANK, repeats=2, **asked)
    some.survey.asked.repeats = 9
    some.survey.rows[1].seconds.pop()
    assert "medians of 1 to 2 rounds in which" in str(some)


@pytest.mark.parametrize(
    ("more", "command"), [((), "the same command"), (("--fresh",), "the same command without --fresh")]
)
@pytest.mark.parametrize(("after", "runs"), [(0, ""), (1, "1 run is"), (3, "3 runs are")])
def test_an_interrupted_study_tells_how_to_go_on(more, command, after, runs, say, empty, monkeypatch):
    real, calls = running.compute, []

    def interrupted(*given):
        calls.append(1)
        if len(calls) > after:
            raise KeyboardInterrupt
        return real(*given)

    monkeypatch.setattr(running, "compute", interrupted)
    code, out, err = say("study", "drift", CRANK, "--stop", "0.02s", "--methods", "hht-si2", *more)
    assert code == 130 and out == ""
    expected = f"{runs} stored; {command} continues from there" if runs else "no run was completed: nothing is stored"
    assert err.splitlines()[-2:] == [expected, "interrupted"]


def test_times_are_no_runs_that_are_kept(say, empty, monkeypatch):
    argv = ("study", "runtime", CRANK, "--stop", "0.02s", "--methods", "hht-i3,hht-si2")
    real, calls = running.simulate_case, []

    def interrupted(*given):
        calls.append(1)
        if len(calls) > 11:  # two runs, and three rounds or more of up to three runs each
            raise KeyboardInterrupt
        return real(*given)

    for module in ("runner", "compute"):
        monkeypatch.setattr(f"mbdsl.studies.{module}.simulate_case", interrupted)
    code, _, err = say(*argv)
    assert code == 130 and "2 runs are stored; the same command continues" in err
