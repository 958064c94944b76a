"""Spherical: a ball joint that holds two frame origins together.

g = r_b - r_a                                                                        (3 rows)

Friction: a torque mu radius |lam| against the relative rotation, see friction.py and sliding_friction.py.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space import sliding_friction
from mbdsl.elements.in_space.coordinates import point
from mbdsl.elements.in_space.prismatic import X_A, Y_A, Z_A
from mbdsl.elements.in_space.vectors import W, cardan_angles, dot, reactions, wrench
from mbdsl.elements.kind import JointKind, Parameter

RATES = tuple(dot(W, a) for a in (X_A, Y_A, Z_A))

KIND = JointKind(
    "Spherical",
    doc="A ball joint: the origins of frame_a and frame_b coincide.",
    rows=3,
    parameters=(
        Parameter("radius", "m", None, "radius of the ball; required with friction", positive=True),
        *friction.parameters("w", "rad/s", 0.01),
    ),
    signals=cardan_angles(),
    reactions=reactions(("-lam[1]", "-lam[2]", "-lam[3]"), None),
    friction=sliding_friction.size("radius*hypot(hypot(lam[1], lam[2]), lam[3])", "w", *RATES),
    friction_along="sliding_in_socket",
    friction_rows=sliding_friction.components("w", *RATES),
    results=(sliding_friction.delivered("w", *RATES),),
    exerts=wrench(None, sliding_friction.against("w", RATES, (X_A, Y_A, Z_A))),
    check=friction.check,
    derive=friction.derive,
    effects=friction.EFFECTS,
    moves=(("phi_x", "rx"), ("phi_y", "ry"), ("phi_z", "rz")),
    in_loops="spherical_in_axes",
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
