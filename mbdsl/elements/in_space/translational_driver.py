"""TranslationalDriver: prescribes the position of frame_b along the axis n of frame_a (rheonomic).

g = x_a . (r_b - r_a) - u(t)     with x along n                                       (1 row)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import translational_driver
from mbdsl.elements.in_space import prismatic
from mbdsl.elements.in_space.coordinates import X, dot2, dot2_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import direction, reactions, total, turned_to

KIND = in_space(
    translational_driver.KIND,
    parameters=(*translational_driver.KIND.parameters, prismatic.AXIS),
    signals=prismatic.SIGNALS,
    reactions=reactions(total(("-lam[1]", prismatic.X_A)), None),
    check=direction,
    follows="translation",
    axes=lambda v: {"frame_a": turned_to("x", v["n"])},
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
