"""Kinds of Modelica (and some of Adams) without the same meaning here, and what to write instead."""

from __future__ import annotations

import math
from collections.abc import Callable

from mbdsl.elements import find
from mbdsl.lang import syntax as s
from mbdsl.lang.foreign_names import inertia, vector, with_unit
from mbdsl.lang.unparse import write

#: joints in space -> their counterparts in the plane
IN_PLANE = {"Spherical": "Revolute", "Universal": "Revolute", "Cylindrical": "Prismatic"}
#: end of a name -> the kind here, and its parameters by the names there
_RENAMED: dict[str, tuple[str, dict[str, str]]] = {
    "Spring": ("SpringDamper", {"c": "k", "s_unstretched": "s0"}),
    "Damper": ("SpringDamper", {"d": "c"}),
    "SpringDamperParallel": ("SpringDamper", {"c": "k", "d": "c", "s_unstretched": "s0"}),
    "WorldForce": ("Force", {}),
    "WorldTorque": ("Torque", {}),
    "RevolutePlanarLoopConstraint": ("Revolute", {}),
    "IdealRolling": ("RollingDisc", {"R": "radius"}),
    "RollingWheel": ("RollingDisc", {"radius": "radius"}),
    "Beam": ("FlexibleBeam", {}),
    "Link": ("Rod", {}),
    "Bar": ("Rod", {}),
    "RigidBody": ("Body", {"Izz": "I", "Jzz": "I", "mass": "m", "inertia": "I"}),
    "Hinge": ("Revolute", {}),
    "Pin": ("Revolute", {}),
    **dict.fromkeys(("Ball", "BallJoint", "BallAndSocket", "SphericalJoint"), ("Spherical", {})),
    **dict.fromkeys(("UniversalJoint", "Cardan", "CardanJoint", "Hooke"), ("Universal", {})),
    "CylindricalJoint": ("Cylindrical", {}),
    "PlanarJoint": ("Planar", {}),
    "ScrewJoint": ("Screw", {}),
    "FixedJoint": ("Fixed", {}),
    "RevoluteJoint": ("Revolute", {}),
    "PrismaticJoint": ("Prismatic", {}),
    "Slider": ("Prismatic", {}),
    "Translational": ("Prismatic", {}),
    "Weld": ("Fixed", {}),
    "Motion": ("RotationalDriver", {}),
    "Motor": ("RotationalDriver", {}),
    **{
        f"{axis}.Components.{name}": (f"{axis}SpringDamper", {"c": "k", "d": "c", "s_rel0": "s0", "phi_rel0": "phi0"})
        for axis in ("Rotational", "Translational")
        for name in ("Spring", "Damper", "SpringDamper")
    },
    "Rotational.Sources.Position": ("RotationalDriver", {}),
    "Rotational.Sources.Speed": ("RotationalVelocityDriver", {}),
    "Translational.Sources.Position": ("TranslationalDriver", {}),
    "Translational.Sources.Speed": ("TranslationalVelocityDriver", {}),
}
_EXPRESSION = "there are no blocks: write the expression where its value is used, as in `tau = 3 N.m*sin(2*time)`"
_GEARS = (
    "there are no shafts: gears are bodies with a GearPair between them, `GearPair gears(wheel.c, pinion.c, r_a = ..., "
    "r_b = ...);`, with the ratio r_b/r_a"
)
_FRICTION = "friction belongs to its joint, as in `Revolute pin(ground, rod.a, mu = 0.1, radius = 10 mm);`"
_LAW = "write a law of the speed, as in `Torque load(pin, tau = -0.1 N.m.s*pin.w);`"
_STOP = "use a TranslationalStop or a RotationalStop, a spring and damper beyond a clearance"
_SENSOR = "sensors are not needed: signals such as `rod.b.x`, `pin.phi` and `pin.fx` can be used and written directly"
#: a part of a name -> what to write instead
_TEXTS = {
    "Blocks.Interfaces": "an input is declared `input Real u;`, an output `Real y = ...;`",
    "Blocks": _EXPRESSION,
    "Sensors": _SENSOR,
    "JointRRR": "use three Revolute joints and two bodies",
    "JointRRP": "use two Revolute joints, a Prismatic and the bodies between them",
    "Inertia": "a rotor is a Body on a Revolute: `Body rotor(m = 1 kg, I = 0.1 kg.m2);`",
    "Translational.Components.Mass": "a sliding mass is a Body on a Prismatic",
    "Rotational.Components.Fixed": "the frame of the ground is the name of the ground",
    "Flange_a": "there are no flanges: connectors are frames, `Frame name;`",
    "Flange_b": "there are no flanges: connectors are frames, `Frame name;`",
    "Forces.Force": "it acts on both frames there, and on frame_b only here: write `Force f(rod.b, fx = ...);`",
    **dict.fromkeys(("IdealGear", "LossyGear", "Gearbox", "IdealGearR2R"), _GEARS),
    "IdealPlanetary": f"{_GEARS}; the carrier is a body that holds the planets",
    "IdealGearR2T": "use a RackAndPinion between a body that turns and one that slides",
    **dict.fromkeys(("IdealRollingWheel", "RollingConstraintVerticalWheel"), "use a RollingDisc"),
    **dict.fromkeys(("BearingFriction", "Brake", "Clutch", "OneWayClutch", "SupportFriction"), _FRICTION),
    **dict.fromkeys(("ElastoBacklash", "ElastoGap"), _STOP),
    **dict.fromkeys(
        ("LinearSpeedDependentTorque", "QuadraticSpeedDependentTorque", "LinearSpeedDependentForce"),
        _LAW,
    ),
    **dict.fromkeys(
        ("ConstantTorque", "TorqueStep", "SignTorque"), "write `Torque t(pin, tau = ...);`, a law of time and signals"
    ),
    **dict.fromkeys(("ConstantForce", "ForceStep"), "write `Force f(rod.b, fx = ...);`, a law of time and signals"),
    **dict.fromkeys(("ConstantSpeed", "Accelerate", "Move"), "use a RotationalDriver, whose `phi` is a law of time"),
    **dict.fromkeys(("LineForceWithMass", "LineForceWithTwoMasses"), "use a SpringDamper and a PointMass"),
    **dict.fromkeys(("ForceAndTorque", "WorldForceAndTorque"), "write a Force and a Torque on the same frame"),
    **dict.fromkeys(
        ("FixedShape", "Visualizers.Ground"), "shapes are in `annotation(Shape(...))` after a body or the ground"
    ),
    "Gravity": "gravity belongs to the ground: `Ground ground(g = 9.81 m/s2);`",
    **dict.fromkeys(("double", "float", "var", "let", "num"), "write `Real`"),
    "int": "write `Integer`",
    "bool": "write `Boolean`",
    "string": "write `String`",
    "str": "write `String`",
}

