"""Names of physical quantities: the types of the language (``Mass``, ``Length``) and the words of its messages."""

from __future__ import annotations

from fractions import Fraction

from mbdsl.lang import units
from mbdsl.lang.units import BASE, NUMBER, Dimension

#: type name -> unit; the first type of a dimension gives the words for messages
TYPES: dict[str, str] = {
    "Mass": "kg",
    "Length": "m",
    "Distance": "m",
    "Position": "m",
    "Radius": "m",
    "Diameter": "m",
    "Height": "m",
    "Thickness": "m",
    "Breadth": "m",
    "Area": "m2",
    "Volume": "m3",
    "Angle": "rad",
    "Time": "s",
    "Duration": "s",
    "Period": "s",
    "Velocity": "m/s",
    "AngularVelocity": "rad/s",
    "Frequency": "Hz",
    "AngularFrequency": "rad/s",
    "Acceleration": "m/s2",
    "AngularAcceleration": "rad/s2",
    "Force": "N",
    "Weight": "N",
    "Torque": "N.m",
    "MomentOfForce": "N.m",
    "Energy": "J",
    "Work": "J",
    "KineticEnergy": "J",
    "PotentialEnergy": "J",
    "Power": "W",
    "Inertia": "kg.m2",
    "MomentOfInertia": "kg.m2",
    "Stiffness": "N/m",
    "TranslationalSpringConstant": "N/m",
    "RotationalStiffness": "N.m/rad",
    "RotationalSpringConstant": "N.m/rad",
    "Damping": "N.s/m",
    "TranslationalDampingConstant": "N.s/m",
    "RotationalDamping": "N.m.s/rad",
    "RotationalDampingConstant": "N.m.s/rad",
    "Density": "kg/m3",
    "Pressure": "Pa",
    "Stress": "Pa",
    "ModulusOfElasticity": "Pa",
    "Current": "A",
    "Voltage": "V",
    "Resistance": "Ohm",
    "Inductance": "H",
    "Capacitance": "F",
    "VolumeFlowRate": "m3/s",
    "Momentum": "kg.m/s",
    "Impulse": "N.s",
    "AngularMomentum": "kg.m2/s",
    "LinearDensity": "kg/m",
    "SecondMomentOfArea": "m4",
    "DimensionlessRatio": "1",
    "Efficiency": "1",
    "CoefficientOfFriction": "1",
}
#: prefixes of the names of types in Modelica
PREFIXES = ("SI.", "SIunits.", "Modelica.Units.SI.", "Modelica.SIunits.")

_WORDS = (
    ("a mass", "kg"),
    ("a length", "m"),
    ("an area", "m2"),
    ("a volume", "m3"),
    ("a time", "s"),
    ("a velocity", "m/s"),
    ("an angular velocity or frequency", "rad/s"),
    ("an acceleration", "m/s2"),
    ("an angular acceleration", "rad/s2"),
    ("a force", "N"),
    ("a torque or energy", "N.m"),
    ("a power", "W"),
    ("a moment of inertia", "kg.m2"),
    ("a stiffness", "N/m"),
    ("a damping constant", "N.s/m"),
    ("a rotational damping constant", "N.m.s/rad"),
    ("a density", "kg/m3"),
    ("a pressure or modulus", "Pa"),
    ("a momentum", "kg.m/s"),
    ("a mass per length", "kg/m"),
    ("a second moment of area", "m4"),
    ("a temperature", "K"),
    ("a current", "A"),
    ("a voltage", "V"),
    ("a resistance", "Ohm"),
    ("an inductance", "H"),
    ("a capacitance", "F"),
    ("a volume flow", "m3/s"),
)
_BY_DIMENSION = {units.dimension(unit): (words, unit) for words, unit in _WORDS}


def type_unit(name: str) -> str | None:
    """The unit that a type name stands for ("SI.Mass": "kg"); None if it is not a quantity."""
    for prefix in PREFIXES:
        if name.startswith(prefix):
            name = name[len(prefix) :]
            break
    return TYPES.get(name)


def unit_text(dimension: Dimension) -> str:
    """The dimension as a unit, as short as possible: ``N.m``, ``kg.m3/s``."""
    if dimension == NUMBER:
        return "1"
    if dimension in _BY_DIMENSION:
        return _BY_DIMENSION[dimension][1]
    above, below = [], []
    for base, exponent in zip(BASE, dimension, strict=True):
        if exponent:
            size = abs(Fraction(exponent))
            shown = base if size == 1 else f"{base}{size}" if size == int(size) else f"{base}^({size})"
            (above if exponent > 0 else below).append(shown)
    text = ".".join(above) or "1"
    if not below:
        return text
    return f"{text}/{below[0]}" if len(below) == 1 else f"{text}/({'.'.join(below)})"


def type_name(dimension: Dimension) -> str | None:
    """The first type of a dimension; None if there is none."""
    return next((name for name, unit in TYPES.items() if units.dimension(unit) == dimension), None)


def words(dimension: Dimension, unit: str = "") -> str:
    """The dimension for a message: ``a length [m]``; ``unit`` is the unit as written or expected."""
    if dimension == NUMBER:
        return "an angle or pure number" if unit in ("rad", "deg") else "a pure number"
    name = _BY_DIMENSION.get(dimension, ("a quantity", ""))[0]
    return f"{name} [{unit or unit_text(dimension)}]"
