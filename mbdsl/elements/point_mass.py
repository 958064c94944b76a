"""PointMass: a mass without extent; two coordinates, no rotation."""

from mbdsl.bodies import point_mass_kernels as motion
from mbdsl.elements import body
from mbdsl.elements.kind import BodyKind, Parameter, Signal

KIND = BodyKind(
    "PointMass",
    doc="A mass at a point. Its name stands for its only frame, which only welds and sliding joints can turn.",
    parameters=(Parameter("m", "kg", doc="mass; zero where joints hold the point", minimum=0.0),),
    signals=tuple(Signal(x.name, x.unit, x.formula, "always 0") if x.name in ("phi", "w") else x for x in body.SIGNALS),
    coordinates=("x", "y"),
    is_frame=True,
    table=lambda v: (v["m"], v["m"]),
)
