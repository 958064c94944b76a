"""PlanetaryGear: a sun, a ring with internal teeth, and a carrier with planets between them, as one part.

    g = (sun - carrier) + ratio (ring - carrier) - phi0                                  (1 row, by expression)

Relative to the carrier, the sun turns -ratio times as far as the ring, ratio = teeth of the ring/teeth of the sun
(R. Willis, *Principles of Mechanism*, 1841). The torques on sun, ring and carrier are as 1 : ratio : -(1 + ratio).
Their sum is zero, so that no housing carries any. The planets have no mass here.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Signal, in_space


def check(v):
    if not v["ratio"] > 1.0:
        return f"its ratio is {v['ratio']:g}, but the ring has more teeth than the sun that it surrounds"
    return None


KIND = JointKind(
    "PlanetaryGear",
    doc="A planetary stage as one part: sun - carrier = -ratio*(ring - carrier) + phi0, with the angles of the three "
    "shafts, of joints on one axis or of bodies. It has no frames.",
    ports=(),
    rows=1,
    coupled=("sun", "carrier", "ring"),
    parameters=(
        Parameter("sun", "rad", doc="angle of the sun, such as `sun_pin.phi`", law=True),
        Parameter("carrier", "rad", doc="angle of the carrier of the planets", law=True),
        Parameter("ring", "rad", doc="angle of the ring", law=True),
        Parameter("ratio", "1", doc="teeth of the ring divided by teeth of the sun"),
        Parameter("phi0", "rad", 0.0, "angle of the sun where those of ring and carrier are zero"),
    ),
    relations=("sun - carrier + ratio*(ring - carrier) - phi0",),
    reactions=(
        Signal("tau_sun", "N.m", "-lam[1]", "torque on the sun"),
        Signal("tau_carrier", "N.m", "(1 + ratio)*lam[1]", "torque on the carrier"),
        Signal("tau_ring", "N.m", "-ratio*lam[1]", "torque on the ring"),
    ),
    check=check,
    drawing="nothing",
)
IN_SPACE = in_space(KIND)
