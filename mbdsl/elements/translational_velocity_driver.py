"""TranslationalVelocityDriver: prescribes the velocity of frame_b along the axis n of frame_a; the position follows.

    Gamma = d/dt (x_a . (r_b - r_a)) - u = 0      with x along n                         (1 row, of velocities)

u may depend on more than time: on inputs, positions and other velocities.
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import AXIAL, JointKind, in_space
from mbdsl.elements.motions import SLIDING, along_n

KIND = JointKind(
    "TranslationalVelocityDriver",
    doc="A drive that moves a sliding joint with a given velocity.",
    parameters=(Parameter("v", "m/s", doc="the velocity", law=True),),
    signals=SLIDING,
    velocity_rows=("der(s) - v",),
    results=(AXIAL, power("-(force*v)")),
    drawing="pushing",
)
IN_SPACE = in_space(KIND, along_n, drawing="actuator")
