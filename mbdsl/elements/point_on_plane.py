"""PointOnPlane: the origin of frame_b stays on the plane through the origin of frame_a with the normal n; in space.

    z_a . d = 0      with d = r_b - r_a and z along n                                    (1 row)

Friction: a force mu |lam| against the sliding, see friction.py and sliding_friction.py.
"""

from mbdsl.elements import friction, sliding_friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AT_B_IN_SPACE, JointKind, Placing, Signal, axis_given
from mbdsl.elements.rows import X_A, Y_A, along
from mbdsl.elements.vectors import turned_to

ON_PLANE = sliding_friction.against(
    "abs(lam[1])", "v", "sliding_on_plane", ("der(s_x)", "der(s_y)"), (X_A, Y_A), ("s_x", "s_y")
)

IN_SPACE = JointKind(
    "PointOnPlane",
    doc="The origin of frame_b stays on the plane with the normal n through the origin of frame_a.",
    g=(along("z"),),
    parameters=(
        Parameter("n", "1", (0.0, 0.0, 1.0), "normal of the plane, in frame_a", shape=(3,)),
        *friction.parameters("v", "m/s", 1e-3),
        friction.STICKS,
    ),
    signals=(
        Signal("s_x", "m", along("x").space, "position of frame_b along the x axis of the plane"),
        Signal("s_y", "m", along("y").space, "position of frame_b along the y axis of the plane"),
    ),
    **ON_PLANE | {"check": lambda v: axis_given(v) or friction.check(v)},
    touches=AT_B_IN_SPACE,
    axes=lambda v: {"frame_a": turned_to("z", v["n"])},
    placing=Placing(moves=(("s_x", "x"), ("s_y", "y")), free_axes={"translation": None}),
    spatial=True,
    drawing="point",
)
