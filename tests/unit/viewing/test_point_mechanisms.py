"""Pictures of gyroscopes whose frames are all at one point: their only lengths are those of solids."""

import numpy as np
import pytest

import mbdsl
from mbdsl import parse
from mbdsl.viewing.motion import motion
from mbdsl.viewing.projection import drawing as flat_drawing
from mbdsl.viewing.projection import projected
from mbdsl.viewing.shapes import outline
from mbdsl.viewing.space.shapes import drawing, edge

ROUNDING = 1e-17  # [m]: simulations displace the bodies from the point by this order


def gyroscope(outer="Body hoop(m = 1 kg, I = {0.01, 0.01, 0.02} kg.m2)", scale=1.0, rotor=""):
    """Thin discs of radii 0.2 m and 0.1 m: C = m r^2/2; ``scale`` multiplies lengths of the rotor and of the ring."""
    a, c = 0.005 * scale**2, 0.01 * scale**2
    return f"""spatial model A Ground ground(n = {{0, 0, -1}}); {outer};
      Body ring(m = 12 kg, I = {{{0.05 * scale**2}, {0.1 * scale**2}, {0.13 * scale**2}}} kg.m2);
      Body rotor(m = 2 kg, I = {{{c}, {a}, {a}}} kg.m2{rotor});
      Revolute O(ground, hoop.c, n = {{0, 0, 1}}); Revolute M(hoop.c, ring.c, n = {{0, 1, 0}});
      Revolute R(ring.c, rotor.c, n = {{1, 0, 0}});
      RotationalSpringDamper twist(ring.c, rotor.c, n = {{1, 0, 0}}, k = 1 N.m/rad); end A;"""


@pytest.fixture
def at_a_point(trajectory_of):
    def made(text):
        scene = parse(text)
        states = {c.name: np.full((1, len(c.kind.coordinates)), 0.0) for c in scene.bodies()}
        for k, values in enumerate(states.values()):
            values[0, :3] = (k + 1) * ROUNDING
        return trajectory_of(scene, [0.0], states)

    return made


def sizes(drawn):
    return {s.name: (s.draw, *np.sort(s.size)[::-1]) for s in drawn.solids if s.role == "body"}


@pytest.mark.parametrize(
    "outer",
    [
        "Body hoop(m = 1 kg, I = {0.01, 0.01, 0.02} kg.m2)",
        "Cylinder hoop(m = 1 kg, radius = 20 mm, length = 10 mm)",  # smaller than the others, which are drawn
    ],
)
@pytest.mark.parametrize("rotor", ["", ", frames(eccentric = {0, 0, 1} mm)"])
def test_solids_are_the_size_of_a_gyroscope(at_a_point, outer, rotor):
    """The box around a cuboid 0.3 x 0.2 x 0.1 m, a disc of radius 0.1 m across x, and the outer ring."""
    drawn = drawing(motion(at_a_point(gyroscope(outer, rotor=rotor))))
    found = sizes(drawn)
    assert found["ring"][0] == "box" and found["ring"][1:] == pytest.approx((0.3, 0.2, 0.1))
    assert found["rotor"][0] == "cylinder" and found["rotor"][1:3] == pytest.approx((0.1, 0.1))
    radius = 0.02 if "Cylinder" in outer else 0.2
    assert found["hoop"][1:3] == pytest.approx((radius, radius))
    x, y = max(0.15, radius), max(0.1, radius)
    assert drawn.bounds[1] == pytest.approx([x, y, 0.1], abs=1e-12)
    assert drawn.size == pytest.approx(2 * np.hypot(np.hypot(x, y), 0.1))
    assert 0.01 * drawn.size < drawn.unit < 0.1 * drawn.size


def test_twice_as_large_solids_are_a_twice_as_large_picture(at_a_point):
    """Moments of inertia of the same mass are proportional to the square of the lengths."""
    outer = "Body hoop(m = 1 kg, I = {0.04, 0.04, 0.08} kg.m2)"
    small, large = (drawing(motion(at_a_point(text))) for text in (gyroscope(), gyroscope(outer, 2.0)))
    assert large.size == pytest.approx(2 * small.size) and large.unit == pytest.approx(2 * small.unit)
    assert large.bounds == pytest.approx(2 * small.bounds)


