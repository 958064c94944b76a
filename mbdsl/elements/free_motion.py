"""FreeMotion: no constraint; declares that a body may move freely, and measures its motion in world axes."""

from mbdsl.elements.kind import JointKind, Signal, in_space
from mbdsl.elements.motions import TURNING_ASKEW
from mbdsl.elements.vectors import D, W

KIND = JointKind(
    "FreeMotion",
    doc="No constraint on frame_b: declares that a body without joints or forces may move freely.",
    rows=0,
    signals=(
        Signal("x", "m", "frame_b.x - frame_a.x", "in world axes"),
        Signal("y", "m", "frame_b.y - frame_a.y", "in world axes"),
        Signal("phi", "rad", "frame_b.phi - frame_a.phi"),
        Signal("vx", "m/s", "der(x)"),
        Signal("vy", "m/s", "der(y)"),
        Signal("w", "rad/s", "der(phi)"),
    ),
    drawing="nothing",
)
IN_SPACE = in_space(
    KIND,
    signals=(
        *(Signal(key, "m", d, "in world axes") for key, d in zip("xyz", D, strict=True)),
        *TURNING_ASKEW,
        *(Signal(f"v{key}", "m/s", f"der({key})") for key in "xyz"),
        *(
            Signal(f"w{key}", "rad/s", w, "relative angular velocity, in world axes")
            for key, w in zip("xyz", W, strict=True)
        ),
    ),
)
