"""Linkages against closed forms and against constructions with compass and ruler, over 1,000 revolutions.

Points are complex numbers. Angles of the 1,000th revolution are rounded to 1e-12 rad, lengths are up to 1.3 m, and no
linkage magnifies an error by more than ten.
"""

import numpy as np

EXACT = 1e-11


def circles(a, ra, b, rb, side):
    """The intersection of circles about a and b, left (1) or right (-1) of the line from a to b."""
    d = b - a
    apart = np.abs(d)
    along = (apart**2 + ra**2 - rb**2) / (2 * apart)
    return a + d / apart * (along + 1j * side * np.sqrt(ra**2 - along**2))


def point(run, name):
    return run[f"{name}.x"] + 1j * run[f"{name}.y"]


def turn(run, period):
    """exp(i phi) of a crank that starts on the x axis."""
    return np.exp(2j * np.pi * (run.t / period))


def on_plate(A, B, at_a, at_b, at):
    """The position of a point of a plate whose points ``at_a`` and ``at_b`` are at A and B."""
    return A + (B - A) * (at - at_a) / (at_b - at_a)


def assert_same(found, expected, within=EXACT):
    assert np.abs(found - expected).max() < within


def test_four_bar_curves(turned):
    run = turned("four_bar_curves")
    A = 0.04 * turn(run, 3.0)
    B = circles(A, 0.1, 0.11, 0.09, 1)
    for name, at in (("P", -0.02 + 0.06j), ("Q", 0.04 + 0.07j), ("R", 0.08 + 0.025j)):
        assert_same(point(run, f"coupler.{name}"), on_plate(A, B, -0.05, 0.05, at))


def test_jansen_leg(turned):
    run, side = turned("jansen_leg"), {"left": 1, "right": -1}
    paths = []
    for leg, pin in ((f"{name}{k + 1}", k) for name in side for k in range(3)):
        s = side[leg[:-1]]
        crank = 0.15 * np.conj(turn(run, 3.0)) * np.exp(2j * np.pi * pin / 3)
        m = crank if s > 0 else -np.conj(crank)  # a right leg is the mirror image of a left one
        Y = -0.38 - 0.078j
        P = circles(m, 0.5, Y, 0.415, -1)
        E = circles(P, 0.558, Y, 0.401, -1)
        L = circles(m, 0.619, Y, 0.393, 1)
        F = circles(E, 0.394, L, 0.367, -1)
        toe = circles(F, 0.657, L, 0.49, -1)
        assert_same(point(run, f"{leg}.foot.T"), toe if s > 0 else -np.conj(toe))
        paths.append(toe[:24])
    # the numbers of the page
    low = paths[0].imag.min()
    assert (
        np.ptp(paths[0].real) > 0.65
        and 0.2 < np.ptp(paths[0].imag) < 0.225
        and 9 <= (paths[0].imag - low < 0.02).sum() <= 14
    )


def test_klann_leg(turned):
    """The patent's coordinates of a leg, and its mirror image on the opposite pin."""
    run = turned("klann_leg")
    p9, p11, p15 = 1.366 + 1.366j, 1.009 + 0.574j, 1.599 + 0.75j
    p27, p29, p33, p35, p37 = 0.741 + 0.75j, 1.331 + 0.75j, 0, 0.232 + 0.866j, 0.866 + 1.5j
    for leg in ("left", "right"):
        crank = -turn(run, 3.0) if leg == "left" else -np.conj(turn(run, 3.0))
        pin = p15 + 0.268 * crank
        elbow = circles(pin, abs(p29 - p27), p11, abs(p27 - p11), -1)
        knee = on_plate(pin, elbow, p29, p27, p35)
        hip = circles(knee, abs(p35 - p37), p9, abs(p37 - p9), 1)
        foot = 0.1 * (on_plate(knee, hip, p35, p37, p33) - p15)
        assert_same(point(run, f"{leg}.shank.foot"), foot if leg == "left" else -np.conj(foot))


