"""RotationalVelocityDriver: prescribes the angular velocity of frame_b relative to frame_a; the angle follows.

    Gamma = w_b - w_a - u = 0                                                            (1 row, of velocities)

u may depend on more than time: on inputs, positions and other velocities.
"""

from mbdsl.elements import revolute
from mbdsl.elements.kind import JointKind, Parameter, power, wrench

KIND = JointKind(
    "RotationalVelocityDriver",
    doc="A drive that turns a joint with a given angular velocity.",
    parameters=(Parameter("w", "rad/s", doc="the angular velocity", law=True),),
    signals=revolute.KIND.signals,
    velocity_rows=("frame_b.w - frame_a.w - w",),
    reactions=wrench(tau="-lam[1]"),
    results=(power("tau*w"),),
)
