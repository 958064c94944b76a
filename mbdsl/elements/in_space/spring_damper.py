"""SpringDamper: a spring and a damper between two points in space, linear or by a law of distance s and its rate v.

g = |r_b - r_a|;  tension  k (g - s0) + c dg/dt
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import spring_damper
from mbdsl.elements.in_space.coordinates import length, length_hessian
from mbdsl.elements.in_space.distance import SIGNALS
from mbdsl.elements.in_space.kinds import in_space

KIND = in_space(spring_damper.KIND, signals=(*SIGNALS, spring_damper.KIND.signals[-1]))


@kernel
def gradient(frames, a, b, p, G):
    length(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    length_hessian(frames, a, b, s[0], H)
