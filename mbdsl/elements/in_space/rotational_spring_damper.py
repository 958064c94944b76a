"""RotationalSpringDamper: a torsional spring and damper about the axis n, linear or by a law of angle phi and rate w.

g = angle of frame_b about n in frame_a;  torque  k (g - phi0) + c dg/dt, against the relative rotation
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import rotational_spring_damper
from mbdsl.elements.in_space import revolute
from mbdsl.elements.in_space.coordinates import angle, angle_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import both, direction

KIND = in_space(
    rotational_spring_damper.KIND,
    parameters=(*rotational_spring_damper.KIND.parameters, revolute.AXIS),
    signals=(*revolute.SIGNALS_OF_ANGLE, rotational_spring_damper.KIND.signals[-1]),
    table=lambda v: (0.0, 0.0),
    check=lambda v: rotational_spring_damper.KIND.check(v) or direction(v),
    follows="rotation",
    axes=both("z"),
    counts_turns=True,
)


@kernel
def gradient(frames, a, b, p, G):
    angle(frames, a, b, p, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    angle_hessian(frames, a, b, s[0], H)
