"""Ground: the inertial frame in space, with gravity and any number of frames fixed to it."""

from mbdsl.elements import ground
from mbdsl.elements.kind import BodyKind, Parameter, zero

KIND = BodyKind(
    "Ground",
    doc=ground.KIND.doc,
    parameters=(
        ground.KIND.parameters[0],
        Parameter("n", "1", (0.0, -1.0, 0.0), "direction of gravity, of length 1", shape=(3,)),
        Parameter("frames", "", (), "further frames"),
    ),
    check=ground.check,
    effects={"gravity": zero("g")},
    com=lambda v: (0.0, 0.0, 0.0),
    is_frame=True,
    spatial=True,
)
