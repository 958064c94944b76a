"""Models in space against closed forms, textbook formulas, and loops closed by SciPy, in plain numpy."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import mbdsl

FOLDER = Path(__file__).parents[2] / "models" / "space"
NAMES = sorted(path.stem for path in FOLDER.glob("*.mbd"))
G = 9.81
#: positions of driven mechanisms: Newton's iteration ends where corrections are below 1e-9 of the size, and converges
#: at least linearly with a factor of 1e-2
CLOSED = 1e-11


@pytest.fixture(scope="module")
def run():
    return lambda name, **given: mbdsl.simulate(FOLDER / f"{name}.mbd", **given)


def point(found, name):
    return np.stack([found[f"{name}.{key}"] for key in "xyz"], axis=-1)


def turns(axis, angle):
    """Rotations about a fixed axis."""
    return Rotation.from_rotvec(np.multiply.outer(angle, np.array(axis, float)))


def attitude(found, body):
    return Rotation.from_quat(np.stack([found[f"{body}.p{k}"] for k in (1, 2, 3, 0)], axis=-1))


def solution(rates, start, t):
    """States at times t by an explicit method of order 8, to 1e-11."""
    found = solve_ivp(rates, (t[0], t[-1]), start, "DOP853", t_eval=t, rtol=1e-11, atol=1e-11)
    assert found.success
    return found.y


def power_is_rate_of_energy(found, driver, w):
    """The work of a driver, by the trapezoidal rule, is the change of the energy.

    The rule has an error of h^2/12 times the change of the power's rate; 30 times less is left by extrapolation.
    """
    power = sum(found[f"{driver}.t{i}"] * w[i] for i in "xyz")
    h = found.t[1]
    fine = h * (power[1:] + power[:-1]) / 2
    coarse = h * (power[2::2] + power[:-2:2])
    work = (4 * fine.reshape(-1, 2).sum(axis=1) - coarse) / 3
    energy = found["energy.total"] - found["energy.total"][0]
    assert np.ptp(energy) > 0.1 * np.abs(energy).max() > 0
    assert np.abs(np.cumsum(work) - energy[2::2]).max() < 1e-4 * np.ptp(energy)


@pytest.mark.parametrize("name", NAMES)
def test_model_has_a_title_and_a_source(name):
    scene = mbdsl.load(FOLDER / f"{name}.mbd")
    text = (FOLDER / f"{name}.mbd").read_text(encoding="utf-8")
    assert scene.spatial and scene.doc and scene.experiment.stop and len(text.splitlines()) <= 60
    assert text.startswith("// ") and max(map(len, text.splitlines())) <= 132


# -- free and forced motions ------------------------------------------------------------------------------


def test_gyroscope(run):
    """The steady precession of a horizontal axle: moment of the weight over moment of momentum about the axle."""
    found = run("gyroscope", stop=2.0, interval=0.02)
    m, M, r, l, spin = 2.0, 0.3, 0.1, 0.25, 100 * np.pi
    rate = G * (m * l + M * l / 2) / (m * r**2 / 2 * spin)
    assert rate == pytest.approx(1.678, abs=1e-3)
    expected = np.stack([l * np.cos(rate * found.t), l * np.sin(rate * found.t), 0.5 + 0 * found.t], axis=-1)
    # an error of (h spin)^2/12 = 3e-4 in the rate of the wheel's axes makes the arm nod by that part of 3.4 rad
    assert np.abs(point(found, "wheel") - expected).max() < 3e-4 * 3.4 * l
    assert found["axle.w"] == pytest.approx(spin, rel=1e-6)


def test_dzhanibekov(run):
    """Euler's equations by Jacobi's elliptic functions (L. D. Landau, E. M. Lifshitz, Mechanics, section 37)."""
    low, middle, high = 1.2, 2.0, 3.0  # moments of inertia; only their ratios matter
    start = np.array([0.02, 10.0, 0.0])
    energy = high * start[0] ** 2 + middle * start[1] ** 2
    square = (high * start[0]) ** 2 + (middle * start[1]) ** 2
    fast, slow = energy * high - square, square - energy * low
    rate = np.sqrt((high - middle) * slow / (low * middle * high))
    k2 = (middle - low) * fast / ((high - middle) * slow)
    period = 4 * ellipk(k2) / rate
    found = run("dzhanibekov", tol=1e-7, stop=1.5 * period, interval=period / 40)
    # at the start the angular velocity about the middle axis is largest
    sn, cn, dn, _ = ellipj(rate * found.t + ellipk(k2), k2)
    expected = np.stack(
        [
            np.sqrt(slow / (high * (high - low))) * dn,
            np.sqrt(fast / (middle * (high - middle))) * sn,
            -np.sqrt(fast / (low * (high - low))) * cn,
        ],
        axis=-1,
    )
    assert np.abs(found.v[:, 3:] - expected).max() < 1e-3 * 10  # the start is near the unstable rotation: errors grow
    # it flips every half of a period, while its moment of momentum stays
    for k in range(4):
        assert found.v[20 * k, 4] == pytest.approx(10.0 * (-1) ** k, rel=1e-3)
        assert found["nut.head.y"][20 * k] == pytest.approx(0.04 * (-1) ** k, rel=1e-2)
    inertia = 1e-5 * np.array([high, middle, low])
    momentum = attitude(found, "nut").apply(inertia * found.v[:, 3:])
    assert np.abs(momentum - momentum[0]).max() < 1e-6 * np.abs(momentum[0]).max()


def test_flyball_governor(run):
    """The height at rest is (m + M) g/(m w^2), without sleeve Huygens' g/w^2; the motion by Lagrange's equation."""
    found = run("flyball_governor")
    arm, m, sleeve, slow, fast, lag = 0.3, 2.0, 1.0, 2.5 * np.pi, 95 * np.pi / 30, 0.5
    ball = 0.4 * m * 0.04**2

    def height(w):
        return (m + sleeve) * G / (m * w**2)

    def rates(t, y):
        s, c = np.sin(y[0]), np.cos(y[0])
        speed = fast - (fast - slow) * np.exp(-t / lag)
        inertia = 2 * m + 2 * ball / arm**2 + 4 * sleeve * s**2
        load = -2 * (m + sleeve) * G / arm * s + 2 * m * speed**2 * s * c
        return [y[1], (load - 4 * sleeve * s * c * y[1] ** 2 - 25 * 4 * s**2 * y[1]) / inertia]

    phi = solution(rates, [np.arccos(height(slow) / arm), 0], found.t)[0]
    # 10 times the tolerance of 1e-5: the mechanism of 0.6 m, and its damped motion
    assert np.abs(-found["ball[1].z"] - arm * np.cos(phi)).max() < 1e-4
    assert np.abs(found["slide.s"] + 2 * arm * np.cos(phi)).max() < 2e-4
    assert -found["ball[2].z"][[0, -1]] == pytest.approx([height(slow), height(fast)], rel=1e-4)
    assert [height(slow), height(fast)] == pytest.approx([0.2386, 0.1487], abs=1e-4)


def test_trebuchet(run):
    """Lagrange's equations of beam and counterweight with the rope in space, and the balance of energy."""
    found = run("trebuchet")
    k, sling, m, heavy, span = 50e3, 4.2, 30, 2000, 1.3 * 1.4
    beam = 150 * 6.3**2 / 12 + 150 * 1.85**2 + heavy * 1.3**2
    weight = heavy * 0.8**2 / 6 + heavy * 1.4**2

    def tension(theta, stone, v):
        rope = np.array([-5 * np.cos(theta), 4 - 5 * np.sin(theta), 0]) - stone
        length = np.linalg.norm(rope)
        opened = v[0] > 1 and v[1] < v[0]
        return (0.0 if opened else max(0.0, k * (length - sling))) * rope / length

    def rates(_, state):
        theta, psi, dtheta, dpsi, *rest = state
        stone, v = np.array(rest[:3]), np.array(rest[3:])
        pull = tension(theta, stone, v)  # on the stone
        s, c = heavy * span * np.sin(psi - theta), heavy * span * np.cos(psi - theta)
        tip = 5 * np.array([np.sin(theta), -np.cos(theta)])  # of its rate
        torque = (150 * 1.85 - heavy * 1.3) * G * np.cos(theta) - tip @ pull[:2]
        load = [torque - c * dpsi**2, -heavy * G * 1.4 * np.sin(psi) + c * dtheta**2]
        a = pull / m + [0, max(0.0, -50e3 * stone[1]) / m - G, 0]
        return [dtheta, dpsi, *np.linalg.solve([[beam, s], [s, weight]], load), *v, *a]

    x = np.sqrt(4.2**2 - 0.3**2 - 0.4**2) - np.sqrt(25 - 3.7**2)
    y = solution(rates, [np.arcsin(3.7 / 5), 0, 0, 0, x, 0, 0.4, 0, 0, 0], found.t)
    assert np.abs(found["axle.phi"] - y[0]).max() < 1e-4
    assert np.abs(point(found, "stone") - y[4:7].T).max() < 1e-3
    # kinetic energy and weight, and what ropes and trough store; the sling is without force when it opens
    stretched = [np.linalg.norm(tension(*row)) ** 2 / (2 * k) for row in zip(y[0], y[4:7].T, y[7:].T, strict=True)]
    stored = stretched + 25e3 * np.minimum(found["stone.y"], 0) ** 2
    total = found["energy.total"] + stored
    opened = np.argmax((y[7] > 1) & (y[8] < y[7]))
    drop = np.ptp(found["energy.total"][:opened])
    assert np.abs(total[:opened] - total[0]).max() < 1e-2 * max(drop, stretched[opened - 1])
    # it misses its line by metres: with the speed sideways until it lands
    x, h, z, vx, vy, vz = (found[f"stone.{key}"][-1] for key in ("x", "y", "z", "vx", "vy", "vz"))
    flight = (vy + np.sqrt(vy**2 + 2 * G * h)) / G
    expected = y[4:, -1]
    time = (expected[4] + np.sqrt(expected[4] ** 2 + 2 * G * expected[1])) / G
    assert [x + vx * flight, z + vz * flight] == pytest.approx(
        [expected[0] + expected[3] * time, expected[2] + expected[5] * time], rel=1e-3
    )


