"""Screw: frame_b slides along the axis n of frame_a and turns about it in proportion, as a nut on a spindle; in space.

    y_a . d,   z_a . d,   y_a . x_b,   z_a . x_b,   x_a . d - h angle      with d = r_b - r_a, x along n   (5 rows)

h = pitch/(2 pi), and the angle is that of y_b about x_a. Whole turns, that is whole pitches, are removed from the last
row: the number of turns follows from the position, so that s = h phi.

Friction: a force mu N along the thread at its mean radius r, against the sliding there, v along the axis and r w around
it, see friction.py and sliding_friction.py. The flanks of a square thread carry the thrust lam_5 with the normal force
lam_5 (1 + (h/r)^2)^(1/2), and N contains the load (lam_1, lam_2) across the axis as well. A thread that sticks is held
along the helix of this radius: its place is (s + (r/h) r phi)/(1 + (r/h)^2)^(1/2).
"""

from collections.abc import Mapping
from math import pi

from mbdsl.elements import cylindrical, friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import Signal, axis_given, in_space
from mbdsl.elements.motions import AXIS_X, SLIDING_IN_SPACE
from mbdsl.elements.row import Row
from mbdsl.elements.rows import X_A, Y_A, Y_B, Z_A
from mbdsl.elements.sliding_friction import delivered, speed
from mbdsl.elements.vectors import D, W, dot

ANGLE_OF = f"{dot(Z_A, Y_B)}, {dot(Y_A, Y_B)}"
POSITION, ANGLE = f"{dot(X_A, D)}", f"atan2({ANGLE_OF})"
TURNS = f"floor(({POSITION}/(pitch/{2 * pi!r}) - {ANGLE})/{2 * pi!r} + 0.5)"
SLOPE = f"(radius*{2 * pi!r}/pitch)"  # r/h
HELIX = f"hypot(1, {SLOPE})"
FLANKS = f"lam[5]*hypot(1, pitch/({2 * pi!r}*radius))"


NORMAL = f"hypot(hypot(lam[1], lam[2]), {FLANKS})"


def check(v: Mapping) -> str | None:
    if v["pitch"] == 0.0:
        return "the pitch is zero: the joint is a Revolute"
    return axis_given(v) or friction.check(v)


IN_SPACE = in_space(
    cylindrical.IN_SPACE,
    name="Screw",
    doc="A nut on a spindle: frame_b slides along the axis n of frame_a, and turns about it once for each pitch.",
    g=(*cylindrical.LINES, Row(f"{POSITION} - pitch/{2 * pi!r}*({ANGLE} + {2 * pi!r}*{TURNS})")),
    parameters=(
        Parameter("pitch", "m", doc="displacement of a turn to the right; negative for a left-hand thread"),
        AXIS_X,
        Parameter("radius", "m", None, "mean radius of the thread; required with friction", positive=True),
        *cylindrical.PARAMETERS,
    ),
    signals=(
        *SLIDING_IN_SPACE,
        Signal("phi", "rad", f"s/pitch*{2 * pi!r}", "angle of frame_b about the axis, in proportion to s"),
        Signal("w", "rad/s", f"v/pitch*{2 * pi!r}", "its rate"),
    ),
    friction=friction.formula(NORMAL, speed("v", *cylindrical.RATES), "v"),
    normal=NORMAL,
    slides=(f"v*{HELIX}",),
    places=(f"(s + {SLOPE}*radius*angle({ANGLE_OF}, {dot(W, X_A)}))/{HELIX}",),
    sticking_rows=(f"rub[1]/{HELIX}", f"rub[1]*radius*{SLOPE}/{HELIX}"),
    results=(delivered("v", *cylindrical.RATES), friction.SLIDING),
    derive=friction.derive,
    check=check,
)
