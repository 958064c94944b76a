"""Backends: discovery and registration, their input, and the treatment of their output."""

import importlib
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import mbdsl
from mbdsl import Builder, cli, integrators
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.explanation.receipt import explain
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import Method, Option, available, compiled, declared, problems, register
from mbdsl.integrators.backends import Problem
from mbdsl.system import build
from mbdsl.system.index1 import Index1

ROOT = Path(__file__).parents[3]
MODEL = ROOT / "models" / "slider_crank.mbd"
OWN = ("scipy-dop853", "scipy-radau", "scipy-lsoda", "ida")


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """The backends that a test registers, and no others."""
    given = {}
    monkeypatch.setattr(integrators, "_given", given)
    integrators._registered.cache_clear()
    yield given
    integrators._registered.cache_clear()


def backend(solve, name="toy", **declaration):
    declaration = {"own_reactions": False, "steps": ("fixed",), **declaration}
    return SimpleNamespace(METHOD=Method(name, "a toy", 1, 1, (), "nobody", **declaration), solve=solve)


def falling():
    """Two masses that nothing holds: two parts."""
    b = Builder("Falling")
    ground = b.Ground("ground")
    for name in ("one", "two"):
        mass = b.PointMass(name, m=2.0)
        b.FreeMotion(f"{name}_free", ground, mass)
        b.initial(mass.y, 1.0)
    return b.scene()


def exact(problem):
    """Free fall."""
    for t in problem.times:
        s = t - problem.start
        problem.counts["steps"] += 1
        yield t, problem.q + s * problem.v + s * s / 2 * problem.a, problem.v + s * problem.a


# -- solutions -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize("tol", [1e-3, 1e-5, 1e-7, 1e-9])
def test_the_error_follows_the_tolerance(method, tol):
    """One second of the slider crank, within three times the tolerance and ten times the stated error."""
    reference = mbdsl.simulate(MODEL, method="scipy-dop853", tol=1e-12, stop=1.0, interval=0.05)
    found = mbdsl.simulate(MODEL, method=method, tol=tol, stop=1.0, interval=0.05)
    error = np.abs((found.q - reference.q) * reference.system.tables.scale).max()
    assert error < 3.0 * tol and error < 10.0 * found.stats["error"]
    assert found.stats["steps"] > 0 and found.stats["evaluations"] > found.stats["steps"] / 2
    assert found.stats["tol"] == tol and found.stats["h"] is None


@pytest.mark.parametrize("method", OWN)
def test_reactions_are_those_of_the_motion(method):
    own = mbdsl.simulate(MODEL, method="hht-si2", step=1e-4, stop=0.2)
    found = mbdsl.simulate(MODEL, method=method, tol=1e-8, stop=0.2)
    assert np.abs(found.lam - own.lam).max() < 1e-5 * np.abs(own.lam).max()


@pytest.mark.parametrize("method", OWN)
def test_steps_end_at_breaks(method):
    """No step passes a time at which the equations jump, and the states after it are as accurate."""
    system = build(mbdsl.load(MODEL))
    system.kernels(2)
    start = initial_state(system, system.graph, 0.0)
    given = (0.0, 0.1, np.array([0.05, 0.1]), start.q, start.v, start.a, start.lam, (), 0.1, 1e-6, {})
    states = {}
    for breaks in ((), (0.0123, 0.05, 0.07)):
        solve = integrators.backend(method).solve
        states[breaks] = list(solve(Problem(system, *given, breaks=breaks)))
        met = np.array([t for t, _, _ in states[breaks]])
        assert {0.05, 0.1} <= set(met)
        assert all(np.abs(met - t).min() < 1e-14 for t in breaks)
    (_, q, v), (_, other_q, other_v) = (found[-1] for found in states.values())
    assert np.abs(q - other_q).max() < 1e-5 and np.abs(v - other_v).max() < 1e-4


def test_parts_and_kinematics_go_their_own_ways():
    """Two masses fall side by side, each solved by itself; the driven crank is solved by kinematics with every
    method."""
    found = mbdsl.simulate(falling(), method="scipy-dop853", stop=1.0, interval=0.1)
    assert found.stats["solved"]["parts"] == 2
    for name in ("one", "two"):
        np.testing.assert_allclose(found[f"{name}.y"], 1.0 - 9.81 * found.t**2 / 2, atol=1e-9)
    model = ROOT / "models" / "driven_crank.mbd"
    own = mbdsl.simulate(model, stop=1.0, interval=0.1)
    np.testing.assert_allclose(mbdsl.simulate(model, method="ida", stop=1.0, interval=0.1).q, own.q, atol=1e-12)


