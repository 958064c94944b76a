"""CircleContact: two balls that push each other apart where they overlap, or a ball in a spherical hole.

force = k d max(0, 1 + alpha d'),  d = r_a + r_b - |r_b - r_a| > 0     as of the circles of the plane
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import circle_contact
from mbdsl.elements.coordinates_in_space import length, length_hessian
from mbdsl.elements.kind import in_space
from mbdsl.elements.motions import APART_IN_SPACE

DRAWING = "circles"

KIND = in_space(
    circle_contact.KIND,
    doc="Contact of two balls about the frame origins, which push each other apart where they overlap; without "
    "friction.",
    signals=(*APART_IN_SPACE, *circle_contact.KIND.signals[2:]),
)


@kernel
def gradient(frames, a, b, p, G):
    length(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    length_hessian(frames, a, b, s[0], H)
