"""Events between steps are found: pulses and windows much shorter than the steps of a quiet motion.

A mass of 1 kg slides without friction; a law, a table, a window or a driver acts for a tiny part of the time or of the
way. Answers are closed forms: the momentum and the place that an impulse leaves, the work done on the way.
"""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators.external import _peaks
from mbdsl.integrators.peak_zones import Landings
from mbdsl.system import build
from mbdsl.system.peaks_along_motion import OnTheWay

TEXT = """
model Unseen
  {tables}
  Ground ground(g = 0);
  Body b(m = 1.0, I = 1);
  Prismatic s(ground, b.c);
  TranslationalSpringDamper law(s, force = -({force}));
initial equation
  s.s = 0.0;
  s.v = {v};
  annotation(experiment(StopTime = {stop}));
end Unseen;
"""
OWN = ("hht-si2", "hht-i3", "radau5")
#: largest error over the tolerance; a missed pulse is an error of about 1
FACTOR = {"hht-si2": 3.0, "hht-i3": 3.0, "radau5": 20.0, "scipy-dop853": 20.0}
CENTRE, PEAK = 3.3337, float(1.0 / np.sqrt(np.pi))


def gauss(width, centre):
    """A pulse with an impulse of 1 N.s."""
    return f"{PEAK / width!r}*exp(-((time - {centre})/{width})^2)"


def windows():
    """sin(100 t) > 0.99999 for t in [0, 1]: middles of the intervals, and their length."""
    k = np.arange(16)
    return (np.pi / 2.0 + 2.0 * np.pi * k) / 100.0, 2.0 * np.arccos(0.99999) / 100.0


def spike(smoothness):
    rows = "0, 0; 1, 0; 2, 0; 2.0005, 2000; 2.001, 0; 3, 0; 4, 0"
    return f'Table p(table = [{rows}], smoothness = "{smoothness}", '


#: law -> tables, force [N], speed at the start, stop, and v and s at the end
CASES = {
    "10 ms in 10 s": ("", gauss(0.01, CENTRE), 0.0, 10.0, (1.0, 10.0 - CENTRE)),
    "1 ms in 10 s, moving": ("", gauss(1e-3, CENTRE), 1.0, 10.0, (2.0, 10.0 + 10.0 - CENTRE)),
    "1 ms in 1000 s": ("", gauss(1e-3, 333.37), 1.0, 1000.0, (2.0, 1000.0 + 1000.0 - 333.37)),
    "nested condition": (
        "",
        "if sin(100*time) > 0.99999 then 1000 else 0",
        0.0,
        1.0,
        (16 * 1000 * windows()[1], 1000 * windows()[1] * (1.0 - windows()[0]).sum()),
    ),
    "table": (spike("linear") + 'extrapolation = "hold");', "p(time)", 0.0, 4.0, (1.0, 4.0 - 2.0005)),
    "periodic table": (
        spike("linear") + 'extrapolation = "periodic");',
        "p(time)",
        0.0,
        20.0,
        (5.0, sum(20.0 - 2.0005 - 4.0 * k for k in range(5))),
    ),
    "difference of steps": (
        "",
        "500*(tanh(1e6*(time - 3)) - tanh(1e6*(time - 3.001)))",
        0.0,
        10.0,
        (1.0, 10.0 - 3.0005),
    ),
}


def scene(name):
    tables, force, v, stop, _ = CASES[name]
    return mbdsl.parse(TEXT.format(tables=tables, force=force, v=v, stop=stop))


def check(run, exact, bound):
    v, s = exact
    assert abs(run.v[-1, 0] - v) < bound * abs(v)
    assert abs(run.q[-1, 0] - s) < bound * abs(s)


@pytest.mark.parametrize("tol", [1e-3, 1e-6])
@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize("name", CASES)
def test_what_time_alone_does_is_seen(name, method, tol):
    check(mbdsl.simulate(scene(name), method=method, tol=tol), CASES[name][-1], FACTOR[method] * tol)


@pytest.mark.parametrize("name", ["10 ms in 10 s", "nested condition"])
def test_backends_see_it(name):
    run = mbdsl.simulate(scene(name), method="scipy-dop853", tol=1e-3)
    check(run, CASES[name][-1], FACTOR["scipy-dop853"] * 1e-3)


