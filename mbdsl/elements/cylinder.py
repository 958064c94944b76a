"""Cylinder: a uniform circular cylinder or tube, with frames a and b in the middle of its ends."""

from collections.abc import Mapping
from math import hypot, pi

from mbdsl.bodies import spatial_rigid_body_kernels as motion
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import axis_given
from mbdsl.elements.solid import solid
from mbdsl.elements.vectors import UNTURNED


def along(v: Mapping) -> tuple[float, ...]:
    """The unit vector of the axis."""
    return tuple(x / hypot(*v["n"]) for x in v["n"])


def ends(v: Mapping) -> dict[str, tuple[float, ...]]:
    half = v["length"] / 2
    return {name: (*(side * half * x for x in along(v)), *UNTURNED) for name, side in (("a", -1.0), ("b", 1.0))}


def check(v: Mapping) -> str | None:
    if v["bore"] >= v["radius"]:
        return "the radius of the bore is not smaller than the radius"
    return axis_given(v)


def inertia(v: Mapping) -> tuple[tuple[float, ...], ...]:
    """Across the axis J, about it J + d: J 1 + d n n^T."""
    square, n = v["radius"] ** 2 + v["bore"] ** 2, along(v)
    across = v["m"] * (3 * square + v["length"] ** 2) / 12
    d = v["m"] * square / 2 - across
    return tuple(tuple((across if i == k else 0.0) + d * n[i] * n[k] for k in range(3)) for i in range(3))


IN_SPACE = solid(
    "Cylinder",
    doc="A uniform circular cylinder or tube; frames a and b are in the middle of its ends, b in the direction n.",
    parameters=(
        Parameter("length", "m", doc="length along the axis", positive=True),
        Parameter("radius", "m", doc="radius", positive=True),
        Parameter("bore", "m", 0.0, "radius of the bore, of a tube", minimum=0.0),
        Parameter("n", "1", (1.0, 0.0, 0.0), "direction of the axis", shape=(3,)),
    ),
    volume=lambda v: pi * (v["radius"] ** 2 - v["bore"] ** 2) * v["length"],
    inertia=inertia,
    check=check,
    size="length",
    frames=ends,
)
