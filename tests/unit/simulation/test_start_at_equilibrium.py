"""Runs that begin at the equilibrium: it stays what it is, and a load that begins later moves it as its closed form."""

import math

import numpy as np
import pytest

import mbdsl
from mbdsl import cli
from mbdsl.errors import EquilibriumError, UsageError

SCALE = """
model Scale
  parameter Force F = 0 N;
  Ground ground(frames(up = {0 m, 0 m, 90 deg}));
  PointMass load(m = 2 kg);
  Prismatic guide(ground.up, load);
  SpringDamper spring(ground, load, k = 1 N/mm, s0 = 1 m);
  Force pull(load, fy = if time > 0.1 s then -F else 0 N);
initial equation
  load.y = -1.2 m;
  load.vy = 3 m/s;
  annotation(experiment(StopTime = 0.5 s));
end Scale;
"""
CRANE = """
model Crane
  Ground ground(frames(mast = {0 m, 3 m, 0 rad}));
  Rod boom(m = 80 kg, length = 4 m);
  PointMass hook(m = 200 kg);
  Revolute foot(ground, boom.a);
  SpringDamper stay(ground.mast, boom.b, k = 40 kN/m, s0 = 4 m);
  Distance rope(boom.b, hook, length = 2 m);
initial equation
  foot.phi = 60 deg;
  guess hook.x = 3 m;
  guess hook.y = 1 m;
  annotation(experiment(StopTime = 0.5 s));
end Crane;
"""
DOOR = """
spatial model Door
  Ground ground;
  Body leaf(m = 3 kg, I = {0.1 kg.m2, 0.1 kg.m2, 0.2 kg.m2}, frames(edge = {-0.5 m, 0 m, 0 m}));
  Revolute hinge(ground, leaf.edge, n = {0, 1, 0});
  RotationalSpringDamper closer(ground, leaf.edge, n = {0, 1, 0}, k = 20 N.m/rad, phi0 = 400 deg);
  annotation(experiment(StopTime = 0.3 s));
end Door;
"""
BEAM = """
model Cantilever
  Ground world;
  FlexibleBeam beam(length = 1 m, mass = 1 kg, S = 1e-4 m2, I = 1e-9 m4, E = 200 GPa, {how});
  Fixed clamp(world, beam.a);
  annotation(experiment(StopTime = 0.05 s));
end Cantilever;
"""


@pytest.fixture
def scale(tmp_path):
    path = tmp_path / "scale.mbd"
    path.write_text(SCALE)
    return path


def test_a_mass_on_a_spring_stays_where_it_hangs(scale):
    found = mbdsl.simulate(scale, initial="static", step=1e-3)
    np.testing.assert_allclose(found["load.y"], -1.0 - 2.0 * 9.81 / 1000.0, atol=1e-12)
    np.testing.assert_allclose(found["load.vy"], 0.0, atol=1e-11)
    np.testing.assert_allclose(found["spring.force"], 2.0 * 9.81, rtol=1e-10)


def test_a_sudden_load_moves_it_twice_as_far_as_at_rest(scale):
    """y = -F/k (1 - cos w (t - 0.1 s)) below the equilibrium."""
    found = mbdsl.simulate(scale, parameters={"F": 50.0}, initial="static", tol=1e-7, method="dop853")
    t = np.maximum(found.t - 0.1, 0.0)
    expected = -1.01962 - 0.05 * (1.0 - np.cos(math.sqrt(500.0) * t))
    np.testing.assert_allclose(found["load.y"], expected, atol=1e-6)


def test_the_load_of_the_start_time_counts(scale):
    found = mbdsl.simulate(scale, parameters={"F": 50.0}, initial="static", start=0.2, stop=0.3, step=1e-3)
    np.testing.assert_allclose(found["load.y"], -1.06962, atol=1e-11)


@pytest.mark.parametrize("general", [False, True])
def test_a_mechanism_with_loads_stays(general):
    scene = mbdsl.parse(CRANE)
    still = mbdsl.static(scene)
    found = mbdsl.simulate(scene, initial="static", step=1e-3, general=general)
    for name in ("foot.phi", "hook.x", "hook.y"):
        np.testing.assert_allclose(found[name], still[name], atol=1e-9)
    assert np.ptp(mbdsl.simulate(scene, step=1e-3)["foot.phi"]) > 0.1  # which moves from its own initial values


def test_turns_in_space_are_kept():
    """A spring that is unstressed at 400 degrees holds a door against its weight."""
    scene = mbdsl.parse(DOOR)
    still = mbdsl.static(scene)
    found = mbdsl.simulate(scene, initial="static", step=1e-3)
    assert still["closer.phi"] == pytest.approx(math.radians(400.0))
    np.testing.assert_allclose(found["closer.phi"], still["closer.phi"], atol=1e-9)
    np.testing.assert_allclose(found["leaf.z"], still["leaf.z"], atol=1e-9)


