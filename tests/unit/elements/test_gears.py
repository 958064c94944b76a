"""Gears, racks, belts, cams, stops and contacts against the mechanics of rigid bodies, without any run."""

import numpy as np
import pytest

import mbdsl
from mbdsl.elements import (
    belt_drive,
    cam,
    contact_law,
    gear_pair,
    loaded,
    rack_and_pinion,
    rotational_cam,
)
from mbdsl.errors import ModelError
from mbdsl.expressions.symbolic import evaluate
from mbdsl.kernels.columns import PLANE as C
from mbdsl.system import row_kernels

ROUNDING = 1e-13  #: of a few dozen operations on numbers of order 1
R_A, R_B, PHI0 = 0.3, 0.8, 0.4


def pose(*rows):
    """Frames a and b: position as a complex number, angle."""
    return np.array([[r.real, r.imag, phi, 0.0, 0.0, 0.0] for r, phi in rows])


def g_and_rate(module, p, Z, rates, plain):
    """g, and its rate for the rates (2, 3) of the frames."""
    G = np.zeros((1, C.VALUE + 1))
    plain(row_kernels.module(loaded(module.__name__)).gradient)(Z, 0, 1, p, G)
    return G[0, C.VALUE], G[0, :6] @ np.asarray(rates, float).ravel()


def velocity(Z, rates, frame, point):
    """Velocity of the material point of a body, complex."""
    v, w = complex(*rates[frame, :2]), rates[frame, 2]
    return v + 1j * w * (point - complex(*Z[frame, :2]))


@pytest.mark.parametrize("internal", [False, True])
def test_teeth_meet_with_one_velocity_along_the_pitch_circles(internal, plain):
    """The rate of g is the velocity of gear a less that of gear b, along the tangent where the pitch circles touch."""
    rng = np.random.default_rng(1)
    for _ in range(5):
        line = np.exp(1j * rng.uniform(-3, 3))
        a = complex(*rng.uniform(-1, 1, 2))
        Z = pose((a, rng.uniform(-3, 3)), (a + (R_A - R_B if internal else R_A + R_B) * line, rng.uniform(-3, 3)))
        rates = rng.uniform(-1, 1, (2, 3))
        rates[1, :2] = rates[0, :2] + rng.uniform(-1, 1) * np.array([-line.imag, line.real])  # at the same distance
        touch = a + R_A * line
        slip = ((velocity(Z, rates, 0, touch) - velocity(Z, rates, 1, touch)) / (1j * line)).real
        p = (R_A, -R_B if internal else R_B, 0.0)
        assert g_and_rate(gear_pair, p, Z, rates, plain)[1] == pytest.approx(slip, abs=ROUNDING)


@pytest.mark.parametrize("crossed", [False, True])
def test_strands_of_a_belt_keep_their_lengths(crossed, plain):
    """The rate of g is the velocity of pulley a less that of pulley b along a strand, where it leaves them."""
    rng, distance, sense = np.random.default_rng(2), 1.7, -1.0 if crossed else 1.0
    lean = np.arccos((R_A - sense * R_B) / distance)  # of the radii to the ends of a strand, from the line of centres
    for _ in range(5):
        line = np.exp(1j * rng.uniform(-3, 3))
        Z = pose((0j, rng.uniform(-3, 3)), (distance * line, rng.uniform(-3, 3)))
        rates = np.zeros((2, 3))
        rates[:, 2] = rng.uniform(-1, 1, 2)
        out = line * np.exp(1j * lean)
        ends = R_A * out, distance * line + sense * R_B * out
        along = (ends[1] - ends[0]) / abs(ends[1] - ends[0])
        stretch = ((velocity(Z, rates, 1, ends[1]) - velocity(Z, rates, 0, ends[0])) * along.conjugate()).real
        p = (R_A, -sense * R_B, 0.0)
        assert g_and_rate(belt_drive, p, Z, rates, plain)[1] == pytest.approx(stretch, abs=ROUNDING)


def test_a_planet_keeps_its_tooth_over_turns_of_the_carrier(plain):
    """Willis: of a sun at rest the planet turns (1 + R_A/R_B) times as fast as the carrier; g is zero all the way."""
    p = (R_A, R_B, R_B * PHI0)
    for carrier in np.linspace(-20.0, 20.0, 321):
        Z = pose((0j, 0.0), ((R_A + R_B) * np.exp(1j * carrier), PHI0 + (1 + R_A / R_B) * carrier))
        assert g_and_rate(gear_pair, p, Z, np.zeros((2, 3)), plain)[0] == pytest.approx(0.0, abs=1e-12)
        Z[1, 2] += 0.1
        assert g_and_rate(gear_pair, p, Z, np.zeros((2, 3)), plain)[0] == pytest.approx(0.1 * R_B, abs=1e-12)


