"""Radau IIA in space: orders against closed forms and published problems, redundancy, velocity constraints, stiffness.

References: the top's published problem solved to 16 digits (tests/data/reference/heavy_top.json), Bricard's linkage
(bricard.json), closed forms; where there are none, dop853, which has other equations and formulas.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl

ROOT = Path(__file__).parents[2]
SPACE = ROOT / "models" / "space"
REFERENCE = ROOT / "tests" / "data" / "reference"
METHODS = ("radau5", "radau9", "radau13")


def attitude_error(t, body, p):
    """The angle of a body at the end from the attitude p, for small angles."""
    found = np.array([t[f"{body}.p{j}"][-1] for j in range(4)])
    return 2.0 * min(np.abs(found - p).max(), np.abs(found + p).max())


def top_reference():
    """Position, quaternion, body-fixed angular velocity, and by the laws of motion the reaction at the point."""
    values = json.loads((REFERENCE / "heavy_top.json").read_text(encoding="utf-8"))["values"]
    x, p, w = (np.array(values[key], float) for key in ("x_com", "quat_wxyz", "Omega_body"))
    u = p[1:]
    skew = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    R = np.eye(3) * (p[0] ** 2 - u @ u) + 2 * np.outer(u, u) + 2 * p[0] * skew
    s, m, g = np.array([0.0, 1.0, 0.0]), 15.0, np.array([0.0, 0.0, -9.81])
    J = np.diag([0.234375, 0.46875, 0.234375]) + m * (np.eye(3) - np.outer(s, s))
    alpha = np.linalg.solve(J, np.cross(s, m * R.T @ g) - np.cross(w, J @ w))
    return x, p, w, m * (R @ (np.cross(alpha, s) + np.cross(w, np.cross(w, s))) - g)


def top_errors(t):
    """Errors of position, attitude, angular velocity and reaction at 0.1 s."""
    x, p, w, force = top_reference()
    position = max(abs(t[f"top.{key}"][-1] - value) for key, value in zip("xyz", x, strict=True))
    reaction = max(abs(t[f"ball.f{key}"][-1] - value) for key, value in zip("xyz", force, strict=True))
    return np.array([position, attitude_error(t, "top", p), np.abs(t.v[-1, 3:] - w).max(), reaction])


@pytest.mark.parametrize(
    ("method", "sizes", "off"),
    [("radau5", (2e-3, 1e-3), 0.15), ("radau9", (5e-3, 4e-3), 0.6)],
)
def test_order_on_the_heavy_top(method, sizes, off):
    """Steps of 0.15 to 0.75 rad of the spin. ``off``: the next term of the error, and rounding of 1e-14 for radau9.

    Both levels of constraints hold to rounding: EPS times the size 1 m, and times the velocity of 150 m/s of points
    at 1 m from the axis of the spin."""
    runs = [mbdsl.simulate(SPACE / "heavy_top.mbd", method=method, step=h, stop=0.1, interval=h) for h in sizes]
    coarse, fine = map(top_errors, runs)
    order = np.log(coarse / fine) / np.log(sizes[0] / sizes[1])
    assert order == pytest.approx(int(method[5:]), abs=off)
    for k in (1, 2, 3):
        assert np.abs(runs[1][f"ball.Phi[{k}]"]).max() < 1e-14
        assert np.abs(runs[1][f"ball.dPhi[{k}]"]).max() < 1e-11


def test_radau13_on_the_heavy_top():
    """Its error at steps of 0.75 rad is rounding, of 20 steps at 150 rad/s."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method="radau13", step=5e-3, stop=0.1)
    assert (top_errors(t) / [1.0, 1.0, 150.0, 15 * 150.0**2]).max() < 1e-13


FREE = """spatial model Free "A symmetric free body"
  Ground ground(g = 0);
  Body b(m = 1 kg, I = {2, 2, 3} kg.m2);
  Force none(b.c);
initial equation
  b.wx = 1 rad/s;
  b.wy = 0 rad/s;
  b.wz = 2 rad/s;
annotation(experiment(StopTime = 4 s));
end Free;"""


def product(p, q):
    """The quaternion of two rotations."""
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def turn(vector):
    """The quaternion of a rotation vector."""
    size = np.linalg.norm(vector)
    return np.array([np.cos(size / 2), *(np.sin(size / 2) / size * np.asarray(vector))])


@pytest.mark.parametrize(("method", "steps"), [("radau5", (20, 40)), ("radau9", (10, 20)), ("radau13", (5, 6))])
def test_order_on_a_free_body(method, steps):
    """Regular precession: the rotation L t/I1 about the constant angular momentum, after that of -(I3 - I1)/I1 w3 t
    about the body's axis. Steps of 0.2 to 2 rad; the next term of the error is not small with the longest ones."""
    p = product(turn(np.array([2.0, 0.0, 6.0]) / 2.0 * 4.0), turn([0.0, 0.0, -0.5 * 2.0 * 4.0]))
    model = mbdsl.parse(FREE)
    coarse, fine = (
        attitude_error(mbdsl.simulate(model, method=method, step=4.0 / n, interval=4.0), "b", p) for n in steps
    )
    order = np.log(coarse / fine) / np.log(steps[1] / steps[0])
    assert -0.2 < order - int(method[5:]) < 2.0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tol", [1e-4, 1e-8])
