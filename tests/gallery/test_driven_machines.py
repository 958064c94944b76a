"""Driven machines against constructions with circles and textbook formulas, in plain numpy, over 1,000 cycles."""

import numpy as np
import pytest

import mbdsl

#: rounding of the angle of the 1,000th revolution is 5e-13 rad; lengths are up to 6 m
EXACT = 5e-12


def circles(a, ra, b, rb, side):
    """The intersection of circles about a and b, left (1) or right (-1) of the line from a to b."""
    d = b - a
    apart = np.abs(d)
    along = (apart**2 + ra**2 - rb**2) / (2 * apart)
    return a + d / apart * (along + 1j * side * np.sqrt(ra**2 - along**2))


def point(run, name):
    return run[f"{name}.x"] + 1j * run[f"{name}.y"]


def turn(phi):
    return np.exp(1j * phi)


def assert_same(found, expected, tolerance=EXACT):
    assert np.abs(found - expected).max() < tolerance


def test_ackermann_steering(turned):
    """The trapezium by circles; its deviation from Ackermann's rule, cot(outer) - cot(inner) = track/wheelbase."""
    run = turned("ackermann_steering")
    track, wheelbase, arm = 1.4, 2.6, 0.2
    corner = arm * np.exp(-1j * (np.pi / 2 - np.arctan(track / 2 / wheelbase)))
    steering = np.radians(35) * np.sin(np.pi / 2 * run.t)
    ball_left = -track / 2 + corner * turn(steering)
    ball_right = circles(ball_left, track - 2 * corner.real, track / 2 + 0j, arm, -1)
    assert_same(point(run, "tie_rod.b"), ball_right)
    right = np.angle((ball_right - track / 2) / -corner.conjugate())
    assert_same(run["right.phi"], right)
    lock = np.argmax(steering)
    ideal = np.arctan(1 / (1 / np.tan(steering[lock]) + track / wheelbase))
    # to the left the right wheel is the outer one; without a trapezium it would turn by 35 deg as well
    assert np.degrees([right[lock], ideal]) == pytest.approx([28.87, 26.95], abs=0.01)


def test_double_wishbone(turned):
    run = turned("double_wishbone")
    lower, upper = 0.36 + 0.2j, 0.43 + 0.47j
    C = lower + abs(0.32 + 0.02j) * turn(run["lower_arm.phi"])
    low, high = -0.07 - 0.12j, -0.095 + 0.21j
    D = circles(C, abs(high - low), upper, abs(0.225 + 0.04j), -1)
    axis = (D - C) / (high - low)
    assert_same(point(run, "upright"), C - low * axis)
    assert_same(run["camber"], -np.angle(axis))
    travel = 0.08 * np.sin(np.pi * run.t)
    assert_same((C - low * axis).imag, 0.3 + travel)
    ends = [np.argmax(travel), np.argmin(travel)]
    assert np.degrees(run["camber"][ends]) == pytest.approx([-3.87, 2.60], abs=0.01)


def test_mcpherson_strut(turned):
    """The axis of the strut passes through the mount at a fixed distance from the ball joint, which gives a sine."""
    run = turned("mcpherson_strut")
    ball, strut, mount = -0.07 - 0.13j, -0.12 + 0.1j, 0.56 + 0.85j
    axis = (-0.07 + 0.45j) / abs(-0.07 + 0.45j)
    offset = (axis.conjugate() * (ball - strut)).imag
    P = 0.36 + 0.19j + abs(0.32 + 0.02j) * turn(run["arm.phi"])
    psi = np.angle(P - mount) - (np.pi - np.arcsin(offset / np.abs(P - mount)))
    rotation = turn(psi) / axis
    assert_same(point(run, "upright"), P - ball * rotation)
    travel = 0.08 * np.sin(np.pi * run.t)
    assert_same((P - ball * rotation).imag, 0.3 + travel)
    ends = [np.argmax(travel), np.argmin(travel)]
    assert np.degrees(-run["upright.phi"][ends]) == pytest.approx([-0.69, 1.97], abs=0.01)


def test_windscreen_wiper(turned):
    """Pins by circles; the sweep from the two triangles in which crank and link are in line."""
    run = turned("windscreen_wiper")
    motor = 0.3 - 0.12j
    A = motor + 0.045 * turn(np.pi * run.t)
    B = circles(A, 0.317, 0j, 0.06, 1)
    assert_same(point(run, "wiper[1].lever"), B)
    assert_same(point(run, "wiper[1].tip"), -B / 0.06 * 0.5)
    assert_same(point(run, "wiper[2].tip"), 0.55 - B / 0.06 * 0.5)
    apart = abs(motor)
    ends = [np.arccos((0.06**2 + apart**2 - p**2) / (2 * 0.06 * apart)) for p in (0.317 - 0.045, 0.317 + 0.045)]
    # 24 states a turn miss the ends by up to 7.5 deg of the crank: 1 - cos(7.5 deg) = 0.9 % of half the sweep
    swept = np.ptp(run["wiper[1].phi"])
    assert 0.99 * (ends[1] - ends[0]) < swept <= ends[1] - ends[0]
    assert np.degrees(ends[1] - ends[0]) == pytest.approx(97.8, abs=0.05)


