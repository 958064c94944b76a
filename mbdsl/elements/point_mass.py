"""PointMass: a mass without extent; two coordinates, no rotation."""

from mbdsl.bodies import point_mass_kernels as motion
from mbdsl.elements import body
from mbdsl.elements.kind import BodyKind, Parameter

KIND = BodyKind(
    "PointMass",
    doc="A mass at a point. Its name stands for its only frame, which does not rotate.",
    parameters=(Parameter("m", "kg", doc="mass", positive=True),),
    signals=body.SIGNALS,
    coordinates=("x", "y"),
    is_frame=True,
    table=lambda v: (v["m"], v["m"]),
)
