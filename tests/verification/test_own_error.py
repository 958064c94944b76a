"""The error estimates of runs with controlled steps are true, or the runs stop with the reason and the time.

Motions that magnify errors, immediately or late, bounce, or diverge, by our own methods and by backends. Truth: closed
forms, and SciPy's DOP853 at 1e-13 in one coordinate, restarted where the force has a corner. Errors are counted in the
mechanism's size, velocities relative to the largest.
"""

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

import mbdsl
from mbdsl.errors import IntegrationError
from mbdsl.integrators.loop import loop_state as S
from mbdsl.simulation import error_growth as perturbations
from mbdsl.simulation import simulate
from mbdsl.simulation.mechanism_run import MechanismRun

BLOCK = """
model Block
  Ground ground(g = 0);
  Body b(m = 1.0, I = 1);
  Prismatic s(ground, b.c);
  TranslationalSpringDamper law(s, force = {force});
initial equation
  s.s = {s};
  s.v = {v};
  annotation(experiment(StopTime = {stop}));
end Block;
"""
PENDULUM = """
model Inverted
  Ground ground(g = 9.81);
  Body b(m = 1, I = 0.25);
  Frame foot(b, r = {{0, -1}});
  Revolute pin(ground, foot);
initial equation
  b.phi = {phi};
  b.w = 0;
  annotation(experiment(StopTime = {stop}));
end Inverted;
"""
ORBIT = """
model Orbit
  Ground ground(g = 0);
  PointMass b(m = 1);
  SpringDamper s(ground, b, force = 1/(1*s)^2);
initial equation
  b.x = -1.9; b.y = 0; b.vx = 0; b.vy = -0.22941573387056174;
  annotation(experiment(StopTime = 18.84955592153876));
end Orbit;
"""
#: squared growth rate of the inverted pendulum
RATE2 = 9.81 / 1.25


def block(force, s, v, stop):
    return mbdsl.parse(BLOCK.format(force=force, s=s, v=v, stop=stop))


def run(scene, method, tol, **given):
    """The trajectory, and whether the tolerance is reached."""
    try:
        return mbdsl.simulate(scene, method=method, tol=tol, **given), True
    except IntegrationError as problem:
        return problem.trajectory, False


def smooth(f, y0):
    return lambda t: solve_ivp(f, (t[0], t[-1]), y0, method="DOP853", rtol=1e-13, atol=1e-15, t_eval=t).y


def bouncing(t):
    """x'' = -9.81, and -1e6 x moreover where x < 0, from rest at 0.5."""
    x, y, now, free = np.zeros((2, len(t))), np.array([0.5, 0.0]), t[0], True
    x[:, 0] = y
    while now < t[-1]:

        def end(_, y):
            return y[0]

        end.terminal, end.direction = True, -1 if free else 1
        stiff = 0.0 if free else 1e6
        part = solve_ivp(
            lambda _, y, k=stiff: [y[1], -9.81 - k * y[0]],
            (now, t[-1]), y, method="DOP853", rtol=1e-13, atol=1e-15, events=end, dense_output=True, max_step=0.05,
        )  # fmt: skip
        rows = (t > now) & (t <= part.t[-1])
        x[:, rows] = part.sol(t[rows])
        now, y, free = part.t[-1], part.y[:, -1], not free
    return x


#: scene, truth: s and v (2, N) at times (N,)
CASES = {
    "forced": (
        block("0.1*v + 1*s^3 - 7.5*cos(1*time)", 1.0, 0.0, 20.0),
        smooth(lambda t, y: [y[1], -0.1 * y[1] - y[0] ** 3 + 7.5 * np.cos(t)], [1.0, 0.0]),
    ),
    "bouncing": (block("9.81 - (if s < 0 then -1e6*s else 0)", 0.5, 0.0, 2.0), bouncing),
    "growing": (
        block("-1e-30*exp(40*time)", 0.0, 0.0, 2.0),
        lambda t: 1e-30 * np.array([(np.exp(40 * t) - 1 - 40 * t) / 1600, (np.exp(40 * t) - 1) / 40]),
    ),
    "unstable": (
        block("-1600*s", 0.2, 0.0, 0.15),
        lambda t: 0.2 * np.array([np.cosh(40 * t), 40 * np.sinh(40 * t)]),
    ),
    "blow up": (block("-6*s^2", 1.0, 2.0, 0.9), lambda t: np.array([(1 - t) ** -2.0, 2 * (1 - t) ** -3.0])),
    "oscillator": (
        block("1000*s", 0.2, 0.0, 2.0),
        lambda t: 0.2 * np.array([np.cos(1000**0.5 * t), -(1000**0.5) * np.sin(1000**0.5 * t)]),
    ),
}


