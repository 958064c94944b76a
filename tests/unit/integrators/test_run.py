"""The driver around a method: steps, stop times, output, failures, determinism."""

from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import mbdsl
from mbdsl import Builder
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import compiled as methods
from mbdsl.integrators import modules
from mbdsl.integrators.options import check_options
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

METHODS = sorted(methods())
G = 9.81


def pendulum():
    """A point mass on a link of 1 m, let go level at the left; with its closed form."""
    b = Builder("Pendulum")
    ground, mass = b.Ground("ground"), b.PointMass("mass", m=1.0)
    b.Distance("rod", ground, mass, length=1.0)
    b.initial(mass.x, -1.0, fixed=False)
    b.initial(mass.y, 0.0)
    return b.scene()


def exact(t):
    """x, vx and the vertical reaction on the mass; sin(phi/2) = sin(pi/4) sn(K + w0 t | 1/2), phi from -y."""
    sn, cn, _, _ = ellipj(ellipk(0.5) + np.sqrt(G) * t, 0.5)
    phi, rate = -2 * np.arcsin(np.sqrt(0.5) * sn), -2 * np.sqrt(0.5 * G) * cn
    return np.sin(phi), np.cos(phi) * rate, (rate**2 + G * np.cos(phi)) * np.cos(phi)


# -- options ---------------------------------------------------------------------------------------------------


def refusal(method, **options):
    try:
        check_options(method, options)
    except UsageError as problem:
        return problem.message
    return ""


@pytest.mark.parametrize("method", METHODS)
def test_options_of_every_method(method):
    """Both ends of the interval are allowed, though other options may not fit them; values outside, and NaN, are
    refused."""
    for name, option in methods()[method].parameters.items():
        assert check_options(method, {name: None})[name] == option.default
        assert option.default is None or option.lower <= option.default <= option.upper
        assert all("is outside" not in refusal(method, **{name: value}) for value in (option.lower, option.upper))
        for value in (option.lower - 0.01, option.upper + 0.01, float("nan")):
            assert f"{name} = {value:g} is outside" in refusal(method, **{name: value})


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "hht-add"])
def test_alpha(method):
    assert (methods()[method].parameters["alpha"].lower, check_options(method, {})["alpha"]) == (-1 / 3, -0.1)
    with pytest.raises(UsageError, match="alpha"):
        mbdsl.simulate(pendulum(), method=method, stop=0.1, options={"alpha": 0.01})
    with pytest.raises(UsageError, match="no parameter beta"):
        mbdsl.simulate(pendulum(), method=method, stop=0.1, options={"beta": 0.3})


def test_options_of_newmark():
    """beta follows from gamma unless it is given; together they have to be stable."""
    coefficients = modules()["newmark"].coefficients
    assert coefficients(check_options("newmark", {}))[:2] == pytest.approx((1.1**2 / 4, 0.6))
    assert coefficients(check_options("newmark", {"gamma": 1.0}))[:2] == pytest.approx((9 / 16, 1.0))
    with pytest.raises(UsageError, match=r"gamma = 0\.4 is outside"):
        check_options("newmark", {"gamma": 0.4})
    with pytest.raises(UsageError, match=r"beta = 0.28 is below \(gamma \+ 1/2\)\^2/4 = 0.3025: .*unstable"):
        check_options("newmark", {"beta": 0.28})


def test_the_trapezoidal_rule_is_refused_on_constrained_models():
    given = {"gamma": 0.5, "beta": 0.25}
    with pytest.raises(UsageError, match=r"trapezoidal rule.*constrained") as caught:
        mbdsl.simulate(pendulum(), method="newmark", stop=0.1, options=given)
    assert "force" in caught.value.hint
    forced = mbdsl.simulate(pendulum(), method="newmark", stop=0.1, options=given, force=True)
    assert forced["mass.y"][-1] == pytest.approx(-G * 0.1**2 / 2, rel=1e-3)
    free = Builder("Free")  # it is a good method without constraints
    mass = free.PointMass("mass", m=1.0)
    free.FreeMotion("free", free.Ground("ground"), mass)
    assert mbdsl.simulate(free, method="newmark", stop=0.1, options=given)["mass.y"][-1] == pytest.approx(
        -G * 0.1**2 / 2
    )


