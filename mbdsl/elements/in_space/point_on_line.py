"""PointOnLine: the origin of frame_b stays on a line through the origin of frame_a along n, free to turn.

g = y_a . d,   z_a . d     with d = r_b - r_a, x along n                                 (2 rows)

Friction: a force mu |lam| against the sliding, see friction.py.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space import prismatic
from mbdsl.elements.in_space.coordinates import Y, Z, dot2, dot2_hessian
from mbdsl.elements.in_space.prismatic import Y_A, Z_A
from mbdsl.elements.in_space.revolute import SIGNALS_OF_ANGLE
from mbdsl.elements.in_space.vectors import both, direction, origin, reactions, total
from mbdsl.elements.kind import JointKind, power

KIND = JointKind(
    "PointOnLine",
    doc="A pin in a slot: the origin of frame_b stays on the line along n through the origin of frame_a.",
    rows=2,
    parameters=(prismatic.AXIS, *friction.parameters("v", "m/s", 1e-3)),
    signals=(*prismatic.SIGNALS, *SIGNALS_OF_ANGLE),
    reactions=reactions(total(("-lam[1]", Y_A), ("-lam[2]", Z_A)), None),
    friction=prismatic.FRICTION,
    friction_along="translational_spring_damper",
    results=(power("-(friction*v)"),),
    touches=origin("frame_b"),
    resists=(("friction", "s"),),
    check=lambda v: direction(v) or friction.check(v),
    derive=friction.derive,
    effects=friction.EFFECTS,
    axes=both("x"),
    angle=("phi",),
    along=("s",),
    free_axes={"translation": "n"},
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, Y, b, G, 0)
    dot2(frames, a, Z, b, G, 1)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, Y, b, s[0], H)
    dot2_hessian(frames, a, Z, b, s[1], H)
