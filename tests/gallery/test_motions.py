"""Motions with degrees of freedom against equations of motion of their own, integrated by SciPy, and closed forms."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh, expm
from scipy.optimize import brentq, fsolve
from scipy.special import ellipk

import mbdsl

G = 9.81


@pytest.fixture(scope="module")
def run(gallery):
    return lambda name: mbdsl.simulate(gallery(name))


def solution(rates, start, t):
    """States at times t by an explicit method of order 8, to 1e-12."""
    found = solve_ivp(rates, (t[0], t[-1]), start, "DOP853", t_eval=t, rtol=1e-12, atol=1e-12)
    assert found.success
    return found.y


def rods_hanging(lengths, masses, phi, t):
    """Angles of a chain of uniform rods by Lagrange's equations.

    With c_ij = m_i/3 + (masses below) on the diagonal and m_j/2 + (masses below j) for j > i:
    sum_j c_ij l_i l_j (cos(i - j) phi_j'' + sin(i - j) phi_j'^2) = -g l_i cos(phi_i) (m_i/2 + masses below).
    """
    n = len(lengths)
    below = [sum(masses[i + 1 :]) for i in range(n)]
    c = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            last = max(i, j)
            c[i, j] = masses[last] / (3 if i == j else 2) + below[last]
    c = c * np.outer(lengths, lengths)
    weights = G * np.array([lengths[i] * (masses[i] / 2 + below[i]) for i in range(n)])

    def rates(_, y):
        phi, w = y[:n], y[n:]
        d = phi[:, None] - phi
        return np.concatenate([w, np.linalg.solve(c * np.cos(d), -(c * np.sin(d)) @ w**2 - weights * np.cos(phi))])

    return solution(rates, [*np.radians(phi), *np.zeros(n)], t)[:n]


def test_double_pendulum(run):
    found = run("double_pendulum")
    expected = rods_hanging([0.5, 0.4], [0.4, 0.32], [20, 50], found.t)
    size = 0.9  # of the mechanism: angles to 1e-6 rad, with a margin of 3
    assert np.abs(np.array([found["upper.phi"], found["lower.phi"]]) - expected).max() < 3e-6 / size


def test_triple_pendulum(run):
    found = run("triple_pendulum")
    expected = rods_hanging([0.4, 0.3, 0.25], [0.32, 0.24, 0.2], [0, 30, 60], found.t)
    assert np.abs(np.array([found[f"rod[{i}].phi"] for i in (1, 2, 3)]) - expected).max() < 3e-6


def test_quarter_car(run):
    """The bump is the output of a linear system, so that one exponential of a matrix is the whole solution."""
    found = run("quarter_car")
    ms, mu, ks, cs, kt, h, T = 320, 45, 20e3, 1500, 190e3, 0.05, 0.2
    rate = 2 * np.pi / T
    a = np.zeros((7, 7))  # wheel, car, their velocities; 1, cos and sin of the bump
    a[0, 2] = a[1, 3] = 1
    a[2, :4] = np.array([-ks - kt, ks, -cs, cs]) / mu
    a[3, :4] = np.array([ks, -ks, cs, -cs]) / ms
    a[2, 4], a[2, 5] = kt * h / 2 / mu, -kt * h / 2 / mu
    a[5, 6], a[6, 5] = -rate, rate
    start = np.array([0, 0, 0, 0, 1, 1, 0.0])
    crossed = expm(a * T) @ start
    crossed[4:] = 0
    state = [
        start * 0 if t < 0.2 else expm(a * (t - 0.2)) @ start if t < 0.4 else expm(a * (t - 0.4)) @ crossed
        for t in found.t.tolist()
    ]
    wheel, car = np.array(state)[:, :2].T
    # the tolerance is 1e-5 of the lengths in the model, 0.5 m
    assert np.abs(found["wheel.y"] - 0.3 - wheel).max() < 1e-5
    assert np.abs(found["car.y"] - 0.7 - car).max() < 1e-5
    assert [wheel.max(), car.max()] == pytest.approx([0.0546, 0.0314], abs=1e-4)


def test_half_car(run):
    """The motion with the true angles of the springs; bounce and pitch from the textbook's 2 by 2 problem."""
    found = run("half_car")
    m, inertia, arms, stiffness, c = 700, 1100, np.array([1.2, -1.5]), np.array([18e3, 20e3]), 600
    k = np.array([[stiffness.sum(), arms @ stiffness], [arms @ stiffness, arms**2 @ stiffness]])
    frequencies = np.sqrt(eigh(k, np.diag([m, inertia]), eigvals_only=True)) / (2 * np.pi)
    assert frequencies == pytest.approx([1.109, 1.334], abs=1e-3)
    # stiffness and damping over mass by least squares; differences over 10 ms and the angles of springs: 0.1 %
    after = found.t > 0.7
    motion = np.stack([found["car.y"] - 0.6, found["car.phi"], found["car.vy"], found["car.w"]], axis=1)[after]
    forces = np.gradient(np.stack([found["car.vy"], found["car.w"]], axis=1), found.t, axis=0)[after]
    fitted = np.linalg.lstsq(motion, forces, rcond=None)[0][:2].T
    assert np.sqrt(np.sort(np.linalg.eigvals(-fitted))) / (2 * np.pi) == pytest.approx(frequencies, rel=0.01)

    def bump(t):
        """Height and rate of the road below both wheels."""
        u = (t - np.array([0.3, 0.57])) / 0.1
        on = (u > 0) & (u < 1)
        return on * 0.1 * np.sin(np.pi * u) ** 2, on * np.pi * np.sin(2 * np.pi * u)

    def rates(t, state):
        y, phi, vy, w = state
        height, rate = bump(t)
        arm = arms * np.exp(1j * phi)
        spring = arm + 1j * y - arms - 1j * height
        along = spring / np.abs(spring)
        v = (along.conjugate() * (1j * arm * w + 1j * vy - 1j * rate)).real
        force = -along * (stiffness * (np.abs(spring) - 0.6) + c * v)
        return [vy, w, force.imag.sum() / m, (arm.conjugate() * force).imag.sum() / inertia]

    y = solution(rates, [0.6, 0, 0, 0], found.t)
    assert np.abs(found["car.y"] - y[0]).max() < 1e-4
    assert np.abs(found["car.phi"] - y[1]).max() < 1e-4


def test_trebuchet(run):
    """Lagrange's equations of beam and counterweight with the same rope; the range from the flight's parabola."""
    found = run("trebuchet")
    k, sling, m, heavy, span = 50e3, 4.2, 30, 2000, 1.3 * 1.4
    beam = 150 * 6.3**2 / 12 + 150 * 1.85**2 + heavy * 1.3**2
    weight = heavy * 0.8**2 / 6 + heavy * 1.4**2

    def rates(_, state):
        theta, psi, x, y, dtheta, dpsi, vx, vy = state
        rope = 4j - 5 * np.exp(1j * theta) - (x + 1j * y)
        tension = 0.0 if vx > 0 and vy < vx else max(0.0, k * (abs(rope) - sling))
        pull = tension * rope / abs(rope)  # on the stone
        s, c = heavy * span * np.sin(psi - theta), heavy * span * np.cos(psi - theta)
        torque = (150 * 1.85 - heavy * 1.3) * G * np.cos(theta) + 5 * (1j * np.exp(1j * theta) * pull.conjugate()).real
        load = [torque - c * dpsi**2, -heavy * G * 1.4 * np.sin(psi) + c * dtheta**2]
        turning = np.linalg.solve([[beam, s], [s, weight]], load)
        lift = max(0.0, -50e3 * y)
        return [dtheta, dpsi, vx, vy, *turning, pull.real / m, (pull.imag + lift) / m - G]

    start = [np.arcsin(3.7 / 5), 0, 4.2 - np.sqrt(25 - 3.7**2), 0, 0, 0, 0, 0]
    y = solution(rates, start, found.t)
    assert np.abs(found["beam.phi"] - y[0]).max() < 1e-4
    assert np.abs(found["weight.phi"] - y[1]).max() < 1e-4
    assert np.abs(found["stone.x"] - y[2]).max() < 1e-3
    # the sling is open at the end
    x, h, vx, vy = (found[f"stone.{key}"][-1] for key in ("x", "y", "vx", "vy"))
    reach = x + vx * (vy + np.sqrt(vy**2 + 2 * G * h)) / G
    x, h, vx, vy = y[[2, 3, 6, 7], -1]
    assert reach == pytest.approx(x + vx * (vy + np.sqrt(vy**2 + 2 * G * h)) / G, rel=1e-4)
    assert reach == pytest.approx(206, abs=1)
    opened = np.argmax((y[6] > 0) & (y[7] < y[6]))
    drop = 1.3 * (np.sin(y[0, 0]) - np.sin(y[0, opened])) - 1.4 * (np.cos(y[1, 0]) - np.cos(y[1, opened]))
    kinetic = m * (found["stone.vx"][opened] ** 2 + found["stone.vy"][opened] ** 2) / 2
    assert kinetic / (heavy * G * drop) == pytest.approx(0.73, abs=0.01)


def test_loading_crane(run):
    """A point mass on a rope below an accelerated pivot; 2 a/g is the largest angle of the linear theory."""
    found = run("loading_crane")
    rope, hold = 4.0, 1.0
    T = 2 * np.pi * np.sqrt(rope / G)
    a = 6 / (T * (T + hold))

    def rates(t, y):
        push = a if t < T else 0 if t < T + hold else -a if t < 2 * T + hold else 0
        return [y[1], -(G * np.sin(y[0]) + push * np.cos(y[0])) / rope]

    phi = solution(rates, [0, 0], found.t)[0]
    assert np.abs(found["load.x"] - found["trolley.x"] - rope * np.sin(phi)).max() < 5e-4
    assert found["trolley.x"][-1] == pytest.approx(6, abs=1e-9)
    after = found.t > 2 * T + hold
    assert np.degrees([np.abs(phi).max(), 2 * a / G]) == pytest.approx([3.486, 3.485], abs=1e-3)
    assert np.degrees(np.abs(phi[after]).max()) < 0.003


def test_flyball_governor(run):
    """The height at rest is (m + M) g/(m w^2), without sleeve Huygens' g/w^2; the motion by Lagrange's equation."""
    found = run("flyball_governor")
    arm, m, sleeve = 0.3, 2.0, 1.0

    def speed(t):
        u = np.clip(t - 1 if t < 4 else 6 - t, 0, 1)
        return (75 + 20 * (3 * u**2 - 2 * u**3)) * np.pi / 30

    def height(rpm):
        return (m + sleeve) * G / (m * (rpm * np.pi / 30) ** 2)

    def rates(t, y):
        s, c = np.sin(y[0]), np.cos(y[0])
        inertia = 2 * m + 4 * sleeve * s**2
        load = -2 * (m + sleeve) * G / arm * s + 2 * m * speed(t) ** 2 * s * c
        return [y[1], (load - 4 * sleeve * s * c * y[1] ** 2 - 25 * 4 * s**2 * y[1]) / inertia]

    phi = solution(rates, [np.arccos(height(75) / arm), 0], found.t)[0]
    assert np.abs(-found["ball[1].y"] - arm * np.cos(phi)).max() < 1e-4
    settled = -found["ball[1].y"][np.isin(np.rint(found.t / 0.02), [50, 250])]
    assert settled == pytest.approx([height(75), height(95)], rel=1e-3)  # 3 s are ten times the slowest decay
    assert [height(75), height(95)] == pytest.approx([0.2386, 0.1487], abs=1e-4)


def test_robot_arm(run):
    """Computed torque makes the error of each joint that of a critically damped oscillator."""
    found = run("robot_arm")
    t, p, w = found.t, 4, np.pi
    for joint, demand, error, rate in (
        ("shoulder", 50 + 25 * np.sin(w * t), 40, 25 * w),
        ("elbow", -60 + 35 * np.cos(w * t), -60, 0),
    ):
        expected = np.radians(error + (rate + p * error) * t) * np.exp(-p * t)
        assert np.abs(np.radians(demand) - found[f"{joint}.phi"] - expected).max() < 3e-5


def test_swing(run):
    """The angular momentum by SciPy; the growth of small angles, exp(3/4 e w t), by perturbation."""
    found = run("swing")
    m, inertia, ropes = 35, 3, 0.1
    w = np.sqrt(m * G * 2.5 / (m * 2.5**2 + inertia))

    def rates(t, y):
        s = 2.5 + 0.15 * np.sin(2 * w * t)
        spin = y[1] / (m * s**2 + inertia + ropes * 3**2 / 3)
        return [spin, -G * (m * s + ropes * 1.5) * np.sin(y[0])]

    phi = solution(rates, [np.radians(10), 0], found.t)[0]
    assert np.abs(found["ropes.phi"] + np.pi / 2 - phi).max() < 1e-4
    period = 2 * np.pi / w
    first, last = (np.abs(phi[(found.t >= k * period) & (found.t < (k + 1) * period)]).max() for k in (0, 5))
    # 30 deg are not small: the period is 2 % longer there, and the phase of the child's motion is no longer the best
    assert np.log(last / first) / (5 * period) == pytest.approx(0.75 * 0.06 * w, rel=0.1)
    assert np.degrees(np.abs(phi).max()) == pytest.approx(52.7, abs=0.1)


def test_pump_jack(run):
    """The beam by two triangles of the four-bar linkage, the rods as a linear oscillator that the beam excites."""
    found = run("pump_jack")
    radius, tail, crank, pitman, apart = 3.05, 2.44, 0.9, 3, 2.44 - 3j  # the last: from saddle to shaft
    w = 12 * np.pi / 30

    def beam(t):
        pin = apart + crank * np.exp(1j * w * t)
        distance = np.abs(pin)
        return np.angle(pin) + np.arccos((distance**2 + tail**2 - pitman**2) / (2 * distance * tail))

    assert np.abs(found["beam.phi"] - beam(found.t)).max() < 1e-9  # the driver alone moves it
    sides = pitman - crank, pitman + crank
    ends = [np.arccos((abs(apart) ** 2 + tail**2 - x**2) / (2 * abs(apart) * tail)) for x in sides]
    stroke = radius * (ends[1] - ends[0])
    assert np.ptp(radius * found["beam.phi"]) == pytest.approx(stroke, rel=1e-3)

    def rates(t, y):
        return [y[1], (100e3 * (2.4 - radius * beam(t) - y[0]) - 5e3 * y[1]) / 2000]

    y = solution(rates, [2.4, 0], found.t)[0]
    assert np.abs(found["rods.y"] - y).max() < 3e-4  # the tolerance is 1e-4 of a machine of 3 m
    assert [stroke, np.ptp(y)] == pytest.approx([2.309, 2.353], abs=1e-3)


def limb_of_bow(fx, fy):
    """The elastica of a limb under a force at its tip, by shooting: x, y, angle, curvature and energy at the tip."""
    bending = 35e9 * 0.04 * 0.011**3 / 12

    def shot(curvature):
        def rates(_, y):
            return [np.cos(y[2]), np.sin(y[2]), y[3], (fx * np.sin(y[2]) - fy * np.cos(y[2])) / bending, y[3] ** 2]

        start = [0, 0.1, np.radians(105), curvature, 0]
        return solve_ivp(rates, (0, 0.7), start, "DOP853", rtol=1e-9, atol=1e-9).y[:, -1]

    tip = shot(brentq(lambda curvature: shot(curvature)[3], 0, 5, xtol=1e-10))
    return tip[0] + 1j * tip[1], bending * tip[4] / 2


def test_bow(run):
    """Full draw by the elastica; the energy stored in the limbs and the string becomes that of the motion."""
    found = run("bow")
    k, length = 40e3, 0.78

    def away(u):
        pull = u[0] * np.exp(1j * u[1])
        string = limb_of_bow(-pull.real, -pull.imag)[0] + 0.6
        return (np.abs(string) - length) * k - u[0], 100 * (np.angle(string) - u[1])

    tension, angle = fsolve(away, [230, 1.18])
    tip, bent = limb_of_bow(-tension * np.cos(angle), -tension * np.sin(angle))
    assert found["string[1].force"][0] == pytest.approx(tension, rel=1e-3)  # four cubic elements
    assert abs(found["limb[1].b.x"][0] + 1j * found["limb[1].b.y"][0] - tip) < 1e-4
    assert 2 * tension * np.cos(angle) == pytest.approx(176.5, abs=0.1)
    stored = 2 * bent + tension**2 / k
    total = found["energy.total"]  # with the strings, whose laws have a potential
    assert total[0] == pytest.approx(stored, rel=1e-3)
    assert 0.99 * stored < total[-1] < stored  # the limbs lose little
    arrow = 0.025 * found["arrow.vx"][-1] ** 2 / 2
    assert [stored, arrow / stored] == pytest.approx([25.07, 0.54], rel=0.01)


def test_slingshot(run):
    """The cantilever by Euler and Bernoulli, with the next term of the elastica; later the stored energy moves."""
    found = run("slingshot")
    length, bending, band = 0.3, 35e9 * 0.03 * 0.006**3 / 12, 400
    pull = found["band.force"][0]
    assert pull == pytest.approx(67.3, abs=0.05)
    shortened = (pull * length**2 / bending) ** 2
    small = pull * length**3 / (3 * bending)
    assert small == pytest.approx(32.06e-3, abs=1e-5)
    # the elastica by series; its next term is of the order of (P L^2/EI)^4 = 1e-2 times a coefficient below 0.05
    assert -found["fork.b.x"][0] == pytest.approx(small * (1 - 4 / 35 * shortened), rel=1e-3)
    stored = pull**2 / (2 * band) + pull * small / 2 * (1 - 6 / 35 * shortened)
    total = found["energy.total"]  # with the band, whose law has a potential
    assert total[0] == pytest.approx(stored, rel=1e-3)
    assert 0.998 * stored < total[-1] < stored  # the fork loses little
    stone = 0.03 * found["stone.vx"][-1] ** 2 / 2
    assert [stored, stone / stored] == pytest.approx([6.73, 0.8555], rel=2e-3)


def test_clock_escapement():
    """The amplitude by the balance of push and damping from a smaller one, the period by the elliptic integral."""
    path = Path(__file__).parents[2] / "models" / "gallery" / "clock_escapement.mbd"
    found = mbdsl.simulate(mbdsl.load(path, {"A": "7 deg"}), stop=12, interval=2e-3)
    inertia, weight, damping, torque = 1e-5 + 0.5 * 0.18**2, 0.5 * G * 0.18, 1.2e-3, 4e-3
    t, phi, w = found.t, found["pendulum.phi"], found["pendulum.w"]
    row = np.flatnonzero((w[:-1] > 0) & (w[1:] <= 0))  # before each turn to the right
    energy = inertia * w[row] ** 2 / 2 + weight * (1 - np.cos(phi[row]))
    amplitude, turned = np.arccos(1 - energy / weight), t[row] + w[row] / (w[row] - w[row + 1]) * 2e-3
    slow = np.sqrt(weight / inertia)
    settled = np.sqrt(2 * torque * np.radians(5) / (np.pi * damping * slow))
    decay = np.exp(-damping / inertia * turned)
    expected = np.sqrt(settled**2 + (np.radians(7) ** 2 - settled**2) * decay)
    # a pendulum's period, and what it loses, differ from those of an oscillator by the order of A^2/16 = 1.6e-3
    assert amplitude == pytest.approx(expected, rel=2e-3)
    assert np.degrees([settled, amplitude[-1]]) == pytest.approx([9.08, 8.28], abs=0.01)
    row = np.flatnonzero((phi[:-1] < 0) & (phi[1:] >= 0))
    period = np.diff(t[row] - phi[row] / w[row])
    middle = (amplitude[:-1] + amplitude[1:]) / 2  # the elliptic integral with the parameter sin(A/2)^2
    exact = 4 / slow * ellipk(np.sin(middle[: len(period)] / 2) ** 2)
    assert [4 / slow * ellipk(np.sin(settled / 2) ** 2), 2 * np.pi / slow] == pytest.approx([0.8527, 0.8514], abs=5e-5)
    # damping and pushes are symmetrical about the vertical; their second order is below (c/(I w))^2/8 = 1.3e-5
    assert period == pytest.approx(exact, rel=3e-5)
    # one tooth each period, and a tooth is at rest on a pallet at the end
    assert np.degrees(np.interp(turned, t, found["wheel.phi"])) == pytest.approx(
        12 * np.arange(1, len(turned) + 1), abs=0.05
    )
