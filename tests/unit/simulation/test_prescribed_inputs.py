"""Inputs as functions of time: points, functions, numbers, columns of files; against the same table in the model."""

import numpy as np
import pytest

import mbdsl
from mbdsl import cli, results

TEXT = """{spatial}model Drive
  {u}
  Ground ground(g = 0);
  Body wheel(m = 1 kg, I = {inertia} kg.m2);
  Revolute A(ground, wheel.c);
  Torque motor(A, tau = 2*u - 0.5 N.m.s/rad*A.w);
  annotation(experiment(StopTime = 2 s, Interval = 0.1 s));
end Drive;"""
INPUT = "input Torque u(start = 1 N.m);"


def drive(u=INPUT, spatial=""):
    return mbdsl.parse(TEXT.format(u=u, spatial=spatial, inertia="{1, 1, 1}" if spatial else "1"))


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("given", [{"step": 1e-3}, {"tol": 1e-7, "method": "radau5"}])
def test_points_are_a_table_of_the_model(spatial, given):
    t, u = [0.0, 0.5, 0.7, 2.0], [0.0, 3.0, -1.0, 0.5]
    rows = "; ".join(f"{a} s, {b} N.m" for a, b in zip(t, u, strict=True))
    table = f"Table curve(table = [{rows}]); Torque u = curve(time);"
    found = mbdsl.simulate(drive(spatial=spatial), inputs={"u": (t, u)}, **given)
    expected = mbdsl.simulate(drive(table, spatial), **given)
    assert found["A.w"] == pytest.approx(expected["A.w"], abs=1e-13)
    assert found["motor.tau"] == pytest.approx(2.0 * np.interp(found.t, t, u) - 0.5 * found["A.w"], abs=1e-12)


def test_functions_and_numbers():
    """w' = 2 u - w/2: for sin 3t, w = (24 e^{-t/2} + 4 sin 3t - 24 cos 3t)/37; for 5 N.m, w = 20 (1 - e^{-t/2})."""
    run = mbdsl.simulate(drive(), inputs={"u": lambda t: np.sin(3.0 * t)}, tol=1e-8, method="dop853")
    exact = (24.0 * np.exp(-run.t / 2.0) + 4.0 * np.sin(3.0 * run.t) - 24.0 * np.cos(3.0 * run.t)) / 37.0
    assert run["A.w"] == pytest.approx(exact, abs=2e-7)
    jump = mbdsl.simulate(drive(), inputs={"u": lambda t: 0.0 if t < 1.0 else 2.0}, step=1e-3)
    later = np.maximum(jump.t - 1.0, 0.0)
    assert jump["A.w"] == pytest.approx(8.0 * (1.0 - np.exp(-later / 2.0)), abs=5e-3)
    for constant in (5.0, "5 N.m", "0.005 kN.m"):
        run = mbdsl.simulate(drive(), inputs={"u": constant}, tol=1e-8, method="dop853")
        assert run["A.w"] == pytest.approx(20.0 * (1.0 - np.exp(-run.t / 2.0)), abs=1e-6)


@pytest.mark.parametrize("column", ["u", "torque"])
def test_the_command(tmp_path, monkeypatch, capsys, column):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drive.mbd").write_text(TEXT.format(u=INPUT, spatial="", inertia="1"))
    t = np.array([0.0, 0.4, 1.0, 2.0])
    results.write("torque.csv", {"time": t, column: 3.0 * t})
    assert cli.main(["simulate", "drive.mbd", "--input", "u=torque.csv", "--step", "1ms"]) == 0
    columns, _ = results.read("drive.csv")
    run = mbdsl.simulate("drive.mbd", inputs={"u": (t, 3.0 * t)}, step=1e-3)
    assert columns["wheel.w"] == pytest.approx(run["wheel.w"], abs=1e-12)
    capsys.readouterr()
    for words, message in {
        ("u",): "expected NAME=FILE",
        ("v=torque.csv",): "has no input `v`" if column == "torque" else "no columns `time` and `v`",
        ("u=drive.csv",): "has no columns `time` and `u`",
        ("u=none.csv",): "none.csv",
    }.items():
        if column == "u" and words == ("v=torque.csv",):
            message = "has no input `v`"
        assert cli.main(["simulate", "drive.mbd", "--input", *words]) != 0
        err = capsys.readouterr().err
        assert message in err and "Traceback" not in err


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"v": 1.0}, "has no input `v`"),
        ({"u": ([0.0, 1.0], [1.0])}, "have the shapes"),
        ({"u": ([0.0, 0.0], [1.0, 2.0])}, "times must ascend"),
        ({"u": ([0.0, 1.0], [1.0, np.nan])}, "not finite"),
        ({"u": [1, 2, 3]}, r"expected a pair \(t, u\)"),
        ({"u": lambda t: "x"}, "gives no number"),
        ({"u": "3 m"}, "u"),
    ],
)
def test_what_makes_no_sense(given, words):
    with pytest.raises(mbdsl.MbdslError, match=words):
        mbdsl.simulate(drive(), inputs=given)
