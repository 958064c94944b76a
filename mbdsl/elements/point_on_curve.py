"""PointOnCurve: the origin of frame_b stays on a curve of frame_a, the intersection of two surfaces; in space.

    f1(x, y, z) = 0,   f2(x, y, z) = 0     see point_on_surface.py                       (2 rows)

A curve with the parameter u would need u as a further unknown; the two surfaces have the same motion and reaction
without it. A helix is x = r cos(2 pi z/pitch), y = r sin(2 pi z/pitch), and a curve over x is y = Y(x), z = Z(x). The
reaction is normal to the curve. The gradients of f1 and f2 have to be independent on it.
"""

from mbdsl.elements import point_on_surface
from mbdsl.elements.kind import in_space
from mbdsl.elements.point_on_surface import FRICTION, level, surface

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
    drawing="track",
    functions=(("f1", ("x", "y", "z")), ("f2", ("x", "y", "z"))),
)
