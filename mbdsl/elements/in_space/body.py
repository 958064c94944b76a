"""Body: a rigid body in space with any number of frames.

The state is the position x of the centre of mass and the attitude R; M = diag(m, m, m, J) is constant, with J about the
centre of mass in body axes. How frames move with it: :mod:`mbdsl.bodies.spatial_rigid_body_kernels`.
"""

from mbdsl.bodies import spatial_rigid_body_kernels as motion
from mbdsl.elements.kind import BodyKind, Parameter, Signal

SIGNALS = (
    *(Signal(key, "m", f"c.{key}", "centre of mass") for key in ("x", "y", "z")),
    *(Signal(key, "m/s", f"c.{key}") for key in ("vx", "vy", "vz")),
    *(Signal(key, "rad/s", f"c.{key}", "angular velocity, in world axes") for key in ("wx", "wy", "wz")),
)


def inertia(I) -> tuple[float, ...]:
    """The matrix of the moments of inertia, row by row."""
    return (I[0], 0.0, 0.0, 0.0, I[1], 0.0, 0.0, 0.0, I[2]) if len(I) == 3 else tuple(I)


KIND = BodyKind(
    "Body",
    doc="A rigid body in space.",
    parameters=(
        Parameter("m", "kg", doc="mass", minimum=0.0),
        Parameter("I", "kg.m2", doc="moments of inertia about the centre of mass, in body axes", shape=(3,)),
        Parameter("com", "m", (0.0, 0.0, 0.0), "centre of mass, from the reference point", shape=(3,)),
        Parameter("frames", "", (), "further frames"),
    ),
    signals=SIGNALS,
    coordinates=("x", "y", "z", "rx", "ry", "rz"),
    com=lambda v: v["com"],
    table=lambda v: (v["m"], *inertia(v["I"])),
    spatial=True,
)
