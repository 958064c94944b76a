"""RotationalStop: limits of the angle about the axis n, stiff torsional springs with damping beyond them.

g = angle of frame_b about n in frame_a;  torque = k d max(0, 1 + alpha d'),  d = phi - phi_max or phi_min - phi
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import rotational_stop
from mbdsl.elements.in_space import revolute
from mbdsl.elements.in_space.coordinates import angle, angle_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import both, direction

DRAWING = "nothing"
KIND = in_space(
    rotational_stop.KIND,
    parameters=(*rotational_stop.KIND.parameters, revolute.AXIS),
    signals=(*revolute.SIGNALS_OF_ANGLE, rotational_stop.KIND.signals[-1]),
    table=lambda v: (0.0, 0.0),
    check=lambda v: rotational_stop.KIND.check(v) or direction(v),
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
