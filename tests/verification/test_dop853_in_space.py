"""dop853 in space: order 8 on the heavy top, dense output, driven frames, redundancy, velocity constraints, accuracies.

References: the top's published problem solved to 16 digits (tests/data/reference/heavy_top.json), Bricard's linkage
(bricard.json), closed forms.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl

ROOT = Path(__file__).parents[2]
SPACE = ROOT / "models" / "space"
REFERENCE = ROOT / "tests" / "data" / "reference"


def reference():
    values = json.loads((REFERENCE / "heavy_top.json").read_text(encoding="utf-8"))["values"]
    return [np.array(values[key], float) for key in ("x_com", "quat_wxyz", "Omega_body")]


def errors(t):
    """Errors of position, attitude and angular velocity at 0.1 s."""
    x, p, w = reference()
    k = int(np.argmin(np.abs(t.t - 0.1)))
    found = np.array([t[f"top.p{j}"][k] for j in range(4)])
    attitude = 2.0 * min(np.abs(found - p).max(), np.abs(found + p).max())
    position = max(abs(t[f"top.{key}"][k] - value) for key, value in zip("xyz", x, strict=True))
    return np.array([position, attitude, np.abs(t.v[k, 3:] - w).max()])


def test_order_on_the_heavy_top():
    """Steps of 0.6 and 0.3 rad of the spin: order 8, less one for the next term, which is not small yet."""
    sizes = (4e-3, 2e-3)
    coarse, fine = (errors(mbdsl.simulate(SPACE / "heavy_top.mbd", method="dop853", step=h, stop=0.1)) for h in sizes)
    assert np.log2(coarse / fine).min() > 7.0
    assert fine[0] < 1e-11


@pytest.mark.parametrize("tol", [1e-4, 1e-7, 1e-10])
def test_tolerances_keep_their_word(tol):
    """Relative to the size 1 m and the angular velocity 150 rad/s."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method="dop853", tol=tol, stop=0.1, interval=0.1)
    assert (errors(t) / [1.0, 1.0, 150.0]).max() < tol


def test_output_between_steps():
    """The polynomials of degree 7 at 0.1 s, in the middle of a step, are nearly as accurate as the steps."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method="dop853", step=8e-3 / 3, stop=0.16 / 3 * 2, interval=1e-3)
    assert (errors(t) / [1.0, 1.0, 150.0]).max() < 1e-7
    # velocities are those of the positions: central differences over 2 ms of motion at 150 rad/s
    fine = mbdsl.simulate(SPACE / "heavy_top.mbd", method="dop853", step=2e-3, stop=0.02, interval=2.5e-5)
    slope = (fine["top.x"][2:] - fine["top.x"][:-2]) / (fine.t[2:] - fine.t[:-2])
    np.testing.assert_allclose(slope, fine["top.vx"][1:-1], atol=1e-5)


def test_energy_and_constraints_over_many_steps():
    """Projection keeps both levels of constraints at rounding level; the energy is 5,284 J."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method="dop853", step=2e-3, stop=2.0, interval=0.02)
    for k in (1, 2, 3):
        assert np.abs(t[f"ball.Phi[{k}]"]).max() < 1e-12
        assert np.abs(t[f"ball.dPhi[{k}]"]).max() < 1e-10
    assert np.ptp(t["energy.total"]) < 1e-5


def test_bricard():
    """30 rows of rank 29."""
    expected = json.loads((REFERENCE / "bricard.json").read_text(encoding="utf-8"))["P3"]
    t = mbdsl.simulate(SPACE / "bricard.mbd", method="dop853", tol=1e-9, interval=1.0)
    for second, values in expected.items():
        k = int(np.argmin(np.abs(t.t - float(second))))
        assert [t[f"rod3.b.{key}"][k] for key in "xyz"] == pytest.approx([float(x) for x in values], abs=1e-8)


DRIVEN = """spatial model Driven
  Ground ground(g = 0);
  Body arm(m = 2 kg, I = {0.1, 0.2, 0.3} kg.m2, frames(p = {0.5, 0.0, 0.0} m));
  Revolute motor(ground, arm.c, n = {0, 0, 1});
  RotationalDriver turn(ground, arm.c, phi = 0.3*sin(4 rad/s*time) + 2 rad/s*time, n = {0, 0, 1});
  Body rod(m = 1 kg, I = {0.02, 0.03, 0.04} kg.m2, frames(e = {0.2, 0.1, 0.0} m));
  Spherical ball(arm.p, rod.e);
annotation(experiment(StopTime = 1 s));
end Driven;"""


def test_driven_mechanism():
    """The driver's power is the rate of the energy; a method with other equations gives the same motion.

    Errors of hht-si2 are of order 2: a fourth with half of the step."""
    t = mbdsl.simulate(mbdsl.parse(DRIVEN), method="dop853", tol=1e-11, interval=1e-3)
    power = t["turn.tau"] * (1.2 * np.cos(4 * t.t) + 2.0)
    rate = np.gradient(t["energy.total"], t.t)  # with errors of (4 rad/s)^2 (1 ms)^2/6
    np.testing.assert_allclose(rate[1:-1], power[1:-1], atol=1e-4 * np.abs(power).max())
    differ = []
    for h in (1e-3, 5e-4):
        other = mbdsl.simulate(mbdsl.parse(DRIVEN), method="hht-si2", step=h, interval=1e-2)
        differ.append(max(np.abs(other[f"rod.{key}"] - t[f"rod.{key}"][::10]).max() for key in "xyz"))
    assert differ[1] < 1e-5
    assert differ[0] / differ[1] == pytest.approx(4.0, abs=0.2)


def test_accuracy_in_space():
    """The asked accuracy of the top at 0.1 s, angles in radians; a method of another family has checked it."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", accuracy=1e-6, stop=0.1, interval=0.1)
    said = t.stats["accuracy"]
    found = (errors(t) / [1.0, 1.0, 150.0]).max()
    assert found <= said["estimated"] <= 1e-6
    assert said["checked by"]


@pytest.mark.parametrize("method", ["dop853", "hht-si2"])
def test_rolling_with_a_tolerance(method):
    """The coin's centre moves on a circle of 60 mm with the rate W of its closed form.

    The rows of rolling without slip, which are zero along the motion, are not searched for peaks."""
    t = mbdsl.simulate(SPACE / "rolling_coin.mbd", method=method, tol=1e-5, stop=0.3, interval=0.05)
    r, R, a = 12e-3, 60e-3, np.radians(70.0)
    W = np.sqrt(9.81 * r * np.cos(a) / (r**2 / 4 * np.sin(a) * np.cos(a) + 3 / 2 * R * r * np.sin(a)))
    size = t.system.tables.size
    np.testing.assert_allclose(t["coin.x"], R * np.cos(W * t.t), atol=1e-5 * size)
    np.testing.assert_allclose(t["coin.y"], R * np.sin(W * t.t), atol=1e-5 * size)
    assert not t.stats["warnings"]
