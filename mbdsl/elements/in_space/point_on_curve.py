"""PointOnCurve: the origin of frame_b stays on a curve of frame_a, the intersection of two surfaces.

    g = f1(x, y, z),   f2(x, y, z)     see point_on_surface.py                                            (2 rows)

A curve with the parameter u would need u as a further unknown; the two surfaces have the same motion and reaction
without it. A helix is x = r cos(2 pi z/pitch), y = r sin(2 pi z/pitch), and a curve over x is y = Y(x), z = Z(x). The
reaction is normal to the curve. The gradients of f1 and f2 have to be independent on it.
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space import point_on_surface
from mbdsl.elements.in_space.point_on_surface import COUNT, FRICTION, force, level, level_hessian, surface
from mbdsl.elements.kind import in_space
from mbdsl.elements.vectors import reactions

KIND = in_space(
    point_on_surface.KIND,
    name="PointOnCurve",
    doc="The origin of frame_b stays on the curve f1 = f2 = 0 of frame_a, free to turn.",
    rows=2,
    parameters=(
        surface("f1", "function of the coordinates in frame_a that is zero on the curve, of any unit"),
        surface("f2", "another function, whose gradient has another direction"),
        *FRICTION,
    ),
    reactions=reactions(
        tuple(f"({x} + {y})" for x, y in zip(force(1), force(2), strict=True)),  # type: ignore[arg-type]
        None,
    ),
    functions=(("f1", ("x", "y", "z")), ("f2", ("x", "y", "z"))),
    table=lambda v: (0.0,) * (2 * COUNT),
)


@kernel
def gradient(frames, a, b, p, G):
    level(frames, a, b, p, G, 0)
    level(frames, a, b, p[COUNT:], G, 1)


@kernel
def hessian(frames, a, b, p, s, H):
    level_hessian(frames, a, b, p, s[0], H)
    level_hessian(frames, a, b, p[COUNT:], s[1], H)
