"""CylinderContact without stiffness: a rigid cylinder of frame_b on a plane of frame_a, with friction; in space.

It touches at the lowest points of both rims, and of the lower end at the three points that are 90, 180 and 270 degrees
from the lowest one, on which it stands:

    p = -+length/2 a + radius m;   p_u = -w (3 - w^2)/2 length/2 a + radius (cos u m + sin u a x m)

with the axis a of the cylinder, w = n . a, and the direction of the lowest point

    m = p/|p|,   p = ((1 - b) q . c + b s) q + d^2 c,   q = w a - n,   s = |q|,   b = s^4/(s^4 + 0.2^4),   d = 1e-6

which is q/s with two exceptions. An upright cylinder has no lowest point: there m has the direction c (``corner``) in
the cylinder, which an event has set (:mod:`mbdsl.integrators.rim_corners`). This makes the gap too large by d times the
radius at most. And where a cylinder that rocks passes the upright position, the lowest point jumps to the other side: m
does not follow, so that the point that strikes is another one. The factor of the three points, which moves them to the
centre of a lying cylinder, makes them smooth.
"""

from mbdsl.elements.contact_points import contact
from mbdsl.elements.cylinder_contact import DOC, NORMAL_IN_B, SHAPE, on_rim
from mbdsl.elements.line_contact import SIDES, axes, check
from mbdsl.elements.point_contact import TANGENTS

BLUNT = 1e-6  #: d
TERMS = {
    **NORMAL_IN_B,
    "slope": f"hypot(hypot({BLUNT**2}, down), aside)",
    "far": "slope^4/(slope^4 + 0.0016)",
    "to": "(far - 1)*(down*corner[1] + aside*corner[2]) + far*slope",
    "toward_b": f"{BLUNT**2}*corner[1] - to*down",
    "toward_c": f"{BLUNT**2}*corner[2] - to*aside",
    "size": f"hypot(hypot({BLUNT**4}, toward_b), toward_c)",
    "mb": "toward_b/size",
    "mc": "toward_c/size",
    "along": "(0.25*leans*(leans*leans - 3)*length)",
}


def points():
    for side in SIDES:
        yield on_rim(f"({side}*length)", 1, 0)
    for c, s in ((0, 1), (-1, 0), (0, -1)):
        yield on_rim("along", c, s)


IN_SPACE = contact(
    "CylinderContact",
    DOC,
    SHAPE,
    [x._replace(tangents=TANGENTS) for x in points()],
    spatial=True,
    terms=TERMS,
    axes=axes,
    check=check,
    aim=("down", "aside"),
    variant="cylinder_rims",
    drawing="surface",
)
