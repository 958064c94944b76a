"""Body: a planar rigid body with any number of frames.

Coordinates are x, y of the centre of mass and the angle phi, so that M = diag(m, m, I) is constant and there are no
velocity-dependent inertia forces. How frames move with these coordinates: :mod:`mbdsl.bodies.rigid_body_kernels`.
"""

from collections.abc import Mapping

from mbdsl.bodies import rigid_body_kernels as motion
from mbdsl.elements.kind import BodyKind, Parameter, Signal

SIGNALS = (
    Signal("x", "m", "c.x", "centre of mass"),
    Signal("y", "m", "c.y", "centre of mass"),
    Signal("phi", "rad", "c.phi", "angle, counting turns"),
    Signal("vx", "m/s", "c.vx"),
    Signal("vy", "m/s", "c.vy"),
    Signal("w", "rad/s", "c.w"),
)


def ends(values: Mapping) -> dict[str, tuple[float, float, float]]:
    """Frames a and b at -length/2 and +length/2 on the body's x axis."""
    half = values["length"]
    return {} if half is None else {"a": (-half / 2, 0.0, 0.0), "b": (half / 2, 0.0, 0.0)}


def check(values: Mapping) -> str | None:
    if values["I"] is None and values["length"] is None:
        return "the moment of inertia I is missing; give I, or the length of a uniform body"
    return None


def derive(values: Mapping) -> dict:
    return {"I": values["m"] * values["length"] ** 2 / 12} if values["I"] is None else {}


KIND = BodyKind(
    "Body",
    doc="A planar rigid body. With a length it has frames a and b at its ends, and by default a uniform bar's inertia.",
    parameters=(
        Parameter("m", "kg", doc="mass", minimum=0.0),
        Parameter("I", "kg.m2", None, "moment of inertia about the centre of mass; default m length^2/12", minimum=0.0),
        Parameter("length", "m", None, "distance of the frames a and b, reference point halfway", positive=True),
        Parameter("com", "m", (0.0, 0.0), "centre of mass, from the reference point", shape=(2,)),
        Parameter("frames", "", (), "further frames: frames(tip = {x, y, phi}, ...) from the reference point"),
    ),
    signals=SIGNALS,
    check=check,
    derive=derive,
    coordinates=("x", "y", "phi"),
    size="length",
    frames=ends,
    com=lambda v: v["com"],
    table=lambda v: (v["m"], v["m"], v["I"]),
)
