"""Fixed: a weld.

g = r_b - r_a,   x_a . y_b,   x_a . z_b,   y_a . z_b                                     (6 rows)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, point
from mbdsl.elements.in_space.prismatic import SAME_ATTITUDE, X_A, Y_A, Y_B, Z_A, Z_B
from mbdsl.elements.in_space.vectors import about, cross, dot, reactions, total
from mbdsl.elements.kind import JointKind, Parameter, Signal

FORCE, TORQUE = ("fx", "fy", "fz"), ("tx", "ty", "tz")
#: of the section between both bodies, as in the plane; Q and M are Qy and Mz
SECTION = (
    Signal("N", "N", f"-{dot(FORCE, X_A)}", "normal force along x of frame_a, tension"),
    Signal("Qy", "N", f"-{dot(FORCE, Y_A)}", "shear force along y of frame_a"),
    Signal("Qz", "N", f"-{dot(FORCE, Z_A)}", "shear force along z of frame_a"),
    Signal("Mx", "N.m", f"-{dot(TORQUE, X_A)}", "torsional moment about x of frame_a"),
    Signal("My", "N.m", f"-{dot(TORQUE, Y_A)}", "bending moment about y of frame_a"),
    Signal("Mz", "N.m", f"-{dot(TORQUE, Z_A)}", "bending moment about z of frame_a"),
    Signal("Q", "N", "Qy", "shear force along y of frame_a, as in the plane"),
    Signal("M", "N.m", "Mz", "bending moment about z of frame_a, as in the plane"),
)

KIND = JointKind(
    "Fixed",
    doc="A weld: frame_b keeps position and attitude relative to frame_a.",
    rows=6,
    parameters=(Parameter("phi0", "rad", 0.0, "the constant angle of frame_b about the z axis of frame_a"),),
    reactions=reactions(
        ("-lam[1]", "-lam[2]", "-lam[3]"),
        total(("lam[4]", cross(X_A, Y_B)), ("lam[5]", cross(X_A, Z_B)), ("lam[6]", cross(Y_A, Z_B))),
    ),
    results=SECTION,
    axes=lambda v: {"frame_b": about((0.0, 0.0, 1.0), -v["phi0"])} if v["phi0"] else {},
    keeps_attitude=True,
    aligned=SAME_ATTITUDE,
    curved_by_rotations=True,
    in_loops="fixed_in_axes",
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
    dot1(frames, a, X, b, Y, G, 3)
    dot1(frames, a, X, b, Z, G, 4)
    dot1(frames, a, Y, b, Z, G, 5)


@kernel
def hessian(frames, a, b, p, s, H):
    dot1_hessian(frames, a, X, b, Y, s[3], H)
    dot1_hessian(frames, a, X, b, Z, s[4], H)
    dot1_hessian(frames, a, Y, b, Z, s[5], H)
