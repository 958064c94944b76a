"""PointOnLine: the origin of frame_b moves on the x axis of frame_a (a pin in a slot), free to turn.

    g = n_a . (r_b - r_a)                                                                (1 row)

Friction: a force mu * |lam| against the sliding, see friction.py.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction, prismatic
from mbdsl.elements.coordinates import offset, offset_hessian
from mbdsl.elements.kind import AT_B, JointKind, Signal, power, wrench

KIND = JointKind(
    "PointOnLine",
    doc="A pin in a slot: the origin of frame_b stays on the x axis of frame_a.",
    rows=1,
    parameters=friction.parameters("v", "m/s", 1e-3),
    signals=(
        *prismatic.KIND.signals,
        Signal("phi", "rad", "frame_b.phi - frame_a.phi", "angle of frame_b relative to frame_a"),
        Signal("w", "rad/s", "der(phi)", "relative angular velocity"),
    ),
    reactions=wrench("sin(frame_a.phi)*lam[1]", "-(cos(frame_a.phi)*lam[1])"),
    friction=friction.formula("abs(lam[1])", "v"),
    friction_along="translational_spring_damper",
    results=(power("-(friction*v)"),),
    touches=AT_B,
    resists=(("friction", "s"),),
    check=friction.check,
    derive=friction.derive,
    effects=friction.EFFECTS,
    angle=("phi",),
    along=("s",),
)


@kernel
def gradient(frames, a, b, p, G):
    offset(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    offset_hessian(frames, a, b, s[0], H)
