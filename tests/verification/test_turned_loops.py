"""Planar loops in space whose plane turns: motions and reactions do not depend on the direction of the plane.

On a table that turns at a constant rate about the vertical, a loop in a vertical plane moves as in the plane with the
centrifugal forces: for a thin rod m w^2 x at the centre, and the torque -w^2 J sin(phi) cos(phi). The planar model is
solved by mbdsl's planar joints, whose rows are other ones.
"""

import numpy as np
import pytest

import mbdsl

RODS = {"crank": (0.2, 0.1), "coupler": (0.5, 0.3), "rocker": (0.4, 0.25)}
SPACE = """spatial model Table
  Ground ground(n = {{0, 0, -1}});
  Body table(m = 3 kg, I = 0.05 kg.m2, frames(A = {{0, 0, 0}}, D = {{0.3 m, 0, 0}}));
  {rods}
  Revolute turn(ground, table.c, n = {{0, 0, 1}});
  {drive}
  {A}
  {B}
  {C}
  Revolute D(table.D, rocker.a, n = {{0, -1, 0}});
initial equation
  {more}
  A.phi = 90 deg; A.w = 6 rad/s; guess D.phi = 98.86 deg;
  guess coupler.z = 0.15 m; guess rocker.z = 0.12 m;
  annotation(experiment(StopTime = 2.4 s, Interval = 20 ms));
end Table;"""
PLANE = """model Plane
  Ground ground;
  Frame other(ground, r = {{0.3 m, 0}});
  {rods}
  {forces}
  Revolute A(ground, crank.a);
  Revolute B(crank.b, coupler.a);
  Revolute C(coupler.b, rocker.b);
  Revolute D(other, rocker.a);
initial equation
  A.phi = 90 deg; A.w = 6 rad/s; guess D.phi = 98.86 deg;
  guess coupler.y = 0.15 m; guess rocker.y = 0.12 m;
  annotation(experiment(StopTime = 2.4 s, Interval = 20 ms));
end Plane;"""
HINGES = {
    "A": "Revolute A(table.A, crank.a, n = {0, -1, 0});",
    "B": "Revolute B(crank.b, coupler.a, n = {0, -1, 0});",
    "C": "Revolute C(coupler.b, rocker.b, n = {0, -1, 0});",
}


def planar(w):
    rods = "".join(f"Rod {name}(m = {m} kg, length = {length} m);\n" for name, (m, length) in RODS.items())
    forces = "".join(
        f"Force f_{x}({x}.c, fx = {m * w**2!r} N/m*{x}.x); "
        f"Torque t_{x}({x}.c, tau = {-(w**2) * m * length**2 / 12.0!r} N.m*sin({x}.phi)*cos({x}.phi));\n"
        for x, (m, length) in RODS.items()
    )
    return mbdsl.parse(PLANE.format(rods=rods, forces=forces))


def turning(w, **joints):
    rods = "".join(f"Rod {name}(m = {m} kg, length = {length} m);\n" for name, (m, length) in RODS.items())
    drive = f"RotationalDriver drive(turn, phi = {w!r} rad/s*time);"
    return mbdsl.parse(SPACE.format(rods=rods, drive=drive, more="", **{**HINGES, **joints}))


WAYS = [
    ("hht-si2", {"step": 2e-4}, 2e-4),
    ("hht-i3", {"step": 2e-4}, 2e-4),
    ("newmark", {"step": 2e-4}, 0.2),
    ("nstiff", {"step": 2e-4}, 2e-3),
    ("hht-si2", {"tol": 1e-4}, 1e-3),
    ("radau5", {"tol": 1e-6}, 1e-5),
    ("dop853", {"tol": 1e-6}, 1e-5),
]


@pytest.fixture(scope="module")
def plane():
    return mbdsl.simulate(planar(1.3), method="dop853", tol=1e-9)


@pytest.mark.parametrize(("method", "given", "error"), WAYS, ids=[f"{m} {next(iter(g))}" for m, g, _ in WAYS])
def test_a_loop_on_a_turntable(plane, method, given, error, request):
    """Through 180 deg, with the forces in all pins at all angles."""
    if "tol" in given:
        request.getfixturevalue("optimised")
    run = mbdsl.simulate(turning(1.3), method=method, **given)
    assert run["A.phi"] == pytest.approx(plane["A.phi"], abs=10.0 * error)
    along = np.array([np.cos(1.3 * run.t), np.sin(1.3 * run.t)])
    for pin in "BCD":
        size = np.abs(plane[f"{pin}.fx"]).max()
        found = along[0] * run[f"{pin}.fx"] + along[1] * run[f"{pin}.fy"]
        assert found == pytest.approx(plane[f"{pin}.fx"], abs=100.0 * error * size)
        assert run[f"{pin}.fz"] == pytest.approx(plane[f"{pin}.fy"], abs=100.0 * error * size)


@pytest.mark.parametrize(("method", "given"), [("radau5", {"tol": 1e-5}), ("hht-si2", {"step": 2e-4})])
def test_loops_with_other_joints(plane, method, given):
    """With a ball joint and a Cardan joint, no row is redundant but those of the hinges of crank and rocker."""
    cardan = "Universal B(crank.b, coupler.a, n_a = {0, -1, 0}, n_b = {0, 0, 1});"
    run = mbdsl.simulate(turning(1.3, B=cardan, C="Spherical C(coupler.b, rocker.b);"), method=method, **given)
    assert run["A.phi"] == pytest.approx(plane["A.phi"], abs=3e-3)


@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.36, 0.48, 0.8)])
@pytest.mark.parametrize("angle", [0.0, 37.0, 90.0, 143.0])
def test_forces_of_a_loop_in_any_direction(axis, angle, general):
    """A four-bar without gravity in a frame turned about any axis: forces in the axes of that frame are the same."""
    n = ", ".join(map(repr, axis))
    text = f"""spatial model Turned
      Ground ground(g = 0);
      Frame base(ground, n = {{{n}}}, phi = {angle} deg);
      Frame other(base, r = {{0.3 m, 0, 0}});
      Rod crank(m = 0.2 kg, length = 0.1 m); Rod coupler(m = 0.5 kg, length = 0.3 m);
      Rod rocker(m = 0.4 kg, length = 0.25 m);
      Revolute A(base, crank.a); Revolute B(crank.b, coupler.a); Revolute C(coupler.b, rocker.b);
      Revolute D(other, rocker.a);
    initial equation
      A.phi = 80 deg; A.w = 20 rad/s; guess D.phi = 100 deg; guess B.phi = -60 deg;
      annotation(experiment(StopTime = 0.05 s, Interval = 10 ms));
    end Turned;"""
    run = mbdsl.simulate(mbdsl.parse(text), method="radau5", tol=1e-8, general=general)
    first = mbdsl.simulate(mbdsl.parse(text.replace(f"phi = {angle} deg", "phi = 0 deg")), method="radau5", tol=1e-8)
    from scipy.spatial.transform import Rotation

    R = Rotation.from_rotvec(np.radians(angle) * np.array(axis)).as_matrix()
    for pin in "ABCD":
        force, plain = (np.array([x[f"{pin}.f{i}"] for i in "xyz"]) for x in (run, first))
        assert R.T @ force == pytest.approx(plain, abs=1e-5 * np.abs(plain).max())
