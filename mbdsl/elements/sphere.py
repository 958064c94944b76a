"""Sphere: a uniform ball or spherical shell."""

from collections.abc import Mapping
from math import pi

from mbdsl.bodies import spatial_rigid_body_kernels as motion
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.solid import solid


def inertia(v: Mapping) -> tuple[float, float, float]:
    """2/5 m (R^5 - r^5)/(R^3 - r^3), without the difference of numbers that are nearly equal for thin shells."""
    R, x = v["radius"], v["bore"] / v["radius"]
    J = 0.4 * v["m"] * R**2 * (1 + x + x**2 + x**3 + x**4) / (1 + x + x**2)
    return J, J, J


IN_SPACE = solid(
    "Sphere",
    doc="A uniform ball or spherical shell.",
    parameters=(
        Parameter("radius", "m", doc="radius", positive=True),
        Parameter("bore", "m", 0.0, "inner radius, of a shell", minimum=0.0),
    ),
    volume=lambda v: 4 / 3 * pi * (v["radius"] ** 3 - v["bore"] ** 3),
    inertia=inertia,
    check=lambda v: "the inner radius is not smaller than the radius" if v["bore"] >= v["radius"] else None,
    size="radius",
)