def test_windmill(run):
    """Lagrange's equation of the only freedom, with the angle of Hooke's joint and the triangle of the crank."""
    found = run("windmill", stop=6.0)
    c, r, L, sails, shaft, m = np.cos(np.radians(20)), 0.15, 0.9, 60.0, 0.1, 10.0

    def crank(psi):
        """The angle of the crank shaft, and its derivatives with respect to that of the sails."""
        D = np.cos(psi) ** 2 + c**2 * np.sin(psi) ** 2
        return np.arctan2(c * np.sin(psi), np.cos(psi)), c / D, c * (1 - c**2) * np.sin(2 * psi) / D**2

    def plunger(theta):
        """Its height, and derivatives."""
        sin, cos = np.sin(theta), np.cos(theta)
        s = np.sqrt(L**2 - r**2 * cos**2)
        second = -r * sin - r**2 * np.cos(2 * theta) / s + (r**2 * cos * sin) ** 2 / s**3
        return r * sin - s, r * cos - r**2 * cos * sin / s, second

    def rates(_, y):
        theta, first, second = crank(y[0])
        _, dz, ddz = plunger(theta)
        z1, z2 = dz * first, ddz * first**2 + dz * second
        mass = sails + shaft * first**2 + m * z1**2
        water = 120 * (1 + np.tanh(z1 * y[1] / 0.05)) / 2
        load = 60 * (1 - y[1] / (2 * np.pi)) - (water + m * G) * z1
        return [y[1], (load - (shaft * first * second + m * z1 * z2) * y[1] ** 2) / mass]

    psi, w = solution(rates, [0, 0], found.t)
    assert found["wind_shaft.phi"] == pytest.approx(psi, abs=1e-4)  # h = 2 ms, of motions that last 0.3 s
    assert found["wind_shaft.w"] == pytest.approx(w, abs=3e-4)
    assert found["plunger.z"] == pytest.approx(plunger(crank(found["wind_shaft.phi"])[0])[0], abs=CLOSED)


