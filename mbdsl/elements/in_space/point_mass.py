"""PointMass: a mass without extent in space; three coordinates, no rotation."""

from mbdsl.bodies import spatial_point_mass_kernels as motion
from mbdsl.elements import point_mass
from mbdsl.elements.kind import BodyKind, Signal

KIND = BodyKind(
    "PointMass",
    doc=point_mass.KIND.doc,
    parameters=point_mass.KIND.parameters,
    signals=(
        *(Signal(key, "m", f"c.{key}", "centre of mass") for key in ("x", "y", "z")),
        Signal("phi", "rad", "c.phi", "always 0"),
        *(Signal(key, "m/s", f"c.{key}") for key in ("vx", "vy", "vz")),
        Signal("w", "rad/s", "c.wz", "always 0"),
    ),
    coordinates=("x", "y", "z"),
    com=lambda v: (0.0, 0.0, 0.0),
    is_frame=True,
    table=lambda v: (v["m"],),
    spatial=True,
)
