"""RotationalVelocityDriver: prescribes the angular velocity of frame_b about the axis n of frame_a; the angle follows.

    Gamma = m . (w_b - w_a) - u = 0                                                      (1 row, of velocities)

with m . (w_b - w_a) the rate of the angle about n: m = n where both frames have the same axis n.
u may depend on more than time: on inputs, positions and other velocities.
"""

from mbdsl.elements import rotational_velocity_driver
from mbdsl.elements.in_space import revolute
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import W, both, direction, dot, reactions, total

KIND = in_space(
    rotational_velocity_driver.KIND,
    parameters=(*rotational_velocity_driver.KIND.parameters, revolute.AXIS),
    signals=revolute.SIGNALS_OF_ANGLE,
    velocity_rows=(f"{dot(W, revolute.GRADIENT)} - w",),
    reactions=reactions(None, total(("-lam[1]", revolute.GRADIENT)), "-lam[1]"),
    check=direction,
    follows="rotation",
    axes=both("z"),
)