# -- driven mechanisms ------------------------------------------------------------------------------------


def test_cardan_shaft(run):
    """tan(phi) = tan(psi)/cos(beta); the speeds have the ratio cos(beta)/(1 - sin(beta)^2 cos(psi)^2)."""
    found = run("cardan_shaft", stop=1.0)
    beta, psi = np.radians(30), 2 * np.pi * found.t
    along = np.array([np.cos(beta), np.sin(beta), 0])
    across = np.array([-np.sin(beta), np.cos(beta), 0])
    fork = (point(found, "middle.fork") - point(found, "middle.a")) / 0.06
    assert np.abs(fork @ along).max() < CLOSED / 0.06
    phi = np.arctan2(-fork @ across, fork[:, 2])
    away = phi - np.arctan2(np.sin(psi), np.cos(psi) * np.cos(beta))
    assert np.abs(np.sin(away)).max() < CLOSED / 0.06 and np.cos(away).min() > 0
    w = np.stack([found[f"middle.w{i}"] for i in "xyz"], axis=-1)
    ratio = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(psi) ** 2)
    assert w @ along / (2 * np.pi) == pytest.approx(ratio, abs=1e-9)
    assert [ratio.min(), ratio.max()] == pytest.approx([np.cos(beta), 1 / np.cos(beta)], rel=1e-12)
    # the second joint undoes what the first one does
    out = point(found, "driven.fork") - point(found, "driven.a")
    assert out == pytest.approx(0.06 * np.stack([0 * psi, np.cos(psi), np.sin(psi)], axis=-1), abs=CLOSED)
    assert found["driven.wx"] == pytest.approx(2 * np.pi, abs=1e-9)


