"""Forces that jump exactly at the stop time: the last output is there, and is the state before the jump acts.

A wheel of I = 1 kg m2 turns under a torque; w(4 s) is the integral of the torque.
"""

from itertools import product

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import compiled, declared

LAWS = {
    "if time < 4 s then 1 N.m else 0 N.m": 4.0,
    "if time >= 4 s then 1e3 N.m else 1 N.m": 4.0,
    "if mod(time, 1 s) < 0.5 s then 2 N.m else 0 N.m": 4.0,
    "(floor(time/(1 s)) + 1)*(1 N.m)": 10.0,
    "saw(time)": 4.0,
    "(1 + sign(time - 4 s))*(1 N.m)": 0.0,
}
TEXT = """model Stop
  Ground ground;
  Body wheel(m = 1 kg, I = 1 kg.m2);
  Revolute shaft(ground, wheel.c);
  Table saw(table = [0 s, 0 N.m; 1 s, 2 N.m; 2 s, 0 N.m], extrapolation = "periodic");
  Torque tool(shaft, tau = LAW);
  annotation(experiment(StopTime = 4 s));
end Stop;
"""
METHODS = [*compiled(), "scipy-radau", "scipy-lsoda"]
#: each method with three laws, in the plane and in space in turn
CASES = [(list(LAWS)[(k + i) % len(LAWS)], x, (k + i) % 2 == 1) for k, x in enumerate(METHODS) for i in (0, 1, 3)]
OUTPUTS = ({}, {"interval": 2.0}, {"interval": 0}, {"times": [2.0, 4.0]})


def text(law, spatial):
    planar = TEXT.replace("LAW", law)
    return "spatial " + planar.replace("I = 1 kg.m2", "I = {1, 1, 1} kg.m2") if spatial else planar


@pytest.mark.parametrize(("law", "method", "spatial"), CASES)
def test_the_last_output_is_there(law, method, spatial):
    scene = mbdsl.parse(text(law, spatial))
    steps = [{"tol": 1e-6}, {"step": 0.01}] if method in compiled() else [{"tol": 1e-6}]
    for how, outputs in product(steps, OUTPUTS):
        run = mbdsl.simulate(scene, method=method, **outputs, **how)
        assert run.t[-1] == 4.0
        if outputs:
            assert outputs == {"interval": 0} or list(run.t[-2:]) == [2.0, 4.0]
        # fixed steps: the force of a step is that at its end, or of one side of a jump
        most = 1e-5 if "tol" in how else 0.05 if declared(method).order <= 2 else 1e-5
        assert run["shaft.w"][-1] == pytest.approx(LAWS[law], abs=most)


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "dop853"])
def test_a_speed_that_jumps_at_the_stop_time(method):
    law = "  RotationalVelocityDriver tool(shaft, w = if time < 4 s then 1 rad/s else 3 rad/s);"
    scene = mbdsl.parse(TEXT.replace("  Torque tool(shaft, tau = LAW);", law))
    run = mbdsl.simulate(scene, method=method, tol=1e-6, interval=1.0)
    assert np.array_equal(run.t, [0.0, 1.0, 2.0, 3.0, 4.0])
    assert run["shaft.phi"] == pytest.approx(run.t, abs=1e-9)


def test_a_finished_run_without_an_output_is_an_internal_error(monkeypatch):
    from mbdsl.integrators.run import MethodRun

    monkeypatch.setattr(MethodRun, "_record_end", lambda *_: None)
    with pytest.raises(RuntimeError, match="has 1 of 2 outputs"):
        mbdsl.simulate(mbdsl.parse(text("if time < 4 s then 1 N.m else 0 N.m", False)), tol=1e-6, times=[4.0])