# -- fixed steps -----------------------------------------------------------------------------------------------------


def midpoint(problem):
    """The explicit midpoint rule, of order 2; a step from each time to the next."""
    f = Index1(problem.system, problem.left_out)
    t, y = problem.start, f.join(problem.q, problem.v)
    for end in problem.times:
        h = end - t
        y = f.project(end, y + h * f(t + h / 2, y + h / 2 * f(t, y)))
        t = end
        problem.counts["steps"] += 1
        yield t, *f.split(y)


@pytest.mark.parametrize("interval", [0.0, 0.01, 0.03, 0.04, 0.5, 1.0])
@pytest.mark.parametrize("step", [0.01, 0.04, 0.25])
def test_steps_have_the_size_that_was_asked_for(registered, step, interval):
    """Whatever the output interval: free fall is a parabola, which a cubic interpolates exactly."""
    register(backend(exact))
    found = mbdsl.simulate(falling(), method="toy", step=step, stop=1.0, interval=interval)
    assert found.stats["steps"] == round(1.0 / step)  # of each part
    assert found.t[-1] == 1.0 and np.diff(found.t).max() == pytest.approx(interval or step)
    np.testing.assert_allclose(found["one.y"], 1.0 - 9.81 * found.t**2 / 2, atol=1e-12)
    np.testing.assert_allclose(found["two.vy"], -9.81 * found.t, atol=1e-12)


@pytest.mark.parametrize("model", [MODEL, ROOT / "models" / "space" / "bar_pendulum.mbd"], ids=["plane", "space"])
def test_outputs_between_steps(registered, model):
    """They satisfy the constraints, and the error of all outputs has the order of the method."""
    register(backend(midpoint, spatial=True))
    exact = mbdsl.simulate(model, method="dop853", tol=1e-11, stop=0.4, interval=0.003)
    errors = []
    for step in (0.02, 0.01, 0.005):
        found = mbdsl.simulate(model, method="toy", step=step, stop=0.4, interval=0.003)
        system = found.system
        assert found.stats["steps"] == round(0.4 / step)
        assert max(np.abs(system.Phi(t, q)).max() for t, q in zip(found.t, found.q, strict=True)) < 1e-12
        errors.append(np.abs((found.v - exact.v) * system.tables.scale).max())
    assert all(2.8 < a / b < 6.0 for a, b in pairwise(errors))  # 4 in the limit


# -- how they are asked for ------------------------------------------------------------------------------------------


def test_tolerance_by_default_and_no_steps(tmp_path, capsys):
    assert mbdsl.simulate(MODEL, method="scipy-dop853", stop=0.1).stats["tol"] == mbdsl.simulation.plan.DEFAULT_TOL
    arguments = ["simulate", str(MODEL), "--method", "scipy-dop853", "--output", str(tmp_path / "x.csv")]
    assert cli.main([*arguments, "--step", "1ms"]) == 2
    assert "no fixed steps" in (message := capsys.readouterr().err) and "tolerance" in message
    assert cli.main([*arguments, "--tol", "1e-8", "--stop", "0.1 s"]) == 0
    assert re.search(r"steps of scipy-dop853 to t = 0.1 s, \d+ evaluations", capsys.readouterr().out)
    with pytest.raises(UsageError, match="no parameter alpha"):
        mbdsl.simulate(MODEL, method="ida", options={"alpha": -0.1})


def test_what_they_cannot_do_is_told():
    with pytest.raises(UsageError, match="step by step"):
        mbdsl.Simulation(MODEL, method="ida")
    receipt = explain(MODEL, method="scipy-radau")
    assert receipt.step is None and "joints" in str(receipt)


def test_what_is_not_installed_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "sksundae", None)
    monkeypatch.setitem(sys.modules, "sksundae.ida", None)
    assert cli.main(["simulate", str(MODEL), "--method", "ida"]) == 2
    message = capsys.readouterr().err
    assert "ida needs sksundae" in message and "in the folder of mbdsl: pip install '.[sundials]'" in message