def test_oldham_coupling(run):
    """Thales' circle over the two shafts: the disc's centre runs around it at twice the angular speed."""
    found = run("oldham_coupling", stop=1.0)
    e, psi = 0.02, 2 * np.pi * found.t
    assert found["rear.phi"] == pytest.approx(psi, abs=CLOSED / 0.04)
    assert found["rear.w"] == pytest.approx(2 * np.pi, abs=1e-9)
    assert found["disc.y"] == pytest.approx(e / 2 * np.sin(2 * psi), abs=CLOSED)
    assert found["disc.z"] == pytest.approx(e / 2 * (1 - np.cos(2 * psi)), abs=CLOSED)
    assert np.hypot(found["disc.vy"], found["disc.vz"]) == pytest.approx(2 * np.pi * e, abs=1e-9)


def test_rzeppa_coupling(run):
    """At any bend, also while it changes, the axle is turned by the angle of the shaft about its own axis."""
    found = run("rzeppa_coupling")
    psi, beta = 4 * np.pi * found.t, np.radians(40) * np.sin(np.pi * found.t)
    expected = turns([0, 0, 1], beta) * turns([1, 0, 0], psi)
    assert (expected.inv() * attitude(found, "axle")).magnitude().max() < 1e-9
    assert point(found, "axle.rim") == pytest.approx(expected.apply([0.2, 0, 0.3]), abs=CLOSED)
    spin = np.stack([found[f"axle.w{i}"] for i in "xyz"], axis=-1)
    ratio = (spin * expected.apply([1, 0, 0])).sum(axis=1) / (4 * np.pi)
    assert ratio == pytest.approx(1.0, abs=1e-9)


