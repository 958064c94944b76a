"""Gears of Modelica's one-dimensional libraries, and couplings of other programs: the coupling of joints to write."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.lang.mistakes.frames import Ends, Given
from mbdsl.lang.unparse import write

#: flange -> the coordinate of a joint that is connected there, or an example of one
_TURNS, _SLIDES = "phi", "s"
_DELETED = ", and delete its connections"


def _coordinate(ends: Ends, flange: str, key: str, example: str) -> str:
    """The coordinate of the joint whose axis is connected to a flange."""
    found = ends(flange)
    owner, _, port = found[0].rpartition(".") if found is not None else ("", "", "")
    return f"{owner if port == 'axis' else example}.{key}"


def _ratio(given: Given, name: str = "ratio") -> str:
    return write(given[name]) if name in given else "..."


def _gear(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    """phi_a = ratio phi_b."""
    a, b = (_coordinate(ends, f"flange_{x}", _TURNS, f"pin_{x}") for x in "ab")
    made = f"write `Coupling {name}({b}, {a}, ratio = {_ratio(given)});`{_DELETED}"
    return f"{made}: it couples the angles of two joints, without losses; bodies in mesh have a GearPair between them"


def _gear_to_slide(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    """phi = ratio s."""
    phi, x = _coordinate(ends, "flangeR", _TURNS, "pin"), _coordinate(ends, "flangeT", _SLIDES, "slide")
    made = f"write `Coupling {name}({x}, {phi}, ratio = {_ratio(given)});`{_DELETED}"
    return f"{made}; a pinion on a rack is a RackAndPinion"


def _wheel(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    """s = radius phi."""
    phi, x = _coordinate(ends, "flangeR", _TURNS, "pin"), _coordinate(ends, "flangeT", _SLIDES, "slide")
    made = f"write `Coupling {name}({phi}, {x}, ratio = {_ratio(given, 'radius')});`{_DELETED}"
    return f"{made}; a wheel on a plane is a RollingDisc"


def _planetary(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    shafts = ", ".join(_coordinate(ends, x, _TURNS, f"{x}_pin") for x in ("sun", "carrier", "ring"))
    made = f"write `PlanetaryGear {name}({shafts}, ratio = {_ratio(given)});`{_DELETED}"
    return f"{made}: it couples the angles of three joints; planets as bodies have a GearPair to sun and ring"


def _coupling(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    return (
        f"write `Coupling {name}(first.phi, second.phi, ratio = ..., offset = ...);`, second = ratio*first + offset, "
        "with coordinates of joints or bodies, such as `pin.phi`, `slide.s` or `rod.b.x`"
    )


#: end of a name -> what to write instead
GEARS: dict[str, Callable[[str, Given, Ends, bool], str]] = {
    **dict.fromkeys(("IdealGear", "LossyGear", "Gearbox", "IdealGearR2R"), _gear),
    "IdealGearR2T": _gear_to_slide,
    "IdealRollingWheel": _wheel,
    "IdealPlanetary": _planetary,
    **dict.fromkeys(("Coupler", "CoordinateCoupler", "CoordinateConstraint", "CoordinateConnector"), _coupling),
    "GearConstraint": _coupling,
    **dict.fromkeys(("Mimic", "MimicJoint", "JointCoupling", "GearJoint", "ObjectConnectorCoordinate"), _coupling),
}
