"""DistanceDriver: prescribes the distance of two frame origins (a linear actuator; rheonomic).

|r_b - r_a| - u(t) = 0                                                               (1 row)
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import AXIAL, JointKind, Placing, in_space
from mbdsl.elements.motions import APART, APART_IN_SPACE
from mbdsl.elements.rows import LENGTH

KIND = JointKind(
    "DistanceDriver",
    doc="A linear actuator whose length is a given function of time.",
    g=(LENGTH,),
    parameters=(Parameter("s", "m", doc="the distance, an expression in time; stays above zero", law=True),),
    signals=APART,
    results=(AXIAL, power("-(force*v)")),
    driver="s",
    placing=Placing(along=("s",)),
    drawing="actuator",
)
IN_SPACE = in_space(KIND, signals=APART_IN_SPACE)
