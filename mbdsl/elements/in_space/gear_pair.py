"""GearPair: two gears in mesh, whose axes have the direction n, as pitch circles that roll on each other.

    g = r_a phi_a + r_b (phi_b - phi0)     with the angles from the line of centres, see line_of_centres.py  (1 row)

for a ring with internal teeth r_b is negative. The carrier, which holds the axes parallel and apart, may move in any
way. The multiplier is the force between the teeth along the common tangent of the pitch circles [N].
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import gear_pair
from mbdsl.elements.in_space.line_of_centres import (
    ANGLES,
    FIRST_ANGLES,
    M_A,
    M_B,
    THETA,
    rolling,
    rolling_hessian,
)
from mbdsl.elements.kind import axis_given, in_space
from mbdsl.elements.motions import AXIS_Z, TURNING_ASKEW
from mbdsl.elements.vectors import D, both, cross, reactions, total

DRAWING = "gears"
SIGNALS = (THETA, *TURNING_ASKEW, *ANGLES)
REACTIONS = reactions(
    total(("lam[1]*r[1]", M_A), ("lam[1]*r[2]", M_B)),
    total(("lam[1]*r[2]", cross(M_B, D))),
)

KIND = in_space(
    gear_pair.KIND,
    parameters=(*gear_pair.KIND.parameters, AXIS_Z),
    signals=SIGNALS,
    reactions=REACTIONS,
    check=lambda v: gear_pair.check(v) or axis_given(v),
    table=lambda v: (0.0, 0.0, 0.0, 0.0, *gear_pair.KIND.table(v)),
    axes=both("z"),
    counts_turns=True,
    counted=("phi_a", "phi_b"),
    first_angles=FIRST_ANGLES,
)


@kernel
def gradient(frames, a, b, p, G):
    rolling(frames, a, b, p, G)


@kernel
def hessian(frames, a, b, p, s, H):
    rolling_hessian(frames, a, b, p, s, H)
