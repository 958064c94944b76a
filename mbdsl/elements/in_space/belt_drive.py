"""BeltDrive: a belt or chain around two pulleys or sprockets with axes along n, without slip or stretch.

    g = r_a phi_a + r_b (phi_b - phi0)     with the angles from the line of centres, see line_of_centres.py  (1 row)

r_b is negative for an open belt, whose pulleys turn in the same sense, and positive for a crossed belt. The multiplier
is the difference of the tensions of the strands [N].
"""

from mbdsl.elements import belt_drive
from mbdsl.elements.in_space.gear_pair import REACTIONS, SIGNALS, gradient, hessian
from mbdsl.elements.in_space.line_of_centres import FIRST_ANGLES
from mbdsl.elements.kind import axis_given, in_space
from mbdsl.elements.motions import AXIS_Z
from mbdsl.elements.vectors import both

__all__ = ["KIND", "gradient", "hessian"]  #: the kernels are those of a pair of gears

DRAWING = "belt"

KIND = in_space(
    belt_drive.KIND,
    parameters=(*belt_drive.KIND.parameters, AXIS_Z),
    signals=SIGNALS,
    reactions=REACTIONS,
    check=lambda v: belt_drive.check(v) or axis_given(v),
    table=lambda v: (0.0, 0.0, 0.0, 0.0, *belt_drive.KIND.table(v)),
    axes=both("z"),
    counts_turns=True,
    counted=("phi_a", "phi_b"),
    first_angles=FIRST_ANGLES,
)
