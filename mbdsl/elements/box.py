"""Box: a uniform cuboid with edges along its axes, and frames a and b in the middle of its ends."""

from mbdsl.bodies import spatial_rigid_body_kernels as motion
from mbdsl.elements import body
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.solid import solid

IN_SPACE = solid(
    "Box",
    doc="A uniform cuboid; frames a and b are in the middle of its ends, at -length/2 and length/2 on its x axis.",
    parameters=(
        Parameter("length", "m", doc="edge along x", positive=True),
        Parameter("width", "m", doc="edge along y", positive=True),
        Parameter("height", "m", doc="edge along z", positive=True),
    ),
    volume=lambda v: v["length"] * v["width"] * v["height"],
    inertia=lambda v: (
        v["m"] * (v["width"] ** 2 + v["height"] ** 2) / 12,
        v["m"] * (v["length"] ** 2 + v["height"] ** 2) / 12,
        v["m"] * (v["length"] ** 2 + v["width"] ** 2) / 12,
    ),
    size="length",
    frames=body.ends_in_space,
)
