"""Ground: the inertial frame, with gravity and any number of frames fixed to it."""

from math import hypot

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind, in_space, zero

#: tolerance of the length of n: {0.707, 0.707} is a rounded direction, {0.17, 0} is ambiguous
NEARLY = 1e-3


def check(v) -> str | None:
    length = hypot(*v["n"])
    if v["g"] == 0.0 or abs(length - 1.0) <= NEARLY:
        return None
    if length == 0.0:
        return "the direction n of gravity is zero"
    unit = "{" + ", ".join(f"{x / length:.6g}" for x in v["n"]) + "}"
    return (
        f"the direction n of gravity has the length {length:.6g}, expected 1: "
        f"for the full g in that direction write n = {unit}, for a part of it scale g"
    )


KIND = BodyKind(
    "Ground",
    doc="The inertial world. Its name stands for the frame at the origin; gravity acts on every body.",
    parameters=(
        Parameter("g", "m/s2", 9.81, "gravitational acceleration", minimum=0.0),
        Parameter("n", "1", (0.0, -1.0), "direction of gravity, of length 1", shape=(2,)),
        Parameter("frames", "", (), "further frames: frames(wall = {x, y, phi}, ...)"),
    ),
    check=check,
    effects={"gravity": zero("g")},
    is_frame=True,
)
IN_SPACE = in_space(
    KIND,
    parameters=(
        KIND.parameters[0],
        Parameter("n", "1", (0.0, -1.0, 0.0), "direction of gravity, of length 1", shape=(3,)),
        Parameter("frames", "", (), "further frames"),
    ),
    com=lambda v: (0.0, 0.0, 0.0),
)
