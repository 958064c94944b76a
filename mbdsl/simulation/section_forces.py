"""Forces in the sections of rods and beams: the equilibrium of the part beyond a section.

With the loads F, T at r_f of joints and forces on the part between the section at r_0 and frame b, the mass m per
length and the rotary inertia J per length, the part exerts on the rest

    R = sum F + int m (g - a) dx,   M = sum (T + (r_f - r_0) x F) + int m (r - r_0) x (g - a) dx - int J phi'' dx

For a beam this is more accurate than E I times the curvature of the shape functions, whose second derivatives converge
more slowly than the motion; in statics it is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import PairKind
from mbdsl.mechanism import sections
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.scene import Component, SpatialFrame
from mbdsl.simulation.frame_accelerations import States, acceleration

Array = NDArray[np.float64]

POINTS = 4  #: of Gauss, in each interval: exact for a rigid rod and, of a beam, for products of two cubic functions
MOST_INTERVALS = 32  #: of a beam with more elements, an interval is several elements
SAME = 1e-9  #: distance of sections that are one, over the length


def of_frame(states: States, name: str) -> dict[str, Array]:
    """The signals (N,) of the section at a frame of a rod or beam."""
    scene = states.scene
    frame = scene.frames[scene.aliases.get(name, name)]
    found = section(states, scene.components[frame.body], frame.x)
    return {f"{name}.{key}": values for key, values in found.items()}


def section(states: States, body: Component, x: float) -> dict[str, Array]:
    """The signals (N,) [N, N.m] of the section at a distance x [m] from the middle of a rod or beam, by their keys."""
    scene, N = states.scene, len(states.t)
    n = 3 if scene.spatial else 2
    length, mass = float(body.values["length"]), float(body.kind.table(body.values)[0])  # type: ignore[attr-defined]
    origin = _place(states, body, x)
    force, moment = np.zeros((N, n)), np.zeros((N, 3))
    for c, port in _elements_on(states, body):
        at = scene.frames[c.ports[port]]
        if not _beyond(at.x, x, length):
            continue
        parts = scene.on_port(c, port)
        values = np.column_stack(states.evaluate([*parts[0], *parts[1]]))
        load, torque = values[:, :n], values[:, n:]
        lever = np.column_stack([states.evaluate([scene.signal(f"{at.name}.{i}")])[0] for i in "xyz"[:n]]) - origin
        force += load
        moment += _moment(lever, load) + (torque if n == 3 else _about_z(torque[:, 0]))
    field, rotary = np.array(gravity(scene), float), float(body.values.get("rotary") or 0.0)
    for place, weight in zip(*_points(body, x, length), strict=True):
        a = acceleration(states, body.name, _pose(place, n))
        load = mass * weight / length * (field - a[:, :n])
        force += load
        moment += _moment(_place(states, body, place) - origin, load)
        if rotary:
            moment -= _about_z(rotary * weight * a[:, 2])
    return _components(states, body, x, force, moment)


def loaded(states: States, body: Component) -> list[float]:
    """Distances [m] from the middle at which joints and forces act on a rod or beam."""
    scene = states.scene
    return sorted({scene.frames[c.ports[port]].x for c, port in _elements_on(states, body)})


def _elements_on(states: States, body: Component) -> list[tuple[Component, str]]:
    scene = states.scene
    pairs = [c for c in scene.components.values() if isinstance(c.kind, PairKind)]
    return [(c, port) for c in pairs for port, name in c.ports.items() if scene.frames[name].body == body.name]


def _beyond(at: float, x: float, length: float) -> bool:
    """Whether a load belongs to the part beyond a section; at the section itself, to the nearer end."""
    return x >= -SAME * length if abs(at - x) <= SAME * length else at > x


def _points(body: Component, x: float, length: float) -> tuple[Array, Array]:
    """Points of Gauss from the section to frame b, and their weights [m]."""
    elements = int(body.values["elements"]) if body.deforms and body.values["modes"] != 0 else 1
    ends = np.linspace(-length / 2, length / 2, min(elements, MOST_INTERVALS) + 1)
    ends = np.concatenate([[x], ends[ends > x + SAME * length]])
    own, weights = np.polynomial.legendre.leggauss(POINTS)
    half = 0.5 * np.diff(ends)
    places = (ends[:-1] + half)[:, None] + half[:, None] * own
    return places.ravel(), (half[:, None] * weights).ravel()


def _pose(x: float, n: int) -> tuple[float, ...]:
    return (x, 0.0, 0.0) if n == 2 else (x, 0.0, 0.0, *SpatialFrame.axes)


def coordinate(states: States, body: Component, x: float, key: str) -> Array:
    """A coordinate (N,) of the section at x, of a rod or beam that has coordinates."""
    tables = states.system.tables
    model, d = tables.models[body.name], tables.coordinates[body.name]
    q, v = states.q[:, d : d + model.n], states.v[:, d : d + model.n]
    return model.frame(_pose(x, 3 if states.scene.spatial else 2), key, q, v, states.t)


def _place(states: States, body: Component, x: float) -> Array:
    keys = "xyz" if states.scene.spatial else "xy"
    return np.column_stack([coordinate(states, body, x, key) for key in keys])


def _moment(lever: Array, force: Array) -> Array:
    """lever x force (N, 3)."""
    if lever.shape[1] == 3:
        return np.cross(lever, force)
    return _about_z(lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0])


def _about_z(moment: Array) -> Array:
    return np.column_stack([np.zeros((len(moment), 2)), moment])


def _components(states: States, body: Component, x: float, force: Array, moment: Array) -> dict[str, Array]:
    """Force and moment in the axes of the section, as signals."""
    if states.scene.spatial:
        axes = [np.column_stack([coordinate(states, body, x, i + j) for j in "xyz"]) for i in "xyz"]
        found = {key: (force * a).sum(axis=1) for key, a in zip(("N", "Qy", "Qz"), axes, strict=True)}
        found |= {key: (moment * a).sum(axis=1) for key, a in zip(("Mx", "My", "Mz"), axes, strict=True)}
        return found | {"Q": found["Qy"], "M": found["Mz"]}
    phi = coordinate(states, body, x, "phi")
    c, s = np.cos(phi), np.sin(phi)
    (fx, fy), m = force.T, moment[:, 2]
    return dict(zip(sections.UNITS, (c * fx + s * fy, c * fy - s * fx, m), strict=True))
