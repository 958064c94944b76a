"""What to write in place of a body without mass between springs, whose position is that of their equilibrium."""

from __future__ import annotations

from math import sqrt
from typing import Any

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.mechanism.scene import Component, Scene

#: mass to give such a body, relative to the lightest other one, and damping ratio of its vibration: this is fast and
#: decays soon, and the damping of slow motions of the others is small
SMALL, DAMPING = 1e-4, 0.1


def remedy(scene: Scene, name: str) -> str | None:
    """The remedy for the massless body ``name`` that springs alone hold; None if joints hold it, or no spring does."""
    held = [c for c in scene.components.values() if name in {scene.frames[f].body for f in c.ports.values()}]
    springs = [c for c in held if isinstance(c.kind, ForceKind) and _pulls(c)]
    turns = scene.components[name].values.get("I") == 0.0  # a mass alone would not help
    if turns or not springs or any(isinstance(c.kind, JointKind) and c.kind.rows for c in held):
        return None
    masses = [c.values.get("m") for c in scene.bodies() if c.name != name]
    m = SMALL * min((x for x in masses if isinstance(x, float) and x > 0.0), default=1.0)
    k = sum(max(_sizes(c.values["k"])) for c in springs)
    c = 2.0 * DAMPING * sqrt(k * m) / len(springs)
    names = ", ".join(f"`{spring.name}`" for spring in springs)
    small = (
        f"give it a small mass, and its springs the damping that makes its vibration decay: `m = {m:.3g} kg` and "
        f"`c = {c:.3g} N.s/m` in {names}"
    )
    both = _in_series(scene, name, held)
    return f"without a mass its position follows from the springs alone; {both + ', or ' if both else ''}{small}"


def _pulls(c: Component) -> bool:
    """Whether it is a linear spring with a stiffness [N/m]."""
    stiffness = c.kind.parameter("k")
    return stiffness is not None and stiffness.unit == "N/m" and any(_sizes(c.values["k"]))


def _sizes(k: Any) -> tuple[float, ...]:
    return tuple(abs(x) for x in k) if isinstance(k, tuple) else (abs(float(k)),)


def _in_series(scene: Scene, name: str, held: list[Component]) -> str:
    """The spring that two springs with a point between them are; "" if there is none."""
    if len(held) != 2 or any(c.kind.name != "SpringDamper" or not c.values["k"] for c in held):
        return ""
    ends = [[f for f in c.ports.values() if scene.frames[f].body != name] for c in held]
    points = {f for c in held for f in c.ports.values() if scene.frames[f].body == name}
    (k1, c1, s1), (k2, c2, s2) = ([float(c.values[key]) for key in ("k", "c", "s0")] for c in held)
    similar = abs(c1 * k2 - c2 * k1) <= 1e-9 * max(abs(c1 * k2), abs(c2 * k1))  # one spring as well, with damping
    if len(points) != 1 or any(len(x) != 1 for x in ends) or k1 + k2 == 0.0 or not similar:
        return ""
    k, c = k1 * k2 / (k1 + k2), (c1 * c2 / (c1 + c2) if c1 and c2 else 0.0)
    damping = f", c = {c:.12g} N.s/m" if c else ""
    new = f"{held[0].name}({_frame(scene, ends[0][0])}, {_frame(scene, ends[1][0])}, k = {k:.12g} N/m{damping}"
    return (
        f"two springs in a line are one: write `SpringDamper {new}, s0 = {s1 + s2:.12g} m);` in place of "
        f"`{held[0].name}`, `{held[1].name}` and `{name}`"
    )


def _frame(scene: Scene, frame: str) -> str:
    """A frame as models write it."""
    body = scene.components[scene.frames[frame].body]
    return body.name if frame == f"{body.name}.c" and getattr(body.kind, "is_frame", False) else frame
