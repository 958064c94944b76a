"""Screw: frame_b slides along the axis n of frame_a and turns about it in proportion, as a nut on a spindle.

    g = y_a . d,   z_a . d,   y_a . x_b,   z_a . x_b,   x_a . d - h angle      with d = r_b - r_a, x along n   (5 rows)

h = pitch/(2 pi), and the angle is that of y_b about x_a. Whole turns, that is whole pitches, are removed from the last
row: the number of turns follows from the position, so that s = h phi.

Friction: a force mu N along the thread at its mean radius r, against the sliding there, v along the axis and r w around
it, see friction.py and sliding_friction.py. The flanks of a square thread carry the thrust lam_5 with the normal force
lam_5 (1 + (h/r)^2)^(1/2), and N contains the load (lam_1, lam_2) across the axis as well.
"""

from collections.abc import Mapping
from math import floor, pi

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space import cylindrical, prismatic, sliding_friction
from mbdsl.elements.in_space.coordinates import (
    PHI_A,
    PHI_B,
    X,
    Y,
    Z,
    angle_about,
    angle_about_hessian,
    dot2,
    dot2_hessian,
)
from mbdsl.elements.in_space.cylindrical import lines, lines_hessian
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.prismatic import SIGNALS, X_A, Y_A, Z_A
from mbdsl.elements.in_space.vectors import cross, direction, reactions, total
from mbdsl.elements.kind import Parameter, Signal


def check(v: Mapping) -> str | None:
    if v["pitch"] == 0.0:
        return "the pitch is zero: the joint is a Revolute"
    return direction(v) or friction.check(v)


FLANKS = f"lam[5]*hypot(1, pitch/({2 * pi!r}*radius))"
KIND = in_space(
    cylindrical.KIND,
    name="Screw",
    doc="A nut on a spindle: frame_b slides along the axis n of frame_a, and turns about it once for each pitch.",
    rows=5,
    parameters=(
        Parameter("pitch", "m", doc="displacement of a turn to the right; negative for a left-hand thread"),
        prismatic.AXIS,
        Parameter("radius", "m", None, "mean radius of the thread; required with friction", positive=True),
        *friction.parameters("v", "m/s", 1e-3),
    ),
    signals=(
        *SIGNALS,
        Signal("phi", "rad", f"s/pitch*{2 * pi!r}", "angle of frame_b about the axis, in proportion to s"),
        Signal("w", "rad/s", f"v/pitch*{2 * pi!r}", "its rate"),
    ),
    reactions=reactions(
        total(("-lam[1]", Y_A), ("-lam[2]", Z_A), ("-lam[5]", X_A)),
        total(
            ("lam[3]", cross(Y_A, cylindrical.X_B)),
            ("lam[4]", cross(Z_A, cylindrical.X_B)),
            (f"(lam[5]*pitch/{2 * pi!r})", X_A),
        ),
    ),
    friction=sliding_friction.size(f"hypot(hypot(lam[1], lam[2]), {FLANKS})", "v", *cylindrical.RATES),
    derive=friction.derive,
    check=check,
    table=lambda v: (v["pitch"] / (2 * pi),),
)


@kernel
def gradient(frames, a, b, p, G):
    lines(frames, a, b, G)
    h = p[0]
    angle = angle_about(frames, a, b, Y, Z, X, G, 4)
    x, y, z = h * G[4, PHI_B], h * G[4, PHI_B + 1], h * G[4, PHI_B + 2]
    dot2(frames, a, X, b, G, 4)
    turns = floor((G[4, VALUE] / h - angle) / (2.0 * pi) + 0.5)
    G[4, VALUE] -= h * (angle + 2.0 * pi * turns)
    G[4, PHI_A] += x
    G[4, PHI_A + 1] += y
    G[4, PHI_A + 2] += z
    G[4, PHI_B], G[4, PHI_B + 1], G[4, PHI_B + 2] = -x, -y, -z


@kernel
def hessian(frames, a, b, p, s, H):
    lines_hessian(frames, a, b, s, H)
    dot2_hessian(frames, a, X, b, s[4], H)
    angle_about_hessian(frames, a, b, Y, X, -p[0] * s[4], H)
