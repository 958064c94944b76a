"""The answers of docs/how-to/ are those of closed forms, or of SciPy.

The numbers are read from the pages. tests/unit/house/test_docs_commands.py runs the commands of the pages and compares
their output with the same numbers.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, minimize_scalar

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "how-to"
PAGES = sorted(path.stem for path in FOLDER.glob("*.md") if path.stem != "index")
G = 9.81
RPM = np.pi / 30.0
NUMBER = r"(-?\d+(?:\.\d+)?(?:e[+-]\d+)?)(?:\.\.\.)?"  #: the digits of ``0.7901...``


def agree(page, pattern, *expected):
    """Whether the numbers in the groups of ``pattern``, which occurs once in a page, have the ``expected`` values.

    One unit of the last digit is allowed: outputs are cut, and the text is rounded.
    """
    text = " ".join((FOLDER / f"{page}.md").read_text(encoding="utf-8").split())
    matches = re.findall(pattern.replace("#", NUMBER), text)
    assert len(matches) == 1, f"{pattern} occurs {len(matches)} times"
    found = matches[0] if isinstance(matches[0], tuple) else (matches[0],)
    assert len(found) == len(expected)
    for number, value in zip(found, expected, strict=True):
        digits, _, power = number.partition("e")
        unit = 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
        assert abs(float(number) - value) <= unit, f"{pattern}: {number}, expected {value:.8g}"


def test_index_navigation_and_lengths():
    index, site = (FOLDER / "index.md").read_text(encoding="utf-8"), (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert sorted(re.findall(r"\]\(([\w-]+)\.md\)", index)) == PAGES
    assert sorted(re.findall(r"how-to/([\w-]+)\.md", site)) == sorted([*PAGES, "index"])
    for page in PAGES:
        text = (FOLDER / f"{page}.md").read_text(encoding="utf-8")
        assert text.startswith("# How do I ") and len(text.split()) <= 300, page
        assert all((FOLDER / name).is_file() for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)), page


def test_boom_cylinder():
    """Virtual work, with the derivatives of the angle b by the length s, from s^2 = d^2 + e^2 - 2 d e cos b."""
    d, e, v = np.hypot(0.5, 1.0), 1.5, 0.1
    inertia, moment = 300.0 * 4.0**2 / 3.0 + 500.0 * 4.0**2, G * (300.0 * 2.0 + 500.0 * 4.0)

    def push(s):
        b = np.arccos((d**2 + e**2 - s**2) / (2.0 * d * e))
        first = s / (d * e * np.sin(b))
        second = 1.0 / (d * e * np.sin(b)) - s * np.cos(b) * first / (d * e * np.sin(b) ** 2)
        return first * (moment * np.cos(b - np.arctan2(1.0, 0.5)) + inertia * second * v**2)

    most = minimize_scalar(lambda s: -push(s), bounds=(1.4, 2.2), method="bounded", options={"xatol": 1e-9})
    when, largest = (most.x - 1.4) / v, -most.fun
    agree("boom-cylinder", r"oil.force N # # ", -largest, when)
    agree("boom-cylinder", r"Its largest value is # N, at # s", largest, when)
    agree("boom-cylinder", r"pushes with # kN at most, after # s, and", largest / 1e3, when)
    agree("boom-cylinder", r"takes # kW", v * largest / 1e3)
    agree("boom-cylinder", r"oil.power W # 8 # ", v * push(2.2), v * largest)  # its top is flat: no digits of its time


def test_cam_spring():
    m, w, lift = 0.4, 900.0 * RPM, 0.01

    def force(k, up):
        """Of the cam, at the highest (1) and the lowest (-1) point: weight, spring and inertia."""
        return m * G + k * (0.03 + lift * up) - up * m * w**2 * lift

    k = (m * w**2 * lift - m * G) / 0.04
    agree("cam-spring", r"CamSpring: k = # N/mm", k / 1e3)
    agree("cam-spring", r"is zero for k = # N/mm", k / 1e3)
    agree("cam-spring", r"1\.6 # # ``` \*\*Closed", force(1600.0, 1.0), force(1600.0, -1.0))


def test_press_flywheel():
    first, last = 180.0 * RPM, 150.0 * RPM
    work = 6000.0 * np.pi / 6.0
    inertia = 2.0 * work / (first**2 - last**2)
    agree("press-flywheel", r"Press: I = # kg", inertia)
    agree("press-flywheel", r"w1\^2\) = # kg", inertia)
    begin = np.radians(150.0) / first  # the speed falls uniformly during the cut
    duration = np.radians(30.0) / (0.5 * (first + last))
    agree("press-flywheel", r"57\.8745 # # ```", begin, begin + duration)
    agree("press-flywheel", r"rpm\) = # ms", 1e3 * duration)


def test_washing_machine():
    m, k, c = 40.0, 8000.0, 200.0
    ratio, f0 = c / (2.0 * np.sqrt(k * m)), np.sqrt(k / m) / (2.0 * np.pi)
    f, most = f0 / np.sqrt(1.0 - 2.0 * ratio**2), 1.0 / (2.0 * m * ratio * np.sqrt(1.0 - ratio**2))
    agree("washing-machine", r"resonance # # ", f, most)
    agree("washing-machine", r"this is # mm, at # Hz = # rpm", 100.0 * most, f, 60.0 * f)
    agree("washing-machine", r"= # Hz and the damping ratio .* = #, the", f0, ratio)
    agree("washing-machine", r"= # m, at f0/.* = # Hz", most, f)


def test_vibration_absorber():
    def resonances(ma):
        k = ma * (20.0 * np.pi) ** 2
        return np.sqrt(np.sort(np.roots([100.0 * ma, -(4e5 + k) * ma - 100.0 * k, 4e5 * k]))) / (2.0 * np.pi)

    low, high = resonances(10.0)
    agree("vibration-absorber", r"resonance # infinite [.]+ antiresonance # [.]+ resonance # infinite", low, 10.0, high)
    agree("vibration-absorber", r"k\^2: # Hz and # Hz", low, high)
    agree("vibration-absorber", r"Hz\)\^2 = # N/mm", 10.0 * (20.0 * np.pi) ** 2 / 1e3)
    for ma in (5, 10, 20):
        agree("vibration-absorber", rf" {ma} # # (?:10|20|```)", *resonances(ma))


def test_quarter_car():
    s, z = np.loadtxt(ROOT / "models" / "road.csv", delimiter=",", skiprows=1).T
    road, found = CubicSpline(s, z / 1e3), []
    for speed in (5.0, 7.5, 10.0):

        def rates(t, y, speed=speed):
            wheel, body, wheel_v, body_v = y
            force = 2e4 * (wheel - body) + 1500.0 * (wheel_v - body_v)
            return [wheel_v, body_v, (2e5 * (road(speed * t) - wheel) - force) / 40.0, force / 300.0]

        t = np.linspace(0.0, 2.0, 4001)
        run = solve_ivp(rates, (0.0, 2.0), [road(0.0), road(0.0), 0.0, 0.0], t_eval=t, rtol=1e-8, atol=1e-10)
        a = np.array(rates(t, run.y)[3])
        load = 340.0 * G + 2e5 * (road(speed * t) - run.y[0])
        found += [np.sqrt(trapezoid(a**2, t) / 2.0), load.min()]
    pattern = r" 18 # # 27 # # 36 # # ```"
    agree("quarter-car", pattern, *found)
    agree("quarter-car", r"gives #, # and # m/s2, and #, # and # N", *found[::2], *found[1::2])


def test_yo_yo_despin():
    length = np.sqrt(40.0 / 4.0 + 0.5**2)
    time = length / (0.5 * 60.0 * RPM)
    agree("yo-yo-despin", r" 60 # # 120 # # ```", length, time, length, 0.5 * time)
    agree("yo-yo-despin", r"Cords of # m", length)
    agree("yo-yo-despin", r"0\.25\) m = # m\. .* takes # s", length, time)


def test_falling_chimney():
    """The time by quadrature of w = sqrt(3 g (sin 85 - sin phi)/L); the moment is the largest over x, by search."""
    m, length = 9e4, 30.0
    start, end = np.radians([85.0, 45.0])
    # phi = start - u^2 removes the square root at the start
    u, weight = np.polynomial.legendre.leggauss(60)
    top = np.sqrt(start - end)
    u, weight = 0.5 * top * (u + 1.0), 0.5 * top * weight
    w = np.sqrt(3.0 * G / length * (np.sin(start) - np.sin(start - u**2)))
    time = float(weight @ (2.0 * u / w))

    def moment(x, parts=2000):
        """Of the weight and the inertia of the part above x, about the section."""
        y = x + (np.arange(parts) + 0.5) * (length - x) / parts
        across = 1.5 * G * np.cos(end) * y / length - G * np.cos(end)  # inertia and weight per mass
        return float(np.sum(across * (y - x)) * m / length * (length - x) / parts)

    most = minimize_scalar(lambda x: -moment(x), bounds=(1.0, 29.0), method="bounded")
    assert most.x == pytest.approx(length / 3.0, rel=1e-4)
    agree("falling-chimney", r" 90 # # ```", time, -most.fun)
    agree("falling-chimney", r"/27, # kN", -most.fun / 1e3)
    agree("falling-chimney", r"height, # m above", most.x)


def test_scissor_lift():
    s = np.array([1.0, 1.2, 1.4, 1.6, 1.8])
    height = np.sqrt(4.0 - s**2)
    force = (500.0 + 40.0) * G * s / height
    rows = " ".join(rf"{x:g} # #" for x in s)
    agree("scissor-lift", rows, *np.stack([height, force], axis=1).ravel())
    agree("scissor-lift", r"with # kN", force[-1] / 1e3)
    agree("scissor-lift", r"s/h: # N at", force[-1])


def test_door_closer():
    inertia, k = 30.0 * 0.9**2 / 3.0, 12.0

    def motion(c, t):
        """Angle [deg] and its rate [deg/s]."""
        r1, r2 = np.roots([inertia, c, k])
        e1, e2 = np.exp(r1 * t), np.exp(r2 * t)
        return -20.0 + 110.0 * (r2 * e1 - r1 * e2) / (r2 - r1), 110.0 * r1 * r2 * (e1 - e2) / (r2 - r1)

    c = brentq(lambda c: motion(c, 5.0)[0], 25.0, 60.0)
    speed = 0.9 * np.radians(abs(motion(c, 5.0)[1]))
    agree("door-closer", r"Closer: c = # N", c)
    agree("door-closer", r"5 s for c = # N.* moves at # m/s", c, speed)
    agree("door-closer", r" 36\.32 # ```", speed)
