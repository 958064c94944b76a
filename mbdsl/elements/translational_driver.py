"""TranslationalDriver: prescribes the position of frame_b along the axis n of frame_a (rheonomic).

x_a . (r_b - r_a) - u(t) = 0      with x along n, in the plane the x axis            (1 row)
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import AXIAL, JointKind, Placing, in_space
from mbdsl.elements.motions import SLIDING, along_n
from mbdsl.elements.rows import along

KIND = JointKind(
    "TranslationalDriver",
    doc="A drive that moves a sliding joint as a given function of time.",
    g=(along("x"),),
    parameters=(Parameter("s", "m", doc="the position, an expression in time", law=True),),
    signals=SLIDING,
    results=(AXIAL, power("-(force*v)")),
    driver="s",
    placing=Placing(along=("s",)),
    drawing="pushing",
)
IN_SPACE = in_space(KIND, along_n, drawing="actuator")
