"""Solids on planes, and balls on solids, in space: rigid contacts with friction against closed forms.

A rigid cylinder touches by the lowest points of its rims; upright it stands on corners that move towards its load.
"""

from math import atan, cos, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import UsageError

G = 9.81
M, R, L = 2.0, 0.1, 0.3  #: of the cylinder
ABOUT_AXIS, ACROSS = M * R**2 / 2, M * (3 * R**2 + L**2) / 12
UPRIGHT, LYING = (ACROSS, ACROSS, ABOUT_AXIS), (ACROSS, ABOUT_AXIS, ACROSS)
FIXED = {"method": "hht-si2", "step": 5e-3}
BALL = (0.008,) * 3  #: of 2 kg, radius 0.1 m: 2/5 m r^2


def model(contact, start, inertia, slope=0.0, azimuth=0.0, stop=0.2):
    """A body on a plane z = 0 or on a solid, with gravity that is inclined by ``slope`` towards ``azimuth`` from x."""
    down = sin(slope) * cos(azimuth), sin(slope) * sin(azimuth), -cos(slope)
    rest = "".join(f" b.{x} = 0;" for x in ("x", "y", "vx", "vy", "vz", "wx", "wy", "wz") if f"b.{x} =" not in start)
    return mbdsl.parse(f"""
spatial model OnPlane
  Ground ground(n = {{{", ".join(map(repr, down))}}});
  Body b(m = {M}, I = {{{", ".join(map(repr, inertia))}}} kg.m2);
  FreeMotion free(ground, b.c);
  {contact};
initial equation
  {start}{rest}
  annotation(experiment(StopTime = {stop} s));
end OnPlane;
""")


def cylinder(axis, e=0.0, mu=0.0):
    return f"CylinderContact c(ground, b.c, length = {L} m, radius = {R} m, axis = {{{axis}}}, e = {e}, mu = {mu})"


ON_A_SLOPE = {
    "ball on plane": ("PointContact c(ground, b.c, radius = 0.1 m", 0.0, BALL, 2 / 5),
    "capsule": ("LineContact c(ground, b.c, length = 0.3 m, radius = 0.1 m, axis = {0, 1, 0}", 0.0, LYING, 1 / 2),
    "cylinder": ("CylinderContact c(ground, b.c, length = 0.3 m, radius = 0.1 m, axis = {0, 1, 0}", 0.0, LYING, 1 / 2),
    "box": ("BoxContact c(ground, b.c, length = 0.4 m, width = 0.3 m, height = 0.2 m", 0.0, UPRIGHT, np.inf),
    "upright": ("CylinderContact c(ground, b.c, length = 0.2 m, radius = 0.1 m, axis = {0, 0, 1}", 0.0, BALL, np.inf),
    "on box": (
        "SphereBoxContact c(ground, b.c, radius = 0.1 m, length = 9 m, width = 2 m, height = 2 m",
        1.0,
        BALL,
        0.4,
    ),
    "on cylinder": ("SphereCylinderContact c(ground, b.c, radius = 0.1 m, length = 9 m, R = 1 m", 1.0, BALL, 0.4),
    "on capsule": ("SphereCapsuleContact c(ground, b.c, radius = 0.1 m, length = 9 m, R = 1 m", 1.0, BALL, 0.4),
}


@pytest.mark.parametrize(
    ("name", "mu", "options"),
    [
        ("ball on plane", 0.5, {}),
        ("capsule", 0.05, FIXED),
        ("cylinder", 0.5, FIXED),
        ("cylinder", 0.05, {"tol": 1e-6}),
        ("box", 0.5, FIXED),
        ("box", 0.2, FIXED),
        ("upright", 0.5, {"tol": 1e-6}),
        ("upright", 0.2, FIXED),
        ("on box", 0.05, FIXED),
        ("on cylinder", 0.5, FIXED),
        ("on capsule", 0.05, FIXED),
    ],
)
def test_on_a_slope(name, mu, options):
    """It rolls with g sin/(1 + c), I = c m r^2, or slides with g (sin - mu cos) where this is more; N = m g cos."""
    contact, height, inertia, c = ON_A_SLOPE[name]
    slope = 0.3
    scene = model(f"{contact}, e = 0.5, mu = {mu})", f"b.z = {height + 0.1} m;", inertia, slope)
    found = mbdsl.simulate(scene, **options)
    a = max(G * sin(slope) / (1 + c), G * (sin(slope) - mu * cos(slope)))
    np.testing.assert_allclose(found["b.x"], a * found.t**2 / 2, atol=1e-11)
    np.testing.assert_allclose(found["c.force"], M * G * cos(slope), rtol=1e-9)


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_a_tilted_cylinder_strikes_with_its_rim(mu):
    """The impulse acts at the lowest point: u_N+ = -e u_N-, and friction sticks or is mu P_N."""
    th, e, fall = 0.4, 0.5, 0.05
    x, z = R * cos(th) - L / 2 * sin(th), -(L / 2 * cos(th) + R * sin(th))  # of the point, from the centre of mass
    start = f"b.z = {fall - z} m; b.phi_x = 0; b.phi_y = {th}; b.phi_z = 0.5;"
    u = np.sqrt(2 * G * fall)
    stop = u / G + 1e-3
    found = mbdsl.simulate(model(cylinder("0, 0, 1", e, mu), start, UPRIGHT, stop=stop), **FIXED)
    # rows of the velocities of the point along the normal and the tangent in (vx, vz, wy)
    W, mass = np.array([[0, 1, -x], [1, 0, z]]), np.array([M, M, ACROSS])
    D = W / mass @ W.T
    P = np.linalg.solve(D, [(1 + e) * u, 0.0])
    if abs(P[1]) > mu * P[0]:
        P = np.array([1.0, mu * np.sign(P[1])])
        P *= (1 + e) * u / (D[0] @ P)
    v = P @ W / mass - (0, u + 1e-3 * G, 0)
    np.testing.assert_allclose([found[f"b.{k}"][-1] for k in ("vx", "vz", "wy", "wx")], [*v, 0.0], atol=1e-9)
    assert found["c.impulse_1"][-1] == pytest.approx(P[0])


