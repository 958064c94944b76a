"""KnifeEdge: a blade, skate or wheel that does not slip sideways (nonholonomic).

    Gamma = n_b . (v_b - v_a - w_a x (r_b - r_a)) = 0                                    (1 row, of velocities)

with n_b the y axis of frame_b, relative to the point below the blade of the body that frame_a is fixed to.
"""

from mbdsl.elements.kind import AT_B, JointKind, Signal, wrench

_FORWARD = "(frame_b.vx - frame_a.vx + frame_a.w*(frame_b.y - frame_a.y))"
_SIDEWARD = "(frame_b.vy - frame_a.vy - frame_a.w*(frame_b.x - frame_a.x))"

KIND = JointKind(
    "KnifeEdge",
    doc="A blade at the origin of frame_b: it moves along its x axis and turns, but does not slip along its y axis.",
    optional_ports=("frame_a",),
    signals=(
        Signal("v", "m/s", f"cos(frame_b.phi)*{_FORWARD} + sin(frame_b.phi)*{_SIDEWARD}", "velocity along the blade"),
        Signal("phi", "rad", "frame_b.phi - frame_a.phi", "angle of frame_b relative to frame_a"),
        Signal("w", "rad/s", "der(phi)", "relative angular velocity"),
    ),
    velocity_rows=(f"cos(frame_b.phi)*{_SIDEWARD} - sin(frame_b.phi)*{_FORWARD}",),
    reactions=wrench("sin(frame_b.phi)*lam[1]", "-(cos(frame_b.phi)*lam[1])"),
    touches=AT_B,
)