#: a backend calls Python for every step: one case is enough
RUNS = [(name, method) for name in CASES for method in ("hht-si2", "radau5")] + [("oscillator", "scipy-dop853")]


@pytest.mark.parametrize("tol", [1e-3, 1e-5])
@pytest.mark.parametrize(("name", "method"), RUNS)
def test_the_true_error_is_near_the_claim(name, method, tol):
    scene, truth = CASES[name]
    found, reached = run(scene, method, tol)
    (s, v), size = truth(found.t), found.system.tables.size
    speed = max(np.abs(v).max(), size / found.t[-1])
    errors = np.maximum(np.abs(found["s.s"] - s) / size, np.abs(found["s.v"] - v) / speed)
    assert reached
    assert errors.max() < min(3 * tol, 10 * found.stats["error"])
    assert found.stats["error"] <= tol and found.stats["horizon"] is None


#: scene, and the time when errors of 1e-16 have grown to about the tolerance of 1e-5, by growth rates
HORIZONS = {
    # exp(sqrt(RATE2) t)
    "inverted pendulum": (PENDULUM.format(phi=0.0, stop=30), np.log(1e11) / np.sqrt(RATE2)),
    # exp(t)
    "double well": (BLOCK.format(force="1*s^3 - 1*s", s=0.0, v=0.0, stop=60), np.log(1e11)),
    # nearly in equilibrium, at the rate (t - 20 s)/2
    "delayed": (
        BLOCK.format(force="20*v + 10*(20 - 1*time)*s + 1e3*s^3", s=0.1, v=0.0, stop=42),
        20 + 2 * np.sqrt(np.log(1e11)),
    ),
}


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
@pytest.mark.parametrize("name", HORIZONS)
def test_what_rounding_decides_is_not_claimed(name, method):
    """Within a fifth of the time that growth rates give; errors of 1e-13 in place of 1e-16 reduce it by a quarter."""
    text, time = HORIZONS[name]
    found, reached = run(mbdsl.parse(text), method, 1e-5)
    assert not reached
    assert found.status == "inaccurate" and "not reached" in found.message
    assert 0.7 * time < found.stats["horizon"] < 1.2 * time
    assert found.t[-1] == found.scene.experiment.stop  # the file has all results


def test_before_that_all_is_well():
    """Upside down, a milliradian off, the same pendulum falls along a closed form in elliptic functions."""
    found, reached = run(mbdsl.parse(PENDULUM.format(phi=1e-3, stop=3)), "hht-si2", 1e-5)
    k = np.cos(0.5e-3)
    cd = ellipj(np.sqrt(RATE2) * found.t + ellipk(k * k), k * k)[0]
    assert reached
    assert np.abs(found["b.phi"] - 2 * np.arccos(k * cd)).max() < 3e-5
    assert found.stats["error"] <= 1e-5


@pytest.mark.parametrize(("text", "tol", "needed"), [(PENDULUM.format(phi=1e-3, stop=3), 1e-5, 0), (ORBIT, 1e-4, 1)])
def test_growth_is_refined_only_where_it_would_end_the_run(monkeypatch, text, tol, needed):
    runs, growths = [], []
    restart, growth = MechanismRun.restart, perturbations.growth
    monkeypatch.setattr(MechanismRun, "restart", lambda self, plan: (runs.append(plan.every), restart(self, plan))[1])
    monkeypatch.setattr(perturbations, "growth", lambda *given: (growths.append(given[-1]), growth(*given))[1])
    found, reached = run(mbdsl.parse(text), "hht-si2", tol, interval=0.1)
    assert reached
    assert sum(runs) == needed and growths == [1, 4][: 1 + needed]
    assert found.stats["trial_steps"] > 0


def test_interrupted_while_growth_is_refined(monkeypatch):
    integrate = simulate._integrate
    monkeypatch.setattr(
        simulate,
        "_integrate",
        lambda run, *rest: S.RUNNING if run.motion.plan.every else integrate(run, *rest),
    )
    with pytest.raises(mbdsl.Interrupted):
        run(mbdsl.parse(ORBIT), "hht-si2", 1e-4, interval=0.1)