def test_b_of_hht_add():
    with pytest.raises(UsageError, match=r"b = 1/2 .* determines neither"):
        mbdsl.simulate(pendulum(), method="hht-add", stop=0.1, options={"b": 0.5})
    ends = [
        mbdsl.simulate(pendulum(), method="hht-add", step=1e-3, stop=0.5, options={"b": b})["mass.x"][-1]
        for b in (-0.5, 0.0, 0.2)
    ]
    assert ends == pytest.approx([exact(0.5)[0]] * 3, abs=1e-5)
    assert len(set(ends)) == 3  # it arrives


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "rk4"}, "there is no method `rk4`"),
        ({"step": 0.0}, "step must be above zero"),
        ({"step": -1e-3}, "step must be above zero"),
        ({"step": float("nan")}, "not a finite number"),
        ({"stop": float("inf")}, "not a finite number"),
        ({"stop": -1.0}, "before the start"),
        ({"step": 1e-30}, "too small"),
        ({"interval": -0.1}, "must not be negative"),
        ({"interval": 1e-12}, "do not fit in memory"),
    ],
)
def test_arguments_that_make_no_sense(arguments, message):
    with pytest.raises(UsageError, match=message):
        mbdsl.simulate(pendulum(), **{"stop": 1.0, **arguments})


# -- steps and output ------------------------------------------------------------------------------------------


#: numbers of steps for which the order shows: errors of order 9 and 13 are soon those of rounding
COUNTS = {8: (12, 16, 24, 32), 9: (6, 8, 10, 12), 13: (4, 5, 6)}


@pytest.mark.parametrize("name", ["mass.x", "mass.vx", "rod.fy"])
@pytest.mark.parametrize("method", METHODS)
def test_stop_times_are_hit_exactly(method, name, order, slopes):
    """All steps are shortened equally, so that the last one ends at the stop time; q, v and reactions are of order
    2."""
    counts = COUNTS.get(methods()[method].order, (64, 128, 256, 512))
    steps = [1.0 / (n + 0.3) for n in counts]
    expected, errors = dict(zip(("mass.x", "mass.vx", "rod.fy"), exact(1.0), strict=True))[name], []
    for h in steps:
        r = mbdsl.simulate(pendulum(), method=method, step=h, stop=1.0, interval=1.0)
        assert r.t.tolist() == [0.0, 1.0]
        assert r.stats["steps"] == round(1.0 / h - 0.3) + 1
        errors.append(abs(r[name][-1] - expected))
    low, high = slopes(method)
    assert low < order([1.0 / (n + 1) for n in counts], errors) < high


@pytest.mark.parametrize("method", METHODS)
def test_output_between_steps(method, order, slopes):
    """Interpolation adds no error: errors at times that are not multiples of the step fall with order 2 as well.

    Interpolation of order 7 limits a method of order 8, irregularly, as the times lie anywhere in the steps.
    """
    parts = {8: (8, 16, 32, 64), 9: (16, 20, 24, 32), 13: (8, 10, 12, 16)}
    steps = [1.0 / part for part in parts.get(methods()[method].order, (64, 128, 256, 512))]
    errors = []
    for h in steps:
        r = mbdsl.simulate(pendulum(), method=method, step=h, stop=1.5, interval=0.0737)
        late = r.t > 0.0
        found = [r[name] for name in ("mass.x", "mass.vx", "rod.fy")]
        errors.append([np.abs(f - e)[late].max() for f, e in zip(found, exact(r.t), strict=True)])
    low, high = (6.5, 8.5) if methods()[method].order == 8 else slopes(method)
    if methods()[method].order > 8:  # v by the polynomial of s stages: order s + 1
        low, high = (methods()[method].order + 3) / 2 - 0.5, high
    for error in np.transpose(errors):
        assert low < order(steps, error) < high


def test_interpolation_is_of_higher_order_than_the_method():
    """Between steps, the output differs from the smooth curve through the steps by less than the method's error."""
    r = mbdsl.simulate(pendulum(), step=0.01, stop=1.0, interval=0.0)
    fine = mbdsl.simulate(pendulum(), step=0.01, stop=1.0, interval=0.0025)
    assert fine["mass.x"][::4] == pytest.approx(r["mass.x"], abs=1e-15)
    assert fine["mass.vx"][::4] == pytest.approx(r["mass.vx"], abs=1e-14)
    middle = fine["mass.x"][2:-1:4]
    # the cubic of two values and two rates: h^4/384 x'''' is 3e-9; rates of the method are off by h^2, times h/8
    assert np.abs(middle - exact(fine.t[2:-1:4])[0]).max() < 1.5 * np.abs(r["mass.x"] - exact(r.t)[0]).max() + 1e-8


