"""DistanceDriver: prescribes the distance of two frame origins (a linear actuator; rheonomic).

g = |r_b - r_a| - u(t)                                                               (1 row)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import distance as distance_joint
from mbdsl.elements.coordinates import distance, distance_hessian
from mbdsl.elements.kind import AXIAL, JointKind, Parameter, Signal, power

KIND = JointKind(
    "DistanceDriver",
    doc="A linear actuator whose length is a given function of time.",
    rows=1,
    parameters=(Parameter("s", "m", doc="the distance, an expression in time; stays above zero", law=True),),
    signals=(
        Signal("s", "m", "hypot(frame_b.x - frame_a.x, frame_b.y - frame_a.y)", "distance of the frames"),
        Signal("v", "m/s", "der(s)", "its rate"),
    ),
    reactions=distance_joint.KIND.reactions,
    results=(AXIAL, power("-(force*v)")),
    driver="s",
    along=("s",),
)


@kernel
def gradient(frames, a, b, p, G):
    distance(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    distance_hessian(frames, a, b, s[0], H)
