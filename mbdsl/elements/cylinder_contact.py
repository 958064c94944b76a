"""CylinderContact: a circular cylinder of frame_b on a plane of frame_a, with friction; in space.

It acts at three points of each rim: the lowest one, and those at -+120 degrees from it. With the axis a of the cylinder
and the normal n of the plane, the rim with the centre e = -+length/2 a has

    m = (q + 1e-5 y_b)/|q + 1e-5 y_b|,  q = (n . a) a - n;   p = e + radius (c m + s a x m)

(c, s) = (1, 0), (-1/2, -+3^(1/2)/2). An upright cylinder has no lowest point, but the small term along an axis y_b of
the cylinder; the forces of three points at equal angles do not depend on the direction of the first one (they are
linear in q, for a linear law). A lying cylinder acts at two points, and rolls. See contact_points.py; without stiffness
it is of the kind in cylinder_rims.py.
"""

from math import sqrt

from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.line_contact import AXIS, SIDES, axes, check
from mbdsl.elements.point_contact import HEIGHT_IN_SPACE, NORMAL_IN_SPACE, N
from mbdsl.elements.rigid_contact import specialised
from mbdsl.elements.vectors import axis, cross, dot, total

A, B = axis("frame_b", "x"), axis("frame_b", "y")
LOWEST = ("lowest_x", "lowest_y", "lowest_z")
ACROSS = cross(A, LOWEST)


def terms():
    """The direction m of the lowest point."""
    q = total((dot(NORMAL_IN_SPACE, A), A), ("-1", NORMAL_IN_SPACE), ("1e-5", B))
    found = {f"q{i}": x for i, x in zip("xyz", q, strict=True)}
    found["slope"] = "hypot(hypot(qx, qy), qz)"
    return found | {name: f"ratio(q{name[-1]}, slope)" for name in LOWEST}


def rims():
    for side in SIDES:
        for c, s in ((1.0, 0.0), (-0.5, 0.5 * sqrt(3.0)), (-0.5, -0.5 * sqrt(3.0))):
            arm = total((f"({side}*length)", A), (f"({c}*radius)", LOWEST), (f"({s}*radius)", ACROSS))
            yield Point(f"{HEIGHT_IN_SPACE} + {dot(NORMAL_IN_SPACE, arm)}", NORMAL_IN_SPACE, arm)


DOC = (
    "A circular cylinder about the origin of frame_b on the plane through the origin of frame_a, which pushes its rims "
    "to the side of n; with friction."
)
SHAPE = (
    Parameter("length", "m", doc="length along the axis", positive=True),
    Parameter("radius", "m", doc="radius", positive=True),
    AXIS,
    N,
)
IN_SPACE = contact(
    "CylinderContact",
    DOC,
    SHAPE,
    list(rims()),
    spatial=True,
    terms=terms(),
    specialised=specialised("cylinder_rims"),
    axes=axes,
    check=check,
    derive=lambda values: {"corner": (None, None)} if values["k"] is None else {},
    drawing="surface",
)