def test_nothing_of_theirs_is_loaded_without_them(tmp_path):
    code = (
        "import sys, mbdsl\n"
        f"mbdsl.simulate({str(MODEL)!r}, method='hht-si2', stop=0.01)\n"
        "loaded = {'scipy', 'sksundae', 'importlib.metadata', 'mbdsl.integrators.external.ida'} & set(sys.modules)\n"
        "import mbdsl.integrators\n"
        "mbdsl.integrators.available()\n"
        "print(sorted(loaded), sorted({'scipy', 'sksundae'} & set(sys.modules)))"
    )
    for _ in range(2):  # the first compiles code that is not stored, which imports the compiler
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[] []\n"


# -- registration ----------------------------------------------------------------------------------------------------


def install(folder, monkeypatch, **entries):
    """A distribution on the path, as pip leaves one: its entry points are (module, source)."""
    info = folder / "others-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: others\nVersion: 1.0\n")
    lines = [f"{name.replace('_', '-')} = {module}" for name, (module, _) in entries.items()]
    (info / "entry_points.txt").write_text("[mbdsl.integrators]\n" + "\n".join(lines) + "\n")
    for module, source in entries.values():
        if source is not None:
            (folder / f"{module}.py").write_text(source)
    monkeypatch.syspath_prepend(str(folder))
    importlib.invalidate_caches()


def example():
    """The backend in docs/backends.md."""
    page = (ROOT / "docs" / "backends.md").read_text(encoding="utf-8")
    return re.search(r'```python\n("""rk4.py""".*?)```', page, re.DOTALL)[1]


def test_another_package_registers_one(tmp_path, monkeypatch, capsys):
    wrong = "from mbdsl.integrators import Method\nMETHOD = Method('x', '', 1, 1, (), '')\nsolve = print\n"
    install(
        tmp_path,
        monkeypatch,
        rk4=("their_rk4", example()),
        broken=("their_broken", "import what_is_nowhere\n"),
        missing=("their_missing", None),
        empty=("their_empty", "solve = print\n"),
        other=("their_other", wrong),
        ida=("their_ida", wrong.replace("'x'", "'ida'")),
    )
    assert declared("rk4").order == 4 and "rk4" in available() and "rk4" not in compiled()
    found = mbdsl.simulate(MODEL, method="rk4", step=1e-3, stop=0.1)
    own = mbdsl.simulate(MODEL, method="scipy-dop853", tol=1e-10, stop=0.1)
    assert found.stats["steps"] == 100 and np.abs(found.q - own.q).max() < 1e-9  # five outputs in each step
    assert {name.split()[0] for name in problems()} == {"broken", "missing", "empty", "other", "ida"}
    assert declared("ida").source.startswith("Hindmarsh")

    assert cli.main(["methods"]) == 0
    listing = capsys.readouterr().out
    assert re.search(r"^rk4 +order 4", listing, re.MULTILINE) and "the classical Runge-Kutta formula" in listing
    assert "broken (of others): cannot be used: ModuleNotFoundError: No module named 'what_is_nowhere'" in listing
    assert "needs scikit-sundae" in listing
    with pytest.raises(UsageError, match="no method `broken`") as caught:
        mbdsl.simulate(MODEL, method="broken")
    assert "what_is_nowhere" in caught.value.hint
    with pytest.raises(UsageError, match="no method `nothing`") as caught:
        mbdsl.simulate(MODEL, method="nothing")
    assert "rk4" in caught.value.hint and "hht-si2" in caught.value.hint


def test_orders_of_the_example(registered):
    """The Runge-Kutta formula of the page is of order 4 in positions and velocities, with the projection."""
    names = {}
    exec(example(), names)
    register(SimpleNamespace(METHOD=names["METHOD"], solve=names["solve"]))
    reference = mbdsl.simulate(MODEL, method="scipy-dop853", tol=1e-12, stop=0.4, interval=0.1)
    steps, errors = [0.02, 0.01, 0.005], []
    for h in steps:
        found = mbdsl.simulate(MODEL, method="rk4", step=h, stop=0.4, interval=0.1)
        errors.append([np.abs(found.q - reference.q).max(), np.abs(found.v - reference.v).max()])
    slopes = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert ((slopes > 3.7) & (slopes < 4.5)).all(), slopes