@pytest.mark.parametrize(
    "how",
    [
        'reference = "clamped-free"',
        'basis = "craig-bampton", modes = 6',
        'formulation = "ancf", elements = 4',
        'reference = "clamped-free", shape = "static"',
    ],
)
def test_beams_begin_in_the_shape_of_the_equilibrium(how):
    scene = mbdsl.parse(BEAM.replace("{how}", how))
    still = mbdsl.static(scene)
    assert still["beam.b.y"] == pytest.approx(-9.81 / (8.0 * 200.0), rel=2e-2)  # m g L^3/(8 E I)
    found = mbdsl.simulate(scene, initial="static", step=1e-3)
    np.testing.assert_allclose(found["beam.b.y"], still["beam.b.y"], rtol=1e-7)
    np.testing.assert_allclose(found["clamp.tau"], still["clamp.tau"], rtol=1e-5)


def test_a_beam_with_rigid_bodies_that_are_reduced():
    """Two bodies that are welded to each other at the tip: m g L^3/(8 E I) + M g L^3/(3 E I), small deflections."""
    text = BEAM.replace("{how}", 'reference = "clamped-free"')
    bodies = "Body tip(m = 0.1 kg, I = 1e-6 kg.m2); Body lamp(m = 0.1 kg, I = 1e-6 kg.m2);"
    text = text.replace("  ann", f"  {bodies} Fixed glue(beam.b, tip.c); Fixed screw(tip.c, lamp.c);\n  ann")
    scene = mbdsl.parse(text)
    still = mbdsl.static(scene)
    assert still["lamp.y"] == pytest.approx(-9.81 / 1600.0 - 0.2 * 9.81 / 600.0, rel=1e-2)
    found = mbdsl.simulate(scene, initial="static", step=1e-4, stop=0.02)
    np.testing.assert_allclose(found["lamp.y"], still["lamp.y"], rtol=1e-6)


def test_accuracy_and_inputs(scale):
    found = mbdsl.simulate(scale, parameters={"F": 50.0}, initial="static", accuracy=1e-4)
    assert found["load.y"][0] == pytest.approx(-1.01962, abs=1e-12)
    assert found["load.y"].min() == pytest.approx(-1.11962, abs=2e-4)
    text = SCALE.replace("parameter Force F = 0 N", "input Force u(start = 0 N)")
    text = text.replace("if time > 0.1 s then -F else 0 N", "-u")
    found = mbdsl.simulate(mbdsl.parse(text), initial="static", inputs={"u": 50.0}, step=1e-3, stop=0.1)
    np.testing.assert_allclose(found["load.y"], -1.06962, atol=1e-9)


def test_a_saddle_point_is_left():
    scene = mbdsl.parse(
        "model Upright\n  Ground ground;\n  Rod rod(m = 1 kg, length = 1 m);\n  Revolute pin(ground, rod.a);\n"
        "initial equation\n  pin.phi = 90 deg;\n  annotation(experiment(StopTime = 0.1 s));\nend Upright;"
    )
    found = mbdsl.simulate(scene, initial="static", step=1e-3)  # the search leaves the saddle point
    np.testing.assert_allclose(np.cos(found["pin.phi"] + math.pi / 2), 1.0, atol=1e-9)


def test_messages():
    scene = mbdsl.parse(SCALE)
    with pytest.raises(UsageError, match=r"initial: found 'steady', expected a mapping .* or \"static\""):
        mbdsl.simulate(scene, initial="steady")
    falling = mbdsl.parse(
        "model Falling\n  Ground ground;\n  PointMass load(m = 2 kg);\n  FreeMotion free(ground, load);\nend Falling;"
    )
    with pytest.raises(EquilibriumError):
        mbdsl.simulate(falling, initial="static", stop=1.0)


def test_the_command_and_its_checkpoint(scale, tmp_path, capfd):
    words = ["simulate", str(scale), "--from", "static", "--step", "1ms", "--set", "F=50 N", "--quiet"]
    file = tmp_path / "run.csv"
    assert cli.main([*words, "--signals", "load.y", "--output", str(file)]) == 0
    y = np.loadtxt(file, delimiter=",", skiprows=1)[:, 1]
    assert (y[0], y.min()) == pytest.approx((-1.01962, -1.11962), abs=1e-5)
    assert cli.main([*words[:2], "--from", "rest"]) == 2
    assert "static" in capfd.readouterr().err


def test_a_checkpoint_remembers_where_the_run_begins(scale, tmp_path, monkeypatch):
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 120)
    whole = mbdsl.simulate(scale, initial="static", step=1e-3, parameters={"F": 50.0})
    file = tmp_path / "run.check"

    def stop(now):
        if now.t > 0.0:
            raise KeyboardInterrupt

    with pytest.raises(mbdsl.Interrupted):
        mbdsl.simulate(scale, initial="static", step=1e-3, parameters={"F": 50.0}, checkpoint=file, progress=stop)
    found = mbdsl.resume(file)
    np.testing.assert_array_equal(found["load.y"], whole["load.y"])
