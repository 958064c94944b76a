"""Rod: a uniform bar with frames a and b at its ends; a Body whose inertia follows from mass and length."""

from mbdsl.bodies import rigid_body_kernels as motion
from mbdsl.bodies import spatial_rigid_body_kernels as motion_in_space
from mbdsl.elements import body
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind, in_space

KIND = BodyKind(
    "Rod",
    doc="A uniform rigid bar: centre of mass at the midpoint, I = m length^2/12, frames a and b at its ends.",
    parameters=(
        Parameter("m", "kg", doc="mass", minimum=0.0),
        Parameter("length", "m", doc="distance of the frames a and b", positive=True),
        Parameter("frames", "", (), "further frames: frames(tip = {x, y, phi}, ...) from the midpoint"),
    ),
    signals=body.SIGNALS,
    derive=lambda v: {"I": v["m"] * v["length"] ** 2 / 12},
    coordinates=("x", "y", "phi"),
    size="length",
    frames=body.ends,
    table=lambda v: (v["m"], v["m"], v["I"]),
)
IN_SPACE = in_space(
    KIND,
    doc="A thin uniform bar: I = m length^2/12 about y and z, 0 about its axis x, frames a and b at its ends.",
    parameters=(*KIND.parameters[:2], Parameter("frames", "", (), "further frames")),
    signals=body.SIGNALS_IN_SPACE,
    derive=lambda v: {"I": (0.0, v["m"] * v["length"] ** 2 / 12, v["m"] * v["length"] ** 2 / 12)},
    coordinates=body.COORDINATES,
    frames=body.ends_in_space,
    com=lambda v: (0.0, 0.0, 0.0),
    table=lambda v: (v["m"], *body.inertia(v["I"])),
)
