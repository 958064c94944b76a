"""KnifeEdge: a blade, skate or wheel that does not slip sideways on a plane (nonholonomic).

    Gamma = (k x x_b) . (v_b - v_a - w_a x (r_b - r_a)) = 0                              (1 row, of velocities)

with k the normal of the plane, so that k x x_b lies in the plane, across the blade. It does not keep the blade on the
plane: PointOnPlane does.
"""

from mbdsl.elements import knife_edge
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.revolute import SIGNALS_OF_ANGLE, X_B, Z_A
from mbdsl.elements.in_space.vectors import cross, direction, dot, origin, reactions, slip, total, turned_to
from mbdsl.elements.kind import Parameter, Signal

ACROSS = cross(Z_A, X_B)

KIND = in_space(
    knife_edge.KIND,
    doc="A blade at the origin of frame_b: it moves along its x axis and turns, but does not slip sideways on a plane.",
    parameters=(Parameter("n", "1", (0.0, 0.0, 1.0), "normal of the plane, in frame_a", shape=(3,)),),
    signals=(Signal("v", "m/s", dot(X_B, slip()), "velocity along the blade"), *SIGNALS_OF_ANGLE),
    velocity_rows=(dot(ACROSS, slip()),),
    reactions=reactions(total(("-lam[1]", ACROSS)), None),
    touches=origin("frame_b"),
    check=direction,
    axes=lambda v: {"frame_a": turned_to("z", v["n"])},
)
