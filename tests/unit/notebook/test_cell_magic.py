"""The cell magic: variables, options, messages with line and column, and errors without a traceback."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError

MODEL = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
FALL = """model Fall "A mass that falls"
  parameter Acceleration g = 10 m/s2;
  Ground ground(g = g);
  PointMass m(m = 1 kg);
  FreeMotion free(ground, m);
initial equation
  m.y = 0;
  m.vy = 0;
end Fall;
"""


@pytest.fixture
def mbd(shell):
    """``mbd(line, text)``: the result of a cell with the magic."""
    assert shell.run("%load_ext mbdsl").success
    return lambda line, text=FALL: shell.run(f"%%mbd {line}\n{text}")


def test_a_cell_becomes_a_scene(mbd, shell):
    done = mbd("fall")
    assert done.success and done.value is shell.names["fall"] == mbdsl.parse(FALL)
    assert "fall_run" not in shell.names


def test_options_are_those_of_the_command_line(mbd, shell):
    text = MODEL.read_text(encoding="utf-8")
    done = mbd("crank --set 'k=0.2 N/mm' --simulate --step 2ms --stop 0.2s --interval '100 ms'", text)
    run = shell.names["crank_run"]
    assert done.success and done.value is run and shell.names["crank"] is run.scene
    assert run.scene.parameters["k"].value == 200.0
    assert run.t.tolist() == [0.0, 0.1, 0.2] and run.stats["h"] == 2e-3
    wanted = mbdsl.simulate(mbdsl.load(MODEL, {"k": 200.0}), step=2e-3, stop=0.2, interval=0.1)
    np.testing.assert_array_equal(run.q, wanted.q)
    assert mbd("crank --without damping", text).success
    assert shell.names["crank"].components["spring"].values["c"] == 0.0 and shell.names["crank_run"] is run


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("", "ModelError: <cell>:5:3: there is no kind of component or model called `PointMas`\n"),
        ("--nonsense", "UsageError: %mbd has no option `--nonsense`\n  = see %mbd --help"),
        ("--simulate --stpe 1ms", "UsageError: %mbd has no option `--stpe`\n  = did you mean `--stop` or `--step`?"),
        ("--simulate --stop 2 s", "UsageError: `2 s` after --stop is two words: the value ends at the space\n"),
        ("--stop 1s", "UsageError: --stop without --simulate\n  = add --simulate, or omit them"),
        ("--simulate 2x", "UsageError: `2x` is not the name of a variable"),
        ("--set", "UsageError: argument --set: expected one argument"),
        ("--set 'g", "UsageError: cannot read the options"),
        ("--model Other", "UsageError: <cell> has no model `Other`"),
    ],
)
def test_an_error_is_one_message(mbd, shell, line, said):
    text = FALL if line else FALL.replace("PointMass m", "PointMas m")
    done = mbd(f"fall {line}", text)
    assert not done.success and isinstance(done.error, mbdsl.MbdslError)
    assert done.text.strip().startswith(said)
    assert "Traceback" not in done.text and ".py" not in done.text and "get_ipython" not in done.text
    assert "fall" not in shell.names


def test_an_unknown_method_has_a_suggestion(mbd):
    said = mbd("fall --simulate --method hht-s2", FALL).text.strip()
    assert said.startswith("UsageError: there is no method `hht-s2`\n  = did you mean `hht-si2`")


def test_the_caret_is_below_the_word(mbd):
    """Lines count from that of the magic, as the editor of a notebook counts them."""
    lines = mbd("fall", FALL.replace("= g)", "= 3 kg)")).text.strip().splitlines()
    assert lines[0].startswith("ModelError: <cell>:4:21: ")
    assert lines[1].strip() == "Ground ground(g = 3 kg);"
    start = lines[2].index("^")
    assert lines[1][start : start + lines[2].count("^")] == "3 kg"


def test_names_are_those_of_variables(mbd, shell):
    for name in ("2a", "a.b", "class", "--"):
        done = mbd(name)
        assert not done.success and isinstance(done.error, mbdsl.UsageError)
    assert "needs the name of a variable" in mbd("").text
    assert "has no cell" in shell.run("%mbd fall").text


def test_help_lists_the_options(mbd, shell):
    text = shell.run("%mbd --help").text
    assert all(f"--{option}" in text for option in ("simulate", "method", "step", "tol", "stop", "set", "without"))


def test_results_up_to_a_failure_are_kept(mbd, shell, monkeypatch):
    def fail(scene, **settings):
        problem = IntegrationError("no solution at t = 1 s")
        problem.trajectory = settings
        raise problem

    monkeypatch.setattr("mbdsl.api.simulate", fail)
    done = mbd("fall --simulate --stop 2s")
    assert done.text.strip() == "IntegrationError: no solution at t = 1 s"
    assert shell.names["fall_run"]["stop"] == 2.0 and shell.names["fall"].name == "Fall"


def test_warnings_of_the_model_are_shown(mbd):
    done = mbd("fall", FALL.replace("initial", "  SpringDamper s(m, m, k = 1 N/m);\ninitial", 1))
    assert done.success
    assert "<cell>:7:16: warning: SpringDamper `s` has both frames on one body and cannot move anything\n" in done.text
