"""CircleContact with friction: the kind that components with `mu` or `mu_s` are.

The circles touch on their line of centres; with n from the body of frame_a to that of frame_b, and side = -1 in a hole

    n = side (r_b - r_a)/|r_b - r_a|,  gap = side (|r_b - r_a| - reach),  p = -r_b n       see contact_points.py
"""

from mbdsl.elements.circle_contact import DEPTH, SHAPE, check, derive
from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.motions import APART, APART_IN_SPACE
from mbdsl.elements.vectors import D


def rubbing(signals, d, **more):
    """The declaration, with the vector d from the centre of circle a to that of circle b."""
    normal = [f"(side[1]*ratio({x}, s))" for x in d]
    return contact(
        "CircleContact",
        "Contact of two circles about the frame origins, with friction.",
        SHAPE,
        [Point("side[1]*(s - reach[1])", normal, [f"(-r_b*{x})" for x in normal])],
        check=check,
        derive=derive,
        signals=(*signals, DEPTH),
        variant="circle_friction",
        drawing="circles",
        **more,
    )


KIND = rubbing(APART, D[:2])
IN_SPACE = rubbing(APART_IN_SPACE, D, spatial=True)
