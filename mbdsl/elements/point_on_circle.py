"""PointOnCircle: the origin of frame_b stays on a circle of frame_a, with its centre at the origin and the normal n.

    z_a . d = 0,   ((x_a . d)^2 + (y_a . d)^2)^(1/2) - radius = 0      with d = r_b - r_a and z along n

(2 rows, in the plane 1). The body of frame_b is free to turn.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AT_B, JointKind, Placing, Signal, in_space
from mbdsl.elements.motions import AXIS_Z
from mbdsl.elements.row import Row
from mbdsl.elements.rows import IN_AXES, LENGTH, along, less
from mbdsl.elements.vectors import turned_to

X, Y = IN_AXES[:2]
RADIUS = Row(f"sqrt({X.space}*{X.space} + {Y.space}*{Y.space})", LENGTH.plane)


def turning(x: str, y: str) -> tuple[Signal, Signal]:
    return (
        Signal(
            "theta", "rad", f"angle({y}, {x}, der(atan2({y}, {x})))", "angle of the point from the x axis of frame_a"
        ),
        Signal("w", "rad/s", "der(theta)", "its rate"),
    )


KIND = JointKind(
    "PointOnCircle",
    doc="A pin in a circular slot: the origin of frame_b stays on a circle about the origin of frame_a.",
    g=(less(RADIUS, "radius"), along("z")),
    parameters=(Parameter("radius", "m", doc="radius of the circle", positive=True),),
    signals=turning(f"({X.plane})", f"({Y.plane})"),
    touches=AT_B,
    placing=Placing(along=("radius",)),
    size="radius",
    drawing="rod",
)
IN_SPACE = in_space(
    KIND,
    parameters=(*KIND.parameters, AXIS_Z),
    signals=turning(X.space, Y.space),
    axes=lambda v: {"frame_a": turned_to("z", v["n"])},
)
