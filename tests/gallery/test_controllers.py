"""Machines with controllers against SciPy's solution of their equations in minimal coordinates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl


def crane(t, x, control):
    """Rates of (position, sway, their rates, filtered sway) of the trolley with a rope of the length l(t)."""
    M, m, g, way, low, high, T1, T = 5e3, 10e3, 9.81, 20.0, 14.0, 8.0, 10.0, 0.1
    s, sway, v, w, y = x
    u = min(t / T1, 1.0)
    part, rate = u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2 / T1
    second = (60 * u - 180 * u**2 + 120 * u**3) / T1**2
    l, dl, ddl = low + (high - low) * part, (high - low) * rate, (high - low) * second
    filtered = (sway - y) / T
    force = 20e3 * (way * part - s) + 80e3 * (way * rate - v) + control * (300e3 * sway - 200e3 * filtered)
    # of both bodies along the rail, and of the load across the rope
    mass = [[M + m, m * l * np.cos(sway)], [np.cos(sway), l]]
    along = m * (2 * dl * w * np.cos(sway) + ddl * np.sin(sway) - l * w**2 * np.sin(sway))
    return [v, w, *np.linalg.solve(mass, [force - along, -2 * dl * w - g * np.sin(sway)]), filtered]


@pytest.mark.parametrize(("control", "largest"), [(1.0, 0.31), (0.0, 8.64)])
def test_anti_sway_crane(gallery, control, largest):
    scene = gallery("anti_sway_crane")
    run = mbdsl.simulate(scene, tol=1e-9, interval=0.1, parameters={"control": control})
    found = solve_ivp(crane, (0, 20), np.zeros(5), "DOP853", run.t, args=(control,), rtol=1e-11, atol=1e-12).y
    for name, expected in zip(("rail.s", "sway", "rail.v"), found, strict=False):
        assert np.abs(run[name] - expected).max() < 1e-7
    assert np.abs(run["y"] - found[4]).max() < 1e-7
    after = np.degrees(np.abs(run["sway"][run.t >= 14 - 1e-9]))
    assert after.max() == pytest.approx(np.degrees(np.abs(found[1][run.t >= 14 - 1e-9])).max(), abs=1e-5)
    assert 0.97 * largest < after.max() <= largest  # as the page has it


def brake():
    """Times of the switchings and of the end [s], way [m], of the anti-lock brake."""
    M, wheel, R, g, kb, low, high, v1 = 400.0, 1.5, 0.4, 9.81, 25e-5, 0.08, 0.24, 1.5

    def slip(x):
        return 1 - R * x[2] / x[1]

    def rates(t, x, on):
        s = slip(x)
        grip = M * g * (1.28 * (1 - np.exp(-23.99 * s)) - 0.52 * s)
        pressure = (150e5 - x[3]) / 0.15 if on else -x[3] / 0.04
        return [x[1], -grip / M, (R * grip - kb * x[3]) / wheel, pressure]

    def end(t, x, on):
        return x[1] - v1

    def level(t, x, on):
        return slip(x) - (high if on else low)

    end.terminal = level.terminal = True
    t, x, on, times = 0.0, np.array([0.0, 12.0, 12.0 / R, 0.0]), True, []
    while True:
        level.direction = 1 if on else -1
        given = {"args": (on,), "events": (end, level), "rtol": 1e-11, "atol": 1e-12, "max_step": 5e-3}
        found = solve_ivp(rates, (t, 10.0), x, "DOP853", **given)
        t, x, on = found.t[-1], found.y[:, -1], not on
        times.append(t)
        if found.t_events[0].size:
            return np.array(times), x[0]


def test_anti_lock_brake(gallery):
    times, way = brake()
    run = mbdsl.simulate(gallery("anti_lock_brake"), step=1e-4)
    assert [x.kind for x in run.events] == ["when"] * (len(times) - 1) + ["terminate"]
    assert np.abs(np.array([x.t for x in run.events]) - times).max() < 1e-5
    assert run["road.s"][-1] == pytest.approx(way, abs=1e-4)
    # locked wheels need longer; no control is better than the largest grip
    best = 1.28 * (1 - np.exp(-23.99 * 0.17)) - 0.52 * 0.17
    locked, least = ((12.0**2 - 1.5**2) / (2 * 9.81 * mu) for mu in (0.76, best))
    assert least < way < 0.8 * locked
