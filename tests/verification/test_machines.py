"""Machines with controllers, hydraulics, clocks, contacts and friction that sticks, against numbers from outside:
closed forms, and Runge-Kutta methods in minimal coordinates."""

from math import acos, cos, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import mbdsl

MACHINES = Path(__file__).parents[1] / "data" / "machines"
GALLERY = Path(__file__).parents[2] / "models" / "gallery"
#: angles of the boom [deg] at 1, 2, 3 s, in minimal coordinates
BOOM = [20.3535, 33.2030, 34.5896]


METHODS = ["newmark", "hht-i3", "hht-si2", "hht-add", "nstiff", "nstiff-si2", "generalized-alpha"]
METHODS += ["generalized-alpha-i3", "radau5", "radau9", "dop853"]


def errors(name, **given):
    """The differences of a run of a model from the numbers of the specification, in the units of the last digits that
    it gives."""
    if name == "boom":
        run = mbdsl.simulate(MACHINES / "boom.mbd", stop=3, interval=1, **given)
        return (np.rad2deg(run["pin.phi"][1:]) - BOOM) / 1e-4
    if name == "motor_crank":
        run = mbdsl.simulate(MACHINES / "motor_crank.mbd", stop=1.4, interval=1e-4, **given)
        return np.array([run["O.w"][10_000] - 47.71417, run["O.w"].max() - 51.59834]) / 1e-5
    if name == "cart_pole":
        run = mbdsl.simulate(MACHINES / "cart_pole.mbd", stop=1, interval=1, **given)
        return np.array([run["cart.x"][-1] + 0.220807, (run["pole.phi"][-1] - pi / 2 + 0.0332855) * 10]) / 1e-6
    if name == "valve_train":
        run = mbdsl.simulate(MACHINES / "valve_train.mbd", stop=4.4e-3, interval=4e-6, **given)
        off, strike = (next(x.t for x in run.events if x.kind == kind) for kind in ("lift-off", "impact"))
        angles = np.degrees(4000 * pi / 30 * np.array([off, strike])) - 60
        lifted = run["tappet.gap"].max() - 0.70836e-3, run["tappet.impulse"][-1] / 0.1 - 2.69637
        return np.array([*(angles - [-13.4155, 40.2216]) / 1e-4, lifted[0] / 1e-8, lifted[1] / 1e-5])
    run = mbdsl.simulate(MACHINES / "incline.mbd", **given)
    assert run.t[-1] == 3600.0
    return run["slide.s"] / 1e-16


@pytest.mark.parametrize("name", ["boom", "motor_crank", "cart_pole", "incline", "valve_train"])
def test_models_by_default_settings(name):
    """The tolerance of the default is 1e-4 of the size of the motion; the errors are a tenth of this and less."""
    assert np.abs(errors(name)).max() <= (10.0 if name == "motor_crank" else 1.0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("name", "step", "first", "second"),
    [  # errors of newmark, of order 1, and of the others
        ("boom", 1e-3, 15, 1),
        ("cart_pole", 1e-3, 400, 6),
        ("incline", 1.0, 1, 1),
        ("motor_crank", 5e-5, 300, 60),  # corners of its limiter are not located with fixed steps
        ("valve_train", 2e-6, 20, 3),
    ],
)
def test_models_with_fixed_steps(name, step, first, second, method):
    assert np.abs(errors(name, step=step, method=method)).max() <= (first if method == "newmark" else second)


def test_motor_crank():
    run = mbdsl.simulate(MACHINES / "motor_crank.mbd", stop=1.4, tol=1e-7, method="radau9", interval=1e-4)
    assert run["O.w"][10_000] == pytest.approx(47.71417, abs=1e-5)
    peak = np.argmax(run["O.w"])
    assert run["O.w"][peak] == pytest.approx(51.59834, abs=2e-5)
    assert run.t[peak] == pytest.approx(1.36596, abs=1e-4)
    # the limit of the current is reached, and the integrator stops there
    assert run["i"].max() == pytest.approx(10.0, abs=1e-3)
    assert np.abs(run["der(z)"]).max() <= 50.0


def verge_period() -> float:
    """Period of the regular motion of the clock [s].

    From a release at 0.25 rad with the rate w the foliot turns freely and the wheel accelerates, until the next tooth
    meets the other pallet. The momentum q = J_f w_f - n J_w w_w, n = a/r, has no part of the contact's force or
    impulse, and decreases with n tau. In contact w_f = q/J, J = J_f + n^2 J_w, until the other release, where the rate
    is -w: half a period. Bounces between strike and contact change neither q nor the angle, which its integral gives.
    """
    Jw, Jf, tau, n, pitch, release = 4e-5, 1e-5, 1e-3, 0.25, radians(24), 0.25
    J = Jf + n**2 * Jw

    def half(w: float) -> tuple[float, float, float]:
        """Time of the flight, angle and rate of the foliot after it."""
        gap = pitch / 2 - 2 * n * release
        t = (-2 * n * w + sqrt((2 * n * w) ** 2 + 2 * tau / Jw * gap)) / (tau / Jw)
        return t, release + w * t, (Jf * w - n * (Jw * n * w + tau * t)) / J

    def surplus(w: float) -> float:
        _, angle, rate = half(w)
        return rate**2 + 2 * n * tau / J * (angle + release) - w**2

    w = brentq(surplus, 0.1, 100, xtol=1e-14)
    t, _, rate = half(w)
    return 2 * (t + (rate + w) / (n * tau / J))


