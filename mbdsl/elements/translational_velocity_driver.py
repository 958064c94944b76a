"""TranslationalVelocityDriver: prescribes the velocity of frame_b along the x axis of frame_a; the position follows.

    Gamma = d/dt (t_a . (r_b - r_a)) - u = 0                                             (1 row, of velocities)

u may depend on more than time: on inputs, positions and other velocities.
"""

from mbdsl.elements import prismatic, translational_driver
from mbdsl.elements.kind import AXIAL, JointKind, Parameter, power

KIND = JointKind(
    "TranslationalVelocityDriver",
    doc="A drive that moves a sliding joint with a given velocity.",
    parameters=(Parameter("v", "m/s", doc="the velocity", law=True),),
    signals=prismatic.KIND.signals,
    velocity_rows=("der(s) - v",),
    reactions=translational_driver.KIND.reactions,
    results=(AXIAL, power("-(force*v)")),
)
