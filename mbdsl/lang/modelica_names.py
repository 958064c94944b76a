"""Names of Modelica with the same meaning here: kinds, functions, constants, frames, parameters without effect."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbdsl.lang import syntax as s
from mbdsl.lang.unparse import write

#: other names of kinds
KINDS = {"World": "Ground", "PlanarWorld": "Ground"}
#: the end of a name in a package -> the kind or type with the same meaning
_QUALIFIED = {
    "MultiBody.World": "Ground",
    "PlanarMechanics.PlanarWorld": "Ground",
    "Parts.Body": "Body",
    "Parts.PointMass": "PointMass",
    "Joints.Revolute": "Revolute",
    "Joints.Prismatic": "Prismatic",
    "Joints.FreeMotion": "FreeMotion",
    **{f"Joints.{name}": name for name in ("Spherical", "Universal", "Cylindrical", "Planar")},
    "Forces.Torque": "Torque",
    "Interfaces.Frame": "Frame",
    "Interfaces.Frame_a": "Frame_a",
    "Interfaces.Frame_b": "Frame_b",
}
#: packages whose functions are known without the package
_FUNCTION_PACKAGES = ("Modelica.Math.", "Modelica.Units.Conversions.", "Modelica.SIunits.Conversions.")
#: functions of conversions -> the unit; their names begin with from_ or to_
CONVERSIONS = {"deg": "deg", "rpm": "rpm", "kmh": "km/h"}
#: constant -> (value, unit)
CONSTANTS = {
    "Modelica.Constants.pi": (math.pi, "1"),
    "Modelica.Constants.e": (math.e, "1"),
    "Modelica.Constants.D2R": (math.pi / 180.0, "1"),
    "Modelica.Constants.R2D": (180.0 / math.pi, "1"),
    "Modelica.Constants.g_n": (9.80665, "m/s2"),
}
#: models without content, which `extends` may name
ICONS = "Modelica.Icons."
#: attributes of signals without an effect; all but the first are mentioned in the note about what is passed over
NO_EFFECT = ("displayUnit", "stateSelect", "nominal", "min", "max")
#: parameters of components without an effect on the motion, which are passed over: pictures, states, flanges, checks
_PASSED = frozenset(
    """
    animation animate enableAnimation animateWorld animateGravity animateGround stateSelect enforceStates useQuaternions
    sequence_angleStates useAxisFlange useFlange useFlanges checkTotalPower driveTrainMechanics3D zPosition extra
    color colour width height sphereDiameter sphereColor cylinderDiameter cylinderLength cylinderColor shapeType r_shape
    specularCoefficient axisLength axisDiameter axisShowLabels label1 label2 numberOfWindings coilWidth headAtOrigin
    boxWidth boxHeight boxColor boxWidthDirection N_to_m Nm_to_m rodDiameter rodColor lineForceType lineForceWidth
    lineForceColor forceColor torqueColor massDiameter massColor showMass nominalLength groundColor groundAxis_u
    groundLength_u groundLength_v extraLine defaultZPosition useHeatPort length_a length_b diameter_a diameter_b color_a
    color_b fixedRotationAtFrame_a fixedRotationAtFrame_b enableAssert useSupport exact
    """.split()
)
_PASSED_BEGINNINGS = ("axisColor_", "gravityArrow", "defaultAxis", "defaultJoint", "defaultForce", "defaultBody")
_PASSED_BEGINNINGS += ("defaultWidth", "defaultArrow", "defaultFrame", "defaultSpecular", "defaultN")


def kind(name: str) -> str:
    """The name here of a kind or type: that at the end of ``Modelica.Mechanics.MultiBody.Joints.Revolute``."""
    name = _QUALIFIED.get(".".join(name.split(".")[-2:]), name) if "." in name else name
    return KINDS.get(name, name)


def function(name: str) -> str:
    """The name here of the function ``name``."""
    package = next((p for p in _FUNCTION_PACKAGES if name.startswith(p)), "")
    return name[len(package) :]


def frame_of_body(name: str, frames: Sequence[str], is_frame: bool, centred: bool) -> str | None:
    """The frame of a body that Modelica calls ``frame_a`` or ``frame_b``; None if there is none."""
    own = {"frame_a": "a", "frame_b": "b"}.get(name)
    if own is None or own in frames:
        return own
    return "c" if is_frame or (name == "frame_a" and centred) else None


#: ports by the names that the ends of bodies have
PORTS = {"a": "frame_a", "b": "frame_b"}


def has_no_effect(name: str, e: s.Expression | None) -> bool:
    """Whether a parameter of Modelica, with this value, has no effect on the motion and is passed over."""
    uniform = name == "gravityType" and e is not None and write(e).endswith(".UniformGravity")
    uniform = uniform or (name == "enableGravity" and e is not None and write(e) == "true")
    return name in _PASSED or name.startswith(_PASSED_BEGINNINGS) or uniform