def test_chebyshev_lambda(turned):
    """B has equal distances from the crank's pin, P and D: the angle at D is right, by Thales."""
    run = turned("chebyshev_lambda")
    A, D = 0.04 * turn(run, 3.0), 0.08
    P = point(run, "coupler.b")
    assert_same(P, D + -1j * (A - D) / np.abs(A - D) * np.sqrt(0.2**2 - np.abs(A - D) ** 2))
    straight = np.cos(2 * np.pi * (run.t / 3.0)) < 1e-9  # the half of the turn that is far from D
    assert np.ptp(P[straight].real) > 0.15 and np.ptp(P[straight].imag) < 0.002


def test_watt_straight_line(turned):
    """The middle of AB, and Watt's curve about the middle of the base, for rockers b, base 2 a and coupler 2 c.

    r^2 = b^2 - (a sin u +- sqrt(c^2 - a^2 cos^2 u))^2, without the root a polynomial.
    """
    run = turned("watt_straight_line")
    P, D = point(run, "coupler.c"), 0.4 - 0.12j
    A = 0.2 * np.exp(1j * np.deg2rad(24.0) * np.sin(2 * np.pi * (run.t / 3.0)))
    assert_same(P, (A + circles(A, 0.12, D, 0.2, -1)) / 2)
    a, b, c = abs(D) / 2 / 0.2, 1.0, 0.3  # relative to the rockers
    at = (P - D / 2) / (D / abs(D)) / 0.2
    x, y, r2 = at.real, at.imag, np.abs(at) ** 2
    left, right = (r2 * (r2 - b**2 + c**2) + a**2 * (y**2 - x**2)) ** 2, 4 * (a * y) ** 2 * (c**2 * r2 - (a * x) ** 2)
    assert_same(left, right)
    assert np.abs(left).max() > 1e-3
    assert np.ptp(P.imag) > 0.15 and np.abs(P.real - 0.2).max() < 0.002


def test_roberts(turned):
    """The tip goes through both pins, where the triangle has turned by the same angle."""
    run = turned("roberts")
    turned_by = np.deg2rad(36.0) * np.sin(2 * np.pi * (run.t / 3.0))
    # AB has a given direction: shifted by it, the circle of B meets that of A
    AB = 0.1 * np.exp(1j * turned_by)
    A = circles(0, 0.12, 0.2 - AB, 0.12, 1)
    P = A + AB * (0.05 - 1j * np.sqrt(0.12**2 - 0.05**2)) / 0.1
    assert_same(point(run, "triangle.P"), P)
    between = np.abs(P.real - 0.1) < 0.1
    assert between.any() and np.abs(P.imag[between]).max() < 0.003


def test_peaucellier_lipkin(turned):
    """P is the inverse of C: on a straight line at (arm^2 - side^2)/(2 radius) from O."""
    run = turned("peaucellier_lipkin")
    P, C = point(run, "rhombus[3].b"), point(run, "crank.b")
    swing = np.deg2rad(70.0) * np.sin(2 * np.pi * (run.t / 4.0))
    line = (0.25**2 - 0.1**2) / 0.2
    assert_same(P.real, line)
    assert_same(P.imag, line * np.tan(swing / 2))
    assert_same(P * np.conj(C), 0.25**2 - 0.1**2)
    assert np.ptp(P.imag) > 0.3


def test_whitworth_quick_return(turned):
    run = turned("whitworth_quick_return")
    pin = 0.1 * turn(run, 3.0) + 0.05j
    C = -0.08 * pin / np.abs(pin)
    assert_same(run["ram.x"], C.real + np.sqrt(0.3**2 - C.imag**2))
    # dead centres: the pin is level with the arm's, sin(phi) = -1/2, crank angles -30 and 210 degrees, a ratio of 2
    degrees = np.rint(np.rad2deg(run["crank.phi"])) % 360
    for angle, place in ((330, 0.22), (210, 0.38)):
        at = degrees == angle
        assert at.sum() == 1000 and np.abs(run["ram.x"][at] - place).max() < EXACT
        assert np.abs(run["ram.vx"][at]).max() < EXACT


