"""Runs step by step in space: the bits of a run, saved states, copies, and angles that count turns."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError

TOP = Path(__file__).parents[3] / "models" / "space" / "heavy_top.mbd"
WOUND = """
spatial model Wound "A flywheel on a torsional spring, about a tilted axis"
  Ground ground(g = 0);
  Body wheel(m = 1 kg, I = {1, 1, 1} kg.m2);
  Revolute hinge(ground, wheel.c, n = {1, 2, 2});
  RotationalSpringDamper spring(ground, wheel.c, n = {1, 2, 2}, k = 0.01 N.m/rad);
initial equation
  hinge.w = 10 rad/s;
end Wound;
"""


@pytest.mark.parametrize("method", ["hht-si2", "nstiff", "radau5", "radau9", "dop853"])
def test_the_same_bits_as_a_run(method):
    steps = mbdsl.Simulation(TOP, step=1e-3, method=method)
    steps.step(50)
    found = steps.trajectory()
    run = mbdsl.simulate(TOP, method=method, step=1e-3, stop=0.05, interval=1e-3)
    assert np.array_equal(found.q, run.q) and np.array_equal(found.v, run.v)
    for name in ("top.x", "top.wy"):
        assert np.array_equal(found[name], run[name])
        # the attitude from the quaternion or from the rotation vector, which are rounded differently
        assert steps[name] == pytest.approx(run[name][-1], rel=2e-15)
    # of methods without reactions of their own, these follow from the state, for many states at once or for one
    assert steps["ball.fz"] == pytest.approx(run["ball.fz"][-1], rel=1e-13)
    assert abs(steps["top.p2"]) == pytest.approx(abs(run["top.p2"][-1]), rel=1e-14)  # both signs are the same attitude


def test_saved_states_copies_and_pickles():
    steps = mbdsl.Simulation(TOP, step=1e-3)
    steps.step(20)
    state, copy, other = steps.state, steps.copy(), pickle.loads(pickle.dumps(steps))
    found = []
    for each in (steps, copy, other):
        each.step(30)
        found.append(each["top.x"])
    steps.state = state
    steps.step(30)
    assert len({*found, steps["top.x"]}) == 1


def test_angles_count_turns():
    """phi = w0/w sin(w t) with w = sqrt(k/J): 4.7 turns. HHT's error is (h w)^2/12, which is below rounding here."""
    steps = mbdsl.Simulation(mbdsl.parse(WOUND), step=1e-3, general=True)
    steps.step(3000)
    assert steps["hinge.phi"] == pytest.approx(100 * np.sin(0.3), rel=1e-7)
    blind = mbdsl.Simulation(mbdsl.parse(WOUND), step=1e-3, record=False)
    blind.step(10)
    assert blind["hinge.w"] == pytest.approx(10 * np.cos(0.001), rel=1e-7)
    with pytest.raises(UsageError, match="angles in space that count turns follow from all states"):
        blind["hinge.phi"]


#: a wheel on a frame off the centres of mass, turned by an input
WHEEL = """
spatial model Wheel
  input Torque u(start = 0.1 N.m);
  Ground ground(g = 0);
  Body bus(m = 3 kg, I = {0.8, 1.1, 0.9} kg.m2, frames(a = {0.3, 0.1, -0.2} m));
  Cylinder wheel(m = 0.5 kg, length = 0.05 m, radius = 0.15 m, n = {1, 0, 0}, frames(s = {0.04, 0, 0} m));
  PointMass p(m = 1 kg);
  FreeMotion free(ground, bus.c);
  SpringDamper s(bus.a, p, k = 20 N/m, s0 = 0.5 m);
  Revolute j(bus.a, wheel.s, n = {1, 0, 0});
  Torque t(bus.a, wheel.s, n = {1, 0, 0}, tau = u - 0.001 N.m.s/rad*j.w);
initial equation
  bus.wx_local = 0.2 rad/s; bus.wy_local = -0.3 rad/s; bus.wz_local = 0.5 rad/s; p.y = 1 m; j.w = 30 rad/s;
end Wheel;
"""


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_rotors_of_gyrostats(method):
    """Signals of each body from its gyrostat, reactions of the hinge from the motion; states, copies and pickles."""
    scene = mbdsl.parse(WHEEL)
    steps = mbdsl.Simulation(scene, step=1e-2, method=method)
    steps.step(20)
    state, copy, other = steps.state, steps.copy(), pickle.loads(pickle.dumps(steps))
    found = []
    for each in (steps, copy, other):
        each.step(30)
        found.append(each["wheel.wy"])
    steps.state = state
    steps.inputs.u = 0.1
    steps.step(30)
    assert len({*found, steps["wheel.wy"]}) == 1
    run = mbdsl.simulate(scene, method=method, step=1e-2, stop=0.5, interval=1e-2)
    for body in ("bus", "wheel"):
        for key in ("x", "y", "vx", "vz", "wx", "wy", "wz_local", "phi_y"):
            assert steps[f"{body}.{key}"] == pytest.approx(run[f"{body}.{key}"][-1], rel=1e-13, abs=1e-14)
        assert abs(steps[f"{body}.p1"]) == pytest.approx(abs(run[f"{body}.p1"][-1]), rel=1e-13)
    for name in ("p.x", "p.vy", "j.w", "j.fx", "j.ty", "wheel.s.vz", "j.phi", "energy.total"):
        assert steps[name] == pytest.approx(run[name][-1], rel=1e-12, abs=1e-14), name
    steps.inputs.u = 0.3
    steps.step(1)
    turned = steps["wheel.wx_local"]
    # the moment about the axle is that of the torque, 0.3 - 0.001 w N.m, to second order in the step
    slope = (turned - run["wheel.wx_local"][-1]) / 1e-2
    assert slope == pytest.approx((0.3 - 0.001 * steps["j.w"]) / (0.5 * 0.15**2 / 2), rel=1e-3)