def test_sewing_machine(turned):
    run = turned("sewing_machine")
    theta = np.pi * run.t
    A = 0.015 * turn(theta)
    assert_same(point(run, "needle_bar.a"), 1j * (A.imag - np.sqrt(0.04**2 - A.real**2)))
    C = 0.012 * turn(theta + np.radians(70))
    D = circles(C, abs(-0.022 + 0.008j), -0.032 + 0.018j, 0.032, -1)
    eye = C + (D - C) / (-0.022 + 0.008j) * (-0.04 + 0.03j)
    assert_same(point(run, "lever.eye"), eye)
    assert np.ptp(run["needle_bar.y"]) == pytest.approx(0.03, abs=EXACT)
    assert np.ptp(eye.imag) == pytest.approx(0.0312, abs=5e-5)


def loom_batten(theta):
    """Joint of rocker and link, and direction of the batten, from the angle of the crank, by circles."""
    a, b, c, h, e, l = 0.08, 0.3, 0.19, 0.4, 0.13, 0.26
    rocker_shaft = h * turn(np.radians(80)) - (e + l) * turn(np.radians(5))
    d = np.sqrt(b**2 + c**2 - a**2)
    line = np.radians(5) + np.arccos((c**2 + d**2 - (b - a) ** 2) / (2 * c * d))
    coupler = circles(rocker_shaft - d * turn(line) + a * turn(theta), b, rocker_shaft, c, 1)
    joint = rocker_shaft + (rocker_shaft - coupler) / c * e
    return joint, circles(joint, l, 0j, h, 1) / h


def test_loom(turned):
    """Pins by circles; the dwell as the turn of the crank with the batten within 2 % of its swing."""
    run = turned("loom")
    joint, batten = loom_batten(np.pi * run.t)
    assert_same(point(run, "rocker.E"), joint)
    assert_same(point(run, "batten.reed"), 0.8 * batten)
    theta = np.radians(np.arange(0, 360, 0.1))
    angle = np.degrees(np.angle(loom_batten(theta)[1]))
    assert angle.min() == pytest.approx(80, abs=1e-6)
    swing = np.ptp(angle)
    dwell = 0.1 * np.sum(angle < 80 + 0.02 * swing)
    assert [swing, dwell, 800 * np.radians(swing)] == pytest.approx([10.37, 97.5, 144.8], abs=0.1)
    waiting = np.degrees(run["batten.phi"]) < 80 + 0.02 * swing
    assert waiting.mean() == pytest.approx(dwell / 360, abs=1 / 24)  # 24 states a turn


def slider_crank_bearing(theta, w, gas):
    """Force on the crank by its bearing [N], of a slider crank with a vertical bore, by Newton and Euler."""
    r, l, piston_m, rod_m = 0.045, 0.15, 0.45, 0.55
    ux, dux, ddux = -r * np.cos(theta) / l, r * w * np.sin(theta) / l, r * w**2 * np.cos(theta) / l
    uy = np.sqrt(1 - ux**2)
    duy = -ux * dux / uy
    dduy = -(dux**2 + ux * ddux + duy**2) / uy
    u, ddu = ux + 1j * uy, ddux + 1j * dduy
    pin = -r * w**2 * turn(theta)
    piston = pin + l * ddu
    centre = rod_m * (pin + piston) / 2
    moment = rod_m * l**2 / 12 * (u.conjugate() * ddu).imag
    fy = piston_m * piston.imag - gas  # on the piston, by the rod
    fx = (ux * fy + moment / l + (u.conjugate() * centre).imag / 2) / uy
    return centre + fx + 1j * fy, piston.imag


