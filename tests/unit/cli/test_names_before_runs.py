"""Names of signals, frames and joints are checked before a model is simulated."""

from pathlib import Path

import pytest

from mbdsl.cli import main

MODEL = str(Path(__file__).parents[3] / "models" / "slider_crank.mbd")


@pytest.fixture
def no_run(monkeypatch, tmp_path):
    def refuse(*given, **named):
        raise AssertionError("a run begins")

    for name in ("simulation.simulate.simulate", "analysis.equilibria.static", "analysis.operating_points.find"):
        monkeypatch.setattr(f"mbdsl.{name}", refuse)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("plot", MODEL, "--signals", "B.xx"), "`B.xx`"),
        (("plot", MODEL, "--against", "crank.ph"), "`crank.ph`"),
        (("animate", MODEL, "--trace", "C"), "there is no frame or joint `C`"),
        (("animate", MODEL, "--trace", "wall"), "`wall` does not move"),
        (("animate", MODEL, "--signals", "no*"), "`no*`"),
        (("simulate", MODEL, "--signals", "O.fq"), "`O.fq`"),
        (("static", MODEL, "--signals", "O.fq"), "`O.fq`"),
        (("study", "convergence", MODEL, "--signals", "O.fq", "--steps", "1ms,2ms"), "`O.fq`"),
        (("linearise", MODEL, "--inputs", "nothing"), "nothing"),
        (("linearise", MODEL, "--signals", "nothing"), "nothing"),
    ],
    ids=lambda x: " ".join(x[:1] + x[2:3]) if isinstance(x, tuple) else "",
)
def test_a_name_that_is_not_there(command, said, no_run, capsys):
    assert main(list(command)) == 2
    assert said in capsys.readouterr().err


def test_a_joint_is_traced_at_its_moving_frame(tmp_path, monkeypatch):
    import mbdsl
    from mbdsl.viewing.animation import traced_point

    scene = mbdsl.load(MODEL)
    assert traced_point(scene, "A") == "rod.a"
    assert traced_point(scene, "O") == "crank.a"  # its frame_a is on the ground
    assert traced_point(scene, "rod") == "rod.c"
    assert traced_point(scene, "A.frame_a") == "crank.b"