def test_tolerances_keep_their_word(method, tol):
    """Relative to the size 1 m and the angular velocity 150 rad/s; the longest step, 2 ms, is a fiftieth of the run."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method=method, tol=tol, stop=0.1, interval=0.1)
    assert (top_errors(t)[:3] / [1.0, 1.0, 150.0]).max() < tol
    assert t.stats["rejected"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_bricard(method):
    """30 rows of rank 29; between 9 and 10 s the linkage hardly moves near a pose that magnifies errors."""
    expected = json.loads((REFERENCE / "bricard.json").read_text(encoding="utf-8"))["P3"]
    t = mbdsl.simulate(SPACE / "bricard.mbd", method=method, tol=1e-8, interval=1.0)
    for second, values in expected.items():
        k = int(np.argmin(np.abs(t.t - float(second))))
        assert [t[f"rod3.b.{key}"][k] for key in "xyz"] == pytest.approx([float(x) for x in values], abs=1e-8)


@pytest.mark.parametrize(("method", "h", "error"), [("radau5", 5e-3, 1e-9), ("radau9", 2e-2, 1e-11)])
def test_rolling_coin(method, h, error):
    """Rows of velocities: the coin's centre moves on a circle of 60 mm with the rate W of its closed form."""
    t = mbdsl.simulate(SPACE / "rolling_coin.mbd", method=method, step=h, stop=0.3, interval=0.02)
    r, R, a = 12e-3, 60e-3, np.radians(70.0)
    W = np.sqrt(9.81 * r * np.cos(a) / (r**2 / 4 * np.sin(a) * np.cos(a) + 3 / 2 * R * r * np.sin(a)))
    assert np.abs(t["coin.x"] - R * np.cos(W * t.t)).max() < error
    assert np.abs(t["coin.y"] - R * np.sin(W * t.t)).max() < error


def test_driven_four_link():
    """Haug's four-link without its reduction to kinematics: positions follow from the constraints alone."""
    given = {"tol": 1e-7, "stop": 2.0, "interval": 0.05}
    moved = mbdsl.simulate(SPACE / "haug_four_link.mbd", method="radau5", general=True, **given)
    posed = mbdsl.simulate(SPACE / "haug_four_link.mbd", method="radau5", **given)
    assert moved.stats["iterations"] != posed.stats["iterations"]
    for name in ("link.x", "link.z", "rocker.wy", "link.vx"):
        np.testing.assert_allclose(moved[name], posed[name], atol=1e-7 * max(1.0, np.abs(posed[name]).max()))


STIFF = """spatial model Stiff "A body on a ball joint and a stiff link"
  Ground ground(n = {0, 0, -1}, frames(p = {0, 0, 0.5} m));
  Body top(m = 2 kg, I = {0.02, 0.03, 0.01} kg.m2, frames(foot = {0, -0.3, 0.1} m, tip = {0.1, 0.3, 0.1} m));
  Spherical pin(ground, top.foot);
  LINK
initial equation
  top.x = 0;
  top.y = 0.3 m;
  top.z = -0.1 m;
  top.wz = 3 rad/s;
  top.wx = 0 rad/s;
  link.v = 0;
annotation(experiment(StopTime = 1 s));
end Stiff;"""


@pytest.mark.parametrize("method", METHODS)
def test_stiff_link(method):
    """A spring of 1e8 N/m with a damper is close to a rigid link: forces of 100 N change its length by 1 um, and the
    damper's time constant, 10 ms, is that of creep. Steps follow the motion, not the vibration of 1 kHz."""
    spring = "SpringDamper link(ground.p, top.tip, k = 1e8 N/m, c = 1e6 N.s/m, s0 = 0.78740078740118 m);"
    t = mbdsl.simulate(mbdsl.parse(STIFF.replace("LINK", spring)), method=method, tol=1e-6, interval=0.05)
    rigid = STIFF.replace("LINK", "Distance link(ground.p, top.tip, length = 0.78740078740118 m);")
    rigid = rigid.replace("  link.v = 0;\n", "")
    other = mbdsl.simulate(mbdsl.parse(rigid), method="dop853", tol=1e-9, interval=0.05)
    assert max(np.abs(t[f"top.{key}"] - other[f"top.{key}"]).max() for key in "xyz") < 2e-5
    assert t.stats["steps"] < 1000


