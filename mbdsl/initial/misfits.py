"""Elements whose places do not fit their parameters at the start: wheels, points on surfaces and curves, ropes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import coordinate
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.signals import values
from mbdsl.system.system import System

#: distance of the centres, relative to the mechanism's size, that is zero except for rounding
COINCIDENT = 1e-9
#: sine of the angle between axes or gradients that counts as zero
PARALLEL = 1e-6
#: a gradient is zero if it is below the first part of that at a pose displaced by the second, in the mechanism's size
ZERO, DISPLACED = 1e-9, 1e-2
#: strain of a rope at the start above which its length is probably not as intended
STRETCHED = 1e-3


def misfits(system: System, t: float, q: Array, v: Array) -> list[str]:
    """Warnings about elements with a line of centres, and about ropes, from the consistent state q, v (n,) at the start
    time t.

    Raises
    ------
    InitialisationError
        If two centres coincide, and the line of centres has no direction; in space, if axes that have to cross are
        parallel, or if the functions of a surface or curve have no independent gradients.
    """
    found = []
    scene = system.scene
    state = np.array([t]), q[None], v[None]
    for name, component in scene.components.items():
        if isinstance(component.kind, ForceKind) and component.kind.computed:
            found += _stretched(system, component, state)
        if not isinstance(component.kind, JointKind | ForceKind):
            continue
        if isinstance(component.kind, JointKind) and component.kind.placing.crossing:
            ends = [coordinate(frame, f"z{key}") for frame in component.ports.values() for key in "xyz"]
            z = np.array([x[0] for x in values(system, ends, *state)])
            if np.linalg.norm(np.cross(z[:3], z[3:])) < PARALLEL:
                raise InitialisationError(
                    f"the axes of {component.kind.name} {name} are parallel",
                    component.span,
                    hint="wheels with parallel axes: GearPair",
                )
        if scene.spatial and isinstance(component.kind, JointKind) and component.kind.of_position:
            _check_gradients(system, component, [f for f, _ in component.kind.functions], t, q)
        if component.kind.misfit is None:
            continue
        a, b = component.ports.values()
        line = [coordinate(b, key) - coordinate(a, key) for key in ("xyz" if scene.spatial else "xy")]
        apart = np.array([x[0] for x in values(system, line, *state)])
        if scene.spatial:  # across the axis
            axis = [coordinate(a, f"z{key}") for key in "xyz"]
            apart = np.cross(apart, [x[0] for x in values(system, axis, *state)])
        distance = float(np.linalg.norm(apart))
        if distance <= COINCIDENT * system.tables.size:
            raise InitialisationError(
                f"the centres of {component.kind.name} {name} coincide, and its line of centres has no direction",
                component.span,
                hint="place the frame origins at the centres of the two wheels",
            )
        if (misfit := component.kind.misfit(component.values, distance)) is not None:
            found.append(f"{component.kind.name} {name}: {misfit}")
    return found


def check_tangents(system: System, t: float, q: Array, v: Array) -> None:
    """Raise an error if a span of a rope between two discs has no tangent at the state q, v (n,) at time t."""
    for component in system.scene.components.values():
        if not component.kind.computed:
            continue
        ((straight,),) = values(system, [component.values["straight"]], np.array([t]), q[None], v[None])
        if not np.isfinite(straight):
            a, b = component.ports.values()
            ra, rb = (abs(r) for r in component.values["ends"])
            of = f"{component.kind.name} {component.name}"
            point, disc, radius = (a, b, rb) if ra == 0.0 else (b, a, ra)
            inside = f"`{point}` is inside the disc of radius {radius:g} m at `{disc}`"
            apart = f"no line between the discs of {ra:g} m at {a} and of {rb:g} m at {b} touches both"
            raise InitialisationError(
                f"{of}: {apart if ra and rb else inside}",
                component.span,
                hint="discs have to be apart" if ra and rb else "a rope begins and ends outside of the discs in `over`",
            )


def turned_around(system: System, t: float, q: Array, v: Array) -> Iterator[str]:
    """A line for each rope over discs: by how much it turns around each of them at the state q, v (n,)."""
    scene = system.scene
    for c in scene.components.values():
        if not isinstance(c.kind, ForceKind) or not c.kind.computed or "stretch" not in c.signals:
            continue
        spans = [c, *(scene.components[f"{c.name}.span{j + 2}"] for j in range(len(c.values["radii"])))]
        frames = [c.ports["frame_a"], *(span.ports["frame_b"] for span in spans)]
        assert c.kind.path is not None  # it has computed signals
        path = c.kind.path(c.values, [partial(coordinate, frame) for frame in frames], scene.spatial)
        angles = values(system, path.wraps, np.array([t]), q[None], v[None])
        parts = []
        for angle, radius, frame in zip(angles, c.values["radii"], frames[1:-1], strict=True):
            side = "left" if radius > 0.0 else "right"
            parts.append(f"{np.degrees(angle[0]):.4g} deg to the {side} around {frame.removesuffix('.c')}")
        if path.wraps:
            yield f"{c.name}: turns {', '.join(parts)}"


def _stretched(system: System, component: Component, state: tuple[Array, Array, Array]) -> Iterator[str]:
    """A warning if a rope is shorter than its path."""
    if "stretch" not in component.signals:
        return  # a further span
    roots = [component.values[key] for key in ("s", "stretch", "tension")]
    s, stretch, tension = (float(x[0]) for x in values(system, roots, *state))
    if stretch > STRETCHED * s:
        yield (
            f"{component.kind.name} {component.name}: its path is {s:.6g} m at the start, longer than its free length "
            f"by {stretch:.3g} m, and its tension is {tension:.3g} N; without `length`, it begins without tension"
        )


def _check_gradients(system: System, component: Component, names: list[str], t: float, q: Array) -> None:
    """Raise an error if the rows of a joint in space, one for each function, are zero or depend on each other."""
    first, scale = system.tables.rows[component.name], system.tables.scale
    own = slice(first, first + len(names))
    displaced = system.moved(q, DISPLACED * np.linspace(0.5, 1.0, system.n) / scale)  # bodies by different distances
    here, near = (dense(system.Phi_q(t, pose)[own]) / scale for pose in (q, displaced))
    size = np.linalg.norm(here, axis=1)
    for k in np.flatnonzero(size <= ZERO * np.linalg.norm(near, axis=1)):
        raise InitialisationError(
            f"{component.kind.name} {component.name}: the gradient of {names[k]} is zero at the start",
            component.span,
            hint=f"give {names[k]} a gradient where it is zero; its square has none",
        )
    if np.linalg.svd(here / size[:, None], compute_uv=False)[-1] < PARALLEL:
        raise InitialisationError(
            f"{component.kind.name} {component.name}: the gradients of {' and '.join(names)} are parallel at the start",
            component.span,
            hint="surfaces that are the same, or touch each other, have no curve in common",
        )
