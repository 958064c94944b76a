"""Symbols of the elements of machines: cylinders, ropes, turning dampers, limits of angles, and solids of contacts."""

import numpy as np
import pytest

from mbdsl import parse
from mbdsl.viewing.motion import motion
from mbdsl.viewing.shapes import drawing
from mbdsl.viewing.space import shapes as space

T = np.linspace(0.0, 1.0, 5)


def drawn(shapes):
    """Element -> what is drawn for it."""
    found = {}
    for shape in shapes:
        found.setdefault(shape.name, []).append(shape.draw)
    return found


ARM = """{} M Ground ground; Rod arm(m = 1 kg, length = 2 m); Real p(start = 0 N);
  Revolute pin(ground, arm.a); {} equation der(p) = 1 N/s; end M;"""
FORCES = """SpringDamper cylinder(ground, arm.b, force = p), gas(ground, arm.b, force = 1 N/m*s);
  RotationalSpringDamper motor(pin, torque = p*(1 m)), brake(pin, c = 1 N.m.s), spring(pin, k = 1 N.m);"""


def turning(trajectory_of, text):
    """An arm of 2 m that turns about the origin by one radian."""
    arm = np.column_stack([np.cos(T), np.sin(T), *([T] if text.startswith("model") else [0 * T, 0 * T, 0 * T, T])])
    return motion(trajectory_of(parse(text), T, {"arm": arm}))


@pytest.mark.parametrize(
    ("model", "brake"),
    [("model", ["vane"]), ("spatial model", ["cylinder"])],
)
def test_a_force_that_reads_no_coordinate_of_its_frames_is_an_actuator(trajectory_of, model, brake):
    moving = turning(trajectory_of, ARM.format(model, FORCES))
    shapes = space.drawing(moving).solids if "spatial" in model else drawing(moving).shapes
    found = drawn(shapes)
    spatial = "spatial" in model
    assert ("piston" if spatial else "actuator") in found["cylinder"]
    assert ("coil" if spatial else "spring") in found["gas"]
    assert found["motor"] == ["ring" if spatial else "turning"]
    assert found["brake"] == brake
    assert found["spring"] == ["spiral"]


HOIST = """model Hoist Ground ground(frames(well = {0.05, 0, -90 deg})); Body wheel(m = 1 kg, I = 1 kg.m2);
  Body load(m = 1 kg, I = 1 kg.m2); Revolute axis(ground, wheel.c); Prismatic shaft(ground.well, load.c);
  Coupling rope(axis.phi, shaft.s, ratio = %s, offset = 0.3 m); end Hoist;"""


@pytest.mark.parametrize(("ratio", "shown"), [("-50 mm", True), ("-40 mm", False)])
def test_a_coupling_with_the_geometry_of_a_drum_is_a_rope(trajectory_of, ratio, shown):
    """The load moves on the tangent x = 50 mm of the drum, by 50 mm a radian."""
    down = 0.3 - 0.05 * T
    states = {"wheel": np.column_stack([0 * T, 0 * T, T]), "load": np.column_stack([0.05 + 0 * T, -down, 0 * T])}
    moving = motion(trajectory_of(parse(HOIST % ratio), T, states))
    ropes = [x for x in drawing(moving).shapes if x.draw == "rope"]
    assert len(ropes) == shown
    for rope in ropes:
        ends = [moving.positions(spot) for spot in rope.at]
        assert ends[0] == pytest.approx(np.tile([0.05, 0.0], (5, 1)), abs=1e-12)
        assert ends[1] == pytest.approx(np.column_stack([0.05 + 0 * T, -down]), abs=1e-12)


def test_limits_of_an_angle_are_walls_at_these_angles(trajectory_of):
    moving = turning(trajectory_of, ARM.format("model", "RotationalStop ends(pin, phi_min = 30 deg, k = 1 N.m);"))
    (wall,) = (x for x in drawing(moving).shapes if x.draw == "wall")
    angles = [np.degrees(np.arctan2(y, x)) for x, y in wall.items[0].units]
    assert angles == pytest.approx([30.0, 30.0], abs=0.01)
    assert any(x.name == "ends" and x.draw == "stop" for x in drawing(moving).shapes)


