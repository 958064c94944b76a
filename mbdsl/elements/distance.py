"""Distance: a massless link that keeps two frame origins at a constant distance L > 0.

|r_b - r_a| - L = 0                                                                  (1 row)
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AXIAL, JointKind, Placing, in_space
from mbdsl.elements.motions import APART, APART_IN_SPACE
from mbdsl.elements.rows import LENGTH, less

KIND = JointKind(
    "Distance",
    doc="A massless rigid link: the distance of the two frame origins stays constant.",
    g=(less(LENGTH, "length"),),
    parameters=(Parameter("length", "m", doc="the constant distance", positive=True),),
    signals=APART,
    results=(AXIAL,),
    placing=Placing(along=("s", "length")),
    size="length",
    drawing="rod",
)
IN_SPACE = in_space(KIND, signals=APART_IN_SPACE)
