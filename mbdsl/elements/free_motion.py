"""FreeMotion: no constraint; declares that a body may move freely, and measures its motion."""

from mbdsl.elements.kind import JointKind, Signal

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
)
