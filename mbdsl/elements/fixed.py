"""Fixed: a weld.

    r_b - r_a = 0,   x_a . y_b = 0,   x_a . z_b = 0,   y_a . z_b = 0                     (6 rows)

In the plane the last rows are phi_b - phi_a - phi0 = 0 (3 rows).
"""

from mbdsl.elements.kind import JointKind, Placing, Signal, in_space
from mbdsl.elements.prismatic import PHI0, PHI0_IN_SPACE
from mbdsl.elements.rows import POINT, SAME, SAME_ATTITUDE, X_A, Y_A, Z_A
from mbdsl.elements.vectors import about, dot

#: of the section between both bodies, whose normal is the x axis of frame_a: what acts on frame_a, in its axes
SECTION = (
    Signal("N", "N", "-(fx*cos(frame_a.phi) + fy*sin(frame_a.phi))", "normal force along x of frame_a, tension"),
    Signal("Q", "N", "-(fy*cos(frame_a.phi) - fx*sin(frame_a.phi))", "shear force along y of frame_a"),
    Signal("M", "N.m", "-tau", "bending moment"),
)
FORCE, TORQUE = ("fx", "fy", "fz"), ("tx", "ty", "tz")
#: the same in space; Q and M are Qy and Mz
SECTION_IN_SPACE = (
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
    doc="A weld: frame_b keeps position and angle relative to frame_a.",
    g=(*POINT, *SAME_ATTITUDE),
    parameters=(PHI0,),
    results=SECTION,
    placing=Placing(pose=lambda v, s: (0.0, 0.0, v["phi0"]), keeps_attitude=True, angle=("phi0",)),
    drawing="weld",
)
IN_SPACE = in_space(
    KIND,
    doc="A weld: frame_b keeps position and attitude relative to frame_a.",
    parameters=(PHI0_IN_SPACE,),
    results=SECTION_IN_SPACE,
    axes=lambda v: {"frame_b": about((0.0, 0.0, 1.0), -v["phi0"])} if v["phi0"] else {},
    placing=Placing(keeps_attitude=True, aligned=SAME),
)
