"""DistanceDriver: prescribes the distance of two points as a function of time, as a hydraulic cylinder does.

g = |r_b - r_a| - u(t)                                                               (1 row)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import distance_driver
from mbdsl.elements.in_space.coordinates import length, length_hessian
from mbdsl.elements.in_space.distance import SIGNALS
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import D, reactions, total

KIND = in_space(distance_driver.KIND, signals=SIGNALS, reactions=reactions(total(("-lam[1]/s", D)), None))


@kernel
def gradient(frames, a, b, p, G):
    length(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    length_hessian(frames, a, b, s[0], H)
