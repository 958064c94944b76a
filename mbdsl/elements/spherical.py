"""Spherical: a ball joint that holds two frame origins together; in space.

    r_b - r_a = 0                                                                        (3 rows)

Friction: a torque mu radius |lam| against the relative rotation, see friction.py and sliding_friction.py. While it
sticks, the rows that hold it are small angles about the axes of frame_a from the attitude at which it stopped.
"""

from mbdsl.elements import friction, sliding_friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing
from mbdsl.elements.rows import POINT, X_A, X_B, Y_A, Y_B, Z_A, Z_B
from mbdsl.elements.sliding_friction import TURNS
from mbdsl.elements.vectors import cardan_angles, dot

#: the rotation R from frame_b to frame_a, by rows
ATTITUDE = tuple(dot(a, b) for a in (X_A, Y_A, Z_A) for b in (X_B, Y_B, Z_B))


def turned(i: int, j: int) -> str:
    """The angle between R and its value R_0 where friction began to hold it: (R R_0^T - R_0 R^T)_ji/2."""
    place = [f"place[{k + 1}]" for k in range(9)]
    parts = (f"{ATTITUDE[3 * j + m]}*{place[3 * i + m]} - {ATTITUDE[3 * i + m]}*{place[3 * j + m]}" for m in range(3))
    return f"0.5*({' + '.join(parts)})"


IN_SPACE = JointKind(
    "Spherical",
    doc="A ball joint: the origins of frame_a and frame_b coincide.",
    g=POINT,
    parameters=(
        Parameter("radius", "m", None, "radius of the ball; required with friction", positive=True),
        *friction.parameters("w", "rad/s", 0.01),
        friction.STICKS,
    ),
    signals=cardan_angles(),
    **sliding_friction.against(
        "radius*hypot(hypot(lam[1], lam[2]), lam[3])",
        "w",
        "sliding_in_socket",
        tuple(row.space for row in TURNS),
        (X_A, Y_A, Z_A),
        ATTITUDE,
    ),
    holds=tuple(turned(*axes) for axes in ((1, 2), (2, 0), (0, 1))),
    placing=Placing(moves=(("phi_x", "rx"), ("phi_y", "ry"), ("phi_z", "rz"))),
    spatial=True,
    drawing="ball",
)
