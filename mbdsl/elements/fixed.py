"""Fixed: a weld.

g = (r_b - r_a, phi_b - phi_a - phi0)                                                (3 rows)
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements.kind import JointKind, Parameter, Signal, wrench

#: of the section between both bodies, whose normal is the x axis of frame_a: what acts on frame_a, in its axes
SECTION = (
    Signal("N", "N", "-(fx*cos(frame_a.phi) + fy*sin(frame_a.phi))", "normal force along x of frame_a, tension"),
    Signal("Q", "N", "-(fy*cos(frame_a.phi) - fx*sin(frame_a.phi))", "shear force along y of frame_a"),
    Signal("M", "N.m", "-tau", "bending moment"),
)

KIND = JointKind(
    "Fixed",
    doc="A weld: frame_b keeps position and angle relative to frame_a.",
    rows=3,
    parameters=(Parameter("phi0", "rad", 0.0, "the constant angle of frame_b relative to frame_a"),),
    reactions=wrench("-lam[1]", "-lam[2]", "-lam[3]"),
    results=SECTION,
    table=lambda v: (v["phi0"],),
    pose=lambda v, s: (0.0, 0.0, v["phi0"]),
    keeps_attitude=True,
    angle=("phi0",),
)


@kernel
def gradient(frames, a, b, p, G):
    for k in range(3):
        G[k, VALUE] = frames[b, k] - frames[a, k]
        G[k, k], G[k, k + 3] = -1.0, 1.0
    G[2, VALUE] -= p[0]
