"""Errors of a run: of positions, velocities, reactions, energy, constraints, and any signal.

A quantity is a group of signals. Its absolute error is the largest of theirs in their own units. In the scaled error,
lengths are relative to the size of the mechanism, velocities to the largest speed, forces to the largest reaction,
energy to the amount exchanged between its kinds, and a signal to its range.

An output between the times of an event in both runs is behind a jump in one of them only. There the scaled error is at
most the difference of these times, times the largest scaled velocity.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.integrators.event_list import EventGroup
from mbdsl.kernels.arrays import Array
from mbdsl.simulation.event_sequences import apart
from mbdsl.simulation.trajectory import Trajectory

NEAR = 1e-9  #: times that differ by this part of the time span are equal


class ComparedSolution(Protocol):
    """A solution to compare with: signals by name at times t, and the events."""

    t: Array

    @property
    def find_events(self) -> Callable[[], Sequence[EventGroup]]: ...

    def __contains__(self, name: str) -> bool: ...

    def __getitem__(self, name: str) -> Array: ...


@dataclass(frozen=True)
class ErrorQuantity:
    """``weights`` scale the errors of ``signals``; a quantity that is an error ``itself`` needs no reference.

    Errors of ``attitudes`` of bodies in space, each with the signals of its quaternion, are angles. ``speed`` [1/s] is
    the largest scaled velocity of the motion.
    """

    key: str
    label: str
    unit: str
    signals: tuple[str, ...]
    weights: tuple[float, ...]
    itself: bool = False
    speed: float = np.inf
    attitudes: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True)
class Error:
    """The largest error over time and that at the end; absolute and scaled."""

    largest: float
    scaled: float
    end: float
    scaled_end: float


def quantities(
    trajectory: Trajectory, reference: ComparedSolution, patterns: Sequence[str] = ()
) -> list[ErrorQuantity]:
    """The quantities q, v, reactions, energy, Phi and dPhi that exist, and the signals that match ``patterns``.

    ``reference`` determines the scales.
    """
    size, (found, speed) = trajectory.system.tables.size, scaled_motion(trajectory, reference)
    forces = {n: 1.0 if trajectory.unit(n) == "N" else 1.0 / size for n in reactions(trajectory) if n in reference}
    force = _largest(reference, forces)
    found.append(
        ErrorQuantity("reactions", "reactions", "N, N.m", tuple(forces), tuple(w / force for w in forces.values()))
    )
    energies = ("energy.kinetic", "energy.potential", "energy.total")
    if all(name in reference for name in energies):
        kinetic, potential, _ = (reference[name] for name in energies)
        exchanged = float(np.ptp(potential) + kinetic.max(initial=0.0)) or 1.0
        found.append(ErrorQuantity("energy", "energy", "J", ("energy.total",), (1.0 / exchanged,)))
    rows = [n for n in trajectory.names if ".Phi[" in n]
    rates = [n for n in trajectory.names if ".dPhi[" in n or ".Gam[" in n]
    found += [
        ErrorQuantity("Phi", "constraints on positions", "m, rad", tuple(rows), (1.0 / size,) * len(rows), True),
        ErrorQuantity(
            "dPhi", "constraints on velocities", "m/s, rad/s", tuple(rates), (1.0 / (size * speed),) * len(rates), True
        ),
    ]
    for name in trajectory.select(patterns) if patterns else ():
        if name in reference and name != "time":
            S = reference[name][np.isfinite(reference[name])]
            extent = float(np.ptp(S)) if len(S) else 0.0
            extent = extent or float(np.abs(S).max(initial=0.0)) or 1.0
            found.append(ErrorQuantity(name, name, trajectory.unit(name), (name,), (1.0 / extent,)))
    return [replace(quantity, speed=speed) for quantity in found if quantity.signals or quantity.attitudes]


def of_motion(trajectory: Trajectory, reference: ComparedSolution) -> list[ErrorQuantity]:
    """The quantities q and v that exist: without reactions, which some methods have to compute at every output."""
    found, speed = scaled_motion(trajectory, reference)
    return [replace(quantity, speed=speed) for quantity in found if quantity.signals or quantity.attitudes]


def scaled_motion(trajectory: Trajectory, reference: ComparedSolution) -> tuple[list[ErrorQuantity], float]:
    """q and v, and the largest scaled velocity."""
    size = trajectory.system.tables.size
    names = [name for name in trajectory.motion_names if name in reference]
    units = {name: trajectory.unit(name) for name in names}
    lengths = {"m": 1.0 / size, "rad": 1.0, "m/s": 1.0 / size, "rad/s": 1.0}
    q = [name for name in names if units[name] in ("m", "rad")]
    v = [name for name in names if units[name] in ("m/s", "rad/s")]
    speed = _largest(reference, {name: lengths[units[name]] for name in v})
    bodies = [name.removesuffix(".p0") for name in names if name.endswith(".p0")] if trajectory.scene.spatial else []
    turns = tuple(tuple(f"{body}.p{k}" for k in range(4)) for body in bodies)
    found = [
        ErrorQuantity("q", "positions", "m, rad", tuple(q), tuple(lengths[units[n]] for n in q), attitudes=turns),
        ErrorQuantity("v", "velocities", "m/s, rad/s", tuple(v), tuple(lengths[units[n]] / speed for n in v)),
    ]
    return found, speed


def reactions(trajectory: Trajectory) -> list[str]:
    """Names of the reaction forces and torques of all joints."""
    found = []
    for c in trajectory.scene.components.values():
        if isinstance(c.kind, JointKind):
            found += [f"{c.name}.{r}" for r in c.kind.reaction if r in c.signals]
    return found


def _largest(reference: ComparedSolution, weights: Mapping[str, float]) -> float:
    """The largest weighted absolute value; 1 if all are zero."""
    sizes = (
        weight * np.abs(reference[name]).max(initial=0.0, where=np.isfinite(reference[name]))
        for name, weight in weights.items()
    )
    return float(max(sizes, default=0.0)) or 1.0


def over_time(
    quantity: ErrorQuantity, found: ComparedSolution, reference: ComparedSolution, scaled: bool = True
) -> Array:
    """The error (N,) at the times of ``reference``.

    It is infinite where only the reference has a value, and nan where the reference has none. A quantity that is an
    error itself is evaluated at all times of ``found``.
    """
    rows = np.arange(len(found.t)) if quantity.itself else matching(found.t, reference.t)
    largest = np.full(len(rows), np.nan)
    late = None if quantity.itself else late_events(found, reference)
    for name, weight in zip(quantity.signals, quantity.weights, strict=True):
        x, y = found[name][rows], np.zeros(len(rows)) if quantity.itself else reference[name]
        known = np.isfinite(y)
        D = np.full(len(rows), np.nan)
        D[known] = np.where(np.isfinite(x[known]), np.abs(x[known] - y[known]), np.inf)
        if late is not None:
            D = np.where(late > 0.0, np.minimum(D, late * quantity.speed / weight), D)
        largest = np.fmax(largest, D * weight if scaled else D)
    for names in quantity.attitudes:
        largest = np.fmax(largest, _angles([found[name][rows] for name in names], [reference[name] for name in names]))
    return largest


def late_events(found: ComparedSolution, reference: ComparedSolution) -> Array | None:
    """The differences (N,) of the times of events of both, at the times of ``reference`` between them [s]; None if
    there are no events."""
    one, other = found.find_events(), reference.find_events()
    return apart(reference.t, one, other, NEAR * np.ptp(reference.t)) if one and other else None


def _angles(one: list[Array], other: list[Array]) -> Array:
    """The angles (N,) between the attitudes of two lists of quaternions p0 ... p3 (N,) [rad]; p and -p are the same."""
    p, r = np.array(one), np.array(other)
    sines = np.minimum(np.linalg.norm(p - r, axis=0), np.linalg.norm(p + r, axis=0)) / 2.0  # of quarters of the angles
    return 4.0 * np.arcsin(np.minimum(sines, 1.0))


def matching(t: Array, times: Array) -> Array:
    """The index in ``t`` of each of ``times``."""
    return np.minimum(np.searchsorted(t, times - NEAR * (np.ptp(t) or 1.0)), len(t) - 1)


def error(quantity: ErrorQuantity, found: ComparedSolution, reference: ComparedSolution) -> Error:
    """The error of ``found``; infinite if nothing can be compared."""
    plain, scaled = (over_time(quantity, found, reference, s) for s in (False, True))
    there = ~np.isnan(plain)
    if not there.any():
        return Error(np.inf, np.inf, np.inf, np.inf)
    return Error(float(plain[there].max()), float(scaled[there].max()), float(plain[-1]), float(scaled[-1]))


def worst(errors: Iterable[Error]) -> float:
    """The largest scaled error of several quantities."""
    return max((e.scaled for e in errors), default=0.0)
