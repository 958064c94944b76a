"""PointOnPlane: the origin of frame_b stays on the plane through the origin of frame_a with the normal n.

g = z_a . d     with d = r_b - r_a, z along n                                            (1 row)

Friction: a force mu |lam| against the sliding, see friction.py and sliding_friction.py.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space import sliding_friction
from mbdsl.elements.in_space.coordinates import Z, dot2, dot2_hessian
from mbdsl.elements.in_space.revolute import X_A, Y_A, Z_A
from mbdsl.elements.in_space.vectors import D, direction, dot, origin, reactions, total, turned_to, wrench
from mbdsl.elements.kind import JointKind, Parameter, Signal

RATES = "der(s_x)", "der(s_y)"
KIND = JointKind(
    "PointOnPlane",
    doc="The origin of frame_b stays on the plane with the normal n through the origin of frame_a.",
    rows=1,
    parameters=(
        Parameter("n", "1", (0.0, 0.0, 1.0), "normal of the plane, in frame_a", shape=(3,)),
        *friction.parameters("v", "m/s", 1e-3),
    ),
    signals=(
        Signal("s_x", "m", dot(X_A, D), "position of frame_b along the x axis of the plane"),
        Signal("s_y", "m", dot(Y_A, D), "position of frame_b along the y axis of the plane"),
    ),
    reactions=reactions(total(("-lam[1]", Z_A)), None),
    friction=sliding_friction.size("abs(lam[1])", "v", *RATES),
    friction_along="sliding_on_plane",
    friction_rows=sliding_friction.components("v", *RATES),
    touches=origin("frame_b"),
    results=(sliding_friction.delivered("v", *RATES),),
    exerts=wrench(sliding_friction.against("v", RATES, (X_A, Y_A)), None),
    check=lambda v: direction(v) or friction.check(v),
    derive=friction.derive,
    effects=friction.EFFECTS,
    axes=lambda v: {"frame_a": turned_to("z", v["n"])},
    moves=(("s_x", "x"), ("s_y", "y")),
    free_axes={"translation": None},
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, Z, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, Z, b, s[0], H)