def test_growth_past_a_periapsis(monkeypatch):
    """At least the largest factor from one sample to a later one, by the variational equations and DOP853, and at most
    so many times that as there are samples, at each of which as much is added; e^2 for rates that are frozen."""
    seen = []
    growth = perturbations.growth
    monkeypatch.setattr(perturbations, "growth", lambda *given: seen.append(growth(*given)) or seen[-1])
    run(mbdsl.parse(ORBIT), "hht-si2", 1e-4, interval=0.1)
    coarse, fine = seen

    def rate(_, y):
        x, r = y[:2], np.hypot(*y[:2])
        K = (3 * np.outer(x, x) / r**2 - np.eye(2)) / r**3
        dx, dv = y[4:].reshape(2, 2, 4)
        return np.concatenate([y[2:4], -x / r**3, dv.ravel(), (K @ dx).ravel()])

    y0 = np.concatenate([[-1.9, 0, 0, -((0.1 / 1.9) ** 0.5)], np.eye(4).ravel()])
    y = solve_ivp(rate, (0, fine.t[-1]), y0, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=fine.t).y
    units = np.array([1.9, 1.9, 19**0.5, 19**0.5])  # the largest distance and velocity
    reached = y[4:].T.reshape(-1, 4, 4) * units / units[:, None]
    back = np.linalg.inv(reached)
    true = np.log(max(np.abs(reached[k] @ back[: k + 1]).max() for k in range(len(reached))))
    assert true < fine.log.max() < true + np.log(len(fine.t)) + 2.0
    assert coarse.log.max() > true + 12.0


CHAOS = """
model Double
  Ground ground(g = 9.81);
  Rod one(m = 1, length = 1);
  Rod two(m = 1, length = 1);
  Revolute a(ground, one.a);
  Revolute b(one.b, two.a);
initial equation
  one.phi = 2.0;
  two.phi = 2.5;
  annotation(experiment(StopTime = 40));
end Double;
"""


def test_chaos_has_a_horizon_up_to_which_methods_agree(optimised):
    one, two = (run(mbdsl.parse(CHAOS), method, 1e-5) for method in ("radau5", "hht-si2"))
    assert not one[1] and not two[1]
    (a, _), (b, _) = one, two
    both = a.t <= min(a.stats["horizon"], b.stats["horizon"])
    assert 2.0 < a.t[both][-1] < 19.0
    speed = np.abs(a.v * a.system.tables.scale).max()
    assert np.abs((a.q - b.q) * a.system.tables.scale)[both].max() < 6e-5
    assert np.abs((a.v - b.v) * a.system.tables.scale)[both].max() < 6e-5 * speed


def test_a_tolerance_that_is_not_asked_for_is_no_reason_to_stop():
    with pytest.warns(mbdsl.AccuracyWarning, match="is not reached"):
        found = mbdsl.simulate(mbdsl.parse(HORIZONS["double well"][0]), method="radau5")
    assert found.status == "inaccurate"
    assert found.stats["tol"] < found.stats["error"] and found.stats["horizon"] < 60


def test_outputs_asked_for_are_those_of_a_run_that_fails():
    """The force has no value from t = 1 s on; the results before that have the requested tolerance."""
    text = BLOCK.format(force="100*s - 1*sqrt(1 - time)", s=0.1, v=0.0, stop=2)
    times = [0.1, 0.35, 0.9, 0.95, 1.5, 2.0]
    f = smooth(lambda t, y: [y[1], -100 * y[0] + np.sqrt(np.maximum(0.0, 1 - t))], [0.1, 0.0])
    for method in ("hht-si2", "radau5"):
        found, reached = run(mbdsl.parse(text), method, 1e-5, times=times)
        assert not reached and found.status == "failed"
        assert found.t[:5].tolist() == [0.0, *times[:4]] and len(found.t) <= 6
        s, v = f(np.append(found.t[:5], 0.96))[:, :5]
        assert np.abs(found["s.s"][:5] - s).max() < 3e-5
        assert np.abs(found["s.v"][:5] - v).max() < 3e-5 * np.abs(v).max()
        assert found.stats["error"] <= 1e-5


def test_command_line(tmp_path):
    """Exit code 4, a file that is whole and marked, and the reason."""
    (tmp_path / "well.mbd").write_text(HORIZONS["double well"][0], encoding="utf-8")
    command = [sys.executable, "-m", "mbdsl", "simulate", "well.mbd", "--method", "radau5", "--stats", "stats.json"]
    asked, default = (
        subprocess.run([*command, *more], cwd=tmp_path, capture_output=True, text=True, check=False)
        for more in (["--tol", "1e-5"], [])
    )
    assert asked.returncode == 4 and "not reached" in asked.stderr
    assert default.returncode == 0 and "not reached" in default.stderr
    stats = json.loads((tmp_path / "stats.json").read_text(encoding="utf-8"))
    assert stats["status"] == "inaccurate" and stats["horizon"] < 60
    assert stats["error"] > 1 and "error not known" in asked.stdout and "error not known" in default.stdout