def test_one_that_does_not_search_its_steps_says_so_where_a_law_may_have_a_peak(registered):
    """An impulse of 1 N.s on 2 kg, within a step: 0.5 m/s are missed."""
    names = {}
    exec(example(), names)
    register(SimpleNamespace(METHOD=names["METHOD"], solve=names["solve"]))
    scene = mbdsl.lang.load.parse_text(
        """model P Ground g0(g = 0 m/s2); PointMass p(m = 2 kg);
        Force push(p.c, fx = 1 N*time/1 s + 282.0947918 N*exp(-((time - 0.512 s)/2 ms)^2));
        initial equation p.x = 0 m; p.y = 0 m; p.vx = 0 m/s; p.vy = 0 m/s;
        annotation(experiment(StopTime = 1 s)); end P;"""
    )
    run = mbdsl.simulate(scene, method="rk4", step=0.05, interval=0.05)
    assert abs(run["p.vx"][-1] - 0.25) < 1e-6  # of the 0.75 m/s that are right
    (text,) = run.stats["warnings"]
    assert text.startswith("<text>:2:") and "rk4 does not search its steps for peaks of laws" in text
    assert "a peak of the law of Force push between the ends of a step may be missed" in text
    searched = mbdsl.simulate(scene, method="scipy-dop853", tol=1e-6)
    assert searched.stats["warnings"] == [] and abs(searched["p.vx"][-1] - 0.75) < 1e-5
    assert mbdsl.simulate(MODEL, method="rk4", step=1e-3, stop=0.05).stats["warnings"] == []


def test_registered_in_the_process(registered):
    register(backend(exact))
    assert mbdsl.simulate(falling(), method="toy", step=0.1, stop=1.0, interval=0.5)["one.y"][-1] == pytest.approx(
        1.0 - 9.81 / 2
    )
    register(backend(exact))  # twice, as in a notebook
    with pytest.raises(UsageError, match="there is already a method of that name"):
        register(backend(exact, "hht-si2"))
    with pytest.raises(UsageError, match="no METHOD"):
        register(SimpleNamespace(solve=exact))
    with pytest.raises(UsageError, match="function solve"):
        register(SimpleNamespace(METHOD=backend(exact).METHOD))


def test_options_reach_them(registered, tmp_path):
    seen = []

    def solve(problem):
        seen.append(dict(problem.options))
        return exact(problem)

    register(backend(solve, parameters={"theta": Option(0.5, 0.0, 1.0, "a weight")}))
    mbdsl.simulate(falling(), method="toy", step=0.1, stop=1.0, options={"theta": 0.25})
    assert seen[0] == {"theta": 0.25}
    arguments = ["simulate", str(MODEL), "--method", "toy", "--stop", "0.1", "--output", str(tmp_path / "x.csv")]
    assert cli.main([*arguments, "--option", "theta=0.75", "--quiet"]) in (0, 4)
    assert seen[-1] == {"theta": 0.75}
    for wrong, message in (("theta=2", "outside"), ("eta=1", "no parameter eta"), ("theta=x", "--option")):
        with pytest.raises(UsageError, match=message):
            cli._run([*arguments, "--option", wrong])


@pytest.mark.parametrize(("speed", "wanted"), [(3.0, 3.0), (0.0, 0.5)])
def test_tolerances_of_velocities(registered, speed, wanted):
    """Two masses 2 m apart, without gravity: relative to their speed, or to the 2 m in the 4 s of the run."""
    found = []

    def solve(problem):
        found.append(problem.tolerances())
        return exact(problem)

    register(backend(solve, steps=("fixed", "controlled")))
    scene = mbdsl.parse(f"""
model Two
  Ground ground(g = 0 m/s2);
  Frame there(ground, r = {{2 m, 0}});
  PointMass p(m = 1 kg);
  SpringDamper s(there, p, k = 0 N/m, s0 = 2 m);
initial equation
  p.x = 0 m;
  p.y = 0 m;
  p.vy = {speed} m/s;
end Two;
""")
    mbdsl.simulate(scene, method="toy", tol=1e-3, stop=4.0)
    positions, velocities = found[0]
    assert positions == pytest.approx([2e-3, 2e-3], rel=1e-14)
    assert velocities == pytest.approx([1e-3 * wanted] * 2, rel=1e-14)


