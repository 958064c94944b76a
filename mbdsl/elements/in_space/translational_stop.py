"""TranslationalStop: end stops of motion along the axis n of frame_a, stiff springs with damping beyond its limits.

g = x_a . (r_b - r_a);  force = k d max(0, 1 + alpha d'),  d = s - s_max or s_min - s,  where d > 0
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import translational_stop
from mbdsl.elements.in_space import prismatic
from mbdsl.elements.in_space.coordinates import X, dot2, dot2_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import direction, origin, turned_to

DRAWING = "stop"
KIND = in_space(
    translational_stop.KIND,
    parameters=(*translational_stop.KIND.parameters, prismatic.AXIS),
    signals=(*prismatic.SIGNALS, translational_stop.KIND.signals[-1]),
    check=lambda v: translational_stop.KIND.check(v) or direction(v),
    touches=origin("frame_b"),
    follows="translation",
    axes=lambda v: {"frame_a": turned_to("x", v["n"])},
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