@pytest.mark.parametrize(
    ("box", "shown"), [("", False), ("Box big(m = 1 kg, length = 4 m, width = 1, height = 1);", True)]
)
def test_derived_solids_are_not_larger_than_mechanisms_of_some_length(trajectory_of, box, shown):
    """A ball of radius sqrt(5/2) m at an arm of 0.1 m is drawn only if the model has a solid of this size."""
    scene = parse(
        f"""spatial model A Ground g; Rod arm(m = 1 kg, length = 0.1 m); Body ball(m = 1 kg, I = {{1, 1, 1}} kg.m2);
        {box} Revolute p(g, arm.a); Spherical q(arm.b, ball.c); {"FreeMotion f(g, big.c);" if box else ""} end A;"""
    )
    states = {c.name: np.zeros((1, 6)) for c in scene.bodies()}
    states["arm"][0, 0], states["ball"][0, 0] = 0.05, 0.1
    drawn = drawing(motion(trajectory_of(scene, [0.0], states)))
    (radius,) = {s.size[0] for s in drawn.solids if s.name == "ball" and s.draw == "ball"}
    if shown:
        assert radius == pytest.approx(np.sqrt(2.5))
    else:
        assert radius < 0.01  # the symbol of a mass


def test_without_any_length_symbols_have_the_size_of_one_metre(at_a_point):
    """A point mass that rounding moves: in the page and in films."""
    run = at_a_point("spatial model A Ground g; PointMass m(m = 1 kg); Spherical s(g, m); end A;")
    drawn, flat = drawing(motion(run)), flat_drawing(projected(run))
    assert (drawn.size, drawn.unit, flat.unit) == (1.0, 1.0, 1.0)
    assert flat.bounds[:2] == flat.bounds[2:]


def test_films_show_cuboids_as_plates(at_a_point):
    """From above, the largest section of 0.3 x 0.2 m; the disc across x is a line."""
    found = projected(at_a_point(gyroscope()), "top")
    areas = {s.name: s.items[0].at for s in flat_drawing(found).shapes if s.name in ("ring", "rotor")}
    ring = np.array(outline(found.places(areas["ring"], 0)[:, :2].tolist()))
    rotor = found.places(areas["rotor"], 0)[:, :2]
    assert np.abs(ring) == pytest.approx(np.tile([0.15, 0.1], (4, 1)))
    # each edge is along an axis: neighbours differ in one coordinate
    assert np.sort(np.abs(ring - np.roll(ring, 1, axis=0)), axis=1)[:, 0] == pytest.approx(np.zeros(4), abs=1e-12)
    assert np.abs(rotor).max(axis=0) == pytest.approx([0.004, 0.1], abs=1e-12)  # half the thickness: 4 % of the radius


def test_modes_of_a_gyroscope_displace_its_edges():
    """The rotor swings about x with sqrt(k/C), k = 1 N.m/rad, C = 0.01 kg.m2; free modes turn the rest. The edges move
    by at most a tenth of the diagonal of the picture at rest, and the modes with edges that move by so much."""
    modes = mbdsl.eigen(parse(gyroscope()))
    page = modes.animate()
    rest, shapes = page.shapes.rest, page.shapes
    corners = [place for s in drawing(rest).sized for place in edge(s)]
    points = np.concatenate([rest.positions(place) for place in corners])
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert diagonal == pytest.approx(
        np.linalg.norm([0.4, 0.4, 0.2]), rel=1e-3
    )  # of a ring of radius 0.2 m and the cuboid
    assert shapes.largest == pytest.approx(np.full(len(modes), 0.1 * diagonal))
    low, high = page._drawing.bounds
    assert diagonal <= np.linalg.norm(high - low) <= 1.4 * diagonal + 1e-12
    centres = [np.abs(shapes.tracks[:, rest.spots[f"{name}.c"].track, :3]).max() for name in ("ring", "rotor")]
    assert max(centres) < 1e-9


def test_modes_without_any_length_move_by_a_tenth_of_a_metre():
    """A free mass, and a frame of the ground that is apart from it by rounding."""
    text = """spatial model A Ground ground(g = 0); Frame base(ground, r = {1e-17, 0, 0}); PointMass m(m = 1 kg);
      FreeMotion f(base, m); end A;"""
    assert mbdsl.eigen(parse(text)).animate().shapes.largest == pytest.approx([0.1, 0.1, 0.1])
