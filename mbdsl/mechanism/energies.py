"""Gravity, and the energies of a scene as expressions over its frames."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import hypot

from mbdsl.elements.kind import BodyKind, ForceKind
from mbdsl.expressions.symbolic import Expr, const, coordinate
from mbdsl.mechanism.scene import Scene, is_state


def gravity(scene: Scene) -> tuple[float, ...]:
    """The gravity field (x, y), in space (x, y, z) [m/s2]."""
    ground = next((c for c in scene.components.values() if c.kind.name == "Ground"), None)
    n = (0.0,) * (3 if scene.spatial else 2) if ground is None else ground.values["n"]
    length = hypot(*n)
    g = 0.0 if ground is None else float(ground.values["g"])
    return tuple(g * x / length if length else 0.0 for x in n)


def _kinetic(frame: str, masses: Sequence[float]) -> Expr:
    """The kinetic energy of a body in space with the given frame in its centre of mass: m, then J row by row."""
    found = const(0.0)
    for i in "xyz":
        found = found + 0.5 * masses[0] * (coordinate(frame, f"v{i}") * coordinate(frame, f"v{i}"))
    if len(masses) == 1:
        return found
    # angular velocity in body axes
    w = [sum((coordinate(frame, axis + i) * coordinate(frame, f"w{i}") for i in "xyz"), const(0.0)) for axis in "xyz"]
    for i in range(3):
        for j in range(3):
            found = found + 0.5 * masses[1 + 3 * i + j] * (w[i] * w[j])
    return found


def energies(scene: Scene, excluded: Collection[str] = ()) -> tuple[Expr, Expr, Expr]:
    """Kinetic energy, potential energy and their sum [J], without the ``excluded`` bodies.

    The potential energy is that of gravity (zero at the origin of the ground), of springs, stops and contacts, and of
    springs whose law depends on their own coordinate, and on its rate as damping; other forces by expressions have
    none.
    """
    kinetic, potential = const(0.0), const(0.0)
    g = gravity(scene)
    for c in scene.components.values():
        if isinstance(c.kind, BodyKind) and c.kind.coordinates:
            if c.name in excluded or is_state(c):
                continue
            masses = c.kind.table(dict(c.values))
            if scene.spatial:
                kinetic = kinetic + _kinetic(f"{c.name}.c", masses)
                for key, field in zip("xyz", g, strict=True):
                    potential = potential - masses[0] * field * coordinate(f"{c.name}.c", key)
                continue
            for key, rate, mass in zip(("x", "y", "phi"), ("vx", "vy", "w"), masses, strict=False):
                speed = coordinate(f"{c.name}.c", rate)
                kinetic = kinetic + 0.5 * mass * (speed * speed)
                if key != "phi":
                    potential = potential - mass * g["xy".index(key)] * coordinate(f"{c.name}.c", key)
        elif isinstance(c.kind, ForceKind) and c.energy is not None:
            potential = potential + c.energy
    return kinetic, potential, kinetic + potential
