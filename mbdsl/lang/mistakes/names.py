"""Names of Modelica and Adams without the same meaning here, and what to write instead."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from mbdsl.elements.kind import Kind
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes.bodies import MOMENTS, PRODUCTS, inertia
from mbdsl.lang.mistakes.values import floats, numbers
from mbdsl.lang.modelica_names import CONSTANTS
from mbdsl.lang.unparse import write

# -- refused: functions, constants and members -----------------------------------------------------------------------

CLOCK = "clocked equations are written `when sample(0 s, 1 ms) then y = u; end when;`, with `pre(y)` for `previous(y)`"
_SIGNALS = "signals are named directly: `rod.b.x`, `pin.phi`, `pin.w`"
#: function -> what to write instead
FUNCTIONS = {
    **dict.fromkeys(("Clock", "hold", "previous", "interval", "subSample", "superSample", "shiftSample"), CLOCK),
    "reinit": "it is a statement of a `when`: `when condition then reinit(v, -0.8*v); end when;`",
    "delay": "past values are kept by samples, `when sample(0 s, 1 ms) then y1 = u; y2 = pre(y1); end when;`, or by a "
    "state that lags, `der(y) = (u - y)/T`",
    "semiLinear": "write `(if x >= 0 then k1*x else k2*x)`",
    "homotopy": "write its first argument alone",
    "Vectors.length": "write `hypot(x, y)`",
    "Vectors.norm": "write `hypot(x, y)`",
    "norm": "write `hypot(x, y)`",
    "cross": "write the component along z: `x1*y2 - y1*x2`",
    "rem": "write `mod(x, y)` for positive numbers",
    "String": "numbers cannot be converted to texts",
    "pow": "a power is written `x^y`",
    "sqr": "a square is written `x^2`",
    "arctan": "write `atan(x)`",
    "arctan2": "write `atan2(y, x)`",
    "arcsin": "write `asin(x)`",
    "arccos": "write `acos(x)`",
    **dict.fromkeys(("radians", "deg2rad", "DTOR"), "give the number its unit: `30 deg`"),
    **dict.fromkeys(("degrees", "rad2deg", "RTOD"), "divide by a degree: `pin.phi/(1 deg)`"),
    **dict.fromkeys(("step", "STEP", "heaviside"), "write `(if time < t1 then a else b)`, or use a Table for a ramp"),
    **dict.fromkeys(("STEP5", "AKISPL", "CUBSPL"), 'use a Table with `smoothness = "cubic"`'),
    **dict.fromkeys(("IMPACT", "BISTOP"), "use TranslationalStop, RotationalStop or CircleContact"),
    **dict.fromkeys(("DX", "DY", "DM", "VX", "VY", "VM", "VR", "AZ", "WZ", "FX", "FY", "TZ"), _SIGNALS),
}
_RATES = (("roll", "wx_local"), ("pitch", "wy_local"), ("yaw", "wz_local"))
#: member of a component or frame -> what to write instead
MEMBERS = {
    **dict.fromkeys(("w_rel", "w_rel_a"), "the angular velocity of a hinge is w, that of a frame wx, wy, wz in space"),
    **dict.fromkeys(("R", "phi_rel", "angle"), "its angle is phi"),
    **dict.fromkeys(
        ("frame_a", "frame_b"),
        "they are the frames a and b of a body: give it a length, or `frames(a = {0, 0} m, b = {1, 0} m)`, positions "
        "from its reference point, which is frame_a in Modelica",
    ),
    **dict.fromkeys(("q0", "q1", "q2", "q3", "quaternion", "Q"), "its quaternion is p0, p1, p2, p3, in space"),
    **dict.fromkeys(("angles", "psi", "theta"), "its Cardan angles are phi_x, phi_y, phi_z, in space"),
    **{
        name: f"its {name} is the Cardan angle {own}, in space{', and phi in the plane' if own == 'phi_z' else ''}"
        for own, names in {"phi_x": "roll bank", "phi_y": "pitch elevation", "phi_z": "yaw heading"}.items()
        for name in names.split()
    },
    **{f"{name}_rate": f"its angular velocity about its own axes is {own}, in space" for name, own in _RATES},
    **{
        f"{w}{i}": f"its angular velocity is w{i} about the axis of the world, w{i}_local about its own, in space"
        for i in "xyz"
        for w in ("w_", "omega_", "omega")
    },
    "s_rel": "its distance or position is s",
    "v_rel": "its velocity is v",
    "f": "forces are fx and fy, in space also fz, of joints, `force` of springs",
    "t": "torques are tau of joints, `torque` of springs",
    **dict.fromkeys(
        ("axis", "support", "flange", "flange_a", "flange_b"),
        "there are no flanges: drivers and springs are attached to the joint, as in `RotationalDriver d(pin, ...)`",
    ),
}
#: parameter -> its name here
_SAME = {
    "r_CM": "com",
    **dict.fromkeys(("I_33", "I_zz", "Izz", "J", "inertia"), "I"),
    **dict.fromkeys(("s_unstretched", "s_rel0", "l0", "L0"), "s0"),
    **dict.fromkeys(("phi_rel0", "phi_offset"), "phi0"),
    **dict.fromkeys(("L", "l"), "length"),
    "mass": "m",
    "axis": "n",
    "stiffness": "k",
    "damping": "c",
    "R": "radius",
}
_INITIAL = "initial values go under `initial equation`, as in `rod.phi = 30 deg;`"
#: parameter -> what to write instead
PARAMETERS = {
    **dict.fromkeys(
        ("I_11", "I_22", "I_21", "I_31", "I_32"), "leave it out: a planar body has one moment of inertia, `I`"
    ),
    **dict.fromkeys(("k_x", "c_x", "d_x"), "use a Bushing: `k = {kx, ky}`, `c = {cx, cy}`"),
    **dict.fromkeys(("phi_start", "w_start"), _INITIAL),
    "enableGravity": "gravity acts on all bodies; a Force with fy = m*g takes it from one of them",
    "c_w": "in the plane it is `c_phi`",
    "gravityType": "gravity is uniform here; for none, write `g = 0`",
    "density": "give the mass `m`",
}


#: other names of these
_INERTIA = {"Ixx": "I_11", "Iyy": "I_22", "Izz": "I_33", "Ixy": "I_21", "Ixz": "I_31", "Iyz": "I_32"}


#: other names of the components of a force or torque
_LOADS = ("f", "F", "force", "t", "T", "tau", "torque", "M", "moment", "f_x", "Fx", "tau_x")


def components(kind: Kind, e: s.Expression | None) -> str | None:
    """How a vector of a Force or Torque is written by its components; None if it is neither of them."""
    given = e.items if isinstance(e, s.ArrayNode) and len(e.items) <= 3 else ()
    unit = e.unit if isinstance(e, s.ArrayNode) else None
    items = [write(s.Number(x.value, unit) if isinstance(x, s.Number) and x.value and unit else x) for x in given]
    if kind.name == "Force":
        names = ("fx", "fy", "fz") if kind.spatial else ("fx", "fy")
        values = (*items, "0", "0", "0")[: len(names)] if items else ("...",) * len(names)
        return f"give its components: `{', '.join(f'{n} = {x}' for n, x in zip(names, values, strict=True))}`"
    if kind.name != "Torque" or not given:
        return None
    if not kind.spatial:
        return f"in the plane it has one component: `tau = {items[-1]}`"
    axes = ("{1, 0, 0}", "{0, 1, 0}", "{0, 0, 1}")
    parts = [f"`tau = {x}, n = {n}`" for x, n in zip(items, axes, strict=False) if x != "0"]
    several = ", a Torque for each component" if len(parts) > 1 else ""
    return f"it has one value and an axis: {' and '.join(parts) or '`tau = ..., n = {0, 0, 1}`'}{several}"


def with_unit(kind: Kind | None, name: str, e: s.Expression) -> str:
    """A value as it is written for a parameter; a number has its unit, so that its meaning is certain."""
    found = kind.parameter(name) if kind is not None else None
    bare = isinstance(e, s.Number) and e.unit is None and e.value != 0
    return f"{write(e)} {found.unit}" if bare and found is not None and found.unit not in ("", "1") else write(e)


def parameter(kind: Kind, known: Sequence[str], name: str, given: Mapping[str, s.Expression]) -> str | None:
    """The remedy for the parameter ``name`` of a kind that takes ``known``; ``given`` are those given."""
    spatial = kind.spatial
    if spatial and "I" in known and name in (*MOMENTS, *PRODUCTS, *_INERTIA):
        return f"write `I = {inertia({_INERTIA.get(key, key): value for key, value in given.items()})}`"
    if name == "diameter" and "radius" in known:
        return f"write `radius = {_half(given[name])}`" if name in given else "give its `radius`"
    if spatial and name in ("radius", "diameter") and "length" in known and "radius" not in known:
        return "use a Cylinder, which has a `radius`"
    if (same := _SAME.get(name, "")) in known:
        e = given.get(name)
        value = with_unit(kind, same, e) if isinstance(e, s.Number) else vector(e, spatial)
        if name == "r_CM" and kind.name == "Body" and e is not None and not {"frames", "length"} & given.keys():
            # The reference point is frame_a in Modelica.
            return f"write `com = {value}, frames(a = {'{0, 0, 0}' if spatial else '{0, 0}'})`"
        return f"write `{same} = {value}`" if name in given else f"it is called `{same}` here"
    if name == "constantGravity" and (found := numbers(given.get(name))) is not None:
        size = math.hypot(*found[:2])
        n = f", n = {floats([x / size for x in found[:2]])}" if size and (found[0] or found[1] > 0) else ""
        return f"write `g = {size:.12g}{n}`"
    if name in _LOADS and (kind.name in ("Force", "Torque")):
        return components(kind, given.get(name))
    if kind.name in ("Spherical", "Universal", "ConstantVelocity") and name in ("c", "c_w", "d", "damping"):
        value = f"{write(given[name]) if name in given else '...'}"
        return f"a Bushing damps the angular velocity of a joint: write `Bushing damper(joint, c_w = {value});`"
    if name == "d" and "k" in known and "c" in known:
        stiffness = f"k = {with_unit(kind, 'k', given['c'])}, " if "c" in given and "k" not in given else ""
        damping = with_unit(kind, "c", given["d"]) if "d" in given else "..."
        return f"here `k` is the stiffness and `c` the damping: write `{stiffness}c = {damping}`"
    return PARAMETERS.get(name)


def _half(e: s.Expression) -> str:
    if isinstance(e, s.Number):
        return f"{e.value / 2:g}{f' {e.unit.text}' if e.unit is not None else ''}"
    return f"({write(e)})/2"


def constant(name: str) -> str:
    """The remedy for an unknown name in the package Modelica."""
    if name.startswith("Modelica.Constants."):
        return f"known names are {', '.join(c.rpartition('.')[2] for c in CONSTANTS)}; for others write the number"
    return "Modelica.Math, Modelica.Constants, Modelica.Units and the joints and bodies of MultiBody are known"


# -- vectors ---------------------------------------------------------------------------------------------------------


def in_braces(e: s.Expression | None, shape: tuple[int, ...]) -> str | None:
    """A vector of the plane that was given in ``shape``, as the language writes it; None for other shapes."""
    if shape == (3,):
        return planar(e)
    if shape == (1, 2) and isinstance(e, s.ArrayNode) and isinstance(e.items[0], s.ArrayNode):
        return write(s.ArrayNode(e.items[0].items, e.unit))
    return None


def vector(e: s.Expression | None, spatial: bool) -> str:
    """A vector as it is written in a model in space, or in the plane."""
    if not spatial:
        return planar(e)
    return write(e) if e is not None else "{x, y, z}"


def planar(e: s.Expression | None) -> str:
    """A vector as it is written in the plane: {1, 0, 0} as {1, 0}."""
    if isinstance(e, s.ArrayNode) and len(e.items) == 3 and e.unit is None:
        e = s.ArrayNode(e.items[:2])
    return write(e) if e is not None else "{x, y}"


class Attached(NamedTuple):
    """How a joint is declared: the two frames, if they are known, by ``connected`` in connections, and the rest."""

    frames: tuple[str, str] = ("...", "...")
    more: str = ", ..."
    connected: bool = False


def axis(kind_name: str, owner: str, n: Sequence[float], joint: Attached) -> str | None:
    """The remedy for an axis ``n`` of a joint; "" if the joint has this axis, None if it cannot have an axis."""
    (first, second), more, connected = joint
    deleted = ", and delete its connections" if connected else ""
    if kind_name == "Revolute":
        if tuple(n) == (0, 0, 1):
            return ""
        if tuple(n) == (0, 0, -1):
            exchanged = f"`Revolute {owner}({second}, {first}{more});`{deleted}"
            return f"angles are counter-clockwise; exchange its frames: write {exchanged}"
        return "joints in the plane turn about z; for a model in space write `spatial model`"
    if kind_name != "Prismatic" or len(n) not in (2, 3) or not any(n[:2]) or any(n[2:]):
        return None
    if n[0] > 0 and n[1] == 0:
        return ""
    angle = math.degrees(math.atan2(n[1], n[0]))
    return (
        f"it slides along the x axis of frame_a: write `Frame {owner}_axis({first}, phi = {angle:.15g} deg);` and "
        f"`Prismatic {owner}({owner}_axis, {second}, phi0 = {-angle:.15g} deg{more});`{deleted}"
    )
