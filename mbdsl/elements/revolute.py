"""Revolute: a pin that holds two frame origins together and leaves the angle between them free.

    g = r_b - r_a                                                                        (2 rows)
"""

from mbdsl.elements.kind import JointKind, Signal, kernel

KIND = JointKind(
    "Revolute",
    doc="A pin joint: the origins of frame_a and frame_b coincide.",
    rows=2,
    signals=(
        Signal("phi", "rad", "frame_b.phi - frame_a.phi", "angle of frame_b relative to frame_a"),
        Signal("w", "rad/s", "der(phi)", "relative angular velocity"),
    ),
)


@kernel
def position(Z, a, b, p, g):
    g[0] = Z[b, 0] - Z[a, 0]
    g[1] = Z[b, 1] - Z[a, 1]


@kernel
def jacobian(Z, a, b, p, G):
    G[0, 0], G[0, 3] = -1.0, 1.0
    G[1, 1], G[1, 4] = -1.0, 1.0
