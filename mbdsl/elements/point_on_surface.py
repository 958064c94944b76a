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


FRICTION = (*friction.parameters("v", "m/s", 1e-3), friction.STICKS)

#: the unit normal, and two tangents normal to it and to each other: T. Duff et al., *Building an orthonormal basis,
#: revisited*, J. Comput. Graphics Techniques 6 (2017) 1-8
N_X, N_Y, N_Z = (f"(slope[{k}]/hypot(hypot(slope[1], slope[2]), slope[3]))" for k in (1, 2, 3))
_SIDE = f"(1 - 2*lt({N_Z}, 0))"
_A = f"(-1/({_SIDE} + {N_Z}))"
TANGENTS = (
    (f"1 + {_SIDE}*{N_X}^2*{_A}", f"{_SIDE}*{N_X}*{N_Y}*{_A}", f"-{_SIDE}*{N_X}"),
    (f"{N_X}*{N_Y}*{_A}", f"{_SIDE} + {N_Y}^2*{_A}", f"-{N_Y}"),
)


def held(first: int) -> str:
    """The displacement along a tangent place[first], ... of the place that friction holds."""
    return " + ".join(f"place[{first + k}]*({key} - place[{k + 1}])" for k, key in enumerate("xyz"))


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
        "hypot(hypot(fx, fy), fz)",
        "v",
        "sliding_in_space",
        ("vx", "vy", "vz"),
        (X_A, Y_A, Z_A),
        ("x", "y", "z", *TANGENTS[0], *TANGENTS[1]),
    ),
    holds=(held(4), held(7)),
    grips=tuple(f"grip[1]*place[{4 + k}] + grip[2]*place[{7 + k}]" for k in range(3)),
    touches=AT_B_IN_SPACE,
    functions=(("f", ("x", "y", "z")),),
    spatial=True,
    drawing="point",
)