FURUTA = """
spatial model Furuta
  input Torque u(start = 0.02 N.m);
  Ground ground(n = {0, 0, -1});
  Body arm(m = 0.25 kg, I = {2e-4, 9e-4, 1.2e-3} kg.m2,
    com = {0.07, 0.01, 0} m, frames(a = {0, 0, 0}, b = {0.22, 0, 0.03} m));
  Body pend(m = 0.12 kg, I = {{8e-4, 0, 0}, {0, 7.9e-4, 2e-5}, {0, 2e-5, 2e-5}} kg.m2,
    com = {0.01, 0.002, 0.14} m, frames(a = {0, 0, 0}));
  Revolute theta(ground, arm.a, n = {0, 0, 1});
  Revolute alpha(arm.b, pend.a, n = {1, 0, 0});
  Torque motor(theta, tau = u - 0.001 N.m.s/rad*theta.w);
  RotationalSpringDamper f(alpha, c = 1e-4 N.m.s/rad);
initial equation
  theta.phi = 0.3 rad; alpha.phi = 0.25 rad; theta.w = 6 rad/s; alpha.w = -1.5 rad/s;
  annotation(experiment(StopTime = 2 s, Interval = 10 ms));
end Furuta;
"""
SWING = """
spatial model Swing "Two rods that turn in one plane, which the equations are reduced to"
  Ground ground;
  Body arm(m = 1 kg, I = {0.02, 0.02, 0.02} kg.m2, frames(a = {0, -0.3, 0}, b = {0, 0.3, 0}));
  Body fore(m = 1 kg, I = {0.02, 0.02, 0.02} kg.m2, frames(a = {0, -0.3, 0}));
  Revolute top(ground, arm.a, n = {1, 0, 0});
  Revolute mid(arm.b, fore.a, n = {1, 0, 0});
initial equation
  top.w = 14 rad/s; mid.w = 9 rad/s;
end Swing;
"""
HINGES = {FURUTA: ("theta.phi", "alpha.phi"), SWING: ("top.phi", "mid.phi")}


@pytest.mark.parametrize("chunk", [1, 8, 400, 2000])
@pytest.mark.parametrize("text", HINGES, ids=["in space", "in a plane"])
def test_hinge_angles_are_counted_while_the_run_steps(text, chunk):
    """Their turns are those of the stored states, whether the angles are read often or once, and nothing is stored."""
    names = HINGES[text]
    stored = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    stored.step(2000)
    expected = [stored.trajectory()[name][-1] for name in names]
    assert max(np.abs(expected)) > 2.0 * np.pi
    blind = mbdsl.Simulation(mbdsl.parse(text), step=1e-3, record=False)
    read = blind.reader(*names)
    for _ in range(2000 // chunk):
        blind.step(chunk)
    copy, pickled, state = blind.copy(), pickle.loads(pickle.dumps(blind)), blind.state
    for each in (blind, copy, pickled):
        assert [each[name] for name in names] == pytest.approx(expected, abs=1e-9)
    assert read() == pytest.approx(expected, abs=1e-9)
    assert [stored[name] for name in names] == pytest.approx(expected, abs=1e-9)  # first read here
    blind.step(500)
    blind.state = state
    assert read() == pytest.approx(expected, abs=1e-9)
    blind.reset()
    first = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    assert read() == pytest.approx([first[name] for name in names], abs=1e-12)


@pytest.mark.parametrize("text", [FURUTA, SWING], ids=["in space", "in a plane"])
def test_signals_are_read_from_the_buffers(text):
    """Functions over the buffers give the values of arrays, of all signals of frames, joints and forces."""
    steps = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    steps.step(300)
    present = steps._reading()
    names = [name for name in present.known.expressions if ".f" not in name and ".t" not in name]
    functions = [present._compiled([present.known.expressions[name][0]]) for name in names]
    assert None not in functions
    whole = steps.trajectory()
    assert [float(f()[0]) for f in functions] == pytest.approx([whole[name][-1] for name in names], rel=1e-9, abs=1e-12)
