"""Rows: scalar coordinates of two frames as formulas, from which joints, drivers and forces are made.

A joint requires that its rows are zero; a force acts along them. From the formulas follow the gradient, the second
derivatives, the reactions (:mod:`mbdsl.elements.row_derivatives`) and what remains of a joint in a plane.

Formulas are those of :mod:`mbdsl.expressions.formulas`, over the frames and the parameters of a component. The plane is
z = 0: a row that holds there identically has no formula in the plane.
"""

from __future__ import annotations

from mbdsl.elements.row import Row
from mbdsl.elements.vectors import D, axis, dot

X_A, Y_A, Z_A = (axis("frame_a", i) for i in "xyz")
X_B, Y_B, Z_B = (axis("frame_b", i) for i in "xyz")
_C, _S, _DX, _DY = "cos(frame_a.phi)", "sin(frame_a.phi)", "(frame_b.x - frame_a.x)", "(frame_b.y - frame_a.y)"
#: x_a . d, y_a . d and z_a . d in the plane
_ALONG = {"x": f"{_C}*{_DX} + {_S}*{_DY}", "y": f"{_C}*{_DY} - {_S}*{_DX}", "z": ""}
TURN = "frame_b.phi - frame_a.phi"


def along(axis: str) -> Row:
    """a . d with an axis a of frame_a, such as "x", and d = r_b - r_a."""
    return Row(dot(dict(x=X_A, y=Y_A, z=Z_A)[axis], D), _ALONG[axis])


def normal(a: str, b: str, plane: str = "") -> Row:
    """a . b with an axis a of frame_a and an axis b of frame_b."""
    return Row(dot(axis("frame_a", a), axis("frame_b", b)), plane)


#: d = r_b - r_a, in axes of the world and in those of frame_a
IN_AXES = along("x"), along("y"), along("z")
POINT = tuple(Row(d, plane, turned=row.space) for d, plane, row in zip(D, (_DX, _DY, ""), IN_AXES, strict=True))
#: in the plane phi_b - phi_a - phi0; in space phi0 is part of the axes
SAME_ATTITUDE = normal("x", "y", f"{TURN} - phi0"), normal("x", "z"), normal("y", "z")
#: the trace of the rotation from frame_a to frame_b: 3, or -1 after half a turn about one of the axes
SAME = f"({dot(X_A, X_B)} + {dot(Y_A, Y_B)} + {dot(Z_A, Z_B)})"
LENGTH = Row(f"sqrt{dot(D, D)}", f"sqrt({_DX}*{_DX} + {_DY}*{_DY})")
#: of x_b about z_a
ANGLE = Row(f"angle({dot(Y_A, X_B)}, {dot(X_A, X_B)})", TURN)


def less(row: Row, of: str) -> Row:
    """The row ``row - of``."""
    return Row(f"{row.space} - {of}", f"{row.plane} - {of}")