def test_a_burst_at_the_end():
    """Quadrature: of 40 exp(-((t - 97.123)/0.05)^2) sin(60 (t - 97)) over 100 s."""
    from scipy.integrate import quad

    def force(t):
        return 40.0 * np.exp(-(((t - 97.123) / 0.05) ** 2)) * np.sin(60.0 * (t - 97.0))

    v = quad(force, 96.5, 97.8, epsabs=1e-12, limit=200)[0]
    s = quad(lambda t: force(t) * (100.0 - t), 96.5, 97.8, epsabs=1e-12, limit=200)[0]
    text = TEXT.format(tables="", force="40*exp(-((time - 97.123)/0.05)^2)*sin(60*(time - 97))", v=0.0, stop=100.0)
    for method in ("hht-si2", "radau5"):
        check(mbdsl.simulate(mbdsl.parse(text), method=method, tol=1e-6), (v, s), FACTOR[method] * 1e-6)


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_a_bump_of_a_driver_is_seen(method):
    """A cart is driven forth by 0.1 m and back within 6 ms. A mass of 1 kg on it, held by a spring of 1 N/m, is left
    with the impulse of the spring, k 0.1 m 2 ms sqrt(pi) exp(-(omega 2 ms)^2/4), and swings with omega = 1 rad/s."""
    model = """
    model Bump
      Ground ground(g = 0);
      Body cart(m = 1, I = 1);
      Prismatic way(ground, cart.c);
      TranslationalDriver motion(way, s = 0.1*exp(-((time - 3.3337)/2e-3)^2));
      Body b(m = 1.0, I = 1);
      Prismatic rail(cart.c, b.c);
      TranslationalSpringDamper spring(rail, k = 1);
    initial equation
      rail.s = 0.0;
      rail.v = 0.0;
      annotation(experiment(StopTime = 10));
    end Bump;
    """
    run = mbdsl.simulate(mbdsl.parse(model), method=method, tol=1e-6)
    v, t = 0.1 * 2e-3 * np.sqrt(np.pi) * np.exp(-1e-6), 10.0 - CENTRE
    assert run["b.vx"][-1] == pytest.approx(v * np.cos(t), rel=1e-3)
    assert run["b.x"][-1] == pytest.approx(v * np.sin(t), rel=1e-3)


@pytest.mark.parametrize("law", ["exp(-(time/1 s)^2) - 1 + (time/1 s)^2", "cos(time/1 s) - 1 + (time/1 s)^2/2"])
def test_summands_that_cancel_have_no_peaks(law):
    """Laws like t^4 are monotone; their summands are some 1e6 times as large, and rounding has many peaks."""
    text = TEXT.format(tables="", force=f"if time < 9 s then ({law})*1 N else 0 N", v=0.0, stop=0.05)
    assert len(list(islice(build(mbdsl.parse(text)).time_zones(0.0, 0.05), 1000))) < 100


def test_a_law_without_values_has_no_peaks():
    """The square root of a negative number, which an if excludes."""
    text = TEXT.format(tables="", force="sqrt(time/1 s - 9)*1 N*(if time > 9 s then 1 else 0)", v=0.0, stop=4.0)
    assert list(build(mbdsl.parse(text)).time_zones(0.0, 4.0)) == []


@pytest.mark.parametrize(
    "event", ["", " + (if time < 5 s then 0 N else 0.1 N)"], ids=["before the end", "before an event"]
)
@pytest.mark.parametrize(("before", "width"), [(1e-5, 2e-6), (1e-3, 2e-4)])
@pytest.mark.parametrize("method", ["radau5", "dop853", "radau9", "radau13"])
def test_a_pulse_just_before_the_end(method, before, width, event):
    """A step that ends shortly before the stop time, or before a known event, is not lengthened over the pulse."""
    end = 5.0 if event else 10.0
    text = TEXT.format(tables="", force=gauss(width, repr(end - before)) + event, v=0.0, stop=10.0)
    run = mbdsl.simulate(mbdsl.parse(text), method=method, tol=1e-6)
    v, s = (1.5, 5.0 + before + 1.25) if event else (1.0, before)
    assert run["b.vx"][-1] == pytest.approx(v, abs=2e-6) and run["b.x"][-1] == pytest.approx(s, abs=2e-6)


# -- on the way --------------------------------------------------------------------------------------------------------

