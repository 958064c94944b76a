"""Fixed: a weld.

    g = (r_b - r_a, phi_b - phi_a - phi0)                                                (3 rows)
"""

from mbdsl.elements.kind import JointKind, Parameter, kernel

KIND = JointKind(
    "Fixed",
    doc="A weld: frame_b keeps position and angle relative to frame_a.",
    rows=3,
    parameters=(Parameter("phi0", "rad", 0.0, "the constant angle of frame_b relative to frame_a"),),
    reaction=("fx", "fy", "tau"),
    table=lambda v: (v["phi0"],),
)


@kernel
def position(Z, a, b, p, g):
    g[0] = Z[b, 0] - Z[a, 0]
    g[1] = Z[b, 1] - Z[a, 1]
    g[2] = Z[b, 2] - Z[a, 2] - p[0]


@kernel
def jacobian(Z, a, b, p, G):
    for k in range(3):
        G[k, k], G[k, k + 3] = -1.0, 1.0
