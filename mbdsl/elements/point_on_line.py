"""PointOnLine: the origin of frame_b stays on the line along n through the origin of frame_a (a pin in a slot).

    y_a . d = 0,   z_a . d = 0      with d = r_b - r_a and x along n                 (2 rows, in the plane 1)

Friction: a force mu |lam| against the sliding, see friction.py.
"""

from mbdsl.elements import friction
from mbdsl.elements.kind import AT_B, JointKind, Placing, in_space
from mbdsl.elements.motions import AXIS_X, SLIDING, SLIDING_IN_SPACE, TURNING, TURNING_ASKEW
from mbdsl.elements.rows import along
from mbdsl.elements.vectors import both

KIND = JointKind(
    "PointOnLine",
    doc="A pin in a slot: the origin of frame_b stays on the x axis of frame_a.",
    g=(along("y"), along("z")),
    parameters=(*friction.parameters("v", "m/s", 1e-3), friction.STICKS),
    signals=(*SLIDING, *TURNING),
    **friction.against("abs(lam[1])", "v", "s", "translational_spring_damper"),
    touches=AT_B,
    placing=Placing(angle=("phi",), along=("s",)),
    drawing="pin in slot",
)
IN_SPACE = in_space(
    KIND,
    doc="A pin in a slot: the origin of frame_b stays on the line along n through the origin of frame_a.",
    parameters=(AXIS_X, *KIND.parameters),
    signals=(*SLIDING_IN_SPACE, *TURNING_ASKEW),
    friction=friction.formula("hypot(lam[1], lam[2])", "v"),
    normal="hypot(lam[1], lam[2])",
    axes=both("x"),
    placing=Placing(angle=("phi",), along=("s",), free_axes={"translation": "n"}),
    drawing="bead",
)
