"""Force: acts at the origin of frame_b, with components in the axes of frame_a (default: world axes).

f = fx x_a + fy y_a, in space + fz z_a.  frame_a only defines the directions: no reaction acts on it.
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import ForceKind, in_space
from mbdsl.elements.row import Row
from mbdsl.elements.rows import X_A, Y_A, Z_A
from mbdsl.elements.vectors import dot, total, velocity, wrench

FX, FY = "(fx*cos(frame_a.phi) - fy*sin(frame_a.phi))", "(fx*sin(frame_a.phi) + fy*cos(frame_a.phi))"
FORCE = total(("fx", X_A), ("fy", Y_A), ("fz", Z_A))
V = velocity("frame_b")

KIND = ForceKind(
    "Force",
    doc="A force on the origin of frame_b, with components in the axes of frame_a, or of the world without frame_a. No "
    "reaction acts on frame_a. With frame_a = frame_b it is a follower force.",
    g=(
        Row(dot(X_A, V), "cos(frame_a.phi)*frame_b.vx + sin(frame_a.phi)*frame_b.vy"),
        Row(dot(Y_A, V), "cos(frame_a.phi)*frame_b.vy - sin(frame_a.phi)*frame_b.vx"),
        Row(dot(Z_A, V)),
    ),
    optional_ports=("frame_a",),
    parameters=(
        Parameter("fx", "N", 0.0, "component along x, a number or an expression", law=True),
        Parameter("fy", "N", 0.0, "component along y, a number or an expression", law=True),
    ),
    results=(power(f"{FX}*frame_b.vx + {FY}*frame_b.vy"),),
    exerts={"fx": FX, "fy": FY},
    reacts=False,
    laws=("fx", "fy"),
    sign=1.0,
    drawing="nothing",
)
IN_SPACE = in_space(
    KIND,
    parameters=(
        *KIND.parameters,
        Parameter("fz", "N", 0.0, "component along z, a number or an expression", law=True),
    ),
    results=(power(dot(FORCE, V)),),
    exerts=wrench(FORCE, None),
    laws=("fx", "fy", "fz"),
)
