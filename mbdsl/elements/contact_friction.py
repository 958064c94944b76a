"""ContactFriction: force and torque on a frame, the friction of a rigid contact that slides."""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import ForceKind, in_space
from mbdsl.elements.row import Row

PLANE, SPACE = ("fx", "fy", "tau"), ("fx", "fy", "fz", "tx", "ty", "tz")


def loads(names):
    return tuple(Parameter(name, "any", 0.0, "a component, an expression", law=True) for name in names)


KIND = ForceKind(
    "ContactFriction",
    doc="Friction of a rigid contact.",
    g=(
        Row("frame_b.vx", "frame_b.vx"),
        Row("frame_b.vy", "frame_b.vy"),
        Row("frame_b.vz"),
        Row("frame_b.wx"),
        Row("frame_b.wy"),
        Row("frame_b.wz", "frame_b.w"),
    ),
    parameters=loads(PLANE),
    reacts=False,
    laws=PLANE,
    sign=1.0,
    drawing="nothing",
    variant="contact_friction",
)
IN_SPACE = in_space(KIND, parameters=loads(SPACE), laws=SPACE)