def test_rssr(run):
    """The equation between crank and rocker: A cos(phi) + B sin(phi) = C, from the length of the rod."""
    found = run("rssr", stop=1.0)
    theta = 2 * np.pi * found.t
    pin = 0.06 * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1)
    d = np.array([0.3, 0.1, 0.05]) - pin
    c = (0.4**2 - (d**2).sum(axis=1) - 0.25**2) / (2 * 0.25 * np.hypot(d[:, 1], d[:, 2]))
    expected = np.arctan2(d[:, 2], d[:, 1]) + np.arccos(c)
    assert found["D.phi"] == pytest.approx(expected, abs=CLOSED / 0.1)
    assert np.ptp(expected) > 1.5  # it swings by a right angle


def test_stewart_platform(run):
    """The pose is the commanded one."""
    found = run("stewart_platform", interval=0.05)
    t = np.pi * found.t
    expected = np.stack([0.15 * np.sin(t), 0.1 * np.sin(2 * t), 1.1 + 0.1 * np.sin(t)], axis=-1)
    assert point(found, "platform") == pytest.approx(expected, abs=CLOSED)
    yaw, roll = np.radians(15) * np.sin(t), np.radians(10) * np.sin(2 * t)
    commanded = turns([0, 0, 1], yaw) * turns([1, 0, 0], roll)
    assert (commanded.inv() * attitude(found, "platform")).magnitude().max() < 1e-9
    # the six legs carry the platform: the sum of their forces is its weight and its acceleration
    force = sum(point_of_force(found, f"leg[{i}]") for i in range(1, 7))
    a = np.stack([-0.15 * np.sin(t), -0.4 * np.sin(2 * t), -0.1 * np.sin(t)], axis=-1) * np.pi**2
    assert force == pytest.approx(100 * (a + [0, 0, G]), abs=0.02)  # of 981 N: h = 2 ms, 6 rad/s


def point_of_force(found, joint):
    return np.stack([found[f"{joint}.f{i}"] for i in "xyz"], axis=-1)


def test_delta_robot(run):
    """The platform moves as commanded, and does not turn; the arms are on the circles of their inverse kinematics."""
    found = run("delta_robot", stop=1.0)
    t = 2 * np.pi * found.t
    expected = np.stack([0.12 * np.cos(t), 0.12 * np.sin(t), -0.5 + 0.05 * np.cos(2 * t)], axis=-1)
    assert point(found, "platform") == pytest.approx(expected, abs=CLOSED)
    assert attitude(found, "platform").magnitude().max() < 1e-9
    for i in range(3):
        # a triangle of the arm, the middle of its rods, and the distance from the motor to the platform's edge
        side = turns([0, 0, 1], 2 * np.pi / 3 * i)
        elbow = side.inv().apply(point(found, f"arm[{i + 1}].b")) - [0.18, 0, 0]
        wrist = side.inv().apply(expected) - [0.12, 0, 0]
        assert np.linalg.norm(elbow, axis=1) == pytest.approx(0.3, abs=CLOSED)
        assert np.linalg.norm(wrist - elbow, axis=1) == pytest.approx(0.6, abs=CLOSED)
        # the elbows stay outside: of both angles, the one with the arm farther out
        assert (elbow[:, 0] > (wrist[:, 0] * elbow[:, 2] / wrist[:, 2])).all()


