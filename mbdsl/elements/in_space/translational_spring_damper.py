"""TranslationalSpringDamper: a spring and a damper along the axis n of frame_a, linear or by a law of s and v.

g = x_a . (r_b - r_a);  force  k (g - s0) + c dg/dt, against the displacement
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import translational_spring_damper
from mbdsl.elements.in_space import prismatic
from mbdsl.elements.in_space.coordinates import X, dot2, dot2_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import direction, turned_to

KIND = in_space(
    translational_spring_damper.KIND,
    parameters=(*translational_spring_damper.KIND.parameters, prismatic.AXIS),
    signals=(*prismatic.SIGNALS, translational_spring_damper.KIND.signals[-1]),
    check=lambda v: translational_spring_damper.KIND.check(v) or direction(v),
    follows="translation",
    axes=lambda v: {"frame_a": turned_to("x", v["n"])},
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
