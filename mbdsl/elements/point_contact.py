"""PointContact: a point, circle or ball about the origin of frame_b on a line or plane of frame_a, with friction.

    gap = n . (r_b - r_a) - radius,   n: y axis of frame_a; in space the direction n      see contact_points.py

The half-plane or half-space behind the line or plane is solid.
"""

from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import axis_given
from mbdsl.elements.vectors import D, axis, dot, turned_to

#: outward normal of the line y = 0 and of the plane z = 0 of frame_a, and the distance of frame_b's origin
NORMAL = ("(-sin(frame_a.phi))", "cos(frame_a.phi)")
HEIGHT = "(cos(frame_a.phi)*(frame_b.y - frame_a.y) - sin(frame_a.phi)*(frame_b.x - frame_a.x))"
NORMAL_IN_SPACE = axis("frame_a", "z")
HEIGHT_IN_SPACE = dot(NORMAL_IN_SPACE, D)
TANGENTS = axis("frame_a", "x"), axis("frame_a", "y")
N = Parameter("n", "1", (0.0, 0.0, 1.0), "outward normal of the plane, in frame_a", shape=(3,))
RADIUS = Parameter("radius", "m", 0.0, "radius about frame_b", minimum=0.0)


def plane(values):
    """``axes`` of kinds with the plane."""
    return {"frame_a": turned_to("z", values["n"])}


KIND = contact(
    "PointContact",
    "A point or circle about the origin of frame_b on the x axis of frame_a, which pushes it to the side of the y "
    "axis; with friction.",
    (RADIUS,),
    [Point(f"{HEIGHT} - radius", NORMAL, [f"-radius*{x}" for x in NORMAL])],
    drawing="surface",
)
IN_SPACE = contact(
    "PointContact",
    "A point or ball about the origin of frame_b on the plane through the origin of frame_a, which pushes it to the "
    "side of n; with friction.",
    (RADIUS, N),
    [Point(f"{HEIGHT_IN_SPACE} - radius", NORMAL_IN_SPACE, [f"-radius*{x}" for x in NORMAL_IN_SPACE], TANGENTS)],
    spatial=True,
    axes=plane,
    check=axis_given,
    drawing="surface",
)
