"""Rod: a thin uniform bar with frames a and b at its ends, along the x axis."""

from mbdsl.bodies import spatial_rigid_body_kernels as motion
from mbdsl.elements import rod
from mbdsl.elements.in_space import body
from mbdsl.elements.kind import BodyKind, Parameter

KIND = BodyKind(
    "Rod",
    doc="A thin uniform bar: I = m length^2/12 about y and z, 0 about its axis x, frames a and b at its ends.",
    parameters=(*rod.KIND.parameters[:2], Parameter("frames", "", (), "further frames")),
    signals=body.SIGNALS,
    derive=lambda v: {"I": (0.0, v["m"] * v["length"] ** 2 / 12, v["m"] * v["length"] ** 2 / 12)},
    coordinates=body.COORDINATES,
    size="length",
    frames=body.ends,
    com=lambda v: (0.0, 0.0, 0.0),
    table=lambda v: (v["m"], *body.inertia(v["I"])),
    spatial=True,
)
