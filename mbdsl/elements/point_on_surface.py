"""PointOnSurface: the origin of frame_b stays on a surface f(x, y, z) = 0 of frame_a; in space.

    f(x, y, z) = 0,  (x, y, z) = (x_a . d, y_a . d, z_a . d),  d = r_b - r_a             (1 row)

The reaction is normal to the surface. f has to have a gradient on it. Friction: a force mu times the reaction against
the sliding, see friction.py and sliding_friction.py.
"""

from mbdsl.elements import friction, sliding_friction
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AT_B_IN_SPACE, JointKind, Signal
from mbdsl.elements.row import Row
from mbdsl.elements.rows import IN_AXES, X_A, Y_A, Z_A

SIGNALS = (
    *(Signal(key, "m", row.space, "position in frame_a") for key, row in zip("xyz", IN_AXES, strict=True)),
    *(Signal(f"v{key}", "m/s", f"der({key})", "its rate") for key in "xyz"),
)


def surface(name: str, doc: str) -> Parameter:
    """The parameter of a function."""
    return Parameter(name, "", doc=doc, law=True)


def level(k: int) -> Row:
    """The k-th function of the coordinates, from 1."""
    return Row(f"law[{k}]", reacts=(True, False))


FRICTION = friction.parameters("v", "m/s", 1e-3)

IN_SPACE = JointKind(
    "PointOnSurface",
    doc="The origin of frame_b stays on the surface f = 0 of frame_a, free to turn.",
    g=(level(1),),
    parameters=(
        surface("f", "function of the coordinates in frame_a that is zero on the surface, of any unit"),
        *FRICTION,
    ),
    signals=SIGNALS,
    **sliding_friction.against(
        "hypot(hypot(fx, fy), fz)", "v", "sliding_in_space", ("vx", "vy", "vz"), (X_A, Y_A, Z_A)
    ),
    touches=AT_B_IN_SPACE,
    functions=(("f", ("x", "y", "z")),),
    spatial=True,
    drawing="point",
)
