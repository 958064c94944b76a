"""GearPair: two gears in mesh, as pitch circles that roll on each other (a constraint of positions).

    g = r_a (phi_a - theta) + r_b (phi_b - theta - phi0)                                 (1 row)

with theta the angle of the line of centres, see line_of_centres.py; for a ring with internal teeth r_b is negative, and
theta is that of the line from frame_b to frame_a, on which the circles touch. The centres may move, like those of
planets: the body that holds them apart is the carrier. The multiplier is the force between the teeth along the common
tangent of the pitch circles [N]; the force along the line of centres, due to the pressure angle, does no work and is
left out.
"""

from math import pi

from mbdsl.compilation.marks import kernel
from mbdsl.elements.kind import JointKind, Parameter, Signal, wrench
from mbdsl.elements.line_of_centres import FORMULA, SQUARE, rolling, rolling_hessian

DRAWING = "gears"
SIGNALS = (
    Signal("theta", "rad", FORMULA, "angle of the line from frame_a to frame_b"),
    Signal("phi", "rad", "frame_b.phi - frame_a.phi", "angle of frame_b relative to frame_a"),
    Signal("w", "rad/s", "der(phi)", "relative angular velocity"),
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
)


@kernel
def gradient(frames, a, b, p, G):
    rolling(frames, a, b, p, G)


@kernel
def hessian(frames, a, b, p, s, H):
    rolling_hessian(frames, a, b, p, s, H)
