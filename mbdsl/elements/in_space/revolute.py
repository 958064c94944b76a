"""Revolute: a hinge, whose axis n is fixed in both frames.

g = r_b - r_a,   x_a . z_b,   y_a . z_b       with z along n                             (5 rows)

Friction: a torque mu radius |F| about n against the relative rotation, see friction.py. F is the whole reaction force:
its part along n rubs on a collar, taken to have the radius of the pin. How bending moments load the pin depends on its
length, and they are left out.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction, revolute
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, point
from mbdsl.elements.in_space.vectors import (
    W,
    axis,
    both,
    cross,
    direction,
    dot,
    gradient_of_angle,
    reactions,
    total,
    wrench,
)
from mbdsl.elements.kind import JointKind, Parameter, Signal, power

X_A, Y_A, Z_A = (axis("frame_a", i) for i in "xyz")
X_B, Z_B = axis("frame_b", "x"), axis("frame_b", "z")
AXIS = Parameter("n", "1", (0.0, 0.0, 1.0), "axis of the rotation, in frame_a", shape=(3,))
SIGNALS = (
    Signal("phi", "rad", f"angle({dot(Y_A, X_B)}, {dot(X_A, X_B)}, w)", "angle of frame_b about the axis of frame_a"),
    Signal("w", "rad/s", dot(W, Z_A), "its rate"),
)
#: the same where the axes n of both frames may differ: the gradient of the angle is not n then
GRADIENT = gradient_of_angle()
SIGNALS_OF_ANGLE = (SIGNALS[0], Signal("w", "rad/s", dot(W, GRADIENT), "its rate"))

KIND = JointKind(
    "Revolute",
    doc="A hinge: the origins of frame_a and frame_b coincide, and so does the axis n in both.",
    rows=5,
    parameters=(AXIS, *revolute.KIND.parameters),
    signals=SIGNALS,
    reactions=reactions(
        ("-lam[1]", "-lam[2]", "-lam[3]"), total(("lam[4]", cross(X_A, Z_B)), ("lam[5]", cross(Y_A, Z_B)))
    ),
    friction=friction.formula("radius*hypot(hypot(lam[1], lam[2]), lam[3])", "w"),
    friction_along="torque",
    results=(power("-(friction*w)"),),
    exerts=wrench(None, total(("(-friction)", Z_A))),
    check=lambda v: direction(v) or friction.check(v),
    derive=friction.derive,
    effects=friction.EFFECTS,
    axes=both("z"),
    angle=("phi",),
    aligned=dot(Z_A, Z_B),
    free_axes={"rotation": "n"},
    curved_by_rotations=True,
    in_loops="revolute_in_axes",
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
    dot1(frames, a, X, b, Z, G, 3)
    dot1(frames, a, Y, b, Z, G, 4)


@kernel
def hessian(frames, a, b, p, s, H):
    dot1_hessian(frames, a, X, b, Z, s[3], H)
    dot1_hessian(frames, a, Y, b, Z, s[4], H)
