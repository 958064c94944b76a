"""Prismatic: frame_b slides along the axis n of frame_a and does not turn relative to it.

g = y_a . d,   z_a . d,   x_a . y_b,   x_a . z_b,   y_a . z_b     with d = r_b - r_a, x along n        (5 rows)

Friction: a force mu |(lam_1, lam_2)| against the sliding, see friction.py. How torques load the guide depends on its
length, and they are left out.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, dot2, dot2_hessian
from mbdsl.elements.in_space.vectors import (
    UNTURNED,
    D,
    about,
    axis,
    cross,
    direction,
    dot,
    origin,
    reactions,
    total,
    turned_to,
)
from mbdsl.elements.kind import JointKind, Parameter, Signal, power

X_A, Y_A, Z_A = (axis("frame_a", i) for i in "xyz")
Y_B, Z_B = axis("frame_b", "y"), axis("frame_b", "z")
AXIS = Parameter("n", "1", (1.0, 0.0, 0.0), "axis of the motion, in frame_a", shape=(3,))
SIGNALS = (
    Signal("s", "m", dot(X_A, D), "position of frame_b along the axis"),
    Signal("v", "m/s", "der(s)", "its rate"),
)
#: of a joint whose first two rows hold frame_b on the axis
FRICTION = friction.formula("hypot(lam[1], lam[2])", "v")
#: the trace of the rotation from frame_a to frame_b: 3, or -1 after half a turn about one of the axes
SAME_ATTITUDE = f"({dot(X_A, axis('frame_b', 'x'))} + {dot(Y_A, Y_B)} + {dot(Z_A, Z_B)})"


def axes(v):
    """Frame_b is turned back by phi0 about the z axis of frame_a, and both have x along n."""
    n = turned_to("x", v["n"])
    if not v["phi0"]:
        return {"frame_a": n, "frame_b": n}
    back = about((0.0, 0.0, 1.0), -v["phi0"])
    product = tuple(sum(back[3 * k + i] * n[3 * j + k] for k in range(3)) for j in range(3) for i in range(3))
    return {"frame_a": n, "frame_b": product if product != UNTURNED else UNTURNED}


KIND = JointKind(
    "Prismatic",
    doc="A sliding joint: frame_b moves along the axis n of frame_a and does not turn.",
    rows=5,
    parameters=(
        AXIS,
        Parameter("phi0", "rad", 0.0, "the constant angle of frame_b about the z axis of frame_a"),
        *friction.parameters("v", "m/s", 1e-3),
    ),
    signals=SIGNALS,
    # torques about the origin of frame_b: the forces act on frame_a along the axis through it
    reactions=reactions(
        total(("-lam[1]", Y_A), ("-lam[2]", Z_A)),
        total(("lam[3]", cross(X_A, Y_B)), ("lam[4]", cross(X_A, Z_B)), ("lam[5]", cross(Y_A, Z_B))),
    ),
    friction=FRICTION,
    friction_along="translational_spring_damper",
    results=(power("-(friction*v)"),),
    touches=origin("frame_b"),
    resists=(("friction", "s"),),
    check=lambda v: direction(v) or friction.check(v),
    derive=friction.derive,
    effects=friction.EFFECTS,
    axes=axes,
    along=("s",),
    keeps_attitude=True,
    aligned=SAME_ATTITUDE,
    free_axes={"translation": "n"},
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, Y, b, G, 0)
    dot2(frames, a, Z, b, G, 1)
    dot1(frames, a, X, b, Y, G, 2)
    dot1(frames, a, X, b, Z, G, 3)
    dot1(frames, a, Y, b, Z, G, 4)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, Y, b, s[0], H)
    dot2_hessian(frames, a, Z, b, s[1], H)
    dot1_hessian(frames, a, X, b, Y, s[2], H)
    dot1_hessian(frames, a, X, b, Z, s[3], H)
    dot1_hessian(frames, a, Y, b, Z, s[4], H)
