"""Cam: a cam that moves a follower along a line, by a function f of its angle.

    g = s - f(phi),  s = x_b . (r_b - r_a),  phi = phi_a - phi_b                         (1 row)

The follower moves along the x axis of frame_b, in space along n, which its guide keeps from turning; s is its position
from the centre of the cam. In space phi is the angle of frame_a about the axis of the cam, relative to frame_b. A flat
follower touches the cam at the distance f'(phi) from the axis, and the multiplier is the contact force [N]. For other
followers the contact force also has a component across the guide, which does no work and is left out.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Signal, in_space
from mbdsl.elements.motions import GRADIENT
from mbdsl.elements.rack_and_pinion import axes, right_angle
from mbdsl.elements.row import Row
from mbdsl.elements.rows import X_A, X_B, Y_A
from mbdsl.elements.vectors import D, W, dot

LIFT = "cos(frame_b.phi)*(frame_b.x - frame_a.x) + sin(frame_b.phi)*(frame_b.y - frame_a.y)"
RATE = f"(-{dot(W, GRADIENT)})"

KIND = JointKind(
    "Cam",
    doc="A cam about the origin of frame_a moves the origin of frame_b along the x axis of frame_b, as a function of "
    "the cam angle.",
    g=(Row(f"{dot(X_B, D)} - law[1]", f"{LIFT} - law[1]"),),
    parameters=(Parameter("s", "m", doc="position of the follower at the cam angle phi", law=True),),
    signals=(
        Signal("phi", "rad", "frame_a.phi - frame_b.phi", "angle of the cam relative to the axis of the follower"),
        Signal("w", "rad/s", "der(phi)", "angular velocity of the cam"),
        Signal("s", "m", LIFT, "position of the follower along its x axis, from the centre of the cam"),
        Signal("v", "m/s", "der(s)", "its rate"),
    ),
    functions=(("s", ("phi",)),),
    drawing="cam",
)
IN_SPACE = in_space(
    KIND,
    doc="A cam about the origin of frame_a moves the origin of frame_b along n of frame_b, as a function of the cam "
    "angle.",
    parameters=(
        *KIND.parameters,
        Parameter("n", "1", (1.0, 0.0, 0.0), "direction of the follower's motion", shape=(3,)),
        Parameter("axis", "1", (0.0, 0.0, 1.0), "axis of the cam, at right angles to n", shape=(3,)),
    ),
    signals=(
        Signal(
            "phi", "rad", f"angle(-{dot(Y_A, X_B)}, {dot(X_A, X_B)}, {RATE})", "angle of the cam relative to frame_b"
        ),
        Signal("w", "rad/s", RATE, "angular velocity of the cam"),
        Signal("s", "m", dot(X_B, D), "position of the follower along n, from the centre of the cam"),
        Signal("v", "m/s", "der(s)", "its rate"),
    ),
    check=lambda v: right_angle(v, "the axis of the cam is not at right angles to the motion of the follower"),
    axes=axes,
    first_angles={"phi": "frame_a.phi - frame_b.phi"},
)