#: where the ports of a declaration lead: port -> name of a frame, and whether a body has it; "" -> the ground
Ends = Callable[[str], tuple[str, bool] | None]


def instead(d: s.Declaration, ends: Ends, spatial: bool = False) -> str | None:
    """What to write instead of a declaration with a type that mbdsl does not have; None if it is unknown there, too.

    ``spatial``: in a model in space.
    """
    parts = d.type.split(".")
    suffixes = [".".join(parts[i:]) for i in range(len(parts))]
    given = {a.name: a.value for a in d.arguments if a.name and a.value is not None}
    for suffix in suffixes:
        if suffix in _MADE:
            return _MADE[suffix](d.name, given, ends, spatial)
        if suffix in _RENAMED and not (len(parts) == 1 and "." in suffix):
            name, names = _RENAMED[suffix]
            if not spatial and (in_plane := IN_PLANE.get(name)) is not None:
                return f"in the plane write `{_renamed(d, in_plane, names)}`"
            return f"write `{_renamed(d, name, names)}`"
        if suffix in _TEXTS:
            return _TEXTS[suffix]
    found = next((part for part in ("Blocks.Interfaces", "Blocks", "Sensors") if f".{part}." in f".{d.type}"), None)
    return _TEXTS[found] if found else None


def _renamed(d: s.Declaration, name: str, names: dict[str, str]) -> str:
    shown = []
    kind = find(name) or find(name, spatial=True)
    for a in d.arguments:
        if a.value is not None:
            own = names.get(a.name, a.name)
            shown.append(f"{own} = {with_unit(kind, own, a.value)}" if a.name else write(a.value))
    return f"{name} {d.name}({', '.join(shown) or '...'});"