@pytest.mark.parametrize(
    ("module", "choice", "side"),
    [
        (gear_pair, {"internal": False}, 1.0),
        (gear_pair, {"internal": True}, -1.0),  # the line is that from frame_b to frame_a, on which the circles touch
        (belt_drive, {"crossed": False}, 1.0),
        (belt_drive, {"crossed": True}, 1.0),
    ],
)
def test_phi0_is_the_angle_of_frame_b_where_frame_a_and_the_line_are_at_zero(module, choice, side, plain):
    values = {"r_a": R_A, "r_b": R_B, "phi0": PHI0, **choice}
    p = module.KIND.table({**values, **module.KIND.derive(values)})
    for turned, expected in ((0.0, 0.0), (0.1, 0.1 * R_B)):
        Z = pose((0.2 + 0.1j, 0.0), (0.2 + 0.1j + side * 1.7, PHI0 + turned))
        assert abs(g_and_rate(module, p, Z, np.zeros((2, 3)), plain)[0]) == pytest.approx(expected, abs=ROUNDING)


def test_a_pinion_rolls_on_the_pitch_line(plain):
    """The rate of g is the velocity of pinion less rack along the rack, where they touch; the rack may turn."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        axis = np.exp(1j * (phi := rng.uniform(-3, 3)))
        Z = pose((0.2 + 0.1j, phi), (0.2 + 0.1j + axis * (0.7 + 1j * R_A), rng.uniform(-3, 3)))
        rates = rng.uniform(-1, 1, (2, 3))
        touch = complex(*Z[1, :2]) - 1j * axis * R_A
        slip = ((velocity(Z, rates, 1, touch) - velocity(Z, rates, 0, touch)) / axis).real
        assert g_and_rate(rack_and_pinion, (R_A, 0.2), Z, rates, plain)[1] == pytest.approx(slip, abs=ROUNDING)
    Z = pose((0j, 0.0), (0.2 + 1j * R_A, 0.0))
    assert g_and_rate(rack_and_pinion, (R_A, 0.2), Z, rates, plain)[0] == pytest.approx(0.0, abs=ROUNDING)


def test_a_flat_follower_touches_where_the_cam_pushes_it(plain):
    """An eccentric disc (radius r, eccentricity e) under a plate: s = r + e cos(angle of its centre from the axis)."""
    rng, r, e = np.random.default_rng(4), 0.5, 0.2
    for _ in range(5):
        axis, phi_a = np.exp(1j * (phi_b := rng.uniform(-3, 3))), rng.uniform(-3, 3)
        angle = phi_a - phi_b
        lift = (r + e * np.cos(angle), -e * np.sin(angle), -e * np.cos(angle))
        touch = e * np.exp(1j * phi_a) + r * axis
        Z = pose((0j, phi_a), (lift[0] * axis, phi_b))
        rates = np.array([[0, 0, 1.3], [*(0.7 * np.array([axis.real, axis.imag])), 0]])
        g, rate = g_and_rate(cam, lift, Z, rates, plain)
        gap = ((velocity(Z, rates, 1, touch) - velocity(Z, rates, 0, touch)) / axis).real
        assert g == pytest.approx(0.0, abs=ROUNDING) and rate == pytest.approx(gap, abs=ROUNDING)


def test_a_rotational_cam_with_a_constant_ratio_is_a_gear_pair(plain):
    rng = np.random.default_rng(5)
    for _ in range(5):
        Z, rates = rng.uniform(-1, 1, (2, 6)), rng.uniform(-1, 1, (2, 3))
        phi = Z[0, 2] - np.angle(complex(*(Z[1, :2] - Z[0, :2])))
        p = (-R_A / R_B * phi, -R_A / R_B, 0.0)
        expected = g_and_rate(gear_pair, (R_A, R_B, 0.0), Z, rates, plain)[1] / R_B
        assert g_and_rate(rotational_cam, p, Z, rates, plain)[1] == pytest.approx(expected, abs=1e-12)


# -- contacts ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("e", [0.1, 0.3, 0.5, 0.9])
def test_an_impact_at_the_given_speed_has_the_given_restitution(e):
    """Runge-Kutta of order 4 for d'' = -d (1 + D d'), d'(0) = 1: the speed at d = 0 again is -e."""
    D, h = contact_law.damping(e), 1e-3

    def rate(x):
        return np.array([x[1], -x[0] * (1 + D * x[1])])

    x = np.array([0.0, 1.0])
    while True:
        k1 = rate(x)
        k2 = rate(x + h / 2 * k1)
        k3 = rate(x + h / 2 * k2)
        new = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h * k3))
        if new[0] < 0.0:
            break
        x = new
    left = x[0] / -x[1]  # straight on for less than a step, whose acceleration is at most 1e-3 (1 + D)
    assert x[1] - left * x[0] == pytest.approx(-e, abs=2 * h**2 * (1 + D))


CONTACTS = """
model M
  Ground ground(g = 0);
  Body a(m = 1 kg, I = 1 kg.m2);
  Prismatic slide(ground, a.c);
  TranslationalStop stop(slide, s_min = -0.2 m, s_max = 0.5 m, k = 100 N/m, e = 0.5, v_0 = 2 m/s);
  TranslationalStop upper(slide, s_max = 0.5 m, k = 100 N/m);
  CircleContact touch(ground, a.c, r_a = 0.1 m, r_b = 0.2 m, k = 100 N/m, e = 0.5, v_0 = 2 m/s);
  CircleContact hole(ground, a.c, r_a = 0.5 m, r_b = 0.1 m, internal = true, k = 100 N/m);
end M;
"""


def at(s, v):
    """Signals of the contacts for a position and its rate."""
    scene = mbdsl.parse(CONTACTS)

    def leaf(node):
        frame, key = node.value
        return {"x": s, "vx": v}.get(key, 0.0) if frame == "a.c" else 0.0

    return lambda name: evaluate([scene.signal(name)], leaf)[0]


def test_stops_push_back_beyond_their_limits_and_never_pull():
    alpha = 1.4328 / 2  # D for e = 0.5, by tables of the equation for it
    assert at(0.6, 1.0)("stop.force") == pytest.approx(10 * (1 + alpha), rel=1e-4)
    assert at(-0.3, -1.0)("stop.force") == pytest.approx(-10 * (1 + alpha), rel=1e-4)
    assert at(0.6, 1.0)("upper.force") == pytest.approx(10.0, rel=1e-12)
    for s, v in ((0.49, 50.0), (-0.19, -50.0), (0.6, -50.0), (-0.3, 50.0)):
        assert at(s, v)("stop.force") == 0.0
    assert at(-9.0, 0.0)("upper.force") == 0.0


def test_circles_push_each_other_apart_and_never_pull():
    alpha = 1.4328 / 2
    assert at(0.25, -1.0)("touch.force") == pytest.approx(5 * (1 + alpha), rel=1e-4)
    assert at(0.25, -1.0)("touch.depth") == pytest.approx(0.05)
    assert at(0.25, 50.0)("touch.force") == at(0.31, -50.0)("touch.force") == 0.0
    assert at(0.45, 0.0)("hole.force") == pytest.approx(-5.0)  # back, towards the middle of the hole
    assert at(0.39, 9.0)("hole.force") == 0.0


# -- messages ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("declared", "said"),
    [
        ("GearPair g(a.c, b.c, r_a = 2 m, r_b = 1 m, internal = true);", "internal teeth"),
        ("BeltDrive g(a.c, b.c, r_a = 1 m, r_b = 1.0001 m);", "make them equal"),
        ("TranslationalStop g(a.c, b.c, k = 1 N/m);", "give `s_min`, `s_max` or both"),
        ("TranslationalStop g(a.c, b.c, k = 1 N/m, s_min = 1 m, s_max = 0 m);", "is not less than"),
        ("RotationalStop g(a.c, b.c, k = 1 N.m/rad, phi_min = 0 deg, e = 2, w_0 = 1 rad/s);", "between 0.05 and 1"),
        ("CircleContact g(a.c, b.c, k = 1 N/m, r_a = 1 m, r_b = 2 m, internal = true);", "has the hole"),
        ("Cam g(a.c, b.c, s = 1 m*sin(2*time));", "function of `phi` alone"),
        ("RotationalCam g(a.c, b.c, beta = phi + a.x/(1 m));", "function of `phi` alone"),
    ],
)
def test_wrong_values_are_explained(declared, said):
    text = f"model M Ground ground; Body a(m = 1, I = 1); Body b(m = 1, I = 1); {declared} end M;"
    with pytest.raises(ModelError) as caught:
        mbdsl.parse(text)
    assert said in str(caught.value)


def test_misspelled_shapes_are_not_foreign_annotations():
    text = "model M Ground ground; Rod rod(m = 1, length = 1) annotation(Shap(Circle(radius = 1 cm))); end M;"
    with pytest.raises(ModelError, match="there is no annotation `Shap`"):
        mbdsl.parse(text)


# -- centres -----------------------------------------------------------------------------------------------------------
GEARS = """
model Gears
  Ground ground(frames(shaft = {0.09 m, 0}, near = {0.02 m, 0}));
  Body a(m = 1 kg, I = 1e-3 kg.m2); Body b(m = 2 kg, I = 4e-3 kg.m2);
  Revolute pin(ground, a.c); Revolute axle(ground.shaft, b.c);
  GearPair mesh(a.c, b.c, r_a = 30 mm, r_b = 60 mm);
  annotation(experiment(StopTime = 0.01 s, Step = 5 ms));
end Gears;
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0.09 m", "0.09 m", None),
        ("0.09 m", "-90.5 mm", None),  # backlash
        ("0.09 m", "0.095 m", "GearPair mesh: its centres are 0.095 m apart, but its pitch circles touch at 0.09 m"),
        ("mm);", "mm, internal = true);", "apart, but its pitch circles touch at 0.03 m"),
        ("ground.shaft", "ground.near", "its pitch circles touch at 0.09 m"),
    ],
)
def test_centres_that_do_not_fit_cause_a_warning(old, new, said):
    warnings = mbdsl.simulate(mbdsl.parse(GEARS.replace(old, new))).stats["warnings"]
    assert not warnings if said is None else [said in text for text in warnings] == [True]