@pytest.mark.parametrize(
    ("e", "stop", "within", "given"),
    [
        (0.05, 15, 3e-9, {"step": 0.01}),
        (0.5, 7, 1e-5, {"step": 0.01}),
        (0.05, 7, 1e-5, {}),  # default settings
        *((0.05, 7, 1e-5, {"step": 0.01, "method": method}) for method in METHODS),
    ],
)
def test_verge_clock(e, stop, within, given):
    """The motion converges to the regular one by a factor of 0.36 a period."""
    assert verge_period() == pytest.approx(0.9529336667, abs=1e-10)
    text = (MACHINES / "verge_clock.mbd").read_text().replace("e = 0.05", f"e = {e}")
    run = mbdsl.simulate(mbdsl.parse(text), stop=stop, interval=stop, **given)
    assert not run.stats["warnings"]
    ticks = np.array([x.t for x in run.events if x.kind == "when"])
    periods = ticks[2:] - ticks[:-2]
    assert periods[-1] == pytest.approx(verge_period(), abs=within)
    assert run["up"][-1] == len(ticks[::2]) and run["down"][-1] == len(ticks[1::2])


def lift_off(rpm: float) -> tuple[float, float, float, float]:
    """Angle of the lift-off [rad], largest gap [m], angle [rad] and speed [m/s] of the landing.

    On the cam s = a (1 + cos 3 x), and the contact opens where m s'' + k s + F0 = 0. In flight the valve oscillates
    about s = -F0/k.
    """
    m, k, F0, a, w = 0.1, 40e3, 200.0, 4e-3, rpm * pi / 30
    start = -acos((F0 + k * a) / (a * (9 * m * w**2 - k))) / 3
    rate, middle = sqrt(k / m), F0 / k
    s, v = a * (1 + cos(3 * start)), -3 * a * w * sin(3 * start)

    def gap(x: float) -> float:
        t = (x - start) / w
        return (s + middle) * cos(rate * t) + v / rate * sin(rate * t) - middle - a * (1 + cos(3 * x))

    def closing(x: float) -> float:
        t = (x - start) / w
        return (s + middle) * rate * sin(rate * t) - v * cos(rate * t) - 3 * a * w * sin(3 * x)

    top = brentq(closing, start + 0.1, radians(35))
    end = brentq(gap, top, radians(60))
    return start, gap(top), end, closing(end)


def test_valve_train():
    expected = lift_off(4000)
    assert np.degrees([expected[0], expected[2]]) == pytest.approx([-13.4155, 40.2216], abs=1e-4)
    assert [expected[1], expected[3]] == pytest.approx([0.70836e-3, 2.69637], rel=1e-5)
    run = mbdsl.simulate(MACHINES / "valve_train.mbd", stop=4.4e-3, step=2e-6, interval=4e-6)
    changes = np.flatnonzero(np.diff(run["tappet.active"]))
    angle = 4000 * pi / 30 * run.t - radians(60)
    assert len(changes) == 2
    for k, at in zip(changes, (expected[0], expected[2]), strict=True):
        assert angle[k] - 2e-4 < at < angle[k + 1] + 2e-4
    assert run["tappet.gap"].max() == pytest.approx(expected[1], rel=1e-4)
    assert run["tappet.impulse"][-1] / 0.1 == pytest.approx(expected[3], rel=1e-4)


@pytest.mark.parametrize("method", [*METHODS, "radau13"])
@pytest.mark.parametrize("step", [0.25e-3, 1e-3])
def test_valve_train_with_long_steps(method, step):
    """A step turns the cam by 6 and by 24 degrees. Until it lifts off, the valve follows the cam: the event is
    where the reaction of the motion is zero, not that of a step."""
    run = mbdsl.simulate(MACHINES / "valve_train.mbd", stop=4.4e-3, step=step, method=method)
    assert run.events[0].kind == "lift-off"
    assert 4000 * 6 * run.events[0].t - 60 == pytest.approx(np.degrees(lift_off(4000)[0]), abs=0.02)


@pytest.mark.parametrize(("rpm", "leaves"), [(3600, False), (3660, True)])
def test_valve_train_at_its_critical_speed(rpm, leaves):
    """On the nose the contact opens if w^2 > 2 (F0 + k h)/(9 m h), h = 8 mm: above 3629.3 rpm."""
    assert sqrt(2 * (200 + 40e3 * 8e-3) / (9 * 0.1 * 8e-3)) * 30 / pi == pytest.approx(3629.3, abs=0.05)
    text = (MACHINES / "valve_train.mbd").read_text().replace("4000 rpm", f"{rpm} rpm")
    run = mbdsl.simulate(mbdsl.parse(text), stop=120 / 6 / rpm, step=2e-6, interval=4e-6)
    assert (run["tappet.active"].min() == 0) == leaves
    assert run["tappet.gap"].max() == pytest.approx(lift_off(rpm)[1] if leaves else 0.0, abs=2e-8)


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "nstiff-si2"])
def test_incline(method):
    """A block on a slope of 20 degrees holds for an hour: tan(20 deg) = 0.36 is below mu_s."""
    run = mbdsl.simulate(MACHINES / "incline.mbd", step=1.0, method=method)
    assert len(run.t) > 500 and run.t[-1] == 3600.0
    assert np.abs(run["slide.s"]).max() < 1e-16
    assert (run["slide.sliding"] == 0.0).all()
    assert run["slide.friction"] == pytest.approx(np.full(len(run.t), 9.81 * sin(radians(20))), rel=1e-3)


@pytest.mark.parametrize(
    ("name", "model"),
    [("boom", "hydraulic_boom"), *((x, x) for x in ("motor_crank", "cart_pole", "verge_clock", "valve_train"))],
)
def test_models_of_the_gallery_are_these(name, model):
    one, other = mbdsl.load(MACHINES / f"{name}.mbd"), mbdsl.load(GALLERY / f"{model}.mbd")
    assert one.components == other.components
    assert one.initial == other.initial
