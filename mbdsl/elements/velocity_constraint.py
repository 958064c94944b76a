"""VelocityConstraint: any expression in velocities, positions, time and inputs that stays zero (nonholonomic).

    Gamma = gamma = 0                                                                    (1 row, of velocities)

It needs no frames: what it acts on is what its expression mentions.
"""

from mbdsl.elements.kind import JointKind, Parameter

KIND = JointKind(
    "VelocityConstraint",
    doc="An expression in velocities that stays zero, such as the ratio of a gear. It has no frames.",
    ports=(),
    parameters=(Parameter("gamma", "", doc="what stays zero; depends on a velocity, of any unit", law=True),),
    velocity_rows=("gamma",),
)
