"""Revolute: a pin that holds two frame origins together and leaves the angle between them free.

    g = r_b - r_a                                                                        (2 rows)

Friction in the pin: a torque mu * radius * |(lam_1, lam_2)| against the relative rotation, see friction.py.
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.kind import JointKind, Parameter, Signal, power, wrench

KIND = JointKind(
    "Revolute",
    doc="A pin joint: the origins of frame_a and frame_b coincide.",
    rows=2,
    parameters=(
        Parameter("radius", "m", None, "radius of the pin; required with friction", positive=True),
        *friction.parameters("w", "rad/s", 0.01),
    ),
    signals=(
        Signal("phi", "rad", "frame_b.phi - frame_a.phi", "angle of frame_b relative to frame_a"),
        Signal("w", "rad/s", "der(phi)", "relative angular velocity"),
    ),
    reactions=wrench("-lam[1]", "-lam[2]"),
    friction=friction.formula("radius*hypot(lam[1], lam[2])", "w"),
    friction_along="rotational_spring_damper",
    results=(power("-(friction*w)"),),
    resists=(("friction", "phi"),),
    check=friction.check,
    derive=friction.derive,
    effects=friction.EFFECTS,
    pose=lambda v, s: (0.0, 0.0, s),
    free="phi",
    angle=("phi",),
)


@kernel
def gradient(frames, a, b, p, G):
    for k in range(2):
        G[k, VALUE] = frames[b, k] - frames[a, k]
        G[k, k], G[k, 3 + k] = -1.0, 1.0
