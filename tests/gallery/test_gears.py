"""Gears, cams and contacts of the gallery against closed forms, SciPy's splines and plain geometry."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import mbdsl

#: angles reach 6e3 rad in 1,000 revolutions; a few roundings of them
ROUNDING = 1e-11
#: positions of at most 1 m, at angles that are rounded to 1e-12 rad
EXACT = 2e-12


def point(run, name):
    return run[f"{name}.x"] + 1j * run[f"{name}.y"]


@pytest.fixture(scope="module")
def ran(gallery):
    """``ran(name)``: the run that the model describes."""
    return lambda name: mbdsl.simulate(gallery(name))


def test_gear_pair(ran):
    run = ran("gear_pair")
    ratio, inertia = 3.0, 1.2e-3 + 50e-3 / 9
    acceleration = (6.0 - 12.0 / ratio) / inertia
    expected = acceleration * run.t**2 / 2
    assert run["pinion.phi"] == pytest.approx(expected, abs=1e-9 * expected[-1])  # rounding over 500 steps
    assert run["wheel.phi"] == pytest.approx(-expected / ratio, abs=1e-9 * expected[-1])
    tooth = (6.0 - 1.2e-3 * acceleration) / 0.036  # the motor torque without the part that accelerates the pinion
    assert run["mesh.fy"] == pytest.approx(tooth, rel=1e-6)
    assert run["mesh.tau"] == pytest.approx(-0.108 * tooth, rel=1e-6)
    assert run["A.fy"] == pytest.approx(1.5 * 9.81 + tooth, rel=1e-6)


def test_planetary_gear(turned):
    run = turned("planetary_gear")
    sun = 2 * np.pi * run.t
    places = 8 * np.spacing(sun[-1])  # the sun turns by 2.2e4 rad; found: 1.5 of them
    assert run["carrier.phi"] == pytest.approx(2 / 7 * sun, abs=places)
    assert run["planet.phi"] == pytest.approx(-7 / 3 * 2 / 7 * sun, abs=places)
    assert abs(point(run, "planet") - 0.042 * np.exp(2j / 7 * sun)).max() < EXACT


def test_hypocycloid(turned):
    run = turned("hypocycloid")
    u = 2 * np.pi / 4 * run.t
    assert abs(point(run, "wheel.edge") - 0.04 * (2 * np.exp(1j * u) + np.exp(-2j * u))).max() < EXACT


def test_rack_steering(turned):
    run = turned("rack_steering")
    s = 0.008 * np.deg2rad(400) * np.sin(np.pi / 2 * run.t)
    assert run["guide.s"] == pytest.approx(s, abs=EXACT)
    for side, name in ((-1, "wheel_l"), (1, "wheel_r")):
        kingpin, end = side * 0.65 + 0j, s + side * 0.36 - 0.17j
        arm, tie = np.hypot(0.03, 0.14), np.hypot(0.26, 0.03)
        d = end - kingpin
        along = (abs(d) ** 2 + arm**2 - tie**2) / (2 * abs(d))
        tip = kingpin + d / abs(d) * (along + 1j * side * np.sqrt(arm**2 - along**2))
        assert abs(point(run, f"{name}.arm") - tip).max() < 10 * EXACT


def test_bicycle_chain(ran):
    run = ran("bicycle_chain")
    wheel = run["wheel.phi"][0] - 44 / 16 * 2 * np.pi * run.t
    assert run["wheel.phi"] == pytest.approx(wheel, abs=ROUNDING)
    line = np.unwrap(np.angle(point(run, "arm.b") - (-0.42)))
    pulley = line + 16 / 11 * (wheel - line)
    assert run["pulley.phi"] - run["pulley.phi"][0] == pytest.approx(pulley - pulley[0], abs=1e-10)
    assert np.ptp(line) > 0.1


def test_cam_follower(turned, gallery):
    run, (table,) = turned("cam_follower"), {x.value[0] for x in tables(gallery("cam_follower"))}
    lift = CubicSpline(table.u, table.y, bc_type="periodic")
    expected = 0.025 + 0.012 * lift(180 * run.t % 360)
    assert run["slide.s"] == pytest.approx(expected, abs=EXACT)


def tables(scene):
    """The calls of tables in the laws of a model."""
    laws = [value for c in scene.components.values() for value in c.values.values() if hasattr(value, "args")]
    while laws:
        node = laws.pop()
        if node.op == "table":
            yield node
        laws.extend(node.args)


def test_geneva_drive(turned, draw, gallery):
    run = turned("geneva_drive")
    crank = 2 * np.pi / 3 * run.t - np.pi
    local = (crank + np.pi) % (2 * np.pi) - np.pi
    pin = 0.1 * np.sin(np.pi / 4) * np.exp(1j * crank)
    moving = abs(local) < np.pi / 4 - 1e-6
    # one of the four slots points to the pin
    apart = np.angle((pin - 0.1) ** 4 * np.exp(-4j * run["wheel.phi"]))[moving] / 4
    assert moving.sum() == 5 * 1000 and abs(apart).max() < ROUNDING
    whole = slice(0, None, 24)  # a quarter for each revolution
    phi = run["wheel.phi"][whole]
    assert phi - phi[0] == pytest.approx(-np.pi / 2 * np.arange(len(phi)), abs=ROUNDING)
    # the search for peaks of laws, which turned() leaves out, changes no motion and finds none
    searched = draw["turned"](gallery("geneva_drive"), 10)
    assert not searched.stats["warnings"]
    count = len(searched.t)
    assert count == 241 and np.array_equal(searched.q, run.q[:count])


def test_newtons_cradle(ran):
    run = ran("newtons_cradle")
    energy = run["energy.total"]
    start = 0.064 * 9.81 * 0.15 * (1 - np.cos(np.pi / 6))
    assert np.ptp(energy) < 1e-3 * start  # it contains that of the contacts, almost half of it in one of the states
    last, inner = np.rad2deg(run["ball[5].phi"]), np.rad2deg([run[f"ball[{k}].phi"] for k in (2, 3, 4)])
    assert last[run.t < 0.8].max() == pytest.approx(30.0, rel=2e-3)
    assert abs(inner[:, run.t < 0.5]).max() < 1.0


def test_woodpecker(gallery):
    """The limit of small steps of the method of Moreau and Jean, by an independent program with Glocker's parameters:
    y(0.3 s), phi_S(0.3 s), and times and heights where phi_S returns to its first value. Its sleeve began at -0.1036
    in place of -0.10345 rad, which changes the times by 2e-5 s."""
    run = mbdsl.simulate(gallery("woodpecker"), stop=0.3, interval=2e-5)
    assert run["sleeve.y"][-1] == pytest.approx(-0.0413276, abs=4e-6)
    assert run["bird.phi"][-1] == pytest.approx(-0.342346, abs=5e-5)
    assert run["sleeve.phi"][-1] == pytest.approx(-0.103448, abs=1e-6)
    times, heights = _returns(run)
    assert times == pytest.approx([0.145905, 0.291932], abs=2e-5)
    assert heights == pytest.approx([-0.019377, -0.038875], abs=2e-5)
    assert run["beak.impacts"][-1] == 2


def test_woodpecker_by_time_stepping(gallery):
    """Steps of 50 us: the first return, with an error of order 1."""
    run = mbdsl.simulate(gallery("woodpecker"), method="moreau-jean", step=5e-5, stop=0.148, interval=5e-5)
    times, heights = _returns(run)
    assert times == pytest.approx([0.145905], abs=3e-4)
    assert heights == pytest.approx([-0.019377], abs=2e-4)
    assert (run["beak.impacts"][-1], run["lower.impacts"][-1]) == (1, 2)


def _returns(run):
    """Times and heights where the woodpecker passes its first angle downwards."""
    phi, y = run["bird.phi"], run["sleeve.y"]
    k = np.flatnonzero((phi[:-1] > -0.2788) & (phi[1:] <= -0.2788))
    part = (phi[k] + 0.2788) / (phi[k] - phi[k + 1])
    return run.t[k] + part * (run.t[k + 1] - run.t[k]), y[k] + part * (y[k + 1] - y[k])
