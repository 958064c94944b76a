"""Cylindrical: frame_b slides along the axis n of frame_a and turns about it.

g = y_a . d,   z_a . d,   y_a . x_b,   z_a . x_b     with d = r_b - r_a, x along n                     (4 rows)

Friction: a force mu |(lam_1, lam_2)| on the surface of the shaft, against the sliding there, v along the axis and
radius w around it, see friction.py and sliding_friction.py. Without a radius, it acts along the axis only.
"""

from collections.abc import Mapping

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space import prismatic, sliding_friction
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, dot2, dot2_hessian
from mbdsl.elements.in_space.prismatic import X_A, Y_A, Y_B, Z_A
from mbdsl.elements.in_space.vectors import W, axis, both, cross, direction, dot, origin, reactions, total, wrench
from mbdsl.elements.kind import JointKind, Parameter, Signal

X_B = axis("frame_b", "x")

RATES = "v", "(radius*w)"
ALONG, AROUND = sliding_friction.components("v", *RATES)


def derive(v: Mapping) -> dict:
    return friction.derive(v) | ({"radius": 0.0} if v["radius"] is None else {})


KIND = JointKind(
    "Cylindrical",
    doc="Frame_b slides along the axis n of frame_a and turns about it.",
    rows=4,
    parameters=(
        prismatic.AXIS,
        Parameter("radius", "m", None, "radius of the shaft; without it, rotation has no friction", positive=True),
        *friction.parameters("v", "m/s", 1e-3),
    ),
    signals=(
        *prismatic.SIGNALS,
        Signal("phi", "rad", f"angle({dot(Z_A, Y_B)}, {dot(Y_A, Y_B)}, w)", "angle of frame_b about the axis"),
        Signal("w", "rad/s", dot(W, X_A), "its rate"),
    ),
    reactions=reactions(
        total(("-lam[1]", Y_A), ("-lam[2]", Z_A)), total(("lam[3]", cross(Y_A, X_B)), ("lam[4]", cross(Z_A, X_B)))
    ),
    friction=sliding_friction.size("hypot(lam[1], lam[2])", "v", *RATES),
    friction_along="sliding_on_shaft",
    friction_rows=(ALONG, f"radius*{AROUND}"),
    touches=origin("frame_b"),
    results=(sliding_friction.delivered("v", *RATES),),
    exerts=wrench(total((f"(-{ALONG})", X_A)), total((f"(-radius*{AROUND})", X_A))),
    check=lambda v: direction(v) or friction.check({"mu": v["mu"], "mu_s": v["mu_s"]}),
    derive=derive,
    effects=friction.EFFECTS,
    axes=both("x"),
    along=("s",),
    moves=(("s", "x"), ("phi", "rx")),
    aligned=dot(X_A, X_B),
    free_axes={"rotation": "n", "translation": "n"},
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    lines(frames, a, b, G)


@kernel
def hessian(frames, a, b, p, s, H):
    lines_hessian(frames, a, b, s, H)


@kernel
def lines(frames, a, b, G):
    """The x axes of both frames lie on one line (4 rows)."""
    dot2(frames, a, Y, b, G, 0)
    dot2(frames, a, Z, b, G, 1)
    dot1(frames, a, Y, b, X, G, 2)
    dot1(frames, a, Z, b, X, G, 3)


@kernel
def lines_hessian(frames, a, b, s, H):
    """H += d(G^T s)/dz of ``lines``."""
    dot2_hessian(frames, a, Y, b, s[0], H)
    dot2_hessian(frames, a, Z, b, s[1], H)
    dot1_hessian(frames, a, Y, b, X, s[2], H)
    dot1_hessian(frames, a, Z, b, X, s[3], H)
