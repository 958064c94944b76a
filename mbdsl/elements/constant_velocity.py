"""ConstantVelocity: a homokinetic joint, which transmits the rotation about the z axes of its frames at any bend.

r_b - r_a = 0,   x_a . y_b - y_a . x_b = 0      with z along the shafts; in space    (4 rows)
"""

from dataclasses import replace

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing, axis_given
from mbdsl.elements.row import Row
from mbdsl.elements.rows import POINT, X_A, X_B, Y_A, Y_B
from mbdsl.elements.vectors import both, cardan_angles, dot

BENDS = {
    "phi_x": "bend of the shaft of frame_b about the x axis of the joint in frame_a",
    "phi_y": "bend about the y axis, which phi_x has turned",
    "w_x": "rate of phi_x",
    "w_y": "rate of phi_y",
}

IN_SPACE = JointKind(
    "ConstantVelocity",
    doc="A homokinetic joint: shafts along n at any bend, with the same rotation about them.",
    g=(*POINT, Row(f"{dot(X_A, Y_B)} - {dot(Y_A, X_B)}")),
    parameters=(Parameter("n", "1", (0.0, 0.0, 1.0), "direction of the shafts, in both frames", shape=(3,)),),
    signals=tuple(replace(x, doc=BENDS[x.name]) for x in cardan_angles() if x.name in BENDS),
    check=axis_given,
    axes=both("z"),
    placing=Placing(moves=(("phi_x", "rx"), ("phi_y", "ry")), aligned=f"({dot(X_A, X_B)} + {dot(Y_A, Y_B)})"),
    spatial=True,
    drawing="ball",
)