@pytest.mark.parametrize("method", ["scipy-radau", "ida"])
def test_work_is_counted_over_all_events(method):
    """Each of the five smooth pieces needs a matrix of its own, and each matrix at least one factorisation."""
    b = Builder("Jumps")
    ground, p = b.Ground("ground", g=0.0), b.PointMass("p", m=2.0)
    b.SpringDamper("s", ground, p, k=100.0, s0=1.0)
    b.Force("push", p, fx="if mod(time, 0.4 s) < 0.2 s then 1 N else 0 N", fy=0.0)
    b.initial(p.x, 1.0)
    stats = mbdsl.simulate(b.scene(), method=method, tol=1e-4, stop=1.0).stats
    assert stats["events"] == 4
    assert 5 <= stats["matrix_evaluations"] <= stats["factorisations"]
    assert stats["evaluations"] > stats["steps"]


def hesitating(problem):
    """Three states around each output, as if an event were located there."""
    for t, q, v in exact(problem):
        for early in (5e-11, 3e-11, 0.0):
            yield t - early * problem.h, q, v


def test_states_close_to_an_output_are_one_output(registered):
    register(backend(hesitating))
    found = mbdsl.simulate(falling(), method="toy", step=0.1, stop=1.0, interval=0.1)
    np.testing.assert_allclose(found.t, np.linspace(0.0, 1.0, 11), rtol=1e-15)
    np.testing.assert_allclose(found["two.y"], 1.0 - 9.81 * found.t**2 / 2)


# -- errors ----------------------------------------------------------------------------------------------------------


def stopping(problem):
    for state in exact(problem):
        if state[0] > 0.55:
            raise IntegrationError("there is no more to say", hint="say more")
        yield state


@pytest.mark.parametrize(
    ("solve", "message"),
    [
        (stopping, "there is no more to say"),
        (lambda problem: list(exact(problem))[:5], "ended before the stop time"),
        (lambda problem: ((t, q, v if t < 0.55 else 1 // 0) for t, q, v in exact(problem)), "ZeroDivision"),
        (lambda problem: ((t, q * (np.nan if t > 0.55 else 1), v) for t, q, v in exact(problem)), "finite"),
        (lambda problem: (s for k, s in enumerate(exact(problem)) if k != 5), "an output due at 0.6 s"),
        (lambda problem: ((t, q[:1] if t > 0.55 else q, v) for t, q, v in exact(problem)), "shapes"),
    ],
)
def test_failures_are_reported_and_results_kept(registered, solve, message):
    register(backend(solve))
    with pytest.raises(IntegrationError, match=message) as caught:
        mbdsl.simulate(falling(), method="toy", step=0.1, stop=1.0, interval=0.1)
    assert "toy stopped at t = 0.5 s" in caught.value.message and caught.value.hint
    found = caught.value.trajectory
    assert found.status == "failed" and found.t[-1] == 0.5
    np.testing.assert_allclose(found["two.y"], 1.0 - 9.81 * found.t**2 / 2)


@pytest.mark.parametrize("method", OWN)
def test_a_law_that_leaves_its_domain_ends_all_of_them(method):
    """A torque of sqrt(0.5 - phi) has no value beyond 0.5 rad: the results up to there are kept."""
    b = Builder("Domain")
    ground, wheel = b.Ground("ground"), b.Body("wheel", m=1.0, I=1.0)
    b.Revolute("pin", ground, wheel.c)
    b.Torque("motor", ground, wheel.c, tau="1e-3 N.m*sqrt(0.5 - wheel.phi/1 rad)")
    b.initial(wheel.w, 1.0)
    with pytest.raises(IntegrationError, match=f"{method} stopped at t = 0.4") as caught:
        mbdsl.simulate(b.scene(), method=method, tol=1e-6, stop=1.0, interval=0.01)
    found = caught.value.trajectory
    assert found.status == "failed" and found.t[-1] > 0.4
    assert found["wheel.phi"] == pytest.approx(found.t, abs=1e-3)


def test_interrupted_results_are_kept():
    def interrupt(progress):
        if progress.t > 0.3:
            raise KeyboardInterrupt

    def slow(problem):
        from time import sleep

        for state in exact(problem):
            sleep(0.01)
            yield state

    register(backend(slow))
    with pytest.raises(mbdsl.Interrupted) as caught:
        mbdsl.simulate(falling(), method="toy", step=0.1, stop=10.0, interval=0.02, progress=interrupt)
    found = caught.value.trajectory
    assert found.status == "interrupted" and 0.3 < found.t[-1] < 10.0
    np.testing.assert_allclose(found["one.y"], 1.0 - 9.81 * found.t**2 / 2, atol=1e-9)
