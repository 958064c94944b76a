"""SphereBoxContact: a ball about the origin of frame_b on a cuboid about that of frame_a, with friction; in space.

With the centre c of the ball in the axes of frame_a, the half edges h, and q_i = |c_i| - h_i, o_i = max(0, q_i):

    gap = |o| + min(0, max q) - radius,   n_i = sign(c_i) o_i/|o| outside, the axis of the largest q_i inside

The distance |o| has a continuous gradient where its nearest point passes from a face to an edge or a corner.
"""

from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.rows import X_A, Y_A, Z_A
from mbdsl.elements.vectors import D, dot, total

BALL = Parameter("radius", "m", doc="radius of the ball", positive=True)
HALF = {"x": "length", "y": "width", "z": "height"}
AXES = {"x": X_A, "y": Y_A, "z": Z_A}
#: the centre of the ball in frame_a
CENTRE = {f"c{i}": dot(a, D) for i, a in AXES.items()}


def touch(parts):
    """The point of a ball with the centre at the origin of frame_b; ``parts`` of the normal along the axes of
    frame_a are formulas."""
    normal = total(*zip(parts, (X_A, Y_A, Z_A), strict=True))
    return Point("separation - radius", normal, [f"-radius*{x}" for x in normal])


def terms():
    found = {**CENTRE}
    for i, edge in HALF.items():
        found |= {f"q{i}": f"abs(c{i}) - 0.5*{edge}", f"o{i}": f"max(0, q{i})"}
    found |= {"beside": "hypot(hypot(ox, oy), oz)", "deepest": "max(max(qx, qy), qz)"}
    inside = {"x": "le(deepest, qx)", "y": "lt(qx, qy)*le(deepest, qy)", "z": "lt(max(qx, qy), qz)"}
    for i, own in inside.items():
        found[f"normal_{i}"] = f"sign(c{i})*(ratio(o{i}, beside) + le(deepest, 0)*{own})"
    return found | {"separation": "beside + min(0, deepest)"}


IN_SPACE = contact(
    "SphereBoxContact",
    "A ball about the origin of frame_b on the outside of a cuboid about the origin of frame_a; with friction.",
    (
        BALL,
        Parameter("length", "m", doc="edge of the cuboid along x of frame_a", positive=True),
        Parameter("width", "m", doc="edge along y", positive=True),
        Parameter("height", "m", doc="edge along z", positive=True),
    ),
    [touch(("normal_x", "normal_y", "normal_z"))],
    spatial=True,
    terms=terms(),
    drawing="ball on solid",
)
