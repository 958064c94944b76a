"""PointMass: a mass without extent; two coordinates, in space three, and no rotation."""

from mbdsl.bodies import point_mass_kernels as motion
from mbdsl.bodies import spatial_point_mass_kernels as motion_in_space
from mbdsl.elements import body
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind, Signal, in_space

KIND = BodyKind(
    "PointMass",
    doc="A mass at a point. Its name stands for its only frame, which only welds and sliding joints can turn.",
    parameters=(Parameter("m", "kg", doc="mass; zero where joints hold the point", minimum=0.0),),
    signals=tuple(Signal(x.name, x.unit, x.formula, "always 0") if x.name in ("phi", "w") else x for x in body.SIGNALS),
    coordinates=("x", "y"),
    is_frame=True,
    table=lambda v: (v["m"], v["m"]),
)
IN_SPACE = in_space(
    KIND,
    signals=(
        *(Signal(key, "m", f"c.{key}", "centre of mass") for key in ("x", "y", "z")),
        Signal("phi", "rad", "c.phi", "always 0"),
        *(Signal(key, "m/s", f"c.{key}") for key in ("vx", "vy", "vz")),
        Signal("w", "rad/s", "c.wz", "always 0"),
    ),
    coordinates=("x", "y", "z"),
    com=lambda v: (0.0, 0.0, 0.0),
    table=lambda v: (v["m"],),
)
