"""RotationalDriver: prescribes the angle of frame_b relative to frame_a as a function of time (rheonomic).

phi - u(t) = 0      in space, phi is the angle of x_b about z_a, with z along n      (1 row)
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import JointKind, Placing, in_space
from mbdsl.elements.motions import TURNING, about_n
from mbdsl.elements.rows import ANGLE

KIND = JointKind(
    "RotationalDriver",
    doc="A drive that turns a joint as a given function of time.",
    g=(ANGLE,),
    parameters=(Parameter("phi", "rad", doc="the angle, an expression in time", law=True),),
    signals=TURNING,
    results=(power("tau*w"),),
    driver="phi",
    placing=Placing(angle=("phi",)),
    drawing="turning",
)
IN_SPACE = in_space(KIND, about_n, tau="-lam[1]")
