"""Constraints of velocities in space: rolling discs, blades and drivers, against closed forms and published values."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl

FOLDER = Path(__file__).parents[2] / "models" / "space"
G = 9.81


def test_rolling_coin():
    """Steady rolling: moments about the centre of the coin balance the rate of its moment of momentum."""
    found = mbdsl.simulate(FOLDER / "rolling_coin.mbd", stop=1.0)
    r, R, a, t = 0.012, 0.06, np.radians(70), found.t
    W = np.sqrt(G * r * np.cos(a) / (r**2 / 4 * np.sin(a) * np.cos(a) + 1.5 * R * r * np.sin(a)))
    expected = np.stack([R * np.cos(W * t), R * np.sin(W * t), r * np.sin(a) + 0 * t], axis=-1)
    centre = np.stack([found[f"coin.{i}"] for i in "xyz"], axis=-1)
    # h = 1 ms resolves the spin s = 33 rad/s with a relative error of (h s)^2/12 = 1e-4, over W t = 6.3 rad
    assert np.abs(centre - expected).max() < 1e-4 * 6.3 * R
    # the force of the table: the weight, and the centripetal force
    force = np.stack([found[f"table.f{i}"] for i in "xyz"], axis=-1)
    assert force[:, 2] == pytest.approx(0.01 * G, rel=1e-3)
    assert np.hypot(force[:, 0], force[:, 1]) == pytest.approx(0.01 * W**2 * R, rel=2e-3)
    assert np.abs(found["table.Gam[1]"]).max() < 1e-10 and np.abs(found["table.Gam[2]"]).max() < 1e-10
    assert np.abs(found["table.Phi[1]"]).max() < 1e-12


def test_bicycle():
    """Steering follows the four eigenvalues at 5 m/s that Meijaard and others (2007) list in Table 2."""
    found = mbdsl.simulate(FOLDER / "bicycle.mbd", stop=2.0, step=1e-3)
    weave, capsize, caster = -0.775341882195845 + 4.464867713788230j, -0.322866429004087, -14.078389692798216
    modes = np.exp(np.outer(found.t, [weave, np.conj(weave), capsize, caster]))
    steer = found["steer.phi"]
    part, *_ = np.linalg.lstsq(modes, steer.astype(complex), rcond=None)
    # 4 mrad: nonlinear terms are 1e-5 of it; the fastest mode has the error (h 14)^2/12 = 2e-5, weave over 9 rad 2e-5
    assert np.abs(steer).max() > 3e-3
    assert np.abs(modes @ part - steer).max() < 3e-4 * np.abs(steer).max()
    assert np.abs(found["track2.Phi[1]"]).max() < 1e-11


@pytest.mark.parametrize(("speed", "stable"), [(3.5, False), (5.0, True)])
def test_bicycle_balances_at_some_speeds(speed, stable):
    """The weave speed is 4.292 m/s, the capsize speed 6.024 m/s."""
    found = mbdsl.simulate(FOLDER / "bicycle.mbd", stop=4.0, parameters={"v": speed})
    early, late = (np.abs(found["rider.wx"][part]).max() for part in (slice(0, 100), slice(-50, None)))
    assert (late < 0.5 * early) == stable and (late > early) == (not stable)


BLADE = """
spatial model Skate "A skate spins down a slope"
  Ground ground(n = {0, -0.6, -0.8});
  Body skate(m = 2 kg, I = {0.1, 0.1, 0.2} kg.m2);
  Planar ice(ground, skate.c, n = {0, 0, 1});
  KnifeEdge blade(ground, skate.c, n = {0, 0, 1});
initial equation
  skate.x = 0; skate.y = 0; skate.phi = 0;
  blade.v = 0; skate.wz = 3 rad/s;
end Skate;
"""


def test_blade_on_a_slope():
    """With g' = 0.6 g along -y and the angle w t, the blade has no initial velocity.

    The rate of the velocity along the blade is -g' sin(w t). J. I. Neimark, N. A. Fufaev, Dynamics of Nonholonomic
    Systems (1972).
    """
    found = mbdsl.simulate(mbdsl.parse(BLADE), stop=2.0, step=1e-3, interval=0.05)
    g, w, t = 0.6 * G, 3.0, found.t
    speed = g / w * (np.cos(w * t) - 1)
    x = g / w**2 * ((w * t + np.sin(w * t) * np.cos(w * t)) / 2 - np.sin(w * t))
    y = g / w**2 * (np.sin(w * t) ** 2 / 2 + np.cos(w * t) - 1)
    error = 2 * (1e-3 * w) ** 2 / 12 * 4.0 * 6.0  # twice (h w)^2/12 of 4 m/s, over the angle of 6 rad
    assert found["blade.v"] == pytest.approx(speed, abs=error)
    assert found["skate.x"] == pytest.approx(x, abs=error)
    assert found["skate.y"] == pytest.approx(y, abs=error)
    across = found["blade.fx"] * np.cos(w * t) + found["blade.fy"] * np.sin(w * t)
    assert np.abs(across).max() < 1e-9  # the blade transmits no force along itself
    # centripetal force and the weight's part across the blade
    expected = 2.0 * (w * speed + g * np.cos(w * t))
    assert found["blade.fy"] * np.cos(w * t) - found["blade.fx"] * np.sin(w * t) == pytest.approx(expected, abs=1e-3)


DRIVEN = """
spatial model Driven "A turret whose arm slides out, both with given rates"
  Ground ground(n = {0, 0, -1});
  Body turret(m = 3 kg, I = {0.1, 0.1, 0.4} kg.m2);
  Body arm(m = 2 kg, I = {0.01, 0.05, 0.05} kg.m2);
  Revolute pivot(ground, turret.c, n = {0, 0, 1});
  Prismatic slide(turret.c, arm.c, n = {1, 0, 0});
  RotationalVelocityDriver turn(ground, turret.c, n = {0, 0, 1}, w = 2 rad/s + 1 rad/s2*time);
  TranslationalVelocityDriver push(turret.c, arm.c, n = {1, 0, 0}, v = 0.3 m/s);
initial equation
  pivot.phi = 0; slide.s = 0.5 m;
end Driven;
"""


def test_drivers_of_velocities():
    """Torque d/dt ((J + m s^2) w) and force -m s w^2 on the turret and the arm."""
    found = mbdsl.simulate(mbdsl.parse(DRIVEN), stop=2.0, step=1e-3, interval=0.05)
    t = found.t
    s, w = 0.5 + 0.3 * t, 2 + t
    # the arm moves around a circle of 1 m with up to 4 rad/s, by 6 rad: an error of (h w)^2/12 of it
    assert found["slide.s"] == pytest.approx(s, abs=1e-5)
    assert found["pivot.phi"] == pytest.approx(2 * t + t**2 / 2, abs=1e-5)
    assert found["turn.tz"][1:] == pytest.approx((0.45 + 2 * s**2 + 2 * 2 * s * 0.3 * w)[1:], rel=1e-4)
    force = found["push.fx"] * np.cos(2 * t + t**2 / 2) + found["push.fy"] * np.sin(2 * t + t**2 / 2)
    assert force[1:] == pytest.approx((-2 * s * w**2)[1:], rel=1e-4)
