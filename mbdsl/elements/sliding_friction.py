"""Friction of surfaces that rub in more than one direction: common to joints in space with several rates of sliding.

The law of :mod:`mbdsl.elements.friction` gives the size of the force (or torque) from the speed u of sliding, and it
acts against the rates r_i: its components are F r_i/u. With u = (r_1^2 + ... + (1e-6 v_s)^2)^(1/2) they are smooth at
standstill, and in motion the last term changes them by less than 1e-12.

With `sticks = true` they are mu N r_i/u with u = |r|, until the joint is held (:mod:`mbdsl.mechanism.sticking`).
"""

from collections.abc import Sequence
from functools import reduce

from mbdsl.elements import friction
from mbdsl.elements.declaration import power
from mbdsl.elements.kind import PairKind
from mbdsl.elements.row import Row
from mbdsl.elements.rows import IN_AXES, X_A, Y_A, Z_A
from mbdsl.elements.vectors import Vector, W, dot, total, wrench

#: rotations about the axes of frame_a: their rates, as there is no coordinate
TURNS = tuple(Row(dot(W, axis)) for axis in (X_A, Y_A, Z_A))
#: name -> the motions that friction resists
MOTIONS = {
    name: PairKind(name, "motions that friction resists", g=rows, variant=name, spatial=True)
    for name, rows in {
        "sliding_in_socket": TURNS,
        "sliding_in_space": IN_AXES,
        "sliding_on_plane": IN_AXES[:2],
        "sliding_on_shaft": (IN_AXES[0], TURNS[0]),
    }.items()
}


def against(
    normal: str, parameter: str, along: str, rates: Sequence[str], axes: Sequence[Vector], places: Sequence[str] = ()
) -> dict:
    """The fields of a joint with friction for the normal force or its torque; ``parameter`` is v or w, ``rates`` are
    those of sliding ``along`` one of ``MOTIONS``, which has ``axes``, and of ``places``, if these exist."""
    acts = total(*((f"(-drag[{k + 1}])", a) for k, a in enumerate(axes)))
    return {
        "friction": friction.formula(normal, speed(parameter, *rates), parameter),
        "friction_along": along,
        "friction_rows": components(parameter, *rates),
        "normal": normal,
        "slides": tuple(rates),
        "places": tuple(places),
        "results": (delivered(parameter, *rates), friction.SLIDING_ON_SURFACE),
        "exerts": wrench(None, acts) if along == "sliding_in_socket" else wrench(acts, None),
        "check": friction.check,
        "derive": friction.derive,
        "effects": friction.EFFECTS,
    }


def speed(parameter: str, *rates: str) -> str:
    """The speed u of sliding, as a formula."""
    return reduce(lambda a, b: f"hypot({a}, {b})", (*rates, f"(1e-6*{parameter}_s)"))


def components(parameter: str, *rates: str) -> tuple[str, ...]:
    """The components F r_i/u, as formulas."""
    return tuple(f"friction*{rate}/{speed(parameter, *rates)}" for rate in rates)


def delivered(parameter: str, *rates: str):
    """The power of friction, which is negative: -F (r_1^2 + ...)/u."""
    squares = " + ".join(f"{rate}*{rate}" for rate in rates)
    return power(f"-(friction*({squares})/{speed(parameter, *rates)})")
