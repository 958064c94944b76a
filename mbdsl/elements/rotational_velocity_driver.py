"""RotationalVelocityDriver: prescribes the angular velocity of frame_b relative to frame_a; the angle follows.

    Gamma = w - u = 0      in space, w is the rate of the angle of x_b about z_a, with z along n  (1 row, of velocities)

u may depend on more than time: on inputs, positions and other velocities.
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import JointKind, in_space
from mbdsl.elements.motions import GRADIENT, TURNING, about_n
from mbdsl.elements.vectors import W, dot

KIND = JointKind(
    "RotationalVelocityDriver",
    doc="A drive that turns a joint with a given angular velocity.",
    parameters=(Parameter("w", "rad/s", doc="the angular velocity", law=True),),
    signals=TURNING,
    velocity_rows=("frame_b.w - frame_a.w - w",),
    results=(power("tau*w"),),
    drawing="turning",
)
IN_SPACE = in_space(KIND, about_n, velocity_rows=(f"{dot(W, GRADIENT)} - w",), tau="-lam[1]")
