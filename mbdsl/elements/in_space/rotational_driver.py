"""RotationalDriver: prescribes the angle of frame_b about the axis n of frame_a as a function of time (rheonomic).

g = angle - u(t)                                                                     (1 row)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import rotational_driver
from mbdsl.elements.in_space import revolute
from mbdsl.elements.in_space.coordinates import angle, angle_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import both, direction, reactions, total

KIND = in_space(
    rotational_driver.KIND,
    parameters=(*rotational_driver.KIND.parameters, revolute.AXIS),
    signals=revolute.SIGNALS_OF_ANGLE,
    reactions=reactions(None, total(("-lam[1]", revolute.GRADIENT)), "-lam[1]"),
    table=lambda v: (0.0, 0.0),
    check=direction,
    follows="rotation",
    axes=both("z"),
    counts_turns=True,
)


@kernel
def gradient(frames, a, b, p, G):
    angle(frames, a, b, p, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    angle_hessian(frames, a, b, s[0], H)