#: force [N], speed at the start, and v and s after 2 s: 1 J is done on 10 um or 10 nm of the way, or the speed rises by
#: 10 um/s within some 10 ns
BEYOND = np.sqrt(3.0)
WAYS = {
    "10 um": ("if s > 0.50001 and s < 0.50002 then 1e5 else 0", 1.0, (BEYOND, 0.50001 + BEYOND * 1.49999)),
    "10 nm": ("if s > 0.5 and s < 0.50000001 then 1e8 else 0", 1.0, (BEYOND, 0.5 + BEYOND * 1.5)),
    "smooth": ("(1e5 N)/sqrt(pi)*exp(-((s - 0.5 m)/(10 um))^2)", 1.0, (BEYOND, 0.5 + BEYOND * 1.5)),
    "two in a step": (
        "(if s > 0.5 and s < 0.50001 then 1e5 else 0) + (if s > 0.501 and s < 0.50101 then 1e5 else 0)",
        1.0,
        (np.sqrt(5.0), 0.501 + np.sqrt(5.0) * (1.5 - 1e-3 / BEYOND)),
    ),
    "speed": ("0.1 + (if v > 0.15 and v < 0.16 then 1e5 else 0)", 0.1, (0.31, 0.0625 + 0.16 * 1.5 + 0.1125)),
}


@pytest.mark.parametrize("tol", [1e-3, 1e-6])
@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize("name", WAYS)
def test_what_the_state_does_on_the_way_is_seen(name, method, tol):
    """To 20 um more than the tolerance: the answers leave out the motion within the windows."""
    force, v, exact = WAYS[name]
    text = TEXT.format(tables="", force=force, v=v, stop=2.0)
    run = mbdsl.simulate(mbdsl.parse(text), method=method, tol=tol)
    assert run.v[-1, 0] == pytest.approx(exact[0], rel=FACTOR[method] * tol, abs=1e-7)
    assert run.q[-1, 0] == pytest.approx(exact[1], rel=FACTOR[method] * tol, abs=2e-5)


def test_a_backend_looks_on_its_way():
    force, v, exact = WAYS["10 um"]
    run = mbdsl.simulate(
        mbdsl.parse(TEXT.format(tables="", force=force, v=v, stop=2.0)), method="scipy-dop853", tol=1e-6
    )
    assert run.v[-1, 0] == pytest.approx(exact[0], rel=FACTOR["scipy-dop853"] * 1e-6)


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "scipy-dop853"])
def test_a_pulse_whose_time_depends_on_a_frame_at_rest_is_seen(method):
    """A load that passes a marker on the ground: it depends on time and on a constant coordinate."""
    centre = "2.3456 + ground.phi/(1 rad)"
    pulse = f"{PEAK / 1e-4!r}*exp(-((time/(1 s) - {centre})/1e-4)^2)"
    window = f"if time/(1 s) > {centre} and time/(1 s) < {centre} + 1e-3 then 1000 else 0"
    for force in (pulse, window):
        run = mbdsl.simulate(mbdsl.parse(TEXT.format(tables="", force=force, v=0.0, stop=5.0)), method=method, tol=1e-6)
        assert run.v[-1, 0] == pytest.approx(1.0, rel=FACTOR[method] * 1e-6)


@pytest.mark.parametrize("together", [1, 2, 32])
def test_a_backend_returns_to_a_step_with_all_that_followed(together, monkeypatch):
    """A narrow hill on the way, v^2 = 1 + 2 W after it, and known times on both sides of it: each is met once, and no
    output is lost or repeated, including the one at a known time."""
    monkeypatch.setattr(_peaks, "TOGETHER", together)
    hill = f"{0.5 * PEAK / 1e-4!r}*exp(-((s - 1.02)/1e-4)^2)"
    steps = "(if time > 1 then 1e-3 else 0) + (if time > 1.311 and time < 1.315 then 250 else 0)"
    scene = mbdsl.parse(TEXT.format(tables="", force=f"{hill} + {steps}", v=1.0, stop=2.0))
    times = [1.0 - 1e-6, 1.0, 1.01, 1.5, 2.0]
    run = mbdsl.simulate(scene, method="scipy-dop853", tol=1e-6, times=times)
    assert run.t.tolist() == [0.0, *times] and run.stats["events"] == 3
    # 0.5 J of the hill; 1e-3 N from 1 s on; 1 N.s of the push
    assert run.v[-1, 0] == pytest.approx(np.sqrt(2.0) + 1.0 + 1e-3, abs=2e-5)


SPRING = "-(100 N/m)*s - (3 N.s/m)*v - (5 N/m3)*s^3 + (1 N.s/m2)*s*v"


