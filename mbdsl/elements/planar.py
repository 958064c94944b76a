"""Planar: frame_b moves in the plane through the origin of frame_a with the normal n, and turns about n; in space.

    z_a . d = 0,   x_a . z_b = 0,   y_a . z_b = 0      with d = r_b - r_a and z along n  (3 rows)

Friction: a force mu |lam_1| at the origin of frame_b against its sliding, see friction.py and sliding_friction.py. The
torque about n depends on the distribution of the pressure, and is left out.
"""

from dataclasses import fields

from mbdsl.elements import point_on_plane
from mbdsl.elements.kind import JointKind, Placing
from mbdsl.elements.motions import TURNING_IN_SPACE
from mbdsl.elements.rows import Z_A, Z_B, along, normal
from mbdsl.elements.vectors import both, dot

ON_PLANE = point_on_plane.IN_SPACE

IN_SPACE = JointKind(
    **{x.name: getattr(ON_PLANE, x.name) for x in fields(ON_PLANE)}
    | {
        "name": "Planar",
        "doc": "Frame_b moves in the plane with the normal n through the origin of frame_a, and turns about n.",
        "g": (along("z"), normal("x", "z"), normal("y", "z")),
        "signals": (*ON_PLANE.signals, *TURNING_IN_SPACE),
        "axes": both("z"),
        "placing": Placing(
            angle=("phi",),
            moves=(*ON_PLANE.placing.moves, ("phi", "rz")),
            aligned=dot(Z_A, Z_B),
            free_axes={"rotation": "n", "translation": None},
        ),
        "drawing": "plate",
    }
)
