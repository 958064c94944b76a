"""What joints and forces exert on their frames, as expressions.

The wrench on frame_b is the reaction of a joint with its friction, or the load of a force. On frame_a acts the opposite
wrench: elements have no mass, and they measure relative positions only. The torque about the origin of frame_a is that
about the origin of frame_b, and the moment of the force there:

    f_a = -f_b,   t_a = -(t_b + (r_b - r_a) x f_b)

A joint that is an expression of coordinates acts on all frames in it, by -G^T lam with its gradient G for each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mbdsl.elements.kind import JointKind, PairKind
from mbdsl.expressions import formulas
from mbdsl.expressions.frame_derivatives import by_motion, by_rate, frames_in
from mbdsl.expressions.symbolic import Expr, call, const, multiplier
from mbdsl.mechanism import contacts
from mbdsl.mechanism.signals import ComponentFormulas

#: components of the wrench on a port or a frame, and their units
UNITS = {"fx": "N", "fy": "N", "tau": "N.m"}
UNITS_IN_SPACE = {f"f{i}": "N" for i in "xyz"} | {f"t{i}": "N.m" for i in "xyz"} | {"tau": "N.m"}
Vector = Sequence[Expr]
#: a coordinate of a frame by its name, in the axes of which components are needed
Axes = Callable[[str], Expr]


def units(spatial: bool) -> dict[str, str]:
    return UNITS_IN_SPACE if spatial else UNITS


def on_port(f: ComponentFormulas, port: str) -> tuple[Vector, Vector]:
    """Force and torque of an element on one of its ports, at its origin in world axes: (2), (1), in space (3), (3)."""
    assert isinstance(f.kind, PairKind)
    if f.contacts:
        return _of_contacts(f, port)
    force, torque = _on_frame_b(f)
    if port == "frame_a":
        if not f.kind.reacts:
            return [const(0.0)] * len(force), [const(0.0)] * len(torque)
        d = [f.coordinate("frame_b", i) - f.coordinate("frame_a", i) for i in "xyz"[: len(force)]]
        moment = _cross(d, force)
        force, torque = [-x for x in force], [-(t + m) for t, m in zip(torque, moment, strict=True)]
    found = [*force, *torque]
    if not isinstance(f.kind, JointKind) or _rubs(f):
        # each port by itself: the moments of a bushing in axes of the world do not cancel
        for size, signal in f.kind.resists:
            load = formulas.evaluate(size, f)
            found = [x - load * g for x, g in zip(found, _gradient(f, signal, port), strict=True)]
    return found[: len(force)], found[len(force) :]


def _of_contacts(f: ComponentFormulas, port: str) -> tuple[Vector, Vector]:
    """What the rigid contacts of a component exert on one of its ports."""
    frame, n = f.coordinate(port, "x").value[0], 3 if f.kind.spatial else 2
    found = [const(0.0)] * (6 if f.kind.spatial else 3)
    for x in f.contacts.values():
        slips = [x.row(name) for name in ("slip", "slip_2") if x.law(name) is not None]
        force, torque = of_contact(x.name, [x.row("gap")], slips, f.kind.spatial)[frame]
        found = [a + b for a, b in zip(found, (*force, *torque), strict=True)]
    return found[:n], found[n:]


def of_contact(
    contact: str, gap: Sequence[Expr], slips: Sequence[Expr], spatial: bool
) -> dict[str, tuple[Vector, Vector]]:
    """Force and torque of a rigid contact on each frame in its expressions, with its friction while it slides."""
    found, n = of_expressions(contact, gap, slips, spatial), 3 if spatial else 2
    for frame, loads in contacts.rubbing(contact, slips, spatial):
        force, torque = found.get(frame) or ([const(0.0)] * n, [const(0.0)] * (2 * n - 3))
        own = [a + b for a, b in zip((*force, *torque), loads, strict=True)]
        found[frame] = own[:n], own[n:]
    return found


def _rubs(f: ComponentFormulas) -> bool:
    """Whether a joint has friction."""
    return isinstance(f.kind, JointKind) and bool(f.kind.friction and f.given("mu_s"))


def _on_frame_b(f: ComponentFormulas) -> tuple[Vector, Vector]:
    """The reactions of a joint, and what a formula says that an element exerts."""
    kind = f.kind
    assert isinstance(kind, PairKind)
    keys = ("fx", "fy", "fz", "tx", "ty", "tz") if kind.spatial else ("fx", "fy", "tau")
    found = dict.fromkeys(keys, const(0.0))
    if isinstance(kind, JointKind):
        found |= {key: f.signal(key) for key in keys if key in kind.reaction}
    if not isinstance(kind, JointKind) or _rubs(f):
        for key, formula in kind.exerts.items():
            found[key] = found[key] + formulas.evaluate(formula, f)
    n = 3 if kind.spatial else 2
    return [found[key] for key in keys[:n]], [found[key] for key in keys[n:]]


def _gradient(f: ComponentFormulas, signal: str, port: str) -> list[Expr]:
    """The derivatives of a signal with respect to the motion of the frame at a port."""
    frame = f.coordinate(port, "x").value[0]
    return by_motion(f.signal(signal), frame, f.kind.spatial)


def of_expressions(
    joint: str, relations: Sequence[Expr], velocity_constraints: Sequence[Expr], spatial: bool
) -> dict[str, tuple[Vector, Vector]]:
    """Force and torque of a joint on each frame in its expressions, as of ``on_port``; its other rows have none."""
    found: dict[str, list[Expr]] = {}
    n = 3 if spatial else 2
    for k, row in enumerate((*relations, *velocity_constraints)):
        derivatives = by_motion if k < len(relations) else by_rate
        for frame in frames_in(row):
            load = [-(multiplier(joint, k) * g) for g in derivatives(row, frame, spatial)]
            before = found.get(frame)
            found[frame] = load if before is None else [x + y for x, y in zip(before, load, strict=True)]
    return {frame: (load[:n], load[n:]) for frame, load in found.items()}


def in_axes(force: Vector, torque: Vector, axes: Axes) -> dict[str, Expr]:
    """A wrench, in world axes, by the names of its components in the axes of a frame."""
    if len(force) == 2:
        c, s = call("cos", axes("phi")), call("sin", axes("phi"))
        x, y = force
        return {"fx": c * x + s * y, "fy": c * y - s * x, "tau": torque[0]}
    found = {f"{name}{i}": _along(v, axes, i) for name, v in (("f", force), ("t", torque)) for i in "xyz"}
    return found | {"tau": found["tz"]}


def _along(v: Vector, axes: Axes, i: str) -> Expr:
    x, y, z = (a * axes(i + k) for a, k in zip(v, "xyz", strict=True))
    return x + y + z


def _cross(a: Vector, b: Vector) -> list[Expr]:
    if len(b) == 2:
        return [a[0] * b[1] - a[1] * b[0]]
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]
