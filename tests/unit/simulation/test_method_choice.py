"""The method of runs with a tolerance for which no method is named, and the work that they take."""

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main

#: a crank-rocker with the curve of a motor and friction in a pin: stiff at low speeds, and with corners
ROCKER = """
model Rocker "a crank-rocker that a motor drives against friction"
  Ground ground(frames(E = {0.4 m, 0 m}));
  Table curve(table = [-20 rad/s, 6 N.m; 0 rad/s, 5 N.m; 10 rad/s, 4 N.m; 25 rad/s, 0 N.m; 60 rad/s, -8 N.m]);
  Rod crank(m = 0.4 kg, length = 0.1 m);
  Rod coupler(m = 0.9 kg, length = 0.36 m);
  Rod rocker(m = 1.1 kg, length = 0.25 m);
  Revolute O(ground, crank.a);
  Revolute A(crank.b, coupler.a);
  Revolute B(coupler.b, rocker.b);
  Revolute C(ground.E, rocker.a, mu = 0.15, radius = 12 mm, w_s = 0.02 rad/s);
  Torque motor(O, tau = curve(O.w));
  RotationalSpringDamper load(C, c = 0.2 N.m.s/rad, k = 0 N.m/rad);
initial equation
  O.phi = 35 deg; O.w = 0 rad/s;
  guess rocker.phi = 100 deg;
  annotation(experiment(StopTime = 2 s));
end Rocker;
"""


@pytest.fixture(scope="module")
def rocker():
    scene = mbdsl.parse(ROCKER)
    return scene, mbdsl.simulate(scene, method="radau5", tol=1e-8)


@pytest.mark.parametrize("tol", [1e-4, 5e-5, 3e-5, 1e-5], ids=["1e-4", "5e-5", "3e-5", "1e-5"])
def test_an_ordinary_machine_takes_few_steps(rocker, tol):
    scene, exact = rocker
    run = mbdsl.simulate(scene, tol=tol)
    assert run.stats["error"] <= tol and run.stats["status"] == "done"
    assert run.stats["steps"] + run.stats["trial_steps"] < 60_000
    for name in ("O.phi", "rocker.phi", "coupler.phi"):
        assert np.abs(run[name] - exact[name]).max() < tol
    assert run.stats["chosen"].startswith(f"{run.stats['method']} was taken: ")


@pytest.mark.parametrize(("name", "most"), [("flexible_slider_crank", 12_000), ("crank_ivp", 12_000)])
def test_stiff_models_take_few_steps(name, most):
    from pathlib import Path

    run = mbdsl.simulate(Path(__file__).parents[3] / "models" / f"{name}.mbd", tol=1e-4)
    assert run.stats["method"] != "hht-si2" and run.stats["steps"] < most
    assert "hht-si2 would cost about" in run.stats["chosen"] or "hht-si2 does not reach" in run.stats["chosen"]


def test_the_choice_is_the_same_each_time(rocker):
    scene, _ = rocker
    one, other = (mbdsl.simulate(scene, tol=1e-4) for _ in range(2))
    assert one.stats["chosen"] == other.stats["chosen"]
    assert np.array_equal(one.q, other.q)


def test_a_method_that_is_named_is_taken(rocker):
    scene, _ = rocker
    for given in ({"method": "radau5", "tol": 1e-4}, {"step": "1 ms"}):
        run = mbdsl.simulate(scene, **given)
        assert run.stats["method"] == given.get("method", "hht-si2") and "chosen" not in run.stats
    named = mbdsl.parse(ROCKER.replace("StopTime = 2 s", 'StopTime = 2 s, Tolerance = 1e-4, Method = "radau5"'))
    run = mbdsl.simulate(named)
    assert run.stats["method"] == "radau5" and "chosen" not in run.stats


def test_the_summary_says_which_and_why(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rocker.mbd").write_text(ROCKER, encoding="utf-8")
    assert main(["simulate", "rocker.mbd"]) == 0
    out = capsys.readouterr().out
    assert " was taken: " in out and "times as much" in out
    assert main(["simulate", "rocker.mbd", "--method", "hht-si2", "--step", "1ms"]) == 0
    assert " was taken" not in capsys.readouterr().out


def test_a_missed_default_tolerance_is_a_warning():
    """A double pendulum amplifies rounding errors beyond any tolerance."""
    text = """
model Chaos
  Ground ground;
  Rod a(m = 1 kg, length = 1 m);
  Rod b(m = 1 kg, length = 1 m);
  Revolute p(ground, a.a);
  Revolute q(a.b, b.a);
initial equation
  p.phi = 90 deg; q.phi = 10 deg;
  annotation(experiment(StopTime = 60 s, Interval = 1 s));
end Chaos;
"""
    with pytest.warns(mbdsl.AccuracyWarning, match="the tolerance of 0.0001 is not reached"):
        run = mbdsl.simulate(mbdsl.parse(text))
    assert run.status == "inaccurate"
    assert any("the tolerance of 0.0001 is not reached" in x for x in run.stats["warnings"])
    with pytest.raises(mbdsl.IntegrationError, match="is not reached"):
        mbdsl.simulate(mbdsl.parse(text), tol=1e-4)