def test_what_cannot_hide_is_not_looked_at():
    """Springs, dampers, cubes and products of positions and speeds have no narrow peaks: no peak is registered for
    them."""
    from mbdsl.system import build

    for force, looked_at in ((SPRING, 0), ("(100 N)*tanh(v/(1 mm/s))", 1)):
        scene = mbdsl.parse(TEXT.format(tables="", force=force, v=1.0, stop=2.0))
        assert len(build(scene).kept(OnTheWay).terms) == looked_at


@pytest.mark.parametrize("tol", [1e-6, 1e-9])
def test_a_condition_that_rounding_decides_ends_the_run_at_once(tol):
    """The pistons of `chatter_engine.mbd` move along y, and their forces depend on the sign of a speed along x, which
    is rounding. At 1e-9, steps of 1e-14 s followed one another for minutes."""
    model = Path(__file__).parents[1] / "data" / "chatter_engine.mbd"
    with pytest.raises(mbdsl.MbdslError, match="back and forth") as raised:
        mbdsl.simulate(model, method="radau5", tol=tol)
    assert raised.value.trajectory.stats["steps"] < 20_000
    found = str(raised.value)
    assert ".piston.c.vx < 0` changes in the law of Force cyl[" in found
    assert "\n      Force gas(piston.c, fx = -A*p0*(if piston.vx < 0 then 0.1 else 1));\n            ^^^\n" in found


def test_a_force_that_keeps_changing_its_sign(monkeypatch):
    """Coulomb friction as a jump: at rest, velocities of rounding size change the sign of the force in every step. The
    run ends with the reason instead of searching ever shorter steps."""
    text = """model Stop
  Ground ground(g = 0);
  Body b(m = 1, I = 1);
  Prismatic rail(ground, b.c);
  TranslationalSpringDamper law(rail, force = if v > 0 then 2 else -2);
initial equation
  rail.s = 0;
  rail.v = 1;
  annotation(experiment(StopTime = 2));
end Stop;"""
    looks, look = [], Landings._unseen

    def counted(self, rows):
        looks.append(len(rows))
        return look(self, rows)

    monkeypatch.setattr(Landings, "_unseen", counted)
    with pytest.raises(mbdsl.IntegrationError) as stopped:
        mbdsl.simulate(mbdsl.parse(text), method="hht-si2", tol=1e-4, interval=0.02, general=True)
    assert "back and forth" in stopped.value.message and "law" in stopped.value.message
    run = stopped.value.trajectory
    assert run.t[-1] == pytest.approx(0.5, abs=1e-3)  # where v = 1 - 2 t vanishes
    assert len(looks) < 1000


GROWING = """model Growing Ground ground(g = 0);
  PointMass mass(m = 1 kg);
  Force f(mass, fx = -100*mass.x + 1e-4*exp(4*time)*exp(-((mass.x - 0.1)/0.002)^2));
initial equation mass.x = 0.5; mass.y = 0; mass.vx = 1; mass.vy = 0; end Growing;"""


def test_what_is_seen_does_not_depend_on_pauses_nor_on_runs_before():
    """Peaks are compared with the largest one so far, after different numbers of steps: the results have the same
    bits."""
    from mbdsl.integrators.loop import loop_state as S
    from mbdsl.simulation.mechanism_run import MechanismRun
    from mbdsl.simulation.plan import plan
    from mbdsl.simulation.run_options import RunOptions

    scene = mbdsl.parse(GROWING)
    run = plan(scene, RunOptions(method="radau5", tol=3e-2, stop=4.0))
    motion, found = MechanismRun(scene, run), []
    motion.prepare()
    for steps in (10**6, 10**6, 7):
        motion.restart(run)
        while (status := motion.advance(steps)) == S.RUNNING:
            pass
        assert status == S.DONE
        found.append((motion.steps, motion.states()[1]))
    assert found[0][0] == found[1][0] == found[2][0]
    assert np.array_equal(found[0][1], found[1][1])
    assert np.array_equal(found[0][1], found[2][1])


def test_a_law_of_many_terms():
    """A sum of a thousand narrow peaks is split without exhausting the stack."""
    from mbdsl.system import build

    peaks = " + ".join(f"(1 N)*exp(-((s - {k} mm)/(1 mm))^2)" for k in range(1200))
    system = build(mbdsl.parse(TEXT.format(tables="", force=peaks, v=1.0, stop=2.0)))
    assert len(system.kept(OnTheWay).terms) >= 1200