RODS = """spatial model Rods "Two thin rods that do not spin freely about their axes"
  Ground ground;
  Rod a(m = 1 kg, length = 1 m);
  SECOND
  Universal j(ground, a.a, n_a = {0, 1, 0}, n_b = {0, 0, 1});
  Universal k(a.b, b.a, n_a = {0, 1, 0}, n_b = {0, 0, 1});
initial equation
  a.wz = 3 rad/s;
  a.wy = 1 rad/s;
  b.wz = 0 rad/s;
  b.wy = 2 rad/s;
annotation(experiment(StopTime = 0.5 s));
end Rods;"""


@pytest.mark.parametrize(
    "second",
    [
        "Rod b(m = 1 kg, length = 0.7 m);",
        "Body b(m = 0.7 kg, I = {{0.02, 0.02, 0}, {0.02, 0.02, 0}, {0, 0, 0.04}} kg.m2, frames(a = {-0.3, 0, 0} m));",
    ],
)
@pytest.mark.parametrize("method", ["radau5", "radau9"])
def test_bodies_without_inertia_about_an_axis(method, second):
    """The axis is one of the body, or lies between two of them."""
    model = mbdsl.parse(RODS.replace("SECOND", second))
    t, other = (mbdsl.simulate(model, method=m, tol=1e-8, interval=0.1) for m in (method, "dop853"))
    for name in ("a.x", "a.z", "b.x", "b.z", "b.p2"):
        np.testing.assert_allclose(np.abs(t[name]), np.abs(other[name]), atol=2e-8)


LEANING = """spatial model Leaning "A body on a ball joint, pushed by laws with jumps and corners"
  Ground ground(n = {0, 0, -1});
  Body b(m = 1 kg, I = {0.02, 0.05, 0.03} kg.m2, frames(foot = {0, -0.3, 0} m, tip = {0.1, 0.3, 0.2} m));
  Spherical j(ground, b.foot);
  Force push(b.tip, fz = JUMP);
  Force lift(b.tip, fy = CORNER);
initial equation
  b.wy = 20 rad/s;
  b.wx = 3 rad/s;
annotation(experiment(StopTime = 0.4 s));
end Leaning;"""


@pytest.mark.parametrize("method", METHODS)
def test_events(method):
    """Switches that jump, and others with a corner; relative to 25 rad/s and 0.3 m."""
    law = LEANING.replace("JUMP", "if b.tip.x > 0 then 20 N else 0 N")
    model = mbdsl.parse(law.replace("CORNER", "if b.tip.z < 0 then -500 N/m*b.tip.z else 0 N"))
    t = mbdsl.simulate(model, method=method, tol=1e-7, interval=0.01)
    other = mbdsl.simulate(model, method="dop853", tol=1e-10, interval=0.01)
    assert t.stats["events"] > 0
    for key in "xyz":
        np.testing.assert_allclose(t[f"b.{key}"], other[f"b.{key}"], atol=1e-7 * t.system.tables.size)
        np.testing.assert_allclose(t[f"b.w{key}"], other[f"b.w{key}"], atol=1e-7 * 25.0)


@pytest.mark.parametrize(("method", "order"), [("radau5", 5), ("radau9", 6), ("radau13", 8)])
def test_output_between_steps(method, order):
    """Attitudes between the ends of steps, the first step included: polynomials of degree 5, or one more than there
    are stages. Steps of 0.2 and 0.1 rad of the spin."""
    model = mbdsl.parse(LEANING.replace("JUMP", "0 N").replace("CORNER", "-500 N/m*b.tip.z"))
    given = {"stop": 0.1, "interval": 5e-4}
    exact = mbdsl.simulate(model, method="dop853", step=2.5e-4, **given)
    errors = []
    for h in (1e-2, 5e-3):
        t = mbdsl.simulate(model, method=method, step=h, **given)
        errors.append(max(np.abs(np.abs(t[f"b.p{k}"]) - np.abs(exact[f"b.p{k}"])).max() for k in range(4)))
    assert np.log2(errors[0] / errors[1]) > order - 0.5
    rate = t["b.wy"]  # velocities are those of the attitudes: the same order, less one where it is that of degree
    assert np.abs(rate - exact["b.wy"]).max() < 1e-2


def test_first_step():
    """Output within the first step, whose polynomial uses the accelerations at both ends: order 6 within one step."""
    model = mbdsl.parse(LEANING.replace("JUMP", "0 N").replace("CORNER", "-500 N/m*b.tip.z"))
    errors = []
    for h in (1e-2, 5e-3):
        t, exact = (
            mbdsl.simulate(model, method=m, step=h / n, stop=h, interval=h / 8)
            for m, n in (("radau5", 1), ("dop853", 16))
        )
        errors.append(max(np.abs(np.abs(t[f"b.p{k}"]) - np.abs(exact[f"b.p{k}"])).max() for k in range(4)))
    assert np.log2(errors[0] / errors[1]) > 4.5
