"""Revolute: a pin in the plane, a hinge in space: two frame origins stay together, and so does the axis n.

    r_b - r_a = 0,   x_a . z_b = 0,   y_a . z_b = 0      with z along n              (5 rows, in the plane 2)

Friction: a torque mu radius |F| about n against the relative rotation, see friction.py. F is the whole reaction force:
its part along n rubs on a collar, taken to have the radius of the pin. How bending moments load the pin depends on its
length, and they are left out.
"""

from mbdsl.elements import friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing, in_space
from mbdsl.elements.motions import AXIS_Z, TURNING, TURNING_IN_SPACE
from mbdsl.elements.rows import POINT, Z_A, Z_B, normal
from mbdsl.elements.vectors import both, dot, total, wrench

KIND = JointKind(
    "Revolute",
    doc="A pin joint: the origins of frame_a and frame_b coincide.",
    g=(*POINT, normal("x", "z"), normal("y", "z")),
    parameters=(
        Parameter("radius", "m", None, "radius of the pin; required with friction", positive=True),
        *friction.parameters("w", "rad/s", 0.01),
        friction.STICKS,
    ),
    signals=TURNING,
    **friction.against("radius*hypot(lam[1], lam[2])", "w", "phi", "rotational_spring_damper"),
    placing=Placing(pose=lambda v, s: (0.0, 0.0, s), free="phi", angle=("phi",)),
    drawing="pin",
)
LOAD = "radius*hypot(hypot(lam[1], lam[2]), lam[3])"
IN_SPACE = in_space(
    KIND,
    doc="A hinge: the origins of frame_a and frame_b coincide, and so does the axis n in both.",
    parameters=(AXIS_Z, *KIND.parameters),
    signals=TURNING_IN_SPACE,
    friction=friction.formula(LOAD, "w"),
    friction_along="torque",
    normal=LOAD,
    resists=(),
    exerts=wrench(None, total(("(-friction)", Z_A))),
    axes=both("z"),
    placing=Placing(angle=("phi",), aligned=dot(Z_A, Z_B), free_axes={"rotation": "n"}),
    drawing="hinge",
)