def test_robot_arm(run):
    """Position and attitude of the tool: the product of six rotations."""
    found = run("robot_arm")
    w = np.pi * found.t
    one = turns([0, 0, 1], np.radians(80) * np.sin(w))
    two = one * turns([0, 1, 0], np.radians(20 - 30 * np.cos(2 * w)))
    three = two * turns([0, 1, 0], np.radians(15 + 25 * np.sin(2 * w)))
    four = three * turns([1, 0, 0], np.radians(60) * np.sin(w))
    five = four * turns([0, 1, 0], np.radians(30 + 40 * np.cos(w)))
    six = five * turns([1, 0, 0], w)
    wrist = one.apply([0.15, 0, 0.4]) + two.apply([0, 0, 0.6]) + three.apply([0.35, 0, 0.1]) + four.apply([0.3, 0, 0])
    assert point(found, "hand.tool") == pytest.approx(wrist + six.apply([0.2, 0, 0]), abs=CLOSED)
    assert point(found, "hand.thumb") == pytest.approx(wrist + six.apply([0.2, 0.1, 0]), abs=CLOSED)
    # the first motor turns everything about the vertical: its torque is the rate of the moment of momentum
    assert np.abs(found["M1.tz"]).max() > 50


def test_swash_plate(run):
    """The stroke is 2 R tan(alpha), and every piston moves as the sine of the shaft's angle."""
    found = run("swash_plate", stop=1.0)
    R, alpha, theta = 0.05, np.radians(18), 2 * np.pi * found.t
    for i in range(1, 6):
        height = found[f"piston[{i}].z"] - 0.06
        assert height == pytest.approx(-R * np.tan(alpha) * np.cos(theta - 2 * np.pi * i / 5), abs=CLOSED)
    assert np.ptp(found["guide[5].s"]) == pytest.approx(2 * R * np.tan(alpha), abs=CLOSED)
    assert 2 * R * np.tan(alpha) == pytest.approx(32.5e-3, abs=1e-4)


def test_double_wishbone(run):
    """The loop through both arms, upright and tie rod, closed by SciPy."""
    found = run("double_wishbone", interval=0.1)
    lower, upper = np.array([1, 0.05, 0.02]), np.array([1, -0.08, 0.1])
    lower, upper = lower / np.linalg.norm(lower), upper / np.linalg.norm(upper)

    def away(u, height):
        R = Rotation.from_rotvec(u[2:5])
        low = [0, 0.36, 0.2] + Rotation.from_rotvec(u[0] * lower).apply([0, 0.32, -0.02])
        high = [-0.02, 0.43, 0.47] + Rotation.from_rotvec(u[1] * upper).apply([0, 0.225, 0.02])
        hub = u[5:]
        rod = hub + R.apply([-0.12, -0.08, -0.05]) - [-0.12, 0.38, 0.26]
        return np.concatenate(
            [
                hub + R.apply([0.01, -0.07, -0.12]) - low,
                hub + R.apply([-0.02, -0.095, 0.19]) - high,
                [rod @ rod - 0.29**2, hub[2] - height],
            ]
        )

    u = np.array([0, 0, 0, 0, 0, 0, 0.75, 0.3])
    steered = []
    for k, t in enumerate(found.t):
        u, _, solved, message = fsolve(away, u, (0.3 + 0.08 * np.sin(np.pi * t),), xtol=1e-13, full_output=True)
        assert solved == 1, message
        assert point(found, "upright")[k] == pytest.approx(u[5:], abs=1e-10)
        own = Rotation.from_rotvec(u[2:5])
        assert (own.inv() * attitude(found, "upright")[k]).magnitude() < 1e-9
        x = own.apply([1, 0, 0])
        steered.append(np.degrees(np.arctan2(x[1], x[0])))
    assert np.ptp(steered) > 0.1  # bump steer


