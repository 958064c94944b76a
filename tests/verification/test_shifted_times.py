"""A shift of time changes nothing but rounding: runs that start late, and forces that begin behind the start."""

import numpy as np
import pytest
from scipy.linalg import expm

import mbdsl

OSCILLATOR = """{spatial}model Oscillator
  Ground ground(g = 0);
  Body cart(m = 1 kg, I = {inertia});
  Prismatic rail(ground, cart.c);
  TranslationalSpringDamper spring(rail, k = 100 N/m, c = {c} N.s/m);
  {force}
initial equation
  rail.s = 0.1 m; rail.v = 0 m/s;
  annotation(experiment(StartTime = {start}, StopTime = {stop}));
end Oscillator;"""


def oscillator(start, stop, force="", c=0.0, spatial=""):
    inertia = "{1, 1, 1} kg.m2" if spatial else "1 kg.m2"
    return mbdsl.parse(
        OSCILLATOR.format(start=start, stop=start + stop, force=force, c=c, spatial=spatial, inertia=inertia)
    )


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("start", [7200.0, 86400.1, 3e6, -5e5])
@pytest.mark.parametrize(
    ("method", "tol"), [("hht-si2", 1e-4), ("nstiff", 1e-4), ("radau5", 1e-9), ("dop853", 2e-9), ("radau13", 2e-9)]
)
def test_errors_are_those_of_a_start_at_zero(method, tol, start, spatial):
    """s = 0.1 cos(10 (t - t0)); times are rounded to units in the last place of t, by which s differs at most."""
    given = {"method": method, "tol": tol, "interval": 1.0}
    run = mbdsl.simulate(oscillator(start, 3.0, spatial=spatial), **given)
    first = mbdsl.simulate(oscillator(0.0, 3.0, spatial=spatial), **given)
    error = np.abs(run["rail.s"] - 0.1 * np.cos(10.0 * (run.t - start))).max()
    here = np.abs(first["rail.s"] - 0.1 * np.cos(10.0 * first.t)).max()
    assert error <= 1.05 * here + 4.0 * np.spacing(abs(start))
    assert (
        run.stats["error"] <= 1.3 * first.stats["error"] and abs(run.stats["steps"] / first.stats["steps"] - 1) < 0.01
    )


@pytest.mark.parametrize("start", [0.0, 450.0, 86400.0])
@pytest.mark.parametrize(
    ("method", "error"), [("hht-si2", 1e-8), ("hht-i3", 1e-8), ("radau5", 1e-13), ("dop853", 1e-13)]
)
def test_fixed_steps_end_at_jumps_late_in_time(method, error, start):
    """A force of 2 N in every other 10 ms, of 1000 steps each: against the matrix exponential."""
    A, x = np.array([[0.0, 1.0], [-100.0, -1.0]]), np.array([0.1, 0.0])
    E = expm(0.01 * A)
    pushed = np.linalg.solve(A, E - np.eye(2)) @ np.array([0.0, 2.0])
    for _ in range(10):
        x = E @ (E @ x + pushed)
    scene = oscillator(start, 0.2, "Force f(cart.c, fx = if mod(time, 0.02 s) < 0.01 s then 2 N else 0 N);", c=1.0)
    run = mbdsl.simulate(scene, method=method, step=1e-5, interval=0.2)
    assert [run["rail.s"][-1], run["rail.v"][-1]] == pytest.approx(x, abs=error)


BEGINS = {
    "after": "if time > {t} s then 1 N else 0 N",
    "not before": "if time <= {t} s then 0 N else 1 N",
    "sign": "if sign(time - {t} s) > 0 then 1 N else 0 N",
}


@pytest.mark.parametrize("start", [0.0, 12.0])
@pytest.mark.parametrize("law", BEGINS)
@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "nstiff", "newmark", "radau5", "dop853", "generalized-alpha"])
def test_a_force_that_begins_behind_the_start(method, law, start):
    """As one that begins at the start: with fixed steps, step by step, and with a tolerance."""
    force, same = (
        f"Force f(cart.c, fx = {x});" for x in (BEGINS[law].format(t=start), f"if time >= {start} s then 1 N else 0 N")
    )
    one, other = oscillator(start, 1.0, force), oscillator(start, 1.0, same)
    for given in ({"step": 0.01}, {"tol": 1e-4}):
        found, expected = (mbdsl.simulate(x, method=method, **given) for x in (one, other))
        assert found["rail.v"] == pytest.approx(expected["rail.v"], abs=1e-11)
    steps = mbdsl.Simulation(one, method=method, step=0.01)
    steps.step(100)
    assert steps["rail.s"] == pytest.approx(mbdsl.simulate(one, method=method, step=0.01)["rail.s"][-1], abs=1e-14)
