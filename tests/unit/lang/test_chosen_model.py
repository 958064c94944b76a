"""`--model NAME` and `load(path, model=...)`: the model of a file with several."""

import re
from types import SimpleNamespace

import pytest

import mbdsl
from mbdsl import cli
from mbdsl.lang.load import chosen_now
from mbdsl.studies.cases import setting

ARMS = """partial model Base
  Ground ground;
  parameter Length L = 1 m;
end Base;
model ShortArm
  extends Base(L = 0.5 m);
  Rod rod(m = 1 kg, length = L);
  Revolute pin(ground, rod.a);
  annotation(experiment(StopTime = 1 s));
end ShortArm;
model LongArm
  extends Base(L = 2 m);
  Rod rod(m = 1 kg, length = L);
  Revolute pin(ground, rod.a);
  annotation(experiment(StopTime = 1 s));
end LongArm;
"""


@pytest.fixture
def arms(tmp_path, say):
    (tmp_path / "arms.mbd").write_text(ARMS, encoding="utf-8")
    return tmp_path / "arms.mbd"


def test_load_reads_the_named_model(arms):
    found = {name: mbdsl.load(arms, model=name) for name in ("ShortArm", "LongArm")}
    assert [scene.parameters["L"].value for scene in found.values()] == [0.5, 2.0]
    assert mbdsl.load(arms).name == "LongArm"  # the last


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("longarm", "has no model `longarm`\n  = did you mean `LongArm`? its models are ShortArm, LongArm\n"),
        ("Crane", "has no model `Crane`\n  = its models are ShortArm, LongArm\n"),
        (
            "Base",
            "model `Base` of arms.mbd is partial\n    partial model Base\n                  ^^^^\n"
            "  = choose a model that extends it: ShortArm, LongArm\n",
        ),
    ],
)
def test_a_wrong_name_lists_the_models(arms, say, name, message):
    code, out, err = say("check", "arms.mbd", "--model", name)
    assert (code, out) == (2, "") and err.endswith(message)


def test_a_file_with_partial_models_only(tmp_path, say):
    (tmp_path / "base.mbd").write_text("partial model Base\n  Ground ground;\nend Base;\n", encoding="utf-8")
    code, _, err = say("check", "base.mbd", "--model", "Arm")
    assert code == 2 and err.endswith("\n  = it has no model that is not partial\n")


def reading_commands():
    """The commands whose usage names a model, each with its other required arguments."""
    needed = {"graph": ["--quick"], "show": ["--stage", "scene"], "recommend": ["--error", "1e-3"]}
    needed |= {"sweep": ["--vary", "L=1,2"], "solve": ["--vary", "L=1:2", "--for", "max(rod.x) = 1 m"]}
    usages = {name: cli.make_parser(name) for name in cli.commands()}
    for name, parser in usages.items():
        usage = parser._subparsers._group_actions[0].choices[name].format_usage()
        if re.search(r"\bMODEL\b", usage) and name != "help":
            yield [name, *needed.get(name, [])]
    for kind in ("convergence", "energy", "drift", "runtime", "work-precision"):
        yield ["study", kind]
    yield ["study", "effects", "--signal", "rod.phi"]


@pytest.mark.parametrize("words", list(reading_commands()), ids=" ".join)
def test_every_command_that_reads_a_model_has_the_option(arms, say, words):
    """The message proves that the command has looked for the model."""
    code, _, err = say(*words, "arms.mbd", "--model", "Crane")
    assert code == 2 and err.startswith("error: arms.mbd has no model `Crane`")


def test_there_are_many_such_commands():
    assert len(list(reading_commands())) > 15


def test_outputs_are_named_after_the_chosen_model(arms, say, monkeypatch):
    from mbdsl.cli import simulate

    seen = []
    monkeypatch.setattr(simulate, "_run", lambda args, scene, options, parse, output, *rest: seen.append(output) or 0)
    say("simulate", "arms.mbd")
    say("simulate", "arms.mbd", "--model", "ShortArm")
    assert seen == ["arms.csv", "ShortArm.csv"]


def test_a_study_and_its_command_keep_the_choice(arms):
    from mbdsl.lang.load import model_chosen

    with model_chosen("ShortArm"):
        of = setting("arms.mbd")
    assert (of.scene.name, of.model_name) == ("ShortArm", "ShortArm")
    assert chosen_now() is None


def test_the_option_excludes_results_and_syntax(arms, say):
    (arms.parent / "r.csv").write_text("time,x\n0,1\n1,2\n", encoding="utf-8")
    code, _, err = say("plot", "r.csv", "--model", "ShortArm")
    assert code == 2 and err.startswith("error: --model belongs to a model, and these are results")
    code, _, err = say("show", "--stage", "syntax", "arms.mbd", "--model", "ShortArm")
    assert code == 2 and err.startswith("error: --model changes no syntax")


def test_a_resumed_run_reads_the_chosen_model(arms):
    from mbdsl.cli._values import load_model

    args = SimpleNamespace(model="arms.mbd", set=[], without=(), model_name="ShortArm")
    assert load_model(args).name == "ShortArm"
    del args.model_name  # a checkpoint of an earlier version
    assert load_model(args).name == "LongArm"
