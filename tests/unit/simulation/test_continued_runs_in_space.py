"""A run in space that begins at the final state of another one has the same state, and angles that go on counting."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.mechanism.signal_names import SignalNames

SPACE = Path(__file__).parents[3] / "models" / "space"
#: model, and time of the change
CASES = {"heavy_top": 0.1, "cardan_shaft": 0.53, "dzhanibekov": 2.0, "rolling_coin": 0.5}


@pytest.mark.parametrize("name", CASES)
def test_the_state_and_the_turns_are_those_at_the_end(name):
    scene, at = mbdsl.load(SPACE / f"{name}.mbd"), CASES[name]
    a = mbdsl.simulate(scene, stop=at, interval=2e-3, step=1e-3)
    b = mbdsl.simulate(scene, start=at, stop=at + 1e-2, interval=2e-3, step=1e-3, initial=a)
    scale = a.system.tables.scale
    assert np.abs((b.q[0] - a.q[-1]) * scale).max() < 1e-14  # rotation vectors and positions: rounding
    # stabilised methods end with constraints of velocities below 1e-11, which the assembly closes
    assert np.abs((b.v[0] - a.v[-1]) * scale).max() < 1e-10 * np.abs(a.v[-1] * scale).max()
    assert b.moved == ()
    counted = [x for x, (e, _) in SignalNames(scene).expressions.items() if e.op == "angle" and x in scene.signals()]
    assert counted
    for signal in counted:
        # angles of axes that are nearly parallel to that of the angle have errors that are larger than rounding
        assert b[signal][0] == pytest.approx(a[signal][-1], abs=1e-8)


def test_the_motion_goes_on_as_without_a_stop():
    scene, given = mbdsl.load(SPACE / "dzhanibekov.mbd"), {"step": 1e-3, "interval": 0.1, "method": "hht-si2"}
    whole = mbdsl.simulate(scene, stop=1, **given)
    first = mbdsl.simulate(scene, stop=0.5, **given)
    second = mbdsl.simulate(scene, start=0.5, stop=1, initial=first, **given)
    n = len(second.t)
    for name in ("nut.wx", "nut.wy", "nut.wz", "nut.phi_x", "nut.phi_y", "nut.phi_z"):
        # a start with exact accelerations differs by the error of those of the method, of order h^2 |w|^4: 1e-2 rad/s2,
        # times the step
        assert second[name] == pytest.approx(whole[name][-n:], abs=1e-5)


def test_a_driven_angle_keeps_its_turns():
    scene = mbdsl.load(SPACE / "cardan_shaft.mbd")
    a = mbdsl.simulate(scene, stop=2.53, interval=1e-2, step=1e-2)
    b = mbdsl.simulate(scene, start=2.53, stop=3, interval=1e-2, step=1e-2, initial=a)
    assert a["front.phi"][-1] > 2 * np.pi
    assert b["front.phi"][0] == pytest.approx(a["front.phi"][-1], abs=1e-10)


def test_a_run_of_bodies_that_only_turn_has_the_size_of_the_first_one():
    """The origins of a gyroscope are one point: their positions at the end of a run are rounding, not the size."""
    model = mbdsl.parse("""spatial model Gyro
  Ground ground;
  Body ring(m = 1 kg, I = {0.005, 0.01, 0.005} kg.m2);
  Body rotor(m = 2 kg, I = {0.02, 0.01, 0.01} kg.m2);
  Revolute M(ground, ring.c, n = {0, 1, 0});
  Revolute R(ring.c, rotor.c, n = {1, 0, 0});
initial equation
  R.w = 20 rad/s; M.w = 1 rad/s;
end Gyro;""")
    given = {"method": "hht-si2", "step": 1e-3}
    first = mbdsl.simulate(model, stop=0.05, **given)
    at_end = {f"{body}.{key}": 1e-17 for body in ("ring", "rotor") for key in "xyz"}
    second = mbdsl.simulate(model, stop=0.05, initial=first, **given)
    assert second.system.tables.size == first.system.tables.size
    assert second["R.phi"][0] == pytest.approx(first["R.phi"][-1], abs=1e-8)
    assert mbdsl.simulate(model, stop=1e-3, initial=at_end, **given).system.tables.size == first.system.tables.size
