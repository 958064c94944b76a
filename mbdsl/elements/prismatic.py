"""Prismatic: frame_b slides along the x axis of frame_a without turning relative to it.

    g1 = n_a . (r_b - r_a)
    g2 = phi_b - phi_a - phi0                                                            (2 rows)

Friction: a force mu * |lam_1| against the sliding, see friction.py.
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.coordinates import angle, offset, offset_hessian
from mbdsl.elements.kind import AT_B, JointKind, Parameter, Signal, power, wrench

KIND = JointKind(
    "Prismatic",
    doc="A sliding joint: frame_b moves on the x axis of frame_a and keeps its angle to it.",
    rows=2,
    parameters=(
        Parameter("phi0", "rad", 0.0, "the constant angle of frame_b relative to frame_a"),
        *friction.parameters("v", "m/s", 1e-3),
    ),
    signals=(
        Signal(
            "s",
            "m",
            "cos(frame_a.phi)*(frame_b.x - frame_a.x) + sin(frame_a.phi)*(frame_b.y - frame_a.y)",
            "position of frame_b along the axis",
        ),
        Signal("v", "m/s", "der(s)", "sliding velocity"),
    ),
    reactions=wrench("sin(frame_a.phi)*lam[1]", "-(cos(frame_a.phi)*lam[1])", "-lam[2]"),
    friction=friction.formula("abs(lam[1])", "v"),
    friction_along="translational_spring_damper",
    results=(power("-(friction*v)"),),
    touches=AT_B,
    resists=(("friction", "s"),),
    check=friction.check,
    derive=friction.derive,
    effects=friction.EFFECTS,
    table=lambda v: (v["phi0"],),
    pose=lambda v, s: (s, 0.0, v["phi0"]),
    free="s",
    keeps_attitude=True,
    angle=("phi0",),
    along=("s",),
)


@kernel
def gradient(frames, a, b, p, G):
    offset(frames, a, b, G, 0)
    angle(frames, a, b, G, 1)
    G[1, VALUE] -= p[0]


@kernel
def hessian(frames, a, b, p, s, H):
    offset_hessian(frames, a, b, s[0], H)