def test_a_rim_whose_corners_do_not_settle_ends_the_run(monkeypatch):
    monkeypatch.setattr("mbdsl.integrators.rim_corners.MOST", 0)
    scene = model(cylinder("0, 0, 1", 0.0, 0.9), f"b.z = {L / 2} m;", UPRIGHT, atan(1.02 * R / (L / 2)), 0.4, stop=0.1)
    with pytest.raises(mbdsl.InitialisationError, match="no point of the rim of `c` was found at which it carries"):
        mbdsl.simulate(scene, **FIXED)


@pytest.mark.parametrize("azimuth", [0.0, 0.4])
@pytest.mark.parametrize("steep", [0.98, 1.02])
def test_an_upright_cylinder_tips_where_its_weight_leaves_the_circle(steep, azimuth):
    """At tan(slope) = r/(h/2), for all directions of the slope; then it turns about a point of the rim."""
    slope = atan(steep * R / (L / 2))
    contact = cylinder("0, 0, 1", 0.0, 0.9)
    found = mbdsl.simulate(model(contact, f"b.z = {L / 2} m;", UPRIGHT, slope, azimuth, stop=0.6), **FIXED)
    if steep < 1:
        assert found["b.z"][-1] == pytest.approx(L / 2, abs=1e-12)
        return
    far = np.hypot(R, L / 2)

    def rate(_, y):  # of the angle about the point, and its rate
        return y[1], M * G * far * sin(slope - atan(R / (L / 2)) + y[0]) / (ACROSS + M * far**2)

    w = solve_ivp(rate, (0, 0.6), [0.0, 0.0], rtol=1e-9, atol=1e-12).y[1, -1]
    assert found["b.wy"][-1] == pytest.approx(w * cos(azimuth), rel=5e-3)
    assert found["b.wx"][-1] == pytest.approx(-w * sin(azimuth), rel=5e-3, abs=1e-6)


def test_a_cylinder_rocks():
    """At the upright position the other side of the rim strikes. It multiplies the angular velocity by (J - 2 m r^2)/J,
    with J about a point of the rim (G. W. Housner, Bull. Seismol. Soc. Am. 53 (1963) 403-417)."""
    th = 0.2
    height = L / 2 * cos(th) + R * sin(th)
    start = f"b.z = {height} m; b.phi_x = 0; b.phi_y = {th}; b.phi_z = 0.3;"
    found = mbdsl.simulate(model(cylinder("0, 0, 1", 0.0, 0.9), start, UPRIGHT), interval=1e-3, **FIXED)
    J = ACROSS + M * (R**2 + L**2 / 4)
    w = np.sqrt(2 * M * G * (height - L / 2) / J)
    before, lost = J / 2 * w**2, J / 2 * w**2 * (1 - ((J - 2 * M * R**2) / J) ** 2)
    energy, struck = found["energy.total"][0] - found["energy.total"], found["c.impacts"] > 0
    assert struck.any()
    np.testing.assert_allclose(energy[~struck] / before, 0, atol=1e-3)
    np.testing.assert_allclose(energy[struck] / lost, 1, rtol=1e-2)


def test_a_cylinder_from_python_and_by_choice_of_contacts():
    """Dropped on its side: impacts at t1, t1 + 2 e u/g, ...; it rests after t1 (1 + e)/(1 - e)."""
    b = mbdsl.SpatialBuilder("Dropped")
    ground, body = b.Ground("ground", n=(0, 0, -1)), b.Body("b", m=M, I=LYING)
    b.FreeMotion("free", ground, body.c)
    b.CylinderContact("c", ground, body.c, length=L, radius=R, axis=(0, 1, 0), k=1e6, e=0.5)
    b.initial(body.z, R + 0.02)
    found = mbdsl.simulate(b, contacts="rigid", stop=0.25, **FIXED)
    t1 = np.sqrt(0.04 / G)
    np.testing.assert_allclose(np.interp(1.5 * t1, found.t, found["b.z"]), R + 0.005, atol=1e-4)
    assert found["b.z"][found.t > 3 * t1] == pytest.approx(R, abs=1e-9)
    assert found["c.force_1"][-1] == pytest.approx(M * G / 2)


def test_time_stepping_refuses_cylinders():
    scene = model(cylinder("0, 0, 1"), f"b.z = {L / 2} m;", UPRIGHT)
    with pytest.raises(UsageError, match=r"does not support `c`, a rigid cylinder: the points"):
        mbdsl.simulate(scene, method="moreau-jean", step=1e-3)
