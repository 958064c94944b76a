"""SphereCapsuleContact: a ball about the origin of frame_b on a capsule of frame_a, with friction; in space.

With the centre c of the ball in frame_a, x along the capsule, its distance from the nearest point of the axis is

    o = (c_x - max(-length/2, min(length/2, c_x)), c_y, c_z),   gap = |o| - R - radius,   n = o/|o|
"""

from mbdsl.elements.contact_points import contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.sphere_box_contact import BALL, CENTRE, touch
from mbdsl.elements.sphere_cylinder_contact import AXIS, along_axis, check

TERMS = {
    **CENTRE,
    "ox": "cx - max(-0.5*length, min(0.5*length, cx))",
    "beside": "hypot(hypot(ox, cy), cz)",
    "separation": "beside - R",
}
IN_SPACE = contact(
    "SphereCapsuleContact",
    "A ball about the origin of frame_b on the outside of a capsule about the origin of frame_a; with friction.",
    (
        BALL,
        Parameter("length", "m", doc="length of the capsule without its round ends", positive=True),
        Parameter("R", "m", doc="radius of the capsule", positive=True),
        AXIS,
    ),
    [touch(("ratio(ox, beside)", "ratio(cy, beside)", "ratio(cz, beside)"))],
    spatial=True,
    terms=TERMS,
    axes=along_axis,
    check=check,
    drawing="nothing",
)
