"""CircleContact: two balls that push each other apart where they overlap, or a ball in a spherical hole.

force = k d max(0, 1 + alpha d'),  d = r_a + r_b - |r_b - r_a| > 0     as of the circles of the plane
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import circle_contact
from mbdsl.elements.in_space.coordinates import length, length_hessian
from mbdsl.elements.in_space.distance import SIGNALS
from mbdsl.elements.in_space.kinds import in_space

DRAWING = "circles"

KIND = in_space(
    circle_contact.KIND,
    doc="Contact of two balls about the frame origins, which push each other apart where they overlap; without "
    "friction.",
    signals=(*SIGNALS, *circle_contact.KIND.signals[2:]),
)


@kernel
def gradient(frames, a, b, p, G):
    length(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    length_hessian(frames, a, b, s[0], H)
