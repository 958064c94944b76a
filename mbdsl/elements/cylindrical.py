"""Cylindrical: frame_b slides along the axis n of frame_a and turns about it; in space.

    y_a . d = 0,   z_a . d = 0,   y_a . x_b = 0,   z_a . x_b = 0     with d = r_b - r_a and x along n    (4 rows)

Friction: a force mu |(lam_1, lam_2)| on the surface of the shaft, against the sliding there, v along the axis and
radius w around it, see friction.py and sliding_friction.py. Without a radius, it acts along the axis only.
"""

from collections.abc import Mapping

from mbdsl.elements import friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AT_B_IN_SPACE, JointKind, Placing, Signal, axis_given
from mbdsl.elements.motions import AXIS_X, SLIDING_IN_SPACE
from mbdsl.elements.rows import X_A, X_B, Y_A, Y_B, Z_A, along, normal
from mbdsl.elements.sliding_friction import components, delivered, speed
from mbdsl.elements.vectors import W, both, dot, total, wrench

#: the x axes of both frames lie on one line
LINES = along("y"), along("z"), normal("y", "x"), normal("z", "x")
RATES = "v", "(radius*w)"
ALONG, AROUND = components("v", *RATES)
PARAMETERS = (*friction.parameters("v", "m/s", 1e-3), friction.STICKS)
NORMAL = "hypot(lam[1], lam[2])"


def derive(v: Mapping) -> dict:
    return friction.derive(v) | ({"radius": 0.0} if v["radius"] is None else {})


IN_SPACE = JointKind(
    "Cylindrical",
    doc="Frame_b slides along the axis n of frame_a and turns about it.",
    g=LINES,
    parameters=(
        AXIS_X,
        Parameter("radius", "m", None, "radius of the shaft; without it, rotation has no friction", positive=True),
        *PARAMETERS,
    ),
    signals=(
        *SLIDING_IN_SPACE,
        Signal("phi", "rad", f"angle({dot(Z_A, Y_B)}, {dot(Y_A, Y_B)}, w)", "angle of frame_b about the axis"),
        Signal("w", "rad/s", dot(W, X_A), "its rate"),
    ),
    friction=friction.formula(NORMAL, speed("v", *RATES), "v"),
    friction_along="sliding_on_shaft",
    friction_rows=(ALONG, f"radius*{AROUND}"),
    normal=NORMAL,
    slides=RATES,
    places=("s", "radius*phi"),
    sticking_rows=("rub[1]", "radius*rub[2]"),
    touches=AT_B_IN_SPACE,
    results=(delivered("v", *RATES), friction.SLIDING_ON_SURFACE),
    exerts=wrench(total(("(-drag[1])", X_A)), total(("(-drag[2])", X_A))),
    check=lambda v: axis_given(v) or friction.check({**v, "radius": 0.0}),
    derive=derive,
    effects=friction.EFFECTS,
    axes=both("x"),
    placing=Placing(
        along=("s",),
        moves=(("s", "x"), ("phi", "rx")),
        aligned=dot(X_A, X_B),
        free_axes={"rotation": "n", "translation": "n"},
    ),
    spatial=True,
    drawing="sleeve",
)
