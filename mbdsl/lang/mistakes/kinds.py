"""Kinds of Modelica (and some of Adams) without the same meaning here, and what to write instead."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.elements import find
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes import blocks, bodies, frames, members
from mbdsl.lang.mistakes.frames import Ends
from mbdsl.lang.mistakes.gears import GEARS
from mbdsl.lang.mistakes.names import CLOCK, with_unit
from mbdsl.lang.mistakes.values import ZERO, is_zero, opposite, vector
from mbdsl.lang.modelica_names import has_no_effect
from mbdsl.lang.unparse import write

#: kinds in space -> their counterparts in the plane
IN_PLANE = {"Spherical": "Revolute", "Universal": "Revolute", "Cylindrical": "Prismatic", "Gear": "GearPair"}
#: kind here -> ends of names of kinds with the same parameters
_SAME = {
    "Force": "WorldForce",
    "Torque": "WorldTorque",
    "Revolute": "RevolutePlanarLoopConstraint Hinge Pin RevoluteJoint",
    "FlexibleBeam": "Beam",
    "Rod": "Link Bar",
    "Spherical": "Ball BallJoint BallAndSocket SphericalJoint",
    "Universal": "UniversalJoint Cardan CardanJoint Hooke",
    "Cylindrical": "CylindricalJoint",
    "Planar": "PlanarJoint",
    "Screw": "ScrewJoint",
    "Fixed": "FixedJoint Weld",
    "Prismatic": "PrismaticJoint Slider Translational",
    "RotationalDriver": "Motion Motor Rotational.Sources.Position",
    "RotationalVelocityDriver": "Rotational.Sources.Speed",
    "TranslationalDriver": "Translational.Sources.Position",
    "TranslationalVelocityDriver": "Translational.Sources.Speed",
}
#: end of a name -> the kind here, and its parameters by the names there
_RENAMED: dict[str, tuple[str, dict[str, str]]] = {
    **{name: (kind, {}) for kind, names in _SAME.items() for name in names.split()},
    "Spring": ("SpringDamper", {"c": "k", "s_unstretched": "s0"}),
    "Damper": ("SpringDamper", {"d": "c"}),
    "SpringDamperParallel": ("SpringDamper", {"c": "k", "d": "c", "s_unstretched": "s0"}),
    "IdealRolling": ("RollingDisc", {"R": "radius"}),
    "RollingWheel": ("RollingDisc", {"radius": "radius"}),
    "RigidBody": ("Body", {"Izz": "I", "Jzz": "I", "mass": "m", "inertia": "I"}),
    **{
        f"{axis}.Components.{name}": (f"{axis}SpringDamper", {"c": "k", "d": "c", "s_rel0": "s0", "phi_rel0": "phi0"})
        for axis in ("Rotational", "Translational")
        for name in ("Spring", "Damper", "SpringDamper")
    },
}
_FRICTION = (
    "friction belongs to its joint, as in `Revolute pin(ground, rod.a, mu = 0.1, radius = 10 mm);`, with `sticks = "
    "true` if it holds the joint at rest"
)
_LAW = "write a law of the speed, as in `Torque load(pin, tau = -0.1 N.m.s*pin.w);`"
_STOP = (
    "use a TranslationalStop or a RotationalStop, whose limits are the clearance; with `k`, a spring and a damper act "
    "beyond it"
)
_FREEWHEEL = (
    "a freewheel is a torque against one sense: write `Torque lock(pin, tau = 100 N.m.s*max(0, -pin.w));`, with the "
    "joint `pin` between its shafts"
)
_MASS_WITH_STOP = "write a Body on a Prismatic with `mu` and `sticks = true`, and a TranslationalStop of this Prismatic"
_SENSOR = (
    "sensors are not needed: signals such as `rod.b.x`, `pin.phi` and `pin.fx` can be used and written directly; an "
    "accelerometer, gyroscope or load cell in the axes of a frame is a Sensor, `Sensor imu(rod.b);`"
)
_MEASURED = (
    "write `Sensor imu(rod.b);`, with accelerations `imu.ax`, angular velocities `imu.w` (in space `imu.wx`) and loads "
    "`imu.fx`, `imu.tau` in the axes of the frame"
)
_ROPE = "write `Rope rope(block.c, load, over = {wheel}, radius = 0.2 m, k = 100 kN/m, c = 200 N.s/m);`"
_WINCH = "write `Rope rope(load, drum.c, drum = 0.2 m, k = 100 kN/m, c = 200 N.s/m);`, which is wound on the drum"
_DIFFERENTIAL = (
    "write `Coupling differential(0.5*(left.phi + right.phi), drive.phi, ratio = ...);`, with the angles of the joints "
    "of its shafts"
)
_AXES = "its components are in the axes of the world; a first frame has others, as in `Force f(rod.b, rod.b, ...)`"
_AXIS = 'its axis n is one of the world; with `axes = "frame_b"` it is one of the body'
#: kind here -> parameters there without a counterpart, and what that means
_LEFT_OUT = {
    "Force": {"resolveInFrame": _AXES},
    "Torque": {"resolveInFrame": _AXIS},
    "SpringDamper": {"m": "a line force has no mass: put a PointMass where it is", "lengthFraction": ""},
}
#: types that become bodies with frames a and b, and types that become frames
BODIES = ("BodyShape", "BodyBox", "BodyCylinder", "Link", "Bar", "RigidBody", "Beam")
FRAMES = ("FixedTranslation", "FixedRotation", "Parts.Fixed")
#: a part of a name -> what to write instead
_TEXTS = {
    **blocks.TEXTS,
    "Sensors": _SENSOR,
    "Clock": CLOCK,
    **dict.fromkeys(("Accelerometer", "Gyroscope", "Gyro", "IMU", "LoadCell"), _MEASURED),
    **dict.fromkeys(("CutForce", "CutTorque", "CutForceAndTorque"), _MEASURED),
    **dict.fromkeys(("Cable", "Pulley", "Tendon", "Wire"), _ROPE),
    **dict.fromkeys(("Winch", "Hoist"), _WINCH),
    "Chain": f"a chain over discs that only pulls is a Rope; a closed one is a BeltDrive or ElasticBelt: {_ROPE}",
    "Differential": _DIFFERENTIAL,
    "JointRRR": "use three Revolute joints and two bodies",
    "JointRRP": "use two Revolute joints, a Prismatic and the bodies between them",
    "Translational.Components.Mass": "a sliding mass is a Body on a Prismatic",
    "Rotational.Components.Fixed": "the frame of the ground is the name of the ground",
    "Flange_a": "there are no flanges: connectors are frames, `Frame name;`",
    "Flange_b": "there are no flanges: connectors are frames, `Frame name;`",
    "Forces.Force": "it acts on both frames there, and on frame_b only here: write `Force f(rod.b, fx = ...);`",
    "RollingConstraintVerticalWheel": "use a RollingDisc",
    **dict.fromkeys(("BearingFriction", "Brake", "Clutch", "SupportFriction"), _FRICTION),
    **dict.fromkeys(("ElastoBacklash", "ElastoBacklash2", "ElastoGap"), _STOP),
    **dict.fromkeys(("MassWithStopAndFriction", "MassWithStop"), _MASS_WITH_STOP),
    **dict.fromkeys(("Freewheel", "OneWayClutch"), _FREEWHEEL),
    **dict.fromkeys(
        ("LinearSpeedDependentTorque", "QuadraticSpeedDependentTorque", "LinearSpeedDependentForce"),
        _LAW,
    ),
    **dict.fromkeys(("TorqueStep", "SignTorque"), "write `Torque t(pin, tau = ...);`, a law of time and signals"),
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


def instead(d: s.Declaration, ends: Ends, spatial: bool = False) -> str | None:
    """What to write instead of a declaration with a type that mbdsl does not have; None if it is unknown there, too.

    ``spatial``: in a model in space.
    """
    parts = d.type.split(".")
    suffixes = [".".join(parts[i:]) for i in range(len(parts))]
    given = {a.name: a.value for a in d.arguments if a.name and a.value is not None}
    for suffix in suffixes:
        if suffix in _MADE:
            made = _MADE[suffix](d.name, given, ends, spatial)
            starts = members.of_declaration(d, spatial) if suffix in BODIES else ""
            return f"{made}; and `{starts}` under `initial equation`" if starts else made
        if suffix in _RENAMED and not (len(parts) == 1 and "." in suffix):
            name, names = _RENAMED[suffix]
            if not spatial and (in_plane := IN_PLANE.get(name)) is not None:
                return f"in the plane write `{_renamed(d, in_plane, names)}`"
            planar_torque = name == "Torque" and not spatial  # it has one axis
            return f"write `{_renamed(d, name, names)}`{'' if planar_torque else _without(d, name)}"
        if suffix in _TEXTS:
            return _TEXTS[suffix]
    if parts[-1].endswith("Sensor") and len(parts[-1]) > len("Sensor"):
        return _SENSOR
    found = next((part for part in (*blocks.TEXTS, "Sensors") if f".{part}." in f".{d.type}"), None)
    return _TEXTS[found] if found else None


def _renamed(d: s.Declaration, name: str, names: dict[str, str]) -> str:
    shown = []
    kind = find(name) or find(name, spatial=True)
    for a in d.arguments:
        if a.value is not None and not has_no_effect(a.name, a.value) and a.name not in _LEFT_OUT.get(name, ()):
            own = names.get(a.name, a.name)
            shown.append(f"{own} = {with_unit(kind, own, a.value)}" if a.name else write(a.value))
    return f"{name} {d.name}({', '.join(shown) or '...'});"


def _without(d: s.Declaration, name: str) -> str:
    """What the counterpart of a renamed kind does not have."""
    given = {a.name for a in d.arguments if a.value is not None and not is_zero(a.value)}
    return "".join(f"; {text}" for key, text in _LEFT_OUT.get(name, {}).items() if key in given and text)


def _bushing(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    """Springs along x and y of the world: those of a Bushing whose first frame is the ground."""

    def value(key: str) -> str:
        return write(given[key]) if key in given else "0"

    world, first, second = ends(""), ends("frame_a"), ends("frame_b")
    at_world = [
        world is not None and end is not None and end[0].removesuffix(".frame_b") == world[0] for end in (first, second)
    ]
    axes = ""
    sign, frames, moved, rest = 1, "", "", ", whose frames coincide where it is relaxed"
    offset = [given.get(key, ZERO) for key in ("s_relx0", "s_rely0")]
    if any(at_world) and not all(at_world):
        assert world is not None and first is not None and second is not None
        sign = 1 if at_world[0] else -1
        start, end = world[0], (second if at_world[0] else first)[0]
        if not all(map(is_zero, offset)):
            shifted = vector(offset if sign > 0 else [opposite(x) for x in offset], 2)
            moved, start = f"Frame {name}_relaxed({start}, r = {shifted}); ", f"{name}_relaxed"
        frames, rest = f"{start}, {end}, ", ", and delete its connections"
    elif first is not None and second is not None:
        axes = ', axes = "world"'
    shown = f"{frames}k = {{{value('c_x')}, {value('c_y')}}}, c = {{{value('d_x')}, {value('d_y')}}}"
    shown += f", k_phi = {value('c_phi')}" if "c_phi" in given else ""
    shown += f", c_phi = {value('d_phi')}" if "d_phi" in given else ""
    angle = given.get("phi_rel0")
    shown += f", phi0 = {write(angle if sign > 0 else opposite(angle))}" if angle is not None else ""
    return f"write `{moved}Bushing {name}({shown}{axes});`{rest}"


def _marker(name: str, given: dict[str, s.Expression], ends: Ends, spatial: bool) -> str:
    first = ends("frame_a")
    return f"a point of a body is a frame: write `Frame {name}({first[0] if first else 'body'}, r = {{x, y}});`"


_MADE: dict[str, Callable[[str, dict[str, s.Expression], Ends, bool], str]] = {
    **GEARS,
    **blocks.MADE,
    **dict.fromkeys(("Parts.SpringDamper", "Parts.Spring"), _bushing),
    "Marker": _marker,
    "SphericalSpherical": bodies.massless_rod,
    "UniversalSpherical": bodies.massless_rod,
    "FixedTranslation": frames.translation,
    "FixedRotation": frames.rotation,
    "Parts.Fixed": frames.fixed,
    "BodyShape": bodies.shape,
    "BodyBox": bodies.box,
    "BodyCylinder": bodies.cylinder,
}
