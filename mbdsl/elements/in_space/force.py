"""Force: acts at the origin of frame_b, with components in the axes of frame_a (default: world axes).

f = fx x_a + fy y_a + fz z_a.  frame_a only defines the directions: no reaction acts on it.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import force
from mbdsl.elements.in_space.coordinates import PHI_A, R_B, X, add_cross
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import axis, dot, total, wrench
from mbdsl.elements.kind import Parameter, power

FORCE = total(*((f"f{i}", axis("frame_a", i)) for i in "xyz"))

KIND = in_space(
    force.KIND,
    rows=3,
    parameters=(
        *force.KIND.parameters,
        Parameter("fz", "N", 0.0, "component along z, a number or an expression", law=True),
    ),
    results=(power(dot(FORCE, tuple(f"frame_b.v{i}" for i in "xyz"))),),  # type: ignore[arg-type]
    exerts=wrench(FORCE, None),
    laws=("fx", "fy", "fz"),
)


@kernel
def gradient(frames, a, b, p, G):
    for k in range(3):
        for i in range(3):
            G[k, R_B + i] = frames[a, X + 3 * k + i]


@kernel
def hessian(frames, a, b, p, s, H):
    for k in range(3):
        x, y, z = s[k] * frames[a, X + 3 * k], s[k] * frames[a, X + 3 * k + 1], s[k] * frames[a, X + 3 * k + 2]
        add_cross(-x, -y, -z, H, R_B, PHI_A)
