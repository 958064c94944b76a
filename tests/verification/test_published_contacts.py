"""Published problems of rigid contacts with friction, written as a user would write them, against published numbers of
other codes, and against programs of our own in minimal coordinates.

Sources: Siconos tutorials (INRIA), examples/mechanics: ImpactingStick, FourBarLinkageWith3clearance, CamFollower,
FrictionOscillator, with its reference files; P. Flores, R. Leine, C. Glocker, Multibody Syst. Dyn. 23 (2010) 165-190.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import mbdsl

MODELS = Path(__file__).parents[1] / "data" / "contact_problems"
MOREAU = {"method": "moreau-jean"}


def final(name, stop, **options):
    return mbdsl.simulate(MODELS / f"{name}.mbd", stop=stop, **options)


def check(found, expected, close):
    assert {x: found[x][-1] for x in expected} == pytest.approx(expected, abs=close)


# -- impacting stick --------------------------------------------------------------------------------------------------


def stick(stop):
    """x, y, phi and their rates of a stick of 1 m and 1 kg, g = 10 m/s2: parabolas between impacts with e = 1 and
    mu = 0.01, whose restitution is reduced where friction would let the impact gain energy."""
    q, v, t = np.array([np.sqrt(0.125), np.sqrt(0.125) + 0.01, 0.25 * np.pi]), np.array([-0.5, 0.1, 0.1]), 0.0
    mass = np.array([1.0, 1.0, 1.0 / 12.0])

    def at(s):
        return q + v * s - np.array([0.0, 5.0 * s * s, 0.0])

    def gap(s):
        return at(s)[1] - 0.5 * np.cos(at(s)[2])

    while True:
        grid = np.linspace(1e-9, stop - t, 2001)
        below = np.flatnonzero([gap(s) <= 0.0 for s in grid])
        if not len(below):
            s = stop - t
            return np.array([*at(s), v[0], v[1] - 10.0 * s, v[2]])
        s = brentq(gap, grid[below[0] - 1], grid[below[0]], xtol=1e-15)
        q, v, t = at(s), v - np.array([0.0, 10.0 * s, 0.0]), t + s
        W, T = np.array([0, 1, 0.5 * np.sin(q[2])]), np.array([1, 0, 0.5 * np.cos(q[2])])

        def struck(e, v=v, W=W, T=T):
            for sense in (1.0, -1.0):
                R = (W - 0.01 * sense * T) / mass
                new = v - (1.0 + e) * (W @ v) / (W @ R) * R
                if sense * (T @ new) > 0.0:
                    return new
            raise AssertionError("it sticks")

        def gain(e, v=v):
            return float(mass @ struck(e) ** 2 - mass @ v**2)

        v = struck(1.0 if gain(1.0) <= 0.0 else brentq(gain, 0.0, 1.0, xtol=1e-15))


@pytest.mark.parametrize(("options", "close"), [({}, 1e-8), ({"step": 1e-3}, 1e-8), (MOREAU | {"step": 1e-4}, 1e-2)])
def test_impacting_stick(options, close):
    """Siconos, h = 1e-4 s: x, y and the angle at 0.2 s. Its impacts may gain energy, here 7e-4 J of 0.12 J."""
    found = final("impacting_stick", 0.2, **options)
    x, y, angle, vx, vy, w = stick(0.2)
    exact = {"x": x, "y": y, "phi": angle + np.pi / 2, "vx": vx, "vy": vy, "w": w}
    check(found, {f"stick.{k}": x for k, x in exact.items()}, close)
    check(found, {"stick.x": 0.2529172312, "stick.y": 0.2471693301, "stick.phi": 1.081891494 + np.pi / 2}, 2e-4)


# -- dry friction -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("options", "close"), [({"tol": 1e-6}, 1e-5), ({"step": 1e-2}, 1e-5)])
def test_friction_oscillator(options, close):
    """m = k = mu N = 1: half circles about -1 and 1 in the plane of x and v, from (12, 6) until |x| < 1 at rest."""
    x, centre = -1.0 + np.hypot(13.0, 6.0), 1.0
    while abs(x) > 1.0:
        x, centre = 2.0 * centre - x, -centre
    check(final("friction_oscillator", 30.0, **options), {"slide.s": x, "slide.v": 0.0}, close)
    assert x == pytest.approx(0.6820441, abs=2e-4)  # Siconos, h = 0.01 s, at 100 s


# -- cam follower -----------------------------------------------------------------------------------------------------


def follower(stop):
    """s and v of a mass on a spring above a cam: vibrations between impacts with e = 0.8."""
    w, turn = np.sqrt(1430.8 / 1.221), 2 * np.pi * 358 / 60
    k1, k2, r1, r3 = 0.45, 0.40393320723821, 0.85, 0.15

    def cam(t, dt=0.0):
        x = (turn * t + 0.5 * np.pi) % (2 * np.pi)
        b = min(x, 2 * np.pi - x) + np.copysign(turn * dt, np.pi - x)
        if b.real <= 0.5 * np.pi:
            return 0.1
        if b.real <= 0.5 * np.pi + 1.050328174371336:
            return -k1 * np.sin(b) + r1 * np.sqrt(1 - (np.cos(b) * k1 / r1) ** 2) - 0.3
        if b.real <= 0.5 * np.pi + 1.22173047639603:
            b += np.pi / 9
            return -k2 * np.cos(b) + r3 * np.sqrt(1 - (np.sin(b) * k2 / r3) ** 2) - 0.3
        return 0.25393320723821

    t, s, v = 0.0, 0.4, 0.4
    while True:

        def gap(x, t=t, s=s, v=v):
            return s * np.cos(w * x) + v / w * np.sin(w * x) - cam(t + x)

        grid = np.linspace(1e-9, stop - t, 4001)
        below = np.flatnonzero([gap(x) <= 0.0 for x in grid])
        x = brentq(gap, grid[below[0] - 1], grid[below[0]], xtol=1e-15) if len(below) else stop - t
        s, v, t = s * np.cos(w * x) + v / w * np.sin(w * x), v * np.cos(w * x) - s * w * np.sin(w * x), t + x
        if not len(below):
            return s, v
        lift = (cam(t + 1e-7) - cam(t - 1e-7)) / 2e-7
        v = lift - 0.8 * (v - lift)


@pytest.mark.parametrize(("options", "close"), [({}, 1e-4), ({"step": 1e-3, "method": "radau5"}, 1e-4)])
def test_cam_follower(options, close):
    """It leaves the cam of 358 rpm in each turn; from 0.754 s on, the cam is a circle about its axis again."""
    s, v = follower(0.8)
    check(final("cam_follower", 0.8, **options), {"guide.s": s, "guide.v": v}, close * 30)


# -- clearance --------------------------------------------------------------------------------------------------------

#: by DOP853 in the three angles, with location of impacts, lift-off and reversals of the slip, rtol 1e-10
CRANK = {"crank.phi": 1.613025140, "rod.phi": -0.519910471, "slider.phi": 0.0, "crank.w": 71.659582205}


@pytest.mark.parametrize(
    ("options", "stop", "close"),
    [
        ({"tol": 1e-6, "method": "radau5"}, 0.03, 2e-5),
        ({"step": 1e-5}, 0.02, 1e-3),
        (MOREAU | {"step": 2e-5}, 0.02, 5e-3),
    ],
)
def test_slider_crank_with_clearance_in_its_guide(options, stop, close):
    """Twelve impacts of two corners, which accumulate at 2.6925 ms; both lift off at 15.0313 ms."""
    found = final("clearance_crank", stop, **options)
    k = int(np.argmin(np.abs(found.t - 0.02)))
    assert {x: found[x][k] for x in CRANK} == pytest.approx(CRANK, abs=close)
    assert found["high.impacts"][k] >= 2 and found["high.active"][k] == 0.0


#: Siconos, h = 1e-4 s, at 0.05 s
FOUR_BAR = {
    "crank.phi": 1.667922274684632,
    "coupler.phi": 0.3597911516537848,
    "rocker.phi": 1.305371962187748,
    "coupler.x": 1.779863025738767,
    "coupler.y": 1.700461082063057,
    "rocker.x": 3.328023262683081,
    "rocker.y": 1.201227940780370,
}


@pytest.mark.parametrize(
    "options", [{"step": 1e-4}, {"step": 2e-4, "method": "hht-i3"}, {"tol": 1e-4, "method": "radau5"}]
)
def test_four_bar_with_clearance_in_three_pins(options):
    """Each pin strikes its hole, of 5 mm more, and then slides, rolls and sticks in it."""
    found = final("four_bar_clearance", 0.05, **options)
    check(found, FOUR_BAR, 1e-4)
    for name in "ABC":
        assert found[f"{name}.impacts"][-1] > 0 and found[f"{name}.depth"].max() < 1e-7
