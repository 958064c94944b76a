"""Coupling: two coordinates in a fixed ratio, as by gears, belts, racks and cables whose parts are not modelled.

    g = b - ratio a,   g = offset(t)                                                     (1 row, by expression)

a and b are functions of positions: coordinates of joints or bodies, angles with their whole turns. The multiplier is
the generalised force on the coordinate b, up to its sign; ratio times the opposite acts on a. They are the forces of a
mechanism without losses: their power is that of the offset alone.
"""

from mbdsl.elements.declaration import ANY, Parameter, power
from mbdsl.elements.kind import JointKind, Signal, in_space


def check(v):
    if v["ratio"] == 0.0:
        return "its ratio is zero, so that b does not depend on a; for a motion in time use a driver"
    return None


KIND = JointKind(
    "Coupling",
    doc="Two coordinates in a fixed ratio: b = ratio*a + offset. They are angles or lengths, of joints or bodies, or "
    "expressions of these. It has no frames.",
    ports=(),
    rows=1,
    coupled=("a", "b"),
    parameters=(
        Parameter("a", "", doc="the first coordinate, such as `pin.phi`", law=True),
        Parameter("b", "", doc="the second coordinate", law=True),
        Parameter("ratio", ANY, 1.0, "b divided by a, with the unit of b/a; required if a and b have different units"),
        Parameter("offset", "", 0.0, "b where a is zero, an expression in time with the unit of b", law=True),
    ),
    relations=("b - ratio*a",),
    driver="offset",
    reactions=(Signal("force", "", "-lam[1]", "generalised force on b: a torque [N.m] on an angle, else a force [N]"),),
    results=(power("force*der(offset)"),),
    check=check,
    drawing="nothing",
)
IN_SPACE = in_space(KIND)
