"""Prismatic: frame_b slides along the axis n of frame_a and does not turn relative to it.

    y_a . d = 0,   z_a . d = 0,   x_a . y_b = 0,   x_a . z_b = 0,   y_a . z_b = 0        (5 rows)

with d = r_b - r_a and x along n. In the plane, n is the x axis: y_a . d = 0, phi_b - phi_a - phi0 = 0 (2 rows).

Friction: a force mu |(lam_1, lam_2)|, in the plane mu |lam_1|, against the sliding, see friction.py. How torques load
the guide depends on its length, and they are left out.
"""

from mbdsl.elements import friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AT_B, JointKind, Placing, in_space
from mbdsl.elements.motions import AXIS_X, SLIDING, SLIDING_IN_SPACE
from mbdsl.elements.rows import SAME, SAME_ATTITUDE, along
from mbdsl.elements.vectors import UNTURNED, about, turned_to

PHI0 = Parameter("phi0", "rad", 0.0, "the constant angle of frame_b relative to frame_a")
PHI0_IN_SPACE = Parameter("phi0", "rad", 0.0, "the constant angle of frame_b about the z axis of frame_a")


def axes(v):
    """Frame_b is turned back by phi0 about the z axis of frame_a, and both have x along n."""
    n = turned_to("x", v["n"])
    if not v["phi0"]:
        return {"frame_a": n, "frame_b": n}
    back = about((0.0, 0.0, 1.0), -v["phi0"])
    product = tuple(sum(back[3 * k + i] * n[3 * j + k] for k in range(3)) for j in range(3) for i in range(3))
    return {"frame_a": n, "frame_b": product if product != UNTURNED else UNTURNED}


KIND = JointKind(
    "Prismatic",
    doc="A sliding joint: frame_b moves on the x axis of frame_a and keeps its angle to it.",
    g=(along("y"), along("z"), *SAME_ATTITUDE),
    parameters=(PHI0, *friction.parameters("v", "m/s", 1e-3), friction.STICKS),
    signals=SLIDING,
    **friction.against("abs(lam[1])", "v", "s", "translational_spring_damper"),
    touches=AT_B,
    placing=Placing(
        pose=lambda v, s: (s, 0.0, v["phi0"]), free="s", keeps_attitude=True, angle=("phi0",), along=("s",)
    ),
    drawing="slider",
)
IN_SPACE = in_space(
    KIND,
    doc="A sliding joint: frame_b moves along the axis n of frame_a and does not turn.",
    parameters=(AXIS_X, PHI0_IN_SPACE, *KIND.parameters[1:]),
    signals=SLIDING_IN_SPACE,
    friction=friction.formula("hypot(lam[1], lam[2])", "v"),
    normal="hypot(lam[1], lam[2])",
    axes=axes,
    placing=Placing(keeps_attitude=True, along=("s",), aligned=SAME, free_axes={"translation": "n"}),
)
