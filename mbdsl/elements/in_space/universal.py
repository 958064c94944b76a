"""Universal: a Cardan joint, whose cross has one axis n_a in frame_a and one, n_b, in frame_b.

g = r_b - r_a,   z_a . z_b     with z_a along n_a and z_b along n_b                      (4 rows)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import Z, dot1, dot1_hessian, point
from mbdsl.elements.in_space.revolute import Z_A, Z_B
from mbdsl.elements.in_space.vectors import cross, reactions, total, turned_to
from mbdsl.elements.kind import JointKind, Parameter

KIND = JointKind(
    "Universal",
    doc="A Cardan joint: the origins coincide, and the axis n_a of frame_a stays at right angles to n_b of frame_b.",
    rows=4,
    parameters=(
        Parameter("n_a", "1", (1.0, 0.0, 0.0), "axis of the cross in frame_a", shape=(3,)),
        Parameter("n_b", "1", (0.0, 1.0, 0.0), "axis of the cross in frame_b", shape=(3,)),
    ),
    reactions=reactions(("-lam[1]", "-lam[2]", "-lam[3]"), total(("lam[4]", cross(Z_A, Z_B)))),
    check=lambda v: None if any(v["n_a"]) and any(v["n_b"]) else "an axis is zero",
    axes=lambda v: {"frame_a": turned_to("z", v["n_a"]), "frame_b": turned_to("z", v["n_b"])},
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
    dot1(frames, a, Z, b, Z, G, 3)


@kernel
def hessian(frames, a, b, p, s, H):
    dot1_hessian(frames, a, Z, b, Z, s[3], H)
