"""Friction of surfaces that rub in more than one direction: common to joints in space with several rates of sliding.

The law of :mod:`mbdsl.elements.friction` gives the size of the force (or torque) from the speed u of sliding, and it
acts against the rates r_i: its components are F r_i/u. With u = (r_1^2 + ... + (1e-6 v_s)^2)^(1/2) they are smooth at
standstill, and in motion the last term changes them by less than 1e-12.
"""

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction
from mbdsl.elements.in_space.coordinates import PHI_A, PHI_B, add_cross
from mbdsl.elements.in_space.vectors import Vector, total
from mbdsl.elements.kind import Signal, power


class Motion(NamedTuple):
    """The ``KIND`` of a module with the coordinates that friction resists, for the code of a scene."""

    rows: int
    counts_turns: bool = False


def size(normal: str, parameter: str, *rates: str) -> str:
    """The law for a normal force (or its torque); ``parameter`` is v or w."""
    return friction.formula(normal, speed(parameter, *rates), parameter)


def speed(parameter: str, *rates: str) -> str:
    """The speed u of sliding, as a formula."""
    return reduce(lambda a, b: f"hypot({a}, {b})", (*rates, f"(1e-6*{parameter}_s)"))


def components(parameter: str, *rates: str) -> tuple[str, ...]:
    """The components F r_i/u, as formulas."""
    return tuple(f"friction*{rate}/{speed(parameter, *rates)}" for rate in rates)


def against(parameter: str, rates: Sequence[str], axes: Sequence[Vector]) -> Vector:
    """The force or torque on frame_b with these components along the axes of its rates."""
    return total(*((f"(-{x})", a) for x, a in zip(components(parameter, *rates), axes, strict=True)))


def delivered(parameter: str, *rates: str) -> Signal:
    """The power of friction, which is negative: -F (r_1^2 + ...)/u."""
    squares = " + ".join(f"{rate}*{rate}" for rate in rates)
    return power(f"-(friction*({squares})/{speed(parameter, *rates)})")


@kernel
def turn(frames, a, u, G, k):
    """Row k of G is a rotation about the axis of frame a at column u; it has no value."""
    for i in range(3):
        G[k, PHI_A + i], G[k, PHI_B + i] = -frames[a, u + i], frames[a, u + i]


@kernel
def turn_hessian(frames, a, u, factor, H):
    """H += factor * d(G^T)/dz."""
    x, y, z = factor * frames[a, u], factor * frames[a, u + 1], factor * frames[a, u + 2]
    add_cross(x, y, z, H, PHI_A, PHI_A)
    add_cross(-x, -y, -z, H, PHI_B, PHI_A)
