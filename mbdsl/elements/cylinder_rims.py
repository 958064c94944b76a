"""CylinderContact without stiffness: a rigid cylinder of frame_b on a plane of frame_a, with friction; in space.

It touches at the lowest points of both rims, and of the lower end at the three points that are 90, 180 and 270 degrees
from the lowest one, on which it stands:

    p = -+length/2 a + radius m;   p_u = -w (3 - w^2)/2 length/2 a + radius (cos u m + sin u a x m)

with the axis a of the cylinder, w = n . a, and the direction of the lowest point

    m = (q + d c)/|q + d c|,   q = w a - n,   d = 1e-6

which an upright cylinder does not have, q = 0. There it has the direction c (``corner``) in the cylinder, that an event
has set: see :mod:`mbdsl.integrators.rim_corners`. It makes the gap too large by d times the radius at most. The factor
of the three points, which moves them to the centre of a lying cylinder, makes them smooth.
"""

from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.cylinder_contact import DOC, SHAPE, A, B
from mbdsl.elements.line_contact import SIDES, axes, check
from mbdsl.elements.point_contact import HEIGHT_IN_SPACE, NORMAL_IN_SPACE, TANGENTS
from mbdsl.elements.vectors import axis, dot, total

C = axis("frame_b", "z")
BLUNT = 1e-6  #: d
TERMS = {
    "leans": dot(NORMAL_IN_SPACE, A),
    "down": dot(NORMAL_IN_SPACE, B),
    "aside": dot(NORMAL_IN_SPACE, C),
    "qb": f"{BLUNT}*corner[1] - down",
    "qc": f"{BLUNT}*corner[2] - aside",
    "slope": f"hypot(hypot({BLUNT**2}, qb), qc)",
    "mb": "qb/slope",
    "mc": "qc/slope",
    "lower": "radius*(down*mb + aside*mc)",
    "along": "0.25*leans*(3 - leans*leans)*length",
}
LOWEST, ACROSS = total(("mb", B), ("mc", C)), total(("mb", C), ("(-mc)", B))


def points():
    for side in SIDES:
        arm = total((f"({side}*length)", A), ("radius", LOWEST))
        yield Point(f"{HEIGHT_IN_SPACE} + {side}*length*leans + lower", NORMAL_IN_SPACE, arm, TANGENTS)
    for where, height in (
        (("radius", ACROSS), "radius*(aside*mb - down*mc)"),
        (("(-radius)", LOWEST), "(-lower)"),
        (("(-radius)", ACROSS), "radius*(down*mc - aside*mb)"),
    ):
        arm = total(("(-along)", A), where)
        yield Point(f"{HEIGHT_IN_SPACE} - along*leans + {height}", NORMAL_IN_SPACE, arm, TANGENTS)


IN_SPACE = contact(
    "CylinderContact",
    DOC,
    SHAPE,
    list(points()),
    spatial=True,
    terms=TERMS,
    axes=axes,
    check=check,
    aim=("down", "aside"),
    variant="cylinder_rims",
    drawing="surface",
)
