"""BoxContact: a rectangle or cuboid of frame_b on a line or plane of frame_a, with friction.

It acts at its corners, at -+ length/2, -+ width/2, in space -+ height/2 on the axes of frame_b; see contact_points.py.
"""

from itertools import product

from mbdsl.elements.contact_points import contact
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import axis_given
from mbdsl.elements.line_contact import SIDES, X_B, Y_B, corner
from mbdsl.elements.point_contact import N, plane
from mbdsl.elements.vectors import axis

EDGES = (
    Parameter("length", "m", doc="edge along x of frame_b", positive=True),
    Parameter("width", "m", doc="edge along y of frame_b", positive=True),
    Parameter("height", "m", doc="edge along z of frame_b", positive=True),
)


def corners(spatial):
    names = [p.name for p in EDGES[: 3 if spatial else 2]]
    axes = [axis("frame_b", i) for i in "xyz"] if spatial else [X_B, Y_B]
    for sides in product(SIDES, repeat=len(names)):
        yield corner(spatial, *((f"{side}*{x}", a) for side, x, a in zip(sides, names, axes, strict=True)))


KIND = contact(
    "BoxContact",
    "A rectangle about the origin of frame_b on the x axis of frame_a, which pushes its corners to the side of the y "
    "axis; with friction.",
    EDGES[:2],
    list(corners(False)),
    drawing="surface",
)
IN_SPACE = contact(
    "BoxContact",
    "A cuboid about the origin of frame_b on the plane through the origin of frame_a, which pushes its corners to the "
    "side of n; with friction.",
    (*EDGES, N),
    list(corners(True)),
    spatial=True,
    axes=plane,
    check=axis_given,
    drawing="surface",
)