def test_scotch_yoke(turned, one_cycle):
    """x = r cos(w t), and the torque that changes the kinetic energy of the yoke: m r^2 w^2 sin cos."""
    run, w = turned("scotch_yoke"), np.pi
    assert_same(run["yoke.x"], 0.06 * np.cos(w * run.t))
    assert_same(run["yoke.vx"], -0.06 * w * np.sin(w * run.t))
    run = one_cycle("scotch_yoke")
    phi = w * run.t
    assert_same(run["yoke.ax"], -0.06 * w**2 * np.cos(phi))
    assert_same(run["motor.tau"], 4.0 * 0.06**2 * w**2 * np.sin(phi) * np.cos(phi))


def test_elliptical_trammel(turned):
    run = turned("elliptical_trammel")
    P, M = point(run, "bar.P"), point(run, "bar.M")
    assert_same((P.real / 0.22) ** 2 + (P.imag / 0.1) ** 2, 1.0, 10 * EXACT)  # lengths relative to 0.1 m
    assert_same(np.abs(M), 0.06)  # a circle
    assert_same(P, 0.22 * turn(run, 3.0).real + 0.1j * turn(run, 3.0).imag)


def test_pantograph(turned):
    run = turned("pantograph")
    T, P = point(run, "third.b"), point(run, "second.b")
    assert_same(P, 3 * T)
    u = 2 * np.pi * (run.t / 4.0)
    assert_same(T, 0.13 + 0.03 * (0.8 + 0.2 * np.cos(5 * u)) * np.exp(1j * u))


def test_toggle_press(turned, one_cycle):
    """The knee from two circles, the force of the cylinder by virtual work."""
    G = -0.45 - 0.3j

    def pose(t):
        length = 0.389 - 0.044 * np.cos(2 * np.pi * (t / 4.0))
        knee = circles(0, 0.25, G, length, 1)
        return knee, (knee - G) / length

    run = turned("toggle_press")
    knee, _ = pose(run.t)
    assert_same(point(run, "upper.b"), knee)
    assert_same(run["ram.y"], 2 * knee.imag)
    run = one_cycle("toggle_press")
    knee, axis = pose(run.t)
    # for a small turn of the upper link the knee moves along i*knee, and the ram twice as far up as the knee
    force = -20e3 * 2 * knee.real / (axis * np.conj(1j * knee)).real
    found = (run["cylinder.fx"] + 1j * run["cylinder.fy"]) * np.conj(axis)
    # inertia: 7 kg, at most 0.3 m/s^2, magnified by no more than three times as much as the resistance
    assert np.abs(found / force - 1).max() < 7 * 0.3 / 20e3 * 3
    assert 6 < 20e3 / np.abs(force).min() < 6.3


def test_scissor_lift(turned):
    run = turned("scissor_lift")
    span = 0.9 + 0.2 * np.cos(2 * np.pi * (run.t / 6.0))
    assert_same(run["platform.y"], 3 * np.sqrt(1.2**2 - span**2))
    assert_same(run["platform.phi"], 0.0)


def test_stephenson_six_bar(turned):
    run = turned("stephenson_six_bar")
    A = 0.04 * turn(run, 3.0)
    B = circles(A, 0.122, 0.0803, 0.0993, 1)
    P = on_plate(A, B, 0, 0.122, 0.1412 + 0.0216j)
    F = 0.0591 - 0.0765j
    E = circles(P, 0.1533, F, 0.06, 1)
    assert_same(point(run, "output.b"), E)
    swing = np.rad2deg(run["output.phi"][:25])
    waits = slice(12, 19)  # crank angles 180 to 270 degrees
    assert np.ptp(swing) > 20 and np.ptp(swing[waits]) < 0.2


def test_watt_six_bar(turned):
    run = turned("watt_six_bar")
    A = 0.04 * turn(run, 2.0)
    B = circles(A, 0.135, 0.14, 0.06, 1)
    C = on_plate(0.14, B, 0, 0.06, 0.095 * np.exp(-1j * np.deg2rad(40)))
    F = 0.19 - 0.01j
    assert_same(point(run, "output.b"), circles(C, 0.09, F, 0.04, 1))
    assert 180 < np.rad2deg(np.ptp(run["output.phi"])) < 186