def test_coincident_centres_are_refused():
    with pytest.raises(mbdsl.InitialisationError, match="centres of GearPair mesh coincide"):
        mbdsl.simulate(mbdsl.parse(GEARS.replace("0.09 m, 0", "0, 0")))


CAM = """
model Planet
  Ground ground;
  Rod carrier(m = 1 kg, length = 1 m); Body sun(m = 1 kg, I = 0.1 kg.m2); Body planet(m = 1 kg, I = 0.1 kg.m2);
  Revolute O(ground, carrier.a); Revolute S(ground, sun.c); Revolute P(carrier.b, planet.c);
  RotationalCam cam(sun.c, planet.c, beta = -2*phi);
  RotationalDriver drive(O, phi = 2 rad/s*time);
initial equation
  sun.w = 1 rad/s;
  annotation(experiment(StopTime = 4 s, Step = 5 ms, Interval = 5 ms));
end Planet;
"""


def test_a_line_of_centres_turns_with_whole_turns_only():
    """With -2 the sun and the planet are gears of this ratio on the carrier: w_planet = 2 - 2 (w_sun - 2) by Willis."""
    run = mbdsl.simulate(mbdsl.parse(CAM))
    assert run["planet.w"] == pytest.approx(2 - 2 * (run["sun.w"] - 2), abs=1e-9)
    with pytest.raises(mbdsl.IntegrationError) as caught:
        mbdsl.simulate(mbdsl.parse(CAM.replace("-2*phi", "-1.3*phi")))
    assert "`beta` changes by -1.3 turns when `phi` changes by one" in str(caught.value)
    passes = (0.6 + np.pi) / 2  # the carrier reaches 0.6 rad + pi
    assert f"after t = {passes - passes % 0.005:g} s" in str(caught.value)
    swings = CAM.replace("-2*phi", "-1.3*phi").replace("2 rad/s*time", "sin(2 rad/s*time)")
    run = mbdsl.simulate(mbdsl.parse(swings))
    w = 2 * np.cos(2 * run.t)
    assert run["planet.w"] == pytest.approx(w - 1.3 * (run["sun.w"] - w), abs=1e-9)
    wide = swings.replace("sin(2 rad/s*time)", "1.8 rad*cos(2 rad/s*time)")
    # from 1.8 to -1.7 rad between two output times, by way of zero
    run = mbdsl.simulate(mbdsl.parse(wide.replace("Interval = 5 ms", "Interval = 1.4 s")))
    w = -3.6 * np.sin(2 * run.t)
    assert run["planet.w"] == pytest.approx(w - 1.3 * (run["sun.w"] - w), abs=1e-9)
