"""Spherical: a ball joint that holds two frame origins together.

g = r_b - r_a                                                                        (3 rows)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import point
from mbdsl.elements.in_space.vectors import cardan_angles, reactions
from mbdsl.elements.kind import JointKind

KIND = JointKind(
    "Spherical",
    doc="A ball joint: the origins of frame_a and frame_b coincide.",
    rows=3,
    signals=cardan_angles(),
    reactions=reactions(("-lam[1]", "-lam[2]", "-lam[3]"), None),
    moves=(("phi_x", "rx"), ("phi_y", "ry"), ("phi_z", "rz")),
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
