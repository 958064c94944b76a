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
from mbdsl.elements.vectors import axis, dot, total

A, B, C = (axis("frame_b", i) for i in "xyz")
#: components of the normal along the axes of frame_b, and those of the direction m from a vector (toward_b, toward_c)
NORMAL_IN_B = {"leans": dot(NORMAL_IN_SPACE, A), "down": dot(NORMAL_IN_SPACE, B), "aside": dot(NORMAL_IN_SPACE, C)}
LOWEST, ACROSS = total(("mb", B), ("mc", C)), total(("mb", C), ("(-mc)", B))
TERMS = {
    **NORMAL_IN_B,
    "toward_b": "1e-5 - down",
    "toward_c": "-aside",
    "slope": "hypot(toward_b, toward_c)",
    "mb": "ratio(toward_b, slope)",
    "mc": "ratio(toward_c, slope)",
}


def on_rim(end, c, s):
    """The point of the rim with the centre ``end`` a, at the angle with the cosine c and the sine s from m."""
    arm = total((end, A), (f"({c}*radius)", LOWEST), (f"({s}*radius)", ACROSS))
    height = f"radius*({c}*(down*mb + aside*mc) + {s}*(aside*mb - down*mc))"
    return Point(f"{HEIGHT_IN_SPACE} + {end}*leans + {height}", NORMAL_IN_SPACE, arm)


def rims():
    for side in SIDES:
        for c, s in ((1.0, 0.0), (-0.5, 0.5 * sqrt(3.0)), (-0.5, -0.5 * sqrt(3.0))):
            yield on_rim(f"({side}*length)", c, s)


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
    terms=TERMS,
    specialised=specialised("cylinder_rims"),
    axes=axes,
    check=check,
    derive=lambda values: {"corner": (None, None)},  # set at events
    drawing="surface",
)
