"""Planar: frame_b moves in the plane through the origin of frame_a with the normal n, and turns about n.

g = z_a . d,   x_a . z_b,   y_a . z_b     with d = r_b - r_a, z along n                  (3 rows)

Friction: a force mu |lam_1| at the origin of frame_b against its sliding, see friction.py and sliding_friction.py. The
torque about n depends on the distribution of the pressure, and is left out.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space import point_on_plane, revolute
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, dot2, dot2_hessian
from mbdsl.elements.in_space.revolute import X_A, Y_A, Z_A, Z_B
from mbdsl.elements.in_space.vectors import both, cross, dot, reactions, total
from mbdsl.elements.kind import JointKind

KIND = JointKind(
    "Planar",
    doc="Frame_b moves in the plane with the normal n through the origin of frame_a, and turns about n.",
    rows=3,
    parameters=point_on_plane.KIND.parameters,
    signals=(*point_on_plane.KIND.signals, *revolute.SIGNALS),
    reactions=reactions(total(("-lam[1]", Z_A)), total(("lam[2]", cross(X_A, Z_B)), ("lam[3]", cross(Y_A, Z_B)))),
    friction=point_on_plane.KIND.friction,
    friction_along=point_on_plane.KIND.friction_along,
    friction_rows=point_on_plane.KIND.friction_rows,
    results=point_on_plane.KIND.results,
    touches=point_on_plane.KIND.touches,
    exerts=point_on_plane.KIND.exerts,
    check=point_on_plane.KIND.check,
    derive=point_on_plane.KIND.derive,
    effects=point_on_plane.KIND.effects,
    axes=both("z"),
    angle=("phi",),
    moves=(("s_x", "x"), ("s_y", "y"), ("phi", "rz")),
    aligned=dot(Z_A, Z_B),
    free_axes={"rotation": "n", "translation": None},
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, Z, b, G, 0)
    dot1(frames, a, X, b, Z, G, 1)
    dot1(frames, a, Y, b, Z, G, 2)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, Z, b, s[0], H)
    dot1_hessian(frames, a, X, b, Z, s[1], H)
    dot1_hessian(frames, a, Y, b, Z, s[2], H)
