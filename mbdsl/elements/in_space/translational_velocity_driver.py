"""TranslationalVelocityDriver: prescribes the velocity of frame_b along the axis n of frame_a; the position follows.

    Gamma = d/dt (x_a . (r_b - r_a)) - u = 0     with x along n                          (1 row, of velocities)

u may depend on more than time: on inputs, positions and other velocities.
"""

from mbdsl.elements import translational_velocity_driver
from mbdsl.elements.in_space import prismatic
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import D, cross, direction, reactions, total, turned_to

KIND = in_space(
    translational_velocity_driver.KIND,
    parameters=(*translational_velocity_driver.KIND.parameters, prismatic.AXIS),
    signals=prismatic.SIGNALS,
    reactions=reactions(total(("-lam[1]", prismatic.X_A)), None),
    check=direction,
    follows="translation",
    axes=lambda v: {"frame_a": turned_to("x", v["n"])},
)
