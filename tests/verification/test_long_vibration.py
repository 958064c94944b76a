"""A quarter of a million steps of free vibration of a beam: energy and frequency are those of the method, by theory.

A free beam, set vibrating in its first mode (4.730^2 sqrt(EI/(rhoA L^4))) by forces in balance, which act for some
steps; no joints, so that the trapezoidal rule may be used. Of HHT's amplification matrix with h w small the eigenvalues
are exp(-d +- i f), to leading order

    d = -alpha (1 + alpha)^2/8 (h w)^4,   f = h w (1 - c (h w)^2),   c = 1/12 - alpha/4 - 3 alpha^2/8,

and without damping exactly f = 2 atan(h w/2): it is then a rotation of (w q, q'), and keeps the energy.
"""

import numpy as np
import pytest

import mbdsl

ROOT = 4.730040744862704  # of cos(x) cosh(x) = 1
LENGTH, MASS, EI = 2.0, 3.0, 500.0
W = ROOT**2 * np.sqrt(EI / (MASS / LENGTH * LENGTH**4))
HW, STEPS, EVERY = 0.1, 250_000, 250
H = HW / W
TRAPEZOIDAL = {"newmark": {"gamma": 0.5}} | {m: {"alpha": 0.0} for m in ("hht-i3", "hht-add", "hht-si2")}


@pytest.fixture(scope="module")
def scene():
    b = mbdsl.Builder("Free")
    ground = b.Ground("ground", g=0.0)
    beam = b.FlexibleBeam(
        "beam", mass=MASS, length=LENGTH, S=1.0, I=EI / 1e9, E=1e9,
        elements=64, modes=1, axial=0, reference='"mean-axis"', stiffening=False,
    )  # fmt: skip
    until = 30.5 * H
    for name, at, f in (("left", beam.a, 1.0), ("right", beam.b, 1.0), ("middle", beam.c, -2.0)):
        b.Force(name, ground, at, fy=f"if time < {until:.12g} then {f} else 0")
    return b.scene()


@pytest.fixture(scope="module")
def run(scene):
    """``run(method, **options)``: w q and q' at every 250th step from the 250th on, energy likewise."""
    known = {}

    def find(method, **options):
        key = (method, *options.items())
        if key not in known:
            found = mbdsl.simulate(scene, method=method, step=H, stop=STEPS * H, interval=EVERY * H, options=options)
            assert found.stats["steps"] == STEPS
            assert len(found) == STEPS // EVERY + 1
            known[key] = (W * found["beam.q[4]"][1:], found["beam.dq[4]"][1:], found["energy.total"][1:])
            # no other mode moves
            assert np.abs(found["beam.phi"]).max() < 1e-9
        return known[key]

    return find


def turned(x, y, expected):
    """Angle by which (x, y) turns in a step: the value near the expected one that agrees with the measured angles."""
    angles = np.unwrap(np.angle((y + 1j * x) * np.exp(-1j * expected * EVERY * np.arange(len(x)))))
    return expected + np.polyfit(EVERY * np.arange(len(x)), angles, 1)[0]


@pytest.mark.parametrize("method", TRAPEZOIDAL)
def test_the_trapezoidal_rule_keeps_the_energy(run, method):
    """Constant except for rounding: 2.2e-16 a step, at random or, at worst, 5.5e-11 in all; measured: 1.5e-13."""
    _, _, E = run(method, **TRAPEZOIDAL[method])
    assert E[0] > 0.0
    assert np.abs(E / E[0] - 1).max() < 1e-11


@pytest.mark.parametrize("method", TRAPEZOIDAL)
def test_period_of_the_trapezoidal_rule(run, method):
    """2 atan(h w/2), which is late by (h w)^2/12, 20 rad in 25000; 64 elements err by (4.73/64)^4/1440 = 2.07e-8."""
    x, y, _ = run(method, **TRAPEZOIDAL[method])
    found = turned(x, y, 2 * np.arctan(HW / 2))
    assert found == pytest.approx(2 * np.arctan(HW / 2) * (1 + 2.07e-8), rel=1e-9)
    assert (1 - found / HW) / HW**2 == pytest.approx(1 / 12, rel=2e-3)  # and (h w)^2/80 more


@pytest.mark.parametrize("method", ["hht-i3", "hht-add", "hht-si2"])
@pytest.mark.parametrize("alpha", [-0.3, -0.05])
def test_decay_and_period_with_alpha(run, method, alpha):
    """To leading order; the next term, (h w)^2 = 1e-2 of it and less, is in the bounds."""
    x, y, E = run(method, alpha=alpha)
    late = 1 / 12 - alpha / 4 - 3 * alpha**2 / 8
    expected = HW * (1 - late * HW**2)
    assert (1 - turned(x, y, expected) / HW) / HW**2 == pytest.approx(late, rel=2e-2)
    decay = -np.polyfit(EVERY * np.arange(len(E)), np.log(E) / 2, 1)[0]
    assert decay == pytest.approx(-alpha * (1 + alpha) ** 2 / 8 * HW**4, rel=2e-2)
    # E oscillates by about (h w)^2 with the phase of the vibration; it never grows by more
    assert (np.diff(E) / E[:-1]).max() < 2 * HW**2
    averages = E.reshape(20, -1).mean(axis=1)
    assert (np.diff(averages) < 0.0).all()
