"""Rope: pulls two points together along a path over discs, and winds on drums at its ends.

The path, and the tensions of its spans, are those of :mod:`~mbdsl.elements.rope_path`. Each span is a component of this
kind, between two discs with the signed radii r_a, r_b:

    dg = u . (do_b - do_a) - r_a dphi_a + r_b dphi_b,   d^2 g = (n . (do_b - do_a))^2/s
"""

from dataclasses import replace
from math import sqrt

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.disc_tangents import span_gradient, span_hessian
from mbdsl.elements.kind import ForceKind, Signal, in_space, zero
from mbdsl.elements.motions import APART_IN_SPACE
from mbdsl.elements.rope_path import Path
from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel

MOST = 32  #: discs of a rope
_EACH = tuple((n,) for n in range(1, MOST + 1))


def check(values):
    radius, over = values["radius"], values["over"]
    count = len(over)
    if count > MOST:
        return f"it runs over {count} discs, more than {MOST}"
    if count and radius is None:
        return "`over` needs `radius`, of each disc: positive if the rope turns to the left around it, else negative"
    for name in ("radius", "turns"):
        found = values[name]
        if isinstance(found, tuple) and len(found) != count:
            return f"`{name}` has {len(found)} values, and `over` names {count}"
    for x in values["turns"] if isinstance(values["turns"], tuple) else (values["turns"],):
        if x < 0.0 or x != int(x):
            return f"`turns` is {x:g}, expected whole numbers from 0"
    if not count:
        given = [name for name in ("radius", "mu") if values[name] is not None]
        if given:
            return f"`{given[0]}` is that of the discs in `over`, which names none; a drum at frame_b has `drum`"
    elif 0.0 in (radius if isinstance(radius, tuple) else (radius,)):
        return "`radius` of a disc is 0 m; give it a sign: positive if the rope turns to the left around it"
    return None


def derive(values):
    """``radii`` and ``wound`` turns of the discs in ``over``, ``drums`` at both ends, radii ``ends`` of the span."""
    count, drum = len(values["over"]), values["drum"]
    radius, turns = (x if isinstance(x, tuple) else (x,) * count for x in (values["radius"], values["turns"]))
    drums = drum if isinstance(drum, tuple) else (0.0, drum)
    return {"radii": radius, "wound": turns, "drums": drums, "ends": drums}


KIND = ForceKind(
    "Rope",
    doc="A rope, cable or chain that pulls its ends together and never pushes. It may run over discs, and be wound on "
    "drums.",
    rows=1,
    parameters=(
        Parameter("k", "N/m", doc="stiffness of the whole rope", positive=True),
        Parameter("c", "N.s/m", 0.0, "damping", minimum=0.0),
        Parameter(
            "length",
            "m",
            None,
            "free length at the start, without what is wound on drums; default: that of the path at the start",
            positive=True,
        ),
        Parameter(
            "over",
            "",
            (),
            "frames, or bodies with their centres of mass, at the centres of the discs that it runs over, from frame_a "
            "to frame_b: `{wheel, block.sheave}`",
        ),
        Parameter(
            "radius",
            "m",
            None,
            "radius of each disc, or of all of them; positive if the rope turns to the left around the disc (in space: "
            "counter-clockwise about the z axis of its frame), negative if it turns to the right",
            or_shapes=_EACH,
        ),
        Parameter("turns", "1", 0.0, "full turns around each disc, in addition to less than one", or_shapes=_EACH),
        Parameter(
            "mu",
            "1",
            None,
            "coefficient of friction between rope and discs (0: none); without it, the rope does not slide: the discs "
            "turn with it",
            minimum=0.0,
        ),
        Parameter("v_s", "m/s", 1e-3, "speed over which this friction changes its sign: tanh(v/v_s)", positive=True),
        Parameter(
            "drum",
            "m",
            0.0,
            "radius of a drum about frame_b, or of drums about both ends, on which it is wound; signs as of `radius`",
            or_shapes=((2,),),
        ),
    ),
    signals=(
        Signal("s", "m", "hypot(frame_b.x - frame_a.x, frame_b.y - frame_a.y)", "length of the path"),
        Signal("v", "m/s", "der(s)", "its rate"),
        Signal("stretch", "m", "s - length", "by how much the rope is longer than its free length"),
        Signal(
            "tension",
            "N",
            "k*max(0, stretch) + max(-(k*max(0, stretch)), min(k*max(0, stretch), c*v))",
            "tension at frame_a",
        ),
        Signal("taken", "m", "s", "rope used by the first span, with what its discs have wound up or paid out"),
        Signal("tension_b", "N", "tension", "tension at frame_b"),
        Signal("slack", "1", "0.5 - 0.5*sign(stretch)", "1 where the rope is not stretched"),
    ),
    energy="0.5*k*max(0, stretch)^2",
    results=(power("-(tension*der(taken))"),),
    resists=(("tension", "taken"),),
    check=check,
    derive=derive,
    table=lambda v: v["ends"],
    laws=("tension",),
    effects={"damping": zero("c"), "friction": zero("mu")},
    path=Path,
    drawing="rope",
)


@kernel
def gradient(frames, a, b, p, G):
    dx, dy, r = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], p[1] - p[0]
    square = dx * dx + dy * dy
    s = sqrt(max(square - r * r, 0.0))
    ux, uy = 0.0, 0.0
    if square > 0.0:
        ux, uy = (s * dx + r * dy) / square, (s * dy - r * dx) / square
    G[0, C.VALUE] = s
    G[0, 0], G[0, 1], G[0, 2] = -ux, -uy, -p[0]
    G[0, 3], G[0, 4], G[0, 5] = ux, uy, p[1]


@kernel
def hessian(frames, a, b, p, s, H):
    dx, dy, r = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], p[1] - p[0]
    square = dx * dx + dy * dy
    l = sqrt(max(square - r * r, 0.0))
    if l > 0.0:
        nx, ny = (r * dx - l * dy) / square, (l * dx + r * dy) / square
        xx, xy, yy = s[0] * nx * nx / l, s[0] * nx * ny / l, s[0] * ny * ny / l
        for i in (0, 3):
            for j in (0, 3):
                sign = 1.0 if i == j else -1.0
                H[i, j] += sign * xx
                H[i, j + 1] += sign * xy
                H[i + 1, j] += sign * xy
                H[i + 1, j + 1] += sign * yy


IN_SPACE = in_space(
    KIND,
    signals=(replace(APART_IN_SPACE[0], doc=KIND.signals[0].doc), *APART_IN_SPACE[1:], *KIND.signals[2:]),
)


@kernel
def gradient_in_space(frames, a, b, p, G):
    span_gradient(frames, a, b, p[0], p[1], G, 0)


@kernel
def hessian_in_space(frames, a, b, p, s, H):
    span_hessian(frames, a, b, p[0], p[1], s[0], H)
