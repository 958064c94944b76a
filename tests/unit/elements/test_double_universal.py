"""DoubleUniversal against the formula of two Cardan joints one behind the other."""

from math import cos, sin

import numpy as np
import pytest

import mbdsl

L, SPEED = 0.4, 2.0


def shafts(bend_a, bend_b, psi=0.0, axis="{0, 0, 1}"):
    """Two shafts in bearings of the ground; a shaft with two joints along x connects them."""
    return mbdsl.parse(f"""spatial model Shafts
      Ground ground(n = {{0, 0, -1}}, frames(o = {{0, 0, 0}}, e = {{{L}, 0, 0}}));
      Body a(m = 1 kg, I = {{0.1, 0.1, 0.1}}, frames(j = {{0, 0, 0}}));
      Body b(m = 1 kg, I = {{0.1, 0.1, 0.1}}, frames(j = {{0, 0, 0}}));
      Revolute ra(ground.o, a.j, n = {{{cos(bend_a)}, {sin(bend_a)}, 0}});
      Revolute rb(ground.e, b.j, n = {{{cos(bend_b)}, {sin(bend_b)}, 0}});
      DoubleUniversal shaft(a.j, b.j, length = {L} m, psi = {psi}, n_b = {axis});
      RotationalVelocityDriver drive(ra, w = {SPEED} rad/s);
    initial equation
      ra.phi = 0 rad;
      annotation(experiment(StopTime = 3 s));
    end Shafts;""")


def angles(run):
    return np.asarray(run["ra.phi"]), np.asarray(run["rb.phi"])


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_angles_of_both_shafts(method):
    """One Cardan joint: tan(phi of the middle) = tan(phi_a) cos(bend); so tan(phi_b) cos(b) = tan(phi_a) cos(a)."""
    run = mbdsl.simulate(shafts(0.5, 0.3), method=method, tol=1e-7)
    p, q = angles(run)
    left, right = np.sin(q) * np.cos(p) * cos(0.3), np.sin(p) * np.cos(q) * cos(0.5)
    assert left == pytest.approx(right, abs=1e-6)
    assert np.abs(q - p).max() > 0.03 and p[-1] == pytest.approx(3 * SPEED)
    assert run["shaft.s"] == pytest.approx(L, abs=1e-8)


def test_equal_bends_are_homokinetic():
    p, q = angles(mbdsl.simulate(shafts(0.4, -0.4), tol=1e-7))
    assert q == pytest.approx(p, abs=1e-6)


def test_turned_crosses():
    """With a quarter turn between the crosses, the deviations of both joints from uniform rotation add."""
    p, q = angles(mbdsl.simulate(shafts(0.4, 0.4, np.pi / 2, f"{{{sin(0.4)}, {-cos(0.4)}, 0}}"), tol=1e-7))
    assert np.sin(q) * np.cos(p) == pytest.approx(np.sin(p) * np.cos(q) * cos(0.4) ** 2, abs=1e-6)
    assert np.abs(q - p).max() > 0.05


def test_builder_statics_modes_and_pictures(tmp_path):
    """A weight at the end of the shaft hangs as on a rod, and swings like a pendulum."""
    m = mbdsl.SpatialBuilder("Hanging")
    m.Ground("ground")
    m.Body("weight", m=2.0, I=(0.01, 0.01, 0.01), x={"start": 0.01, "fixed": True}, y={"start": -0.5})
    m.DoubleUniversal("shaft", "ground", "weight.c", length=0.5)
    run = mbdsl.simulate(m.scene(), stop=0.1, tol=1e-8)
    swing = np.arctan2(run["weight.x"], -np.asarray(run["weight.y"]))
    force = 2.0 * 9.81 * (3 * np.cos(swing) - 2 * np.cos(swing[0]))  # m g cos(swing) + m v^2 / length
    assert run["shaft.force"] == pytest.approx(force, rel=1e-6)
    assert mbdsl.static(m.scene())["shaft.force"] == pytest.approx(2.0 * 9.81)
    swinging = np.array([abs(mode.eigenvalue.imag) for mode in mbdsl.eigen(m.scene(), at="static")])
    assert np.abs(swinging - np.sqrt(9.81 / 0.5)).min() < 1e-6
    run.animate(tmp_path / "shaft.html")
    assert (tmp_path / "shaft.html").stat().st_size > 10_000
