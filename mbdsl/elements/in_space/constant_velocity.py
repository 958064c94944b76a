"""ConstantVelocity: a homokinetic joint, which transmits the rotation about the z axes of its frames at any bend.

g = r_b - r_a,   x_a . y_b - y_a . x_b     with z along the shafts                       (4 rows)
"""

from dataclasses import replace

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import PHI_A, PHI_B, X, Y, dot1_hessian, point
from mbdsl.elements.in_space.revolute import X_A, X_B, Y_A
from mbdsl.elements.in_space.vectors import axis, both, cardan_angles, cross, direction, dot, reactions, total
from mbdsl.elements.kind import JointKind, Parameter

Y_B = axis("frame_b", "y")
BENDS = {
    "phi_x": "bend of the shaft of frame_b about the x axis of the joint in frame_a",
    "phi_y": "bend about the y axis, which phi_x has turned",
    "w_x": "rate of phi_x",
    "w_y": "rate of phi_y",
}

KIND = JointKind(
    "ConstantVelocity",
    doc="A homokinetic joint: shafts along n at any bend, with the same rotation about them.",
    rows=4,
    parameters=(Parameter("n", "1", (0.0, 0.0, 1.0), "direction of the shafts, in both frames", shape=(3,)),),
    signals=tuple(replace(x, doc=BENDS[x.name]) for x in cardan_angles() if x.name in BENDS),
    reactions=reactions(
        ("-lam[1]", "-lam[2]", "-lam[3]"), total(("lam[4]", cross(X_A, Y_B)), ("-lam[4]", cross(Y_A, X_B)))
    ),
    check=direction,
    axes=both("z"),
    moves=(("phi_x", "rx"), ("phi_y", "ry")),
    aligned=f"({dot(X_A, X_B)} + {dot(Y_A, Y_B)})",
    curved_by_rotations=True,
    in_loops="constant_velocity_in_axes",
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
    value = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        value += frames[a, X + i] * frames[b, Y + i] - frames[a, Y + i] * frames[b, X + i]
        c = frames[a, X + j] * frames[b, Y + k] - frames[a, X + k] * frames[b, Y + j]
        c -= frames[a, Y + j] * frames[b, X + k] - frames[a, Y + k] * frames[b, X + j]
        G[3, PHI_A + i], G[3, PHI_B + i] = c, -c
    G[3, VALUE] = value


@kernel
def hessian(frames, a, b, p, s, H):
    dot1_hessian(frames, a, X, b, Y, s[3], H)
    dot1_hessian(frames, a, Y, b, X, -s[3], H)