def test_geneva_drive(run):
    """The pin is in the plane of a slot while it is above the shaft's plane; else the wheel rests."""
    found = run("geneva_drive")
    turn = np.pi * found.t - np.pi / 2
    pin = point(found, "crank.pin")
    half, radius = np.pi / 4, 0.1
    expected = radius * np.stack(
        [np.cos(half) + 0 * turn, np.sin(half) * np.cos(turn), np.sin(half) * np.sin(turn)], axis=-1
    )
    assert pin == pytest.approx(expected, abs=CLOSED)
    engaged = pin[:, 2] > 1e-9
    # across the plane of the nearest of four slots, which are at odd multiples of 45 deg on the wheel
    azimuth = np.arctan2(pin[:, 1], pin[:, 0]) - found["shaft.phi"]
    off = np.remainder(azimuth - half, 2 * half)
    assert np.minimum(off, 2 * half - off)[engaged].max() < CLOSED / radius
    steps = found["shaft.phi"][~engaged] / (2 * half)
    assert np.abs(steps - np.rint(steps)).max() < 1e-10
    assert found["shaft.phi"][-1] == pytest.approx(-4 * 2 * half, abs=1e-10)
    # fastest in the middle of a step, with tan(half) times the speed of the crank
    assert np.abs(found["shaft.w"]).max() == pytest.approx(np.pi * np.tan(half), rel=1e-9)


def test_haug_slider_crank(run):
    """The slider from the length of the rod."""
    found = run("haug_slider_crank", stop=2.0)
    psi = np.pi / 2 - 2 * np.pi * found.t
    y, z = 0.1 + 0.08 * np.cos(psi), 0.12 + 0.08 * np.sin(psi)
    x = np.sqrt(0.09 - y**2 - z**2)
    assert found["slider.x"] == pytest.approx(x, abs=1e-12)
    rate = -0.16 * np.pi * (z * np.cos(psi) - y * np.sin(psi)) / -x  # of psi is -2 pi
    assert found["slider.vx"] == pytest.approx(rate, abs=1e-9)
    assert point(found, "rod.a") == pytest.approx(np.stack([0 * x, y, z], axis=-1), abs=1e-12)
    # the rod does not spin about itself: its y axis stays at right angles to the slider's
    assert np.abs(attitude(found, "rod").apply([0, 1, 0])[:, 0]).max() < 1e-10
    power_is_rate_of_energy(
        run("haug_slider_crank", stop=1.0, interval=2e-3), "motor", {"x": -2 * np.pi, "y": 0, "z": 0}
    )


def test_haug_four_link(run):
    """The loop closed by SciPy, from the published start on; the work of the motor is the change of the energy."""
    found = run("haug_four_link", stop=2.0, interval=0.05)
    assert point(found, "link")[0] == pytest.approx([-3.74555772, -4.25, 4.26236544], abs=1e-8)
    assert point(found, "rocker")[0] == pytest.approx([-5.74555772, -8.5, 3.26236544], abs=1e-8)
    cross = np.array([0.75, -0.662, 0])

    def away(u, psi):
        rotor, link = Rotation.from_rotvec([psi, 0, 0]), Rotation.from_rotvec(u[:3])
        end = rotor.apply([0, 0, 2]) - link.apply([0, 12.2, 0])
        ball = [-4 - 7.4 * np.cos(u[3]), -8.5, 7.4 * np.sin(u[3])]
        return np.append(end - ball, rotor.apply(cross) @ link.apply([0, 0, 1]))

    u = np.append(attitude(found, "link")[0].as_rotvec(), np.arctan2(3.26236544, 1.74555772))
    for k, t in enumerate(found.t):
        u, _, solved, message = fsolve(away, u, (np.pi * t,), xtol=1e-13, full_output=True)
        assert solved == 1, message
        link = Rotation.from_rotvec(u[:3])
        assert (link.inv() * attitude(found, "link")[k]).magnitude() < 1e-9
        assert point(found, "rocker")[k] == pytest.approx([-4 - 3.7 * np.cos(u[3]), -8.5, 3.7 * np.sin(u[3])], abs=1e-9)
    power_is_rate_of_energy(run("haug_four_link", stop=2.0, interval=5e-3), "motor", {"x": np.pi, "y": 0, "z": 0})
