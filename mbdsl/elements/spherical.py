"""Spherical: a ball joint that holds two frame origins together; in space.

    r_b - r_a = 0                                                                        (3 rows)

Friction: a torque mu radius |lam| against the relative rotation, see friction.py and sliding_friction.py.
"""

from mbdsl.elements import friction, sliding_friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing
from mbdsl.elements.rows import POINT, X_A, Y_A, Z_A
from mbdsl.elements.sliding_friction import TURNS
from mbdsl.elements.vectors import cardan_angles

IN_SPACE = JointKind(
    "Spherical",
    doc="A ball joint: the origins of frame_a and frame_b coincide.",
    g=POINT,
    parameters=(
        Parameter("radius", "m", None, "radius of the ball; required with friction", positive=True),
        *friction.parameters("w", "rad/s", 0.01),
    ),
    signals=cardan_angles(),
    **sliding_friction.against(
        "radius*hypot(hypot(lam[1], lam[2]), lam[3])",
        "w",
        "sliding_in_socket",
        tuple(row.space for row in TURNS),
        (X_A, Y_A, Z_A),
    ),
    placing=Placing(moves=(("phi_x", "rx"), ("phi_y", "ry"), ("phi_z", "rz"))),
    spatial=True,
    drawing="ball",
)
