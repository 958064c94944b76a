"""ElasticBelt: a belt around two pulleys with axes along n that stretches: a spring and damper along the coordinate of
a BeltDrive.

    g = r_a phi_a + r_b phi_b,  force  k (g - g_0) + c dg/dt

with the angles from the line of centres, see line_of_centres.py, and g_0 at the start.
"""

from mbdsl.elements import elastic_belt
from mbdsl.elements.in_space.gear_pair import SIGNALS, gradient, hessian
from mbdsl.elements.in_space.line_of_centres import FIRST_ANGLES
from mbdsl.elements.kind import axis_given, in_space
from mbdsl.elements.motions import AXIS_Z
from mbdsl.elements.vectors import both

__all__ = ["KIND", "gradient", "hessian"]  #: the kernels are those of a pair of gears

DRAWING = "belt"

KIND = in_space(
    elastic_belt.KIND,
    parameters=(*elastic_belt.KIND.parameters, AXIS_Z),
    signals=(*SIGNALS, *elastic_belt.along("r[1]*(phi_a - start(phi_a)) + r[2]*(phi_b - start(phi_b))")),
    check=axis_given,
    table=lambda v: (0.0, 0.0, 0.0, 0.0, *v["r"], 0.0),
    axes=both("z"),
    counts_turns=True,
    counted=("phi_a", "phi_b"),
    first_angles=FIRST_ANGLES,
)