def test_four_cylinder_engine(gallery):
    """Bearing forces by Newton and Euler; their sum has no first order, and its second order is the textbook value."""
    run = mbdsl.simulate(gallery("four_cylinder_engine"), method="newmark", step=1e-3, interval=1e-3)
    w, t = 100 * np.pi, run.t
    table = np.array(
        [[0, 3], [0.3, 5], [0.6, 3.4], [1, 1.6], [1.6, 0.7], [2.4, 0.4], [3.5, 0.1], [9.4, 0.1], [10.9, 0.3]]
        + [[11.8, 0.9], [12.3, 2.3], [4 * np.pi, 3]]
    )
    total, inertia = 0.0, 0.0
    for i, (start, fire) in enumerate(zip((90, 270, 270, 90), (0, 180, 540, 360), strict=True)):
        pressure = np.interp((w * t + np.radians(fire)) % (4 * np.pi), *table.T)
        gas = -58e-4 * (pressure - 0.1) * 1e6
        bearing, acceleration = slider_crank_bearing(w * t + np.radians(start), w, gas)
        found = run[f"main[{i + 1}].fx"] + 1j * run[f"main[{i + 1}].fy"]
        assert_same(found, bearing, 1e-9 * np.abs(bearing).max())
        assert np.abs(bearing).max() == pytest.approx(23.1e3, rel=1e-3)
        total = total + found.imag + gas
        inertia = inertia + (0.45 + 0.55 / 2) * acceleration
    assert_same(total, inertia, 1e-9 * np.abs(inertia).max())
    first, second = (2 * np.mean(total[:-1] * turn(-n * w * t[:-1])) for n in (1, 2))
    ratio = 0.3  # of crank and rod; the next term of the series is 15 ratio^5/128, 0.1 %
    textbook = -4 * (0.45 + 0.55 / 2) * 0.045 * w**2 * (ratio + ratio**3 / 4)
    assert abs(first) < 1e-9 * abs(textbook)
    assert second == pytest.approx(textbook, rel=2e-3)


def arm_poses(t):
    """Origins and directions of boom, stick, bucket, rocker and link of the excavator, by circles."""
    u = np.pi / 2 * t
    foot, base = 1.7j, 0.75 + 1.2j
    jack = circles(base, 2.2 - 0.15 * np.sin(u), foot, abs(2.5 + 0.7j), -1)
    boom = (jack - foot) / (2.5 + 0.7j)
    tip = foot + 5.6 * boom
    jack = circles(foot + (2.9 + 1.2j) * boom, 2.95 - 0.4 * np.cos(u), tip, abs(-0.75 + 0.2j), 1)
    stick = (jack - tip) / (-0.75 + 0.2j)
    pin, wrist = tip + (2.45 + 0.05j) * stick, tip + 2.9 * stick
    end = circles(tip + (0.2 + 0.55j) * stick, 2.38 - 0.33 * np.cos(u - 0.6), pin, 0.6, 1)
    hinge = circles(end, 0.55, wrist, abs(-0.05 + 0.42j), 1)
    bucket = (hinge - wrist) / (-0.05 + 0.42j)
    return (foot, boom), (tip, stick), (wrist, bucket), (pin, (end - pin) / 0.6), (end, (hinge - end) / 0.55)


def energy(t):
    """Kinetic and potential energy of the excavator's arm [J], with velocities by central differences."""
    total = 0.0
    masses = ((1700, 4500, 2.8 + 0.6j), (850, 700, 1.1 + 0.1j), (900, 250, 0.45 - 0.35j))
    masses += ((60, 60 * 0.6**2 / 12, 0.3), (50, 50 * 0.55**2 / 12, 0.275))
    d = 1e-3
    for now, before, after, (m, inertia, com) in zip(
        arm_poses(t), arm_poses(t - d), arm_poses(t + d), masses, strict=True
    ):
        v = (after[0] + com * after[1] - before[0] - com * before[1]) / (2 * d)
        w = np.angle(after[1] / before[1]) / (2 * d)
        total = total + m * np.abs(v) ** 2 / 2 + inertia * w**2 / 2 + m * 9.81 * (now[0] + com * now[1]).imag
    return total


def test_excavator_arm(turned, one_cycle):
    """Poses by circles; the power of the three cylinders is the rate of the energy."""
    run = turned("excavator_arm")
    poses = arm_poses(run.t)
    assert_same(point(run, "bucket.teeth"), poses[2][0] + (1.45 - 0.1j) * poses[2][1])
    assert_same(point(run, "link"), poses[4][0] + 0.275 * poses[4][1])
    run = one_cycle("excavator_arm")
    t, power = run.t, 0.0
    ends = ("ground.boom_cylinder", "boom.jack"), ("boom.stick_jack", "stick.jack"), ("stick.bucket_jack", "rocker.b")
    pushes = {"boom": (132, 260), "stick": (-9, 11), "bucket": (6, 14)}  # [kN]
    for name, (a, b) in zip(("boom", "stick", "bucket"), ends, strict=True):
        force = run[f"{name}_cylinder.fx"] + 1j * run[f"{name}_cylinder.fy"]
        along = point(run, b) - point(run, a)
        push = (along.conjugate() * force).real / np.abs(along)
        power = power + push * run[f"{name}_cylinder.v"]
        assert 1e-3 * np.array([push.min(), push.max()]) == pytest.approx(pushes[name], abs=0.5)
    d = 1e-3
    expected = (energy(t + d) - energy(t - d)) / (2 * d)
    # differences of a motion with a period of 4 s and harmonics up to ten times as fast: (10 pi/2 d)^2 = 2e-4
    assert_same(power, expected, 2e-4 * np.abs(expected).max())
