"""RollingDisc: a disc about the origin of frame_b that rolls without slip on the x axis of frame_a, above it.

In space it is a thin disc that rolls on a plane of frame_a.

    g     = y_a . d - radius,  d = r_b - r_a                                             (1 row)
    Gamma = x_a . (v_b - v_a) + w_a (y_a . d) + radius (w_b - w_a) = 0                   (1 row, of velocities)

Gamma is the velocity along the line of the disc's lowest point, x_a . v_b + radius w_b, less that of the point of the
line below it, x_a . v_a - w_a (y_a . (d - radius y_a)). Its first two terms are the rate of s = x_a . d. The disc rolls
towards +x where it turns clockwise.

In space, with the normal k of the plane, the axis n of the disc, u = k . n and c = sqrt(1 - u^2), the lowest point of
the disc is r = -radius (k - u n)/c from its centre:

    g     = k . d - radius c                                                             (1 row)
    Gamma = (n x k) . V,   (n - u k) . V     with V = v_b - v_a - w_a x d + (w_b - w_a) x r
                                                                                         (2 rows, of velocities)

V is the velocity of the disc's lowest point relative to the plane; its part along k is the rate of g. A disc that lies
flat has no lowest point.
"""

from mbdsl.elements import universal
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing, Signal, in_space
from mbdsl.elements.motions import SLIDING, TURNING
from mbdsl.elements.row import Row
from mbdsl.elements.rows import X_B, Y_A, Y_B, Z_A, Z_B, along
from mbdsl.elements.vectors import D, W, cross, dot, origin, slip, total

#: the lowest point of a circle, on the x axis of frame_a
BELOW = ("frame_b.x + radius*sin(frame_a.phi)", "frame_b.y - radius*cos(frame_a.phi)")
U = dot(Z_A, X_B)
LOWEST = total((f"(-radius/sqrt(1 - {U}*{U}))", Z_A), (f"(radius*{U}/sqrt(1 - {U}*{U}))", X_B))
FORWARD, SIDEWARD = cross(X_B, Z_A), total(("1", X_B), (f"(-{U})", Z_A))
#: rate of the angle of the disc from the normal, about its axis
ROLL = f"({dot(SIDEWARD, W)}/(1 - {U}*{U}))"
V = total(("1", slip()), ("1", cross(W, LOWEST)))


def check(v):
    return "the axis n or the normal is zero" if not (any(v["n"]) and any(v["normal"])) else None


KIND = JointKind(
    "RollingDisc",
    doc="A disc with its centre at the origin of frame_b rolls without slip on the x axis of frame_a, above it.",
    g=(Row(f"{dot(Z_A, D)} - radius*sqrt(1 - {U}*{U})", f"{along('y').plane} - radius"),),
    parameters=(Parameter("radius", "m", doc="radius of the disc", positive=True),),
    signals=(SLIDING[0], Signal("v", "m/s", "der(s)", "velocity of the centre along the axis"), *TURNING),
    velocity_rows=("v + radius*w",),
    touches=BELOW,
    placing=Placing(angle=("phi",), along=("s",)),
    drawing="wheel",
)
IN_SPACE = in_space(
    KIND,
    doc="A thin disc with its centre at the origin of frame_b rolls without slip on a plane through that of frame_a.",
    parameters=(
        *KIND.parameters,
        Parameter("n", "1", (0.0, 0.0, 1.0), "axis of the disc, in frame_b", shape=(3,)),
        Parameter("normal", "1", (0.0, 1.0, 0.0), "normal of the plane, in frame_a, towards the disc", shape=(3,)),
    ),
    signals=(
        Signal("s", "m", dot(Y_A, D), "position of the centre along the direction normal x n at the start"),
        Signal("v", "m/s", "der(s)", "its rate"),
        Signal("phi", "rad", f"angle({dot(Z_A, Y_B)}, {dot(Z_A, Z_B)}, {ROLL})", "angle about the disc's axis"),
        Signal("w", "rad/s", dot(W, X_B), "angular velocity about the disc's axis"),
    ),
    velocity_rows=(dot(FORWARD, V), dot(SIDEWARD, V)),
    touches=total(("1", origin("frame_b")), ("1", LOWEST)),
    check=check,
    # where both frames coincide, the disc is upright, with its axis n in the direction n of the plane's frame
    axes=lambda v: universal.axes({"n_a": v["normal"], "n_b": v["n"]}),
    placing=Placing(),
    drawing="nothing",
)
