"""PointOnCurve: the origin of frame_b stays on a curve of frame_a, the intersection of two surfaces; in space.

    f1(x, y, z) = 0,   f2(x, y, z) = 0     see point_on_surface.py                       (2 rows)

A curve with the parameter u would need u as a further unknown; the two surfaces have the same motion and reaction
without it. A helix is x = r cos(2 pi z/pitch), y = r sin(2 pi z/pitch), and a curve over x is y = Y(x), z = Z(x). The
reaction is normal to the curve. The gradients of f1 and f2 have to be independent on it. Friction that sticks holds the
point along the tangent at the place where it stopped; the sense of sliding is that of grad f1 x grad f2.
"""

from mbdsl.elements import friction, point_on_surface
from mbdsl.elements.kind import in_space
from mbdsl.elements.point_on_surface import FRICTION, held, level, surface
from mbdsl.elements.vectors import cross, dot, vector

ACROSS = cross(vector(f"slope[{k}]" for k in (1, 2, 3)), vector(f"slope[{k}]" for k in (4, 5, 6)))
TANGENT = vector(f"({x}/sqrt{dot(ACROSS, ACROSS)})" for x in ACROSS)

IN_SPACE = in_space(
    point_on_surface.IN_SPACE,
    name="PointOnCurve",
    doc="The origin of frame_b stays on the curve f1 = f2 = 0 of frame_a, free to turn.",
    g=(level(1), level(2)),
    parameters=(
        surface("f1", "function of the coordinates in frame_a that is zero on the curve, of any unit"),
        surface("f2", "another function, whose gradient has another direction"),
        *FRICTION,
    ),
    slides=(dot(TANGENT, vector(("vx", "vy", "vz"))),),
    places=("x", "y", "z", *TANGENT),
    holds=(held(4),),
    grips=(),
    sticking_rows=tuple(f"rub[1]*{x}" for x in TANGENT),
    results=(point_on_surface.IN_SPACE.results[0], friction.SLIDING),
    drawing="track",
    functions=(("f1", ("x", "y", "z")), ("f2", ("x", "y", "z"))),
)
