"""SphereCapsuleContact: a ball about the origin of frame_b on a capsule of frame_a, with friction; in space.

With the centre c of the ball in frame_a, x along the capsule, its distance from the nearest point of the axis is

    o = (c_x - max(-length/2, min(length/2, c_x)), c_y, c_z),   gap = |o| - R - radius,   n = o/|o|
"""

from mbdsl.elements.sphere_box_contact import CENTRE
from mbdsl.elements.sphere_cylinder_contact import on_round

TERMS = {
    **CENTRE,
    "ox": "cx - max(-0.5*length, min(0.5*length, cx))",
    "beside": "hypot(hypot(ox, cy), cz)",
    "separation": "beside - R",
}
IN_SPACE = on_round(
    "SphereCapsuleContact",
    "capsule",
    "length of the capsule without its round ends",
    ("ratio(ox, beside)", "ratio(cy, beside)", "ratio(cz, beside)"),
    TERMS,
)
