"""VelocityConstraint: an expression of velocities, positions, time and inputs that remains zero (nonholonomic).

Gamma = gamma = 0                                                                    (1 row, of velocities)
"""

from mbdsl.elements import velocity_constraint
from mbdsl.elements.in_space.kinds import in_space

KIND = in_space(velocity_constraint.KIND)
