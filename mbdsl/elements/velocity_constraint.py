"""VelocityConstraint: an expression of velocities, positions, time and inputs that remains zero (nonholonomic).

    Gamma = gamma = 0                                                                    (1 row, of velocities)

It has no frames: it acts on the coordinates in its expression.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, in_space

KIND = JointKind(
    "VelocityConstraint",
    doc="An expression of velocities that remains zero, such as the ratio of a gear. It has no frames.",
    ports=(),
    parameters=(Parameter("gamma", "", doc="an expression of velocities that remains zero, of any unit", law=True),),
    velocity_rows=("gamma",),
)
IN_SPACE = in_space(KIND, drawing="nothing")
