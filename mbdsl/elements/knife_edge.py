"""KnifeEdge: a blade, skate or wheel that does not slip sideways (nonholonomic).

    Gamma = y_b . (v_b - v_a - w_a x (r_b - r_a)) = 0                                    (1 row, of velocities)

relative to the point below the blade of the body that frame_a is fixed to. In space, k x x_b with the normal k of the
plane takes the place of y_b; the joint does not keep the blade on the plane: PointOnPlane does.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AT_B, JointKind, Signal, in_space
from mbdsl.elements.motions import TURNING, TURNING_ASKEW
from mbdsl.elements.rows import X_B, Z_A
from mbdsl.elements.vectors import cross, dot, slip, turned_to

_FORWARD = "(frame_b.vx - frame_a.vx + frame_a.w*(frame_b.y - frame_a.y))"
_SIDEWARD = "(frame_b.vy - frame_a.vy - frame_a.w*(frame_b.x - frame_a.x))"

KIND = JointKind(
    "KnifeEdge",
    doc="A blade at the origin of frame_b: it moves along its x axis and turns, but does not slip along its y axis.",
    optional_ports=("frame_a",),
    signals=(
        Signal("v", "m/s", f"cos(frame_b.phi)*{_FORWARD} + sin(frame_b.phi)*{_SIDEWARD}", "velocity along the blade"),
        *TURNING,
    ),
    velocity_rows=(f"cos(frame_b.phi)*{_SIDEWARD} - sin(frame_b.phi)*{_FORWARD}",),
    touches=AT_B,
    drawing="blade",
)
IN_SPACE = in_space(
    KIND,
    doc="A blade at the origin of frame_b: it moves along its x axis and turns, but does not slip sideways on a plane.",
    parameters=(Parameter("n", "1", (0.0, 0.0, 1.0), "normal of the plane, in frame_a", shape=(3,)),),
    signals=(Signal("v", "m/s", dot(X_B, slip()), "velocity along the blade"), *TURNING_ASKEW),
    velocity_rows=(dot(cross(Z_A, X_B), slip()),),
    axes=lambda v: {"frame_a": turned_to("z", v["n"])},
)
