"""GearPair: two gears in mesh, as pitch circles that roll on each other (a constraint of positions).

    g = r_a (phi_a - theta) + r_b (phi_b - theta - phi0)                                 (1 row)

with theta the angle of the line of centres, see line_of_centres.py; for a ring with internal teeth r_b is negative, and
theta is that of the line from frame_b to frame_a, on which the circles touch. The centres may move, like those of
planets: the body that holds them apart is the carrier. The multiplier is the force between the teeth along the common
tangent of the pitch circles [N]; the force along the line of centres, due to the pressure angle, does no work and is
left out.

In space, both gears have axes in the direction n, and phi_a - theta, phi_b - theta are the angles of the frames from
the line of centres about these axes (line_of_centres_in_space.py). The carrier, which holds the axes parallel and
apart, may move in any way.
"""

from math import pi

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, PairKind, Signal, in_space, wrench
from mbdsl.elements.line_of_centres import FORMULA, SQUARE
from mbdsl.elements.line_of_centres import rolling as gradient
from mbdsl.elements.line_of_centres import rolling_hessian as hessian
from mbdsl.elements.line_of_centres_in_space import ANGLES, FIRST_ANGLES, M_A, M_B, THETA
from mbdsl.elements.line_of_centres_in_space import rolling as gradient_in_space
from mbdsl.elements.line_of_centres_in_space import rolling_hessian as hessian_in_space
from mbdsl.elements.motions import AXIS_Z, TURNING, TURNING_ASKEW
from mbdsl.elements.vectors import D, both, cross, reactions, total

SIGNALS = (
    Signal("theta", "rad", FORMULA, "angle of the line from frame_a to frame_b"),
    *TURNING,
)
#: the force between the teeth acts where the pitch circles touch
REACTIONS = wrench(
    f"-(lam[1]*(r[1] + r[2])*(frame_b.y - frame_a.y)/{SQUARE})",
    f"lam[1]*(r[1] + r[2])*(frame_b.x - frame_a.x)/{SQUARE}",
    "-(lam[1]*r[2])",
)
CLOSE = 1e-3  #: difference of two radii, relative to their mean, below which its sign is not reliable in a motion


LOOSE = 0.01  #: difference of the distance of the centres from that of touching pitch circles, relative to it


def close(r_a, r_b):
    """Whether two radii are almost equal."""
    return abs(r_a - r_b) < 0.5 * CLOSE * (r_a + r_b)


def check(values):
    r_a, r_b = values["r_a"], values["r_b"]
    if values["internal"] and (r_b < r_a or close(r_a, r_b)):
        return f"frame_b has the internal teeth, but its radius r_b = {r_b:g} m is not larger than r_a = {r_a:g} m"
    return None


def misfit(values, distance):
    touching = abs(sum(values["r"]))
    if abs(distance - touching) > LOOSE * touching:
        return f"its centres are {distance:.4g} m apart, but its pitch circles touch at {touching:.4g} m"
    return None


KIND = JointKind(
    "GearPair",
    doc="Two gears in mesh: their pitch circles about the frame origins roll on each other. Other joints hold "
    "the centres apart, on the ground or on a moving carrier.",
    rows=1,
    parameters=(
        Parameter("r_a", "m", doc="pitch radius about frame_a", positive=True),
        Parameter("r_b", "m", doc="pitch radius about frame_b", positive=True),
        Parameter("internal", "", False, "whether frame_b is a ring gear with internal teeth, around frame_a"),
        Parameter("phi0", "rad", 0.0, "angle of frame_b when frame_a and the line of centres are at angle 0"),
    ),
    signals=SIGNALS,
    reactions=REACTIONS,
    check=check,
    misfit=misfit,
    derive=lambda v: {"r": (v["r_a"], -v["r_b"] if v["internal"] else v["r_b"])},
    table=lambda v: (*v["r"], v["r"][1] * v["phi0"] + (pi * sum(v["r"]) if v["internal"] else 0.0)),
    drawing="gears",
)


SIGNALS_IN_SPACE = (THETA, *TURNING_ASKEW, *ANGLES)
REACTIONS_IN_SPACE = reactions(
    total(("lam[1]*r[1]", M_A), ("lam[1]*r[2]", M_B)),
    total(("lam[1]*r[2]", cross(M_B, D))),
)


def about_parallel_axes(kind: PairKind) -> dict:
    """What changes in space in gears and belts: both frames have the axis n, and angles from the line of centres are
    counted."""
    return {
        "parameters": (*kind.parameters, AXIS_Z),
        "signals": SIGNALS_IN_SPACE,
        "table": lambda v: (0.0, 0.0, 0.0, 0.0, *kind.table(v)),
        "axes": both("z"),
        "counts_turns": True,
        "counted": ("phi_a", "phi_b"),
        "first_angles": FIRST_ANGLES,
    }


IN_SPACE = in_space(KIND, about_parallel_axes, reactions=REACTIONS_IN_SPACE)