def test_a_rail_touches_the_shape_of_its_body(trajectory_of):
    """The lowest point of the cart is 70 mm below its centre, its ends are 100 mm before and behind it."""
    text = """model M Ground ground; Body cart(m = 1 kg, I = 1 kg.m2) annotation(Shape(
        Rectangle(extent = {{-100, -40}, {100, 30}} mm), Circle(radius = 30 mm, center = {0, -40} mm)));
      Prismatic rail(ground, cart.c); end M;"""
    moving = motion(trajectory_of(parse(text), T, {"cart": np.column_stack([T, 0 * T, 0 * T])}))
    (rail,) = (x.items[0] for x in drawing(moving).shapes if x.draw == "guide")
    assert np.array(rail.metres) == pytest.approx(np.array([(-0.1, -0.07), (1.1, -0.07)]), abs=1e-4)


SOLIDS = {
    "BoxContact c(ground, b.c, length = 1 m, width = 2 m, height = 3 m, k = 1 N/m)": {"box": [(1, 2, 3)]},
    "CylinderContact c(ground, b.c, length = 1 m, radius = 2 m, k = 1 N/m)": {"cylinder": [(2, 2, 1)]},
    "LineContact c(ground, b.c, length = 1 m, radius = 2 m, k = 1 N/m)": {
        "cylinder": [(2, 2, 1)],
        "ball": [(2,) * 3] * 2,
    },
    "PointContact c(ground, b.c, radius = 2 m, k = 1 N/m)": {"ball": [(2,) * 3]},
    "SphereBoxContact c(ground, b.c, radius = 4 m, length = 1 m, width = 2 m, height = 3 m, k = 1 N/m)": {
        "box": [(1, 2, 3)],
        "ball": [(4,) * 3],
    },
    "SphereCylinderContact c(ground, b.c, radius = 4 m, length = 1 m, R = 2 m, k = 1 N/m)": {
        "cylinder": [(2, 2, 1)],
        "ball": [(4,) * 3],
    },
    "SphereCapsuleContact c(ground, b.c, radius = 4 m, length = 1 m, R = 2 m, k = 1 N/m)": {
        "cylinder": [(2, 2, 1)],
        "ball": [(2,) * 3, (2,) * 3, (4,) * 3],
    },
}


@pytest.mark.parametrize("contact", SOLIDS)
def test_contacts_in_space_show_what_touches(trajectory_of, contact):
    text = (
        f"spatial model M Ground ground; Body b(m = 1 kg, I = 1 kg.m2); FreeMotion free(ground, b.c); {contact}; end M;"
    )
    moving = motion(trajectory_of(parse(text), T, {"b": np.column_stack([0 * T, 0 * T, T, 0 * T, 0 * T, 0 * T])}))
    found = {}
    for solid in space.drawing(moving).solids:
        if solid.role == "body":
            found.setdefault(solid.draw, []).append(solid.size)
    assert found == SOLIDS[contact]


def test_symbols_are_small_beside_a_row_of_small_solids(trajectory_of):
    """Thirty bricks of 8 mm in a row of 1.2 m: hinges are no larger than the bricks, but visible."""
    text = """spatial model Row Ground ground; Frame foot[30](ground, r = {{i*40 mm, 0 m, 0 m} for i in 1:30});
      Box brick[30](each m = 8 g, each length = 8 mm, each width = 24 mm, each height = 48 mm);
      Revolute hinge[30](frame_a = foot, frame_b = brick.c); end Row;"""
    states = {f"brick[{i}]": np.column_stack([0.04 * i + 0 * T, *[0 * T] * 5]) for i in range(1, 31)}
    found = space.drawing(motion(trajectory_of(parse(text), T, states)))
    assert 0.012 * found.size <= found.unit < 0.02
