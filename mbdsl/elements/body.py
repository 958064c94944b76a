"""Body: a rigid body with any number of frames.

Coordinates are x, y of the centre of mass and the angle phi, so that M = diag(m, m, I) is constant and there are no
velocity-dependent inertia forces. How frames move with these coordinates: :mod:`mbdsl.bodies.rigid_body_kernels`.

In space the state is the position x of the centre of mass and the attitude R; M = diag(m, m, m, J) is constant, with J
about the centre of mass in body axes: :mod:`mbdsl.bodies.spatial_rigid_body_kernels`.
"""

from collections.abc import Mapping

from mbdsl.bodies import rigid_body_kernels as motion
from mbdsl.bodies import spatial_rigid_body_kernels as motion_in_space
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind, Signal, in_space
from mbdsl.elements.vectors import UNTURNED, least_minor
from mbdsl.expressions.spatial_coordinates import CARDAN, LOCAL, MEANINGS, QUATERNION, UNITS

SIGNALS = (
    Signal("x", "m", "c.x", "centre of mass"),
    Signal("y", "m", "c.y", "centre of mass"),
    Signal("phi", "rad", "c.phi", "angle, counting turns"),
    Signal("vx", "m/s", "c.vx"),
    Signal("vy", "m/s", "c.vy"),
    Signal("w", "rad/s", "c.w"),
)


def ends(values: Mapping, more: tuple[float, ...] = (0.0, 0.0)) -> dict[str, tuple[float, ...]]:
    """Frames a and b at -length/2 and +length/2 on the body's x axis; ``more`` follows x in their poses."""
    half = values["length"]
    return {} if half is None else {"a": (-half / 2, *more), "b": (half / 2, *more)}


def ends_in_space(values: Mapping) -> dict[str, tuple[float, ...]]:
    return ends(values, (0.0, 0.0, *UNTURNED))


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


# -- in space ----------------------------------------------------------------------------------------------------------

#: position of the centre of mass, and the rotation vector of the attitude
COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
SIGNALS_IN_SPACE = (
    *(Signal(key, "m", f"c.{key}", "centre of mass") for key in ("x", "y", "z")),
    Signal("phi", "rad", "c.phi", MEANINGS["phi"]),
    *(Signal(key, "m/s", f"c.{key}") for key in ("vx", "vy", "vz")),
    *(Signal(key, "rad/s", f"c.{key}", "angular velocity, in world axes") for key in ("wx", "wy", "wz")),
    Signal("w", "rad/s", "c.wz", MEANINGS["w"]),
    *(Signal(key, UNITS[key], f"c.{key}", MEANINGS[key]) for key in (*CARDAN, *LOCAL, *QUATERNION)),
)


def check_in_space(values: Mapping) -> str | None:
    if values["I"] is None and values["length"] is None:
        return "the moments of inertia I are missing; give I = {Ixx, Iyy, Izz}, or the length of a uniform bar"
    return None if values["I"] is None else _of_a_mass(_about_axes(values["I"]))


def _about_axes(I) -> tuple:
    """A single moment of inertia, of models in the plane, is the same about all axes: that of a ball."""
    return I if isinstance(I, tuple) else (I, I, I)


#: differences of moments, relative to the largest, that count as rounding of written numbers
ROUNDING = 1e-9
#: the same for moments that are measured or copied with few digits
FEW_DIGITS = 0.005


def _of_a_mass(I) -> str | None:
    """Why I is not the inertia of a body, or None."""
    if isinstance(I[0], tuple):
        size = max(abs(x) for row in I for x in row)
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if abs(I[i][j] - I[j][i]) > ROUNDING * size:
                names = f"I[{i + 1}, {j + 1}] = {I[i][j]:g}", f"I[{j + 1}, {i + 1}] = {I[j][i]:g} kg.m2"
                return f"the matrix of inertia I is not symmetric: {names[0]}, but {names[1]}"
        if least_minor(I, size) < -ROUNDING:
            return "the matrix of inertia I has a negative principal moment; is a product of inertia too large?"
        return None
    name, least = min(zip(("Ixx", "Iyy", "Izz"), I, strict=True), key=lambda x: x[1])
    return f"the moment of inertia {name} in I is {least:g} kg.m2; it must be at least 0" if least < 0.0 else None


def impossible(I) -> str | None:
    """Why no distribution of mass has the moments I, which no equation of motion excludes, or None.

    The matrix of second moments, tr(J)/2 - J, has no negative eigenvalue.
    """
    J = inertia(I)
    half = 0.5 * (J[0] + J[4] + J[8])
    second = [[(half if i == j else 0.0) - J[3 * i + j] for j in range(3)] for i in range(3)]
    if least_minor(second, max(map(abs, J))) > -FEW_DIGITS:
        return None
    if isinstance(I[0], tuple):
        return "a principal moment of inertia is larger than the sum of the other two"
    k = max(range(3), key=lambda k: I[k])
    names = [f"I{axis}{axis}" for axis in "xyz"]
    others = " + ".join(name for i, name in enumerate(names) if i != k)
    return f"{names[k]} = {I[k]:g} kg.m2 is larger than {others} = {sum(I) - I[k]:g} kg.m2"


def derive_in_space(values: Mapping) -> dict:
    bar = 0.0 if values["length"] is None else values["m"] * values["length"] ** 2 / 12
    return {"I": (0.0, bar, bar) if values["I"] is None else _about_axes(values["I"])}


def inertia(I) -> tuple[float, ...]:
    """The matrix of inertia, row by row, of {Ixx, Iyy, Izz} or of the matrix."""
    return (
        tuple(x for row in I for x in row)
        if isinstance(I[0], tuple)
        else (I[0], 0.0, 0.0, 0.0, I[1], 0.0, 0.0, 0.0, I[2])
    )


IN_SPACE = in_space(
    KIND,
    doc="A rigid body in space.",
    parameters=(
        Parameter("m", "kg", doc="mass", minimum=0.0),
        Parameter(
            *(
                "I",
                "kg.m2",
                None,
                "moments of inertia {Ixx, Iyy, Izz} about the centre of mass, the matrix of inertia, or one moment, "
                "which is the same about all axes",
            ),
            shape=(3,),
            or_shapes=((3, 3), ()),
        ),
        Parameter("length", "m", None, "distance of the frames a and b, reference point halfway", positive=True),
        Parameter("com", "m", (0.0, 0.0, 0.0), "centre of mass, from the reference point", shape=(3,)),
        Parameter("frames", "", (), "further frames"),
    ),
    signals=SIGNALS_IN_SPACE,
    check=check_in_space,
    doubt=lambda v: None if v["I"] is None else impossible(_about_axes(v["I"])),
    derive=derive_in_space,
    frames=ends_in_space,
    coordinates=COORDINATES,
    table=lambda v: (v["m"], *inertia(v["I"])),
)
