"""Blades and rolling: closed forms, met with the order of each method."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf

import mbdsl

# -- Chaplygin's sleigh: a body on a blade, its centre of mass ahead of it by a ------------------------------------


def sleigh(t, m=1.0, I=0.1, a=0.1, v0=1.0, w0=2.0):
    """Velocity along the blade, angular velocity, angle (phi(0) = 0); Bloch, Nonholonomic Mechanics, sec. 1.7."""
    b = np.sqrt((I + m * a**2) / m)
    Om = np.sqrt(w0**2 + (v0 / b) ** 2)
    tau0 = np.arctanh(v0 / (b * Om))
    tau = tau0 + a * Om * t / b
    return (
        b * Om * np.tanh(tau),
        Om / np.cosh(tau),
        2 * b / a * (np.arctan(np.tanh(tau / 2)) - np.arctan(np.tanh(tau0 / 2))),
    )


def place(t):
    """The blade at time t, by quadrature of its velocity."""

    def rate_of_x(t):
        v, _, phi = sleigh(t)
        return v * np.cos(phi)

    def rate_of_y(t):
        v, _, phi = sleigh(t)
        return v * np.sin(phi)

    return [quad(rate, 0, t, epsabs=1e-14, epsrel=1e-13, limit=200)[0] for rate in (rate_of_x, rate_of_y)]


def test_closed_form_of_the_sleigh(reference):
    """It satisfies m (v' - a w^2) = 0 and (I + m a^2) w' + m a v w = 0, and is the published one."""
    m, I, a, step = 1.0, 0.1, 0.1, 1e-30
    for t in (0.0, 0.3, 2.0, 7.0):
        v, w, _ = sleigh(t)
        dv, dw, dphi = (x.imag / step for x in sleigh(t + 1j * step))
        assert [dv, dw, dphi] == pytest.approx([a * w**2, -m * a * v * w / (I + m * a**2), w], rel=1e-13)
    assert sleigh(0.0) == pytest.approx((1.0, 2.0, 0.0), abs=1e-15)
    for row in reference("chaplygin_sleigh")["data"]["rows"]:
        t = float(row["t"])
        # sech falls like exp(-1.1 t): its relative error grows with tau
        assert sleigh(t) == pytest.approx([float(row[key]) for key in ("v", "omega", "phi")], rel=1e-13)
        assert place(t) == pytest.approx([float(row[key]) for key in ("xP", "yP")], abs=1e-12)


# -- a disc on a slope, held by a spring -------------------------------------------------------------------------


def disc(t, m=2.0, r=0.1, k=50.0, s0=0.3, slope=np.pi / 6, g=9.81):
    """s, its rate, and the forces along the slope and normal to it that the slope exerts on the disc.

    m s'' = m g sin(slope) - k (s - s0) - F and, rolling, I s''/r = F r with I = m r^2/2; let go at s = s0.
    """
    w, level = np.sqrt(k / (1.5 * m)), s0 + m * g * np.sin(slope) / k
    s, v = level + (s0 - level) * np.cos(w * t), -(s0 - level) * w * np.sin(w * t)
    return s, v, 0.5 * m * w**2 * (s - level), m * g * np.cos(slope) + 0 * t


def test_closed_form_of_the_disc():
    """Newton along the slope, with s'' by differences of v."""
    m, k, s0, g, t, d = 2.0, 50.0, 0.3, 9.81, np.linspace(0, 2, 9), 1e-4
    s, v, force, _ = disc(t)
    ds, dv = ((disc(t + d)[i] - disc(t - d)[i]) / (2 * d) for i in (0, 1))
    # differences are wrong by d^2/6 w^3 times the amplitude of 0.2 m: 2e-8; rounding 1e-16/d
    assert ds == pytest.approx(v, abs=1e-7)
    assert m * dv == pytest.approx(m * g * np.sin(np.pi / 6) - k * (s - s0) + force, abs=1e-6)


# -- the models --------------------------------------------------------------------------------------------------

#: Five halvings. newmark is of first order where its error of that order is the larger one; below 0.2 ms the multiplier
#: of a velocity constraint shows the remaining error of v in Newton's iteration, over h.
LONGEST = 2.0**-5


def test_chaplygin_sleigh(model, any_order, halved, wrong_orders):
    """At 2 s, after most of the turn: velocities, angle, place, and the blade's side force m (v w + a w')."""
    method = any_order
    m, I, a, t = 1.0, 0.1, 0.1, 2.0
    v, w, phi = sleigh(t)
    force = m * (v * w + a * (-m * a * v * w / (I + m * a**2)))
    exact = {"blade.v": v, "sleigh.w": w, "sleigh.phi": phi, "side": force}
    exact["sleigh.P.x"], exact["sleigh.P.y"] = place(t)
    scene, steps = mbdsl.load(model("chaplygin_sleigh")), halved(method, LONGEST)
    errors = {name: [] for name in exact}
    for h in steps:
        end = mbdsl.simulate(scene, method=method, step=h, stop=t, interval=t)
        found = {name: end[name][-1] for name in exact if name != "side"}
        angle = found["sleigh.phi"]
        found["side"] = -np.sin(angle) * end["blade.fx"][-1] + np.cos(angle) * end["blade.fy"][-1]
        for name, value in exact.items():
            errors[name].append(abs(found[name] - value))
    assert not wrong_orders(method, steps, errors)


def test_sleigh_keeps_its_energy_and_does_not_slip(model, method):
    found = mbdsl.simulate(model("chaplygin_sleigh"), method=method, step=1e-3, interval=0.0)
    P = [found[f"sleigh.P.{key}"] for key in ("vx", "vy", "phi")]
    slip = P[1] * np.cos(P[2]) - P[0] * np.sin(P[2])
    assert np.abs(slip).max() < 1e-9
    energy = found["energy.total"]
    assert np.abs(energy - energy[0]).max() < (1e-2 if method == "newmark" else 1e-5) * energy[0]


def test_rolling_disc(model, any_order, halved, wrong_orders):
    method, t = any_order, 2.0
    s, v, along, normal = disc(t)
    scene, steps = mbdsl.load(model("rolling_disc")), halved(method, LONGEST)
    errors = {name: [] for name in ("s", "v", "w", "along")}
    for h in steps:
        end = mbdsl.simulate(scene, method=method, step=h, stop=t, interval=t)
        c, d = np.cos(-np.pi / 6), np.sin(-np.pi / 6)
        fx, fy = end["contact.fx"][-1], end["contact.fy"][-1]
        errors["s"].append(abs(end["contact.s"][-1] - s))
        errors["v"].append(abs(end["contact.v"][-1] - v))
        errors["w"].append(abs(end["disc.w"][-1] + v / 0.1))
        errors["along"].append(abs(c * fx + d * fy - along))
        assert -d * fx + c * fy == pytest.approx(normal, rel=1e-6)  # constant
        # rolled, not slipped: the angle is that of the way, from zero at s = 0.3 m
        assert end["disc.phi"][-1] == pytest.approx(-(end["contact.s"][-1] - 0.3) / 0.1, abs=1e-3)
    assert not wrong_orders(method, steps, errors)


# -- a blade that slides down a slope and turns: its normal turns with it -------------------------------------------

SKATE = """model Skate Ground plane(g = 4.905 m/s2, n = {1, 0});
Body skate(m = 2 kg, I = 0.3 kg.m2); KnifeEdge blade(skate.c);
initial equation skate.x = 0 m; skate.y = 0 m; skate.phi = 0; skate.w = 1.5 rad/s; blade.v = 0 m/s; end Skate;"""


@pytest.mark.parametrize("method", ["nstiff", "hht-i3", "generalized-alpha-i3"])
def test_a_blade_whose_normal_turns(method):
    """It turns evenly, phi = w t. Along it v' = g cos(phi), so v = g/w sin(w t); across, m v w + m g sin(phi) is the
    force. Steps change all the time; the correction of index-3 methods at each change applies to holonomic constraints
    only. The error is within three times the tolerance, relative to the path and to the largest speed; the force
    follows from accelerations and is of the same order."""
    g, w, m, tol = 4.905, 1.5, 2.0, 1e-4
    run = mbdsl.simulate(mbdsl.parse(SKATE), method=method, tol=tol, stop=10.0, interval=0.25)
    x, v = g / w**2 / 2 * np.sin(w * run.t) ** 2, g / w * np.sin(w * run.t)
    y = g / w**2 / 2 * (w * run.t - np.sin(2 * w * run.t) / 2)
    assert np.abs(np.array([run["skate.x"] - x, run["skate.y"] - y])).max() < 3 * tol * y.max()
    assert np.abs(run["blade.v"] - v).max() < 3 * tol * (g / w)
    assert np.abs(run["blade.Gam[1]"]).max() < 3 * tol * (g / w)
    assert np.abs(np.abs(run.lam[:, 0]) - np.abs(2 * m * g * np.sin(w * run.t))).max() < 3 * tol * 2 * m * g


# -- integrated velocity constraints have errors in positions along their normal --------------------------------------

WHEEL = """model Wheel Ground ground(g = 0 m/s2); Body wheel(m = 1 kg, I = 0.1 kg.m2); Revolute O(ground, wheel.c);
RotationalVelocityDriver drive(O, w = 2 + 30*exp(-((time - 1.111)/1e-2)^2));
initial equation wheel.phi = 0.5; guess wheel.w = 2; end Wheel;"""


@pytest.mark.parametrize(("method", "tol"), [("hht-si2", 1e-6), ("hht-i3", 1e-6), ("nstiff", 1e-4)])
def test_the_angle_under_a_driven_speed(method, tol):
    """The speed is that of the driver, but the angle is its integral, with the error of the step: steps whose error
    estimate left that out did not converge, or took ten times as many."""
    run = mbdsl.simulate(mbdsl.parse(WHEEL), method=method, tol=tol, stop=3.0, interval=0.03, general=True)
    angle = 0.5 + 2 * run.t + 0.15 * np.sqrt(np.pi) * (erf((run.t - 1.111) / 1e-2) + 1)
    assert np.abs(run["wheel.phi"] - angle).max() < min(3 * tol, 10 * run.stats["error"])
