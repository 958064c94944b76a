"""LineContact: a straight edge, or a capsule, of frame_b on a line or plane of frame_a, with friction.

It acts at the ends of the edge, which are circles or balls with the `radius`:

    gap_i = n . (r_b + e_i - r_a) - radius,   e_i = -+ length/2 times the axis of the edge    see contact_points.py
"""

from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import axis_given
from mbdsl.elements.point_contact import HEIGHT, HEIGHT_IN_SPACE, NORMAL, NORMAL_IN_SPACE, TANGENTS, N, plane
from mbdsl.elements.vectors import axis, turned_to

LENGTH = Parameter("length", "m", doc="length of the edge, or of a capsule without its round ends", positive=True)
RADIUS = Parameter("radius", "m", 0.0, "radius of a capsule", minimum=0.0)
AXIS = Parameter("axis", "1", (1.0, 0.0, 0.0), "direction of the edge, in frame_b", shape=(3,))
#: axes of frame_b in the plane
X_B, Y_B = ("cos(frame_b.phi)", "sin(frame_b.phi)"), ("(-sin(frame_b.phi))", "cos(frame_b.phi)")
SIDES = (-0.5, 0.5)


def corner(spatial, *edges):
    """The point at the end of edges, (factor, axis of frame_b): a corner of a body, with a `radius` if it has one."""
    n, height = (NORMAL_IN_SPACE, HEIGHT_IN_SPACE) if spatial else (NORMAL, HEIGHT)
    e = ["(" + " + ".join(f"({factor})*{a[i]}" for factor, a in edges) + ")" for i in range(len(n))]
    return Point(
        f"{height} + {' + '.join(f'{a}*{b}' for a, b in zip(n, e, strict=True))}", n, e, TANGENTS if spatial else ()
    )


def rounded(point):
    """The point with a ball of the `radius` about it."""
    arm = [f"{a} - radius*{n}" for a, n in zip(point.arm, point.normal, strict=True)]
    return point._replace(gap=f"{point.gap} - radius", arm=arm)


def axes(values):
    return plane(values) | {"frame_b": turned_to("x", values["axis"])}


def check(values):
    return axis_given({"n": values["n"]}) or (None if any(values["axis"]) else "the direction `axis` is zero")


KIND = contact(
    "LineContact",
    "A straight edge on the x axis of frame_b, or a capsule about it, on the x axis of frame_a, which pushes its ends "
    "to the side of the y axis; with friction.",
    (LENGTH, RADIUS),
    [rounded(corner(False, (f"{side}*length", X_B))) for side in SIDES],
    drawing="surface",
)
IN_SPACE = contact(
    "LineContact",
    "A straight edge through the origin of frame_b, or a capsule about it, on the plane through the origin of frame_a, "
    "which pushes its ends to the side of n; with friction.",
    (LENGTH, RADIUS, AXIS, N),
    [rounded(corner(True, (f"{side}*length", axis("frame_b", "x")))) for side in SIDES],
    spatial=True,
    axes=axes,
    check=check,
    drawing="surface",
)
