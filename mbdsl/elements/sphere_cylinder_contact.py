"""SphereCylinderContact: a ball about the origin of frame_b on a circular cylinder of frame_a, with friction; in space.

With the centre of the ball at the height c_x on the axis, and the distance c_r from it, q = (|c_x| - length/2, c_r - R)
and o = max(0, q):

    gap = |o| + min(0, max q) - radius,   n = o/|o| outside, the direction of the largest q inside

as :mod:`~mbdsl.elements.sphere_box_contact`.
"""

from mbdsl.elements.contact_points import contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.sphere_box_contact import BALL, CENTRE, touch
from mbdsl.elements.vectors import turned_to

AXIS = Parameter("axis", "1", (1.0, 0.0, 0.0), "direction of the cylinder, in frame_a", shape=(3,))
TERMS = {
    **CENTRE,
    "cr": "hypot(cy, cz)",
    "qx": "abs(cx) - 0.5*length",
    "qr": "cr - R",
    "ox": "max(0, qx)",
    "or_": "max(0, qr)",
    "beside": "hypot(ox, or_)",
    "deepest": "max(qx, qr)",
    "normal_x": "sign(cx)*(ratio(ox, beside) + le(deepest, 0)*le(qr, qx))",
    "normal_r": "ratio(ratio(or_, beside) + le(deepest, 0)*lt(qx, qr), cr)",
    "separation": "beside + min(0, deepest)",
}


def along_axis(values):
    return {"frame_a": turned_to("x", values["axis"])}


def check(values):
    return None if any(values["axis"]) else "the direction `axis` is zero, expected one such as {1, 0, 0}"


def on_round(name, what, length, parts, terms):
    """The kind of a ball on a solid about an axis, ``what``, with this meaning of its ``length``."""
    return contact(
        name,
        f"A ball about the origin of frame_b on the outside of a {what} about the origin of frame_a; with friction.",
        (
            BALL,
            Parameter("length", "m", doc=length, positive=True),
            Parameter("R", "m", doc=f"radius of the {what.split()[-1]}", positive=True),
            AXIS,
        ),
        [touch(parts)],
        spatial=True,
        terms=terms,
        axes=along_axis,
        check=check,
        drawing="ball on solid",
    )


IN_SPACE = on_round(
    "SphereCylinderContact",
    "circular cylinder",
    "length of the cylinder",
    ("normal_x", "normal_r*cy", "normal_r*cz"),
    TERMS,
)