def test_every_step_is_stored_with_interval_zero():
    r = mbdsl.simulate(pendulum(), step=0.1, stop=1.05, interval=0.0)
    assert r.t == pytest.approx(np.linspace(0.0, 1.05, 12), abs=1e-15)  # eleven steps of one size
    assert r.stats["steps"] == 11
    assert len(r) == 12


def test_default_interval_gives_501_points():
    r = mbdsl.simulate(pendulum(), step=0.01, stop=1.0)
    assert len(r) == 501
    assert (
        np.abs(np.hypot(r["mass.x"], r["mass.y"]) - 1).max() < 1e-4
    )  # between steps the cubic leaves the circle a little


@pytest.mark.parametrize("method", METHODS)
def test_a_single_step(method):
    """One step as long as the run: x = -1 + O(h^4), y = -g h^2/2."""
    h = 1e-3
    r = mbdsl.simulate(pendulum(), method=method, step=h, stop=h, interval=0.0)
    assert r.stats["steps"] == 1
    assert r.t.tolist() == [0.0, h]
    assert r["mass.y"][-1] == pytest.approx(-G * h**2 / 2, rel=1e-4)
    assert r["mass.vy"][-1] == pytest.approx(-G * h, rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_no_step_at_all(method):
    r = mbdsl.simulate(pendulum(), method=method, start=2.0, stop=2.0)
    assert r.t.tolist() == [2.0]
    assert r.status == "done"
    assert r.stats["steps"] == 0
    assert r["mass.x"] == pytest.approx([-1.0])


def test_a_later_start():
    """Time is the model's, not counted from the start."""
    b = Builder("Late")
    ground, body = b.Ground("ground", g=0.0), b.PointMass("p", m=2.0)
    b.FreeMotion("free", ground, body)
    b.Force("push", body, fx="2 N/s*time")
    r = mbdsl.simulate(b, step=1e-3, start=3.0, stop=4.0, interval=0.5)
    assert r.t.tolist() == [3.0, 3.5, 4.0]
    assert r["p.vx"] == pytest.approx((r.t**2 - 9) / 2, abs=1e-5)


# -- the loop --------------------------------------------------------------------------------------------------


def begun(method, scene=None, h=1e-3, stop=10.0):
    scene = scene if scene is not None else pendulum()
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    run = MethodRun(system, method, h, 0.0, stop, np.array([stop]))
    s = initial_state(system, mechanism, 0.0)
    run.begin(s.q, s.v, s.a, s.lam)
    return run


@pytest.mark.parametrize("method", METHODS)
def test_the_same_twice_and_in_pieces(method):
    """Bit for bit: the buffers hold the whole state of a run."""
    runs = [begun(method) for _ in range(3)]
    runs[0].advance(1000)
    runs[1].advance(1000)
    for _ in range(100):
        runs[2].advance(10)
    assert np.array_equal(runs[0].vectors, runs[1].vectors)
    assert np.array_equal(runs[0].vectors, runs[2].vectors)
    assert np.array_equal(runs[0].integers, runs[2].integers)


# -- errors ----------------------------------------------------------------------------------------------------


def broken(law):
    """A wheel that turns at 1 rad/s, and a torque that is NaN from some time on."""
    b = Builder("Broken")
    ground, wheel = b.Ground("ground"), b.Body("wheel", m=1.0, I=1.0)
    b.Revolute("pin", ground, wheel.c)
    b.table("known", "[0 s, 0 N.m; 0.5 s, 0 N.m]", extrapolation="error")
    b.Torque("motor", ground, wheel.c, tau=law)
    b.initial(wheel.w, 1.0)
    return b.scene()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("law", ["1e-9 N.m*sqrt(0.5 - time/1 s)", "known(time)"])
def test_not_a_number_stops_with_results_so_far(method, law):
    with pytest.raises(IntegrationError) as caught:
        mbdsl.simulate(broken(law), method=method, step=0.01, stop=1.0, interval=0.1)
    error, r = caught.value, caught.value.trajectory
    assert error.exit_code == 4
    assert "not finite" in error.message
    assert "`motor.tau` has no value at time = 0.51 s" in error.message
    assert r.status == "failed"
    assert r.message == error.message
    assert r.stats["status"] == "failed"
    assert r.stats["steps"] == 50
    assert r.t == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert r["wheel.phi"] == pytest.approx(r.t, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_drive_beyond_reach(method):
    """Newton's method finds no pose, and the message names joints."""
    b = Builder("Reach")
    ground = b.Ground("ground")
    link, arm = b.Rod("link", m=1.0, length=0.3), b.Rod("arm", m=1.0, length=0.3)
    b.Revolute("O", ground, link.a)
    b.Revolute("A", link.b, arm.a)
    b.DistanceDriver("pull", ground, arm.b, s="0.5 m + 0.2 m/s*time")
    b.initial(link.phi, 0.5, fixed=False)
    b.initial(arm.phi, -0.5, fixed=False)
    with pytest.raises(IntegrationError) as caught:
        mbdsl.simulate(b, method=method, step=1e-3, stop=1.0, interval=0.1)
    error = caught.value
    assert error.trajectory.status == "failed"
    assert 0.4 <= error.trajectory.t[-1] <= 0.5
    assert any(name in error.message for name in ("pull.", "A.", "O.", "link", "arm"))
    assert error.hint


def test_interruption_keeps_the_results(monkeypatch):
    calls = []
    advance = MethodRun.advance

    def interrupted(self, steps):
        calls.append(steps)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return advance(self, min(steps, 50))

    monkeypatch.setattr(MethodRun, "advance", interrupted)
    with pytest.raises(mbdsl.Interrupted, match=r"interrupted at t = 0\.1 s") as caught:
        mbdsl.simulate(pendulum(), step=1e-3, stop=1.0, interval=0.01)
    assert isinstance(caught.value, KeyboardInterrupt)  # it must end a loop over runs, as any Ctrl-C does
    r = caught.value.trajectory
    assert r.status == "interrupted"
    assert r.stats["steps"] == 100
    assert r.t == pytest.approx(np.arange(11) * 0.01)
    assert np.abs(r["mass.x"] - exact(r.t)[0]).max() < 1e-5


def test_progress_is_told():
    reports = []
    mbdsl.simulate(pendulum(), step=1e-3, stop=1.0, progress=reports.append)
    assert reports
    assert all(p.stop == 1.0 and p.start == 0.0 and p.h == 1e-3 for p in reports)
    assert [p.steps for p in reports] == sorted(p.steps for p in reports)
    assert reports[0].t == pytest.approx(reports[0].steps * 1e-3)


def test_phases_without_progress_are_named():
    class Phases(list):
        phase = list.append
        __call__ = list.append

    phases = Phases()
    mbdsl.simulate(pendulum(), step=1e-3, stop=1e-2, progress=phases)
    names = [phase for phase in phases if isinstance(phase, str)]
    assert names[-2:] == ["assembling the initial state", "taking the first steps"]


@pytest.mark.parametrize("method", METHODS)
def test_counts(method):
    """If the matrix hardly changes, it is kept: fewer factorisations than steps, and at most one more iteration."""
    r = mbdsl.simulate(pendulum(), method=method, step=1e-3, stop=2.0)
    s = r.stats
    assert (s["n"], s["m"], s["p"], s["steps"], s["h"]) == (2, 1, 0, 2000, 1e-3)
    if methods()[method].explicit:  # 12 stages; one to three evaluations are for the projection
        assert 13 * s["steps"] <= s["evaluations"] <= 15 * s["steps"] and s["factorisations"] == 12 * s["steps"]
        assert s["iterations"] == 0
        return
    assert s["evaluations"] == 0
    # stages of order 5 and more are solved to rounding where steps are fixed
    assert s["steps"] <= s["iterations"] <= {5: 4, 9: 4, 13: 5}.get(methods()[method].order, 3) * s["steps"]
    assert 0 < s["factorisations"] < 0.5 * s["steps"]
    assert set(s["seconds"]) == {"parse", "build", "compile", "initialise", "integrate", "write"}


def test_a_step_far_too_large_is_no_result():
    """The slider crank with steps of half a second: Newton converges, to a crank that turns a hundred times."""
    with pytest.raises(IntegrationError, match=r"means nothing|does not converge"):
        mbdsl.simulate(Path(__file__).parents[3] / "models" / "slider_crank.mbd", method="hht-i3", step=0.5, stop=2.0)