def _translation(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    """A frame at one end; the other end is then the frame of a body."""
    r, first, second = vector(given.get("r"), spatial), ends("frame_a"), ends("frame_b")
    if first is not None and first[1]:
        return f"write `Frame {name}({first[0]}, r = {r});`, and `{name}` instead of `{name}.frame_b`"
    if second is not None and second[1]:
        return f"write `Frame {name}({second[0]}, r = -{r});`, and `{name}` instead of `{name}.frame_a`"
    if first is not None and second is not None:
        return f"a link between two joints is a body: write `Rod {name}(m = ..., length = ...);`"
    return f"a frame at a distance is fixed to a body: write `Frame {name}(body.c, r = {r});`"


def _fixed(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    angle = f", phi = {write(given['phi'])}" if "phi" in given else ""
    where = f"r = {vector(given.get('r'), spatial)}{angle if not spatial else ''}"
    world = ends("")
    return (
        f"write `Frame {name}({world[0] if world else 'ground'}, {where});`, and `{name}` instead of `{name}.frame_b`"
    )


def _rotation(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    first = ends("frame_a")
    angle = write(given["alpha"]) if "alpha" in given else "..."
    if "angle" in given:  # in degrees
        given_angle = write(given["angle"])
        angle = f"{given_angle} deg" if isinstance(given["angle"], s.Number) else f"({given_angle})*(1 deg)"
    turned = f"phi = {angle}"
    if spatial:
        n = write(given["n"]) if "n" in given else "{1, 0, 0}"
        at = f"r = {vector(given['r'], spatial)}, " if "r" in given else ""
        turned = f"{at}n = {n}, {turned}"
    return f"write `Frame {name}({first[0] if first and first[1] else 'body.c'}, {turned});`"


def _shape(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    moments = inertia(given) if spatial else next((write(given[key]) for key in ("I_33", "I") if key in given), "...")
    com = f", com = {vector(given['r_CM'], spatial)}" if "r_CM" in given else ""
    m = write(given["m"]) if "m" in given else "..."
    first = "{0, 0, 0}" if spatial else "{0, 0}"
    frames = f"frames(a = {first}, b = {vector(given.get('r'), spatial)})"
    return f"write `Body {name}(m = {m}, I = {moments}{com}, {frames});`"


def _box(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    size = [_number(given.get(key)) for key in ("width", "height", "density")]
    width, height, density = size[0], size[1] or size[0], size[2] or 7700.0
    length = _length(given.get("r"))
    if spatial:
        return _solid("Box", name, {"length": length, "width": width, "height": height}, density)
    if length is None or width is None or height is None:
        return f"write `Body {name}(m = ..., I = m*(length^2 + width^2)/12, length = ...);`"
    m = density * length * width * height
    return _bar(name, m, m * (length**2 + width**2) / 12.0, length, density)


def _cylinder(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    diameter, density = _number(given.get("diameter")), _number(given.get("density")) or 7700.0
    length = _length(given.get("r"))
    if spatial:
        radius = diameter / 2.0 if diameter is not None else None
        return _solid("Cylinder", name, {"length": length, "radius": radius}, density)
    if length is None or diameter is None:
        return f"write `Body {name}(m = ..., I = m*(length^2/12 + diameter^2/16), length = ...);`"
    m = density * math.pi * diameter**2 / 4.0 * length
    return _bar(name, m, m * (length**2 / 12.0 + diameter**2 / 16.0), length, density)


def _solid(kind: str, name: str, sizes: dict[str, float | None], density: float) -> str:
    """A uniform solid in space, whose length is along its x axis."""
    shown = ", ".join(f"{key} = {'...' if value is None else f'{value:.6g} m'}" for key, value in sizes.items())
    return f"write `{kind} {name}(rho = {density:g} kg/m3, {shown});`, whose length is along x, from frame a to frame b"


def _bar(name: str, m: float, inertia: float, length: float, density: float) -> str:
    return (
        f"write `Body {name}(m = {m:.6g} kg, I = {inertia:.6g} kg.m2, length = {length:.6g} m);`, "
        f"for the density {density:g} kg/m3"
    )


def _bushing(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    def value(key: str) -> str:
        return write(given[key]) if key in given else "0"

    shown = f"k = {{{value('c_x')}, {value('c_y')}}}, c = {{{value('d_x')}, {value('d_y')}}}"
    shown += f", k_phi = {value('c_phi')}" if "c_phi" in given else ""
    shown += f", c_phi = {value('d_phi')}" if "d_phi" in given else ""
    return f"write `Bushing {name}({shown});`, whose frames coincide where it is relaxed"


def _massless_rod(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    """A rod with two joints that let it turn at its ends: a distance."""
    length = write(given["rodLength"]) if "rodLength" in given else "..."
    if "rodLength" not in given and isinstance(r := given.get("rRod_ia"), s.Array):
        known = _length(r)
        length = f"{known:.12g} m" if known is not None else length
    return f"write `Distance {name}(length = {length});`, a rod without mass; connect it as before"


def _marker(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    first = ends("frame_a")
    return f"a point of a body is a frame: write `Frame {name}({first[0] if first else 'body'}, r = {{x, y}});`"


_MADE: dict[str, Callable[[str, dict[str, s.Expression], Ends, bool], str]] = {
    "Parts.SpringDamper": _bushing,
    "Marker": _marker,
    "SphericalSpherical": _massless_rod,
    "UniversalSpherical": _massless_rod,
    "FixedTranslation": _translation,
    "FixedRotation": _rotation,
    "Parts.Fixed": _fixed,
    "BodyShape": _shape,
    "BodyBox": _box,
    "BodyCylinder": _cylinder,
}


def _number(e: s.Expression | None) -> float | None:
    if isinstance(e, s.Number):
        return e.value * (e.unit.factor if e.unit is not None else 1.0)
    return None


def _length(e: s.Expression | None) -> float | None:
    if not isinstance(e, s.Array):
        return None
    found = [_number(item) for item in e.items]
    factor = e.unit.factor if e.unit is not None else 1.0
    return math.hypot(*found) * factor if None not in found else None  # type: ignore[arg-type]
