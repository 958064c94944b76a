"""RackAndPinion: the pitch circle about the origin of frame_b rolls on the x axis of frame_a, the pitch line of a rack.

    g = t_a . (r_b - r_a) + radius (phi_b - phi_a) - s0                                  (1 row)

Unlike RollingDisc, it constrains positions, and other joints hold the distance of the pinion from the rack. The
multiplier is the force between the teeth along the rack [N]. In space the rack lies along n of frame_a; phi is the
angle of frame_b relative to frame_a about the axis of the pinion, so that the rack may move in any way, with what
guides the pinion.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, in_space
from mbdsl.elements.motions import SLIDING, SLIDING_IN_SPACE, TURNING, TURNING_ASKEW
from mbdsl.elements.rolling_disc import BELOW
from mbdsl.elements.row import Row
from mbdsl.elements.rows import ANGLE, TURN, Y_A, along
from mbdsl.elements.universal import product, unit
from mbdsl.elements.vectors import origin, total

RIGHT = 1e-9  #: cosine of two directions that counts as that of a right angle


def right_angle(v, problem):
    """A ``check`` for the direction n and the axis."""
    if not (any(v["n"]) and any(v["axis"])):
        return "the direction n or the axis is zero"
    along = sum(x * y for x, y in zip(unit(v["n"]), unit(v["axis"]), strict=True))
    return None if abs(along) < RIGHT else problem


def axes(v):
    """x along the rack, z along the axis of the pinion."""
    x, z = unit(v["n"]), unit(v["axis"])
    found = (*x, *product(z, x), *z)
    return {"frame_a": found, "frame_b": found}


KIND = JointKind(
    "RackAndPinion",
    doc="A pinion about the origin of frame_b rolls on a rack along the x axis of frame_a, above it. Other "
    "joints guide the rack and hold the pinion.",
    g=(Row(f"{along('x').space} + radius*{ANGLE.space} - s0", f"{along('x').plane} + radius*({TURN}) - s0"),),
    parameters=(
        Parameter("radius", "m", doc="pitch radius of the pinion", positive=True),
        Parameter("s0", "m", 0.0, "position of the pinion along the rack when frame_b is at the angle of frame_a"),
    ),
    signals=(*SLIDING, *TURNING),
    touches=BELOW,
    drawing="rack",
)
IN_SPACE = in_space(
    KIND,
    doc="A pinion about the origin of frame_b rolls on a rack along n of frame_a, on the side of axis x n. Other "
    "joints guide the rack and hold the pinion.",
    parameters=(
        *KIND.parameters,
        Parameter("n", "1", (1.0, 0.0, 0.0), "direction of the rack", shape=(3,)),
        Parameter("axis", "1", (0.0, 0.0, 1.0), "axis of the pinion, at right angles to n", shape=(3,)),
    ),
    signals=(*SLIDING_IN_SPACE, *TURNING_ASKEW),
    check=lambda v: right_angle(v, "the axis of the pinion is not at right angles to the rack"),
    touches=total(("1", origin("frame_b")), ("(-radius)", Y_A)),
    axes=axes,
)
