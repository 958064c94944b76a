"""Ground: the inertial frame, with gravity and any number of frames fixed to it."""

from mbdsl.elements.kind import BodyKind, Parameter, zero

KIND = BodyKind(
    "Ground",
    doc="The inertial world. Its name stands for the frame at the origin; gravity acts on every body.",
    parameters=(
        Parameter("g", "m/s2", 9.81, "gravitational acceleration", minimum=0.0),
        Parameter("n", "1", (0.0, -1.0), "direction of gravity (normalised)", shape=(2,)),
        Parameter("frames", "", (), "further frames: frames(wall = {x, y, phi}, ...)"),
    ),
    check=lambda v: None if any(v["n"]) or v["g"] == 0.0 else "the direction n of gravity is zero",
    effects={"gravity": zero("g")},
    is_frame=True,
)
