"""RackAndPinion: the pitch circle about the origin of frame_b rolls on the x axis of frame_a, the pitch line of a rack.

    g = t_a . (r_b - r_a) + radius (phi_b - phi_a) - s0                                  (1 row)

Unlike RollingDisc, it constrains positions, and other joints hold the distance of the pinion from the rack. The
multiplier is the force between the teeth along the rack [N].
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import prismatic, rolling_disc
from mbdsl.elements.coordinates import slide, slide_hessian
from mbdsl.elements.kind import JointKind, Parameter, wrench
from mbdsl.elements.motions import TURNING

DRAWING = "rack"
KIND = JointKind(
    "RackAndPinion",
    doc="A pinion about the origin of frame_b rolls on a rack along the x axis of frame_a, above it. Other "
    "joints guide the rack and hold the pinion.",
    rows=1,
    parameters=(
        Parameter("radius", "m", doc="pitch radius of the pinion", positive=True),
        Parameter("s0", "m", 0.0, "position of the pinion along the rack when frame_b is at the angle of frame_a"),
    ),
    signals=(*prismatic.KIND.signals, *TURNING),
    reactions=wrench("-(cos(frame_a.phi)*lam[1])", "-(sin(frame_a.phi)*lam[1])", "-(radius*lam[1])"),
    touches=rolling_disc.BELOW,
    table=lambda v: (v["radius"], v["s0"]),
)


@kernel
def gradient(frames, a, b, p, G):
    slide(frames, a, b, G, 0)
    G[0, VALUE] += p[0] * (frames[b, 2] - frames[a, 2]) - p[1]
    G[0, 2] -= p[0]
    G[0, 5] = p[0]


@kernel
def hessian(frames, a, b, p, s, H):
    slide_hessian(frames, a, b, s[0], H)
