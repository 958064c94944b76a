"""Gears, belts and cams whose centres do not fit their radii at the start."""

from __future__ import annotations

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import coordinate
from mbdsl.simulation.mechanism_run import Motion
from mbdsl.system.signals import values

#: distance of the centres, relative to the mechanism's size, that is zero except for rounding
COINCIDENT = 1e-9
#: sine of the angle between axes that counts as zero
PARALLEL = 1e-6


def misfits(motion: Motion) -> list[str]:
    """Warnings about joints with a line of centres, from the consistent initial state.

    Raises
    ------
    InitialisationError
        If two centres coincide: the line of centres has no direction.
    """
    found = []
    for part in motion.parts:
        scene, first = part.system.scene, part.initial
        t, q, v = np.array([first.t]), first.q[None], first.v[None]
        for name, component in scene.components.items():
            if not isinstance(component.kind, JointKind):
                continue
            if component.kind.crossing:
                ends = [coordinate(frame, f"z{key}") for frame in component.ports.values() for key in "xyz"]
                z = np.array([x[0] for x in values(part.system, ends, t, q, v)])
                if np.linalg.norm(np.cross(z[:3], z[3:])) < PARALLEL:
                    raise InitialisationError(
                        f"the axes of {component.kind.name} {name} are parallel",
                        component.span,
                        hint="wheels with parallel axes: GearPair",
                    )
            if component.kind.misfit is None:
                continue
            a, b = component.ports.values()
            line = [coordinate(b, key) - coordinate(a, key) for key in ("xyz" if scene.spatial else "xy")]
            apart = np.array([x[0] for x in values(part.system, line, t, q, v)])
            if scene.spatial:  # across the axis
                axis = [coordinate(a, f"z{key}") for key in "xyz"]
                apart = np.cross(apart, [x[0] for x in values(part.system, axis, t, q, v)])
            distance = float(np.linalg.norm(apart))
            if distance <= COINCIDENT * part.system.tables.size:
                raise InitialisationError(
                    f"the centres of {component.kind.name} {name} coincide, and its line of centres has no direction",
                    component.span,
                    hint="place the frame origins at the centres of the two wheels",
                )
            if (misfit := component.kind.misfit(component.values, distance)) is not None:
                found.append(f"{component.kind.name} {name}: {misfit}")
    return found
