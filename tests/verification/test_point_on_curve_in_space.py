"""Points on curves and surfaces in space against closed forms and against joints with the same motion."""

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import modules

METHODS = [name for name, module in modules().items() if module.METHOD.chosen and not hasattr(module, "take")]
G = 9.81
R, PITCH = 0.4, 0.5


def bead(joint, start, more="", ground="Ground ground(n = {0, 0, -1})", mass=3):
    return f"""spatial model Bead
      {ground};
      PointMass bead(m = {mass} kg);
      {more}
      {joint};
    initial equation
      {start}
    end Bead;"""


HELIX = f"f1 = x - {R} m*cos(2*pi*z/({PITCH} m)), f2 = y - {R} m*sin(2*pi*z/({PITCH} m))"


def test_a_bead_slides_down_a_helix():
    """z'' = -g (dz/ds)^2 with the constant slope dz/ds = p/sqrt(p^2 + (2 pi R)^2); normal to the wire, the bead has the
    weight's normal part and the centripetal force m v_xy^2/R. Steps of 1/400 of the last turn: errors of order 2."""
    text = bead(f"PointOnCurve wire(ground, bead, {HELIX})", "guess bead.x = 0.4 m; bead.z = 0 m; bead.vz = 0 m/s;")
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=2.0, interval=0.1)
    slope = PITCH / np.hypot(PITCH, 2 * np.pi * R)
    a = -G * slope**2
    np.testing.assert_allclose(t["wire.z"], a * t.t**2 / 2, rtol=0, atol=2e-5)
    turned = np.exp(2j * np.pi * t["wire.z"] / PITCH)
    np.testing.assert_allclose(t["bead.x"] + 1j * t["bead.y"], R * turned, rtol=0, atol=1e-9)
    around = a * t.t * 2 * np.pi * R / PITCH
    expected = np.hypot(3 * G * np.sqrt(1 - slope**2), 3 * around**2 / R)
    force = np.linalg.norm([t[f"wire.f{i}"] for i in "xyz"], axis=0)
    np.testing.assert_allclose(force, expected, rtol=1e-4)
    assert t["energy.total"] == pytest.approx(0.0, abs=1e-3)  # of 36 J


@pytest.mark.parametrize("method", METHODS)
def test_a_bead_on_a_circle_is_a_pendulum(method):
    """The same constraint as a rod of constant length in a plane, for another function: the same steps.

    The methods differ by what Newton's iteration leaves, relative to forces of 60 N and the length."""
    start = "guess bead.y = -0.4 m; bead.x = 0.3 m; bead.vx = 0 m/s;"
    curve = bead("PointOnCurve wire(ground, bead, f1 = x^2 + y^2 - (0.5 m)^2, f2 = z)", start, ground="Ground ground")
    rod = bead("Distance rod(ground, bead, length = 0.5 m)", start, "PointOnPlane flat(ground, bead);", "Ground ground")
    a, b = (mbdsl.simulate(mbdsl.parse(x), method=method, step=1e-3, stop=0.5, interval=0.05) for x in (curve, rod))
    for key in ("x", "y", "z", "vx", "vy", "vz"):
        np.testing.assert_allclose(a[f"bead.{key}"], b[f"bead.{key}"], rtol=0, atol=1e-7, err_msg=key)
    for key in ("fx", "fy"):
        np.testing.assert_allclose(a[f"wire.{key}"], b[f"rod.{key}"], rtol=0, atol=1e-4, err_msg=key)


def test_a_sphere_is_a_link():
    """A point on a sphere and a point on a link: a spherical pendulum whose centre moves with a cart."""
    more = "Body cart(m = 5 kg, I = {1, 1, 1} kg.m2); Prismatic rail(ground, cart.c, n = {1, 2, 0});"
    start = "bead.x = 0.3 m; bead.y = 0.2 m; guess bead.z = -0.3 m; bead.vx = 1 m/s; rail.s = 0 m; rail.v = 0 m/s;"
    start += " bead.vy = -0.5 m/s;"
    sphere = bead("PointOnSurface bowl(cart.c, bead, f = x^2 + y^2 + z^2 - (0.5 m)^2)", start, more)
    link = bead("Distance bowl(cart.c, bead, length = 0.5 m)", start, more)
    a, b = (mbdsl.simulate(mbdsl.parse(x), step=1e-3, stop=1.0, interval=0.05) for x in (sphere, link))
    for key in ("bead.x", "bead.y", "bead.z", "rail.s", "bowl.fx", "bowl.fy", "bowl.fz"):
        scale = np.abs(b[key]).max()
        np.testing.assert_allclose(a[key], b[key], rtol=0, atol=1e-6 * scale, err_msg=key)


def test_a_wire_that_turns():
    """A bead on a horizontal straight wire that turns at 3 rad/s: r = r0 cosh(w t); the wire pushes with 2 m w r'."""
    more = "Body hub(m = 1 kg, I = {1, 1, 1} kg.m2); Revolute axle(ground, hub.c);"
    more += " RotationalDriver motor(axle, phi = 3 rad/s*time);"
    text = bead("PointOnCurve wire(hub.c, bead, f1 = y, f2 = z)", "wire.x = 0.2 m; wire.vx = 0 m/s;", more)
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, stop=1.0, interval=0.1)
    np.testing.assert_allclose(t["wire.x"], 0.2 * np.cosh(3 * t.t), rtol=2e-5)
    push = np.cos(3 * t.t) * t["wire.fy"] - np.sin(3 * t.t) * t["wire.fx"]
    np.testing.assert_allclose(push, 3 * 2 * 3 * 0.6 * np.sinh(3 * t.t), rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(t["wire.fz"], 3 * G, rtol=1e-9)


def test_a_track_by_a_table():
    """A track over x whose height is a table, the same on both sides: the bead turns at the same height again."""
    rows = "-1 m, 0.9 m; -0.5 m, 0.2 m; 0 m, 0 m; 0.5 m, 0.2 m; 1 m, 0.9 m"
    text = bead(
        "PointOnCurve track(ground, bead, f1 = y - height(x), f2 = z)",
        "bead.x = 0.6 m; guess bead.y = 0.3 m; bead.vx = 0 m/s;",
        f'Table height(table = [{rows}], smoothness = "cubic");',
        "Ground ground",
    )
    t = mbdsl.simulate(mbdsl.parse(text), step=5e-4, stop=2.0, interval=1e-3)
    assert t["bead.x"].min() == pytest.approx(-0.6, abs=1e-4)
    assert t["energy.total"] == pytest.approx(t["energy.total"][0], abs=1e-4)


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        ("PointOnSurface s(ground, bead, f = x + bead.vx*(1 s))", "depends on `bead.c.vx`"),
        ("PointOnSurface s(ground, bead, f = x + time*(1 m/s))", "is a function of `x`, `y` and `z` alone"),
        ("PointOnSurface s(ground, bead)", "needs `f`"),
    ],
)
def test_messages(joint, said):
    with pytest.raises(mbdsl.ModelError, match=said.replace("(", r"\(")):
        mbdsl.parse(bead(joint, ""))
