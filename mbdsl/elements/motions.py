"""Motions that joints leave free, and forces act along: their signals, and the parameters of their axes in space."""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import Kind, Signal
from mbdsl.elements.rows import TURN, X_A, X_B, Y_A, Z_A, along
from mbdsl.elements.vectors import D, W, both, dot, gradient_of_angle, turned_to

AXIS_X = Parameter("n", "1", (1.0, 0.0, 0.0), "axis of the motion, in frame_a", shape=(3,))
AXIS_Z = Parameter("n", "1", (0.0, 0.0, 1.0), "axis of the rotation, in frame_a", shape=(3,))

#: rotation: of frame_b relative to frame_a, in space about z_a
TURNING = (
    Signal("phi", "rad", TURN, "angle of frame_b relative to frame_a"),
    Signal("w", "rad/s", "der(phi)", "relative angular velocity"),
)
TURNING_IN_SPACE = (
    Signal("phi", "rad", f"angle({dot(Y_A, X_B)}, {dot(X_A, X_B)}, w)", "angle of frame_b about the axis of frame_a"),
    Signal("w", "rad/s", dot(W, Z_A), "its rate"),
)
#: the same where z_a and z_b may differ: the gradient of the angle is not z_a then
GRADIENT = gradient_of_angle()
TURNING_ASKEW = (TURNING_IN_SPACE[0], Signal("w", "rad/s", dot(W, GRADIENT), "its rate"))

#: translation along x_a
SLIDING = (
    Signal("s", "m", along("x").plane, "position of frame_b along the axis"),
    Signal("v", "m/s", "der(s)", "sliding velocity"),
)
SLIDING_IN_SPACE = (
    Signal("s", "m", dot(X_A, D), "position of frame_b along the axis"),
    Signal("v", "m/s", "der(s)", "its rate"),
)
#: distance of the origins
APART = (
    Signal("s", "m", "hypot(frame_b.x - frame_a.x, frame_b.y - frame_a.y)", "distance of the frames"),
    Signal("v", "m/s", "der(s)", "its rate"),
)
APART_IN_SPACE = Signal("s", "m", f"sqrt({dot(D, D)})", "distance of the frames"), APART[1]


def about_n(kind: Kind) -> dict:
    """What changes in space in a kind with the signals of a rotation: it has an axis n."""
    return {
        "parameters": (*kind.parameters, AXIS_Z),
        "signals": (*TURNING_ASKEW, *kind.signals[2:]),
        "follows": "rotation",
        "axes": both("z"),
    }


def along_n(kind: Kind) -> dict:
    """What changes in space in a kind with the signals of a translation: it has an axis n."""
    return {
        "parameters": (*kind.parameters, AXIS_X),
        "signals": (*SLIDING_IN_SPACE, *kind.signals[2:]),
        "follows": "translation",
        "axes": lambda v: {"frame_a": turned_to("x", v["n"])},
    }
