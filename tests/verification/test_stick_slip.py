"""A block on a belt sticks, slips and sticks again: compared with its law by an independent solver, and with Coulomb's
law."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl

M, K, N, MU, MU_S, BELT = 1.0, 100.0, 10.0, 0.3, 0.5, 0.1
W = np.sqrt(K / M)


def coulomb(t):
    """Position of the block with friction that drops at once from mu_s to mu: it sticks until the spring pulls with
    mu_s N."""
    high, low = MU_S * N / K, MU * N / K
    stuck = high / BELT
    slip = 2 * (np.pi - np.arctan((high - low) * W / BELT)) / W  # until the block is as fast as the belt again
    again = 2 * low - high  # where it sticks again
    stick = (high - again) / BELT
    t = np.asarray(t, float)
    s = np.mod(t - stuck, slip + stick)
    slipping = low + (high - low) * np.cos(W * s) + BELT / W * np.sin(W * s)
    return np.where(t < stuck, BELT * t, np.where(s < slip, slipping, again + BELT * (s - slip))), slip + stick


def test_closed_form(reference):
    """It is the published one, satisfies m x'' + k x = mu N where it slips, and is as fast as the belt at both ends."""
    data = reference("stick_slip_belt")["data"]
    _, period = coulomb(0.0)
    assert period == pytest.approx(float(data["period"]), rel=1e-15)
    ends = [float(data[key][i]) for i in range(3) for key in ("slip_times", "restick_times")]
    expected = [float(data["slip_position"]), float(data["restick_position"])] * 3
    assert coulomb(ends)[0] == pytest.approx(expected, abs=1e-14)
    assert coulomb(np.linspace(0, 2, 100_001))[0].max() == pytest.approx(float(data["x_max"]), abs=1e-9)
    d = 1e-4
    for t in (0.55, 0.7, 0.85):
        x = coulomb([t - d, t, t + d])[0]
        # differences are wrong by d^2/12 w^4 x: 1e-6; rounding by 1e-16/d^2: 1e-8
        assert M * (x[2] - 2 * x[1] + x[0]) / d**2 + K * x[1] == pytest.approx(MU * N, abs=1e-5)
    for t in (ends[0] + 1e-6, ends[1] - 1e-6):
        x = coulomb([t - 1e-7, t + 1e-7])[0]
        assert (x[1] - x[0]) / 2e-7 == pytest.approx(BELT, abs=1e-4)


def law(times, v_s, v_st):
    """The block with mbdsl's law of friction, by Radau: position."""

    def rhs(t, y):
        v = y[1] - BELT
        force = -N * (MU + (MU_S - MU) * np.exp(-((v / v_st) ** 2))) * np.tanh(v / v_s)
        return y[1], (force - K * y[0]) / M

    found = solve_ivp(rhs, (0, times[-1]), (0.0, BELT), "Radau", t_eval=times, rtol=1e-9, atol=1e-12)
    return found.y[0]


@pytest.fixture(scope="module")
def expected():
    times = np.array([0.4, 0.6, 0.8, 1.2, 1.5])
    return times, law(times, 4e-4, 16e-3)


def test_law(model, method, expected):
    """With v_s = 0.4 mm/s, through a slip, sticking, and into the next slip.

    Errors are 0.2 m/s h of newmark, 27 m/s2 h^2 of the BDF methods, 10 m/s2 h^2 of HHT: half as much again is allowed.
    """
    times, exact = expected
    for h in (1e-4, 5e-5):
        found = mbdsl.simulate(
            model("stick_slip_belt"), method=method, step=h, stop=1.5, interval=0.1, parameters={"v_s": 4e-4}
        )
        x = np.array([found["block.x"][np.abs(found.t - t).argmin()] for t in times])
        error = np.abs(x - exact).max()
        assert error < (0.3 * h if method == "newmark" else 40 * h**2 if "nstiff" in method else 15 * h**2)


def test_coulomb_in_the_limit(model, order):
    """Period and largest deflection tend to those of Coulomb's law as v_s and v_st = 40 v_s go to zero."""
    speeds, periods, deflections = [4e-4, 2e-4, 1e-4, 5e-5], [], []
    for v_s in speeds:
        found = mbdsl.simulate(
            model("stick_slip_belt"), step=2e-5, stop=3.5, interval=0.0, parameters={"v_s": v_s}
        )  # fmt: skip
        slips = found["contact.v"] < -0.01
        sticks = found.t[1:][~slips[1:] & slips[:-1]]
        assert len(sticks) == 4
        periods.append((sticks[-1] - sticks[0]) / 3)
        deflections.append(found["block.x"].max())
    _, period = coulomb(0.0)
    deflection = coulomb(np.linspace(0.5, 0.9, 100_001))[0].max()
    for values, limit in ((periods, period), (deflections, deflection)):
        errors = np.subtract(values, limit)
        assert (errors > 0).all()  # friction that decreases slowly holds longer
        assert (np.diff(errors) < 0).all()
        assert 0.6 < order(speeds, errors) < 1.0
        assert errors[-1] < 0.015 * limit
