"""Static equilibria of a mechanism.

    v = 0,   Q(t, q, 0, lam) - Phi_q^T lam - Gam_v^T nu = 0,   Phi(q, t) = 0

An equilibrium is found by following the overdamped motion from the assembled positions
(:mod:`mbdsl.statics.pseudo_transient`). If the motion ends at a saddle point, it is continued from a position displaced
along the most unstable direction.

Positions only change along directions that the nonholonomic constraints allow, and the forces of these constraints are
among the reactions. For gears and rolling this is equivalent to a constraint of positions; for a knife edge the
equilibrium depends on the initial position.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import is_velocity_level
from mbdsl.initial.consistent import initial_position
from mbdsl.lang.display_units import in_units
from mbdsl.lang.given_values import seconds
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism import graph as mechanism_graph
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import UnitsOfSignals, count, few
from mbdsl.numerics.saddle_point import Array
from mbdsl.simulation.steady_start import PointsAtRest
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.statics.equilibrium_search import prepared, searched
from mbdsl.system import System

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder
    from mbdsl.viewing.equilibrium_picture import EquilibriumPicture


@dataclass
class Equilibrium:
    """A static equilibrium.

    ``equilibrium["pin.fy"]`` is the value of a signal in SI units.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    t : float [s]
        Time at which drivers and forces are evaluated.
    q : (n,) [m, rad]
        Generalised coordinates, in the order of ``system.names()``.
    lam : (m + p,)
        Multipliers; the constraint force is -Phi_q^T lam - Gam_v^T nu. Zero in redundant rows.
    iterations : int
        Number of steps of the overdamped motion and of Newton iterations.
    stability : str
        "stable", "indifferent" (zero stiffness in some direction), "unstable", or "held" (no degree of freedom).
    stiffness : float or None [J]
        The smallest eigenvalue of the stiffness (Phi_q^T lam - Q)_q on the directions that the constraints allow, in
        coordinates scaled by the size of the mechanism; only its sign is significant. None without degrees of freedom.
    redundant : list of str
        Constraints that follow from the others.
    notes : list of str
        Remarks, such as which bodies can move without resistance.
    left_out : tuple of int
        Indices of the redundant constraint rows.
    start : (n,) or None [m, rad]
        Coordinates from which the search began.
    v : (n,) or None
        Velocities: the values of states, and zero for bodies; None: all are zero.
    """

    system: System
    t: float
    q: Array
    lam: Array
    iterations: int
    stability: str
    stiffness: float | None
    redundant: list[str]
    notes: list[str]
    left_out: tuple[int, ...] = field(default=(), repr=False)
    start: Array | None = field(default=None, repr=False)
    v: Array | None = field(default=None, repr=False)

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.system.scene

    @property
    def stable(self) -> bool:
        """Whether the stiffness is positive in all directions, or there is no degree of freedom."""
        return self.stability in ("stable", "held")

    @cached_property
    def trajectory(self) -> Trajectory:
        """The equilibrium as a trajectory of one point, with all signals by name."""
        stats: dict = {"method": "static", "h": None, "tol": None, "status": "done", "iterations": self.iterations}
        stats |= {"stability": self.stability, "redundant": self.redundant}
        q, lam = self.q[None], self.lam[None]
        v = np.zeros_like(q) if self.v is None else self.v[None]
        return PointsAtRest(self.system, np.array([self.t]), q, v, lam, stats, (), self.left_out)

    def show(self, path: str | PathLike | None = None) -> EquilibriumPicture:
        """Draw the equilibrium over the initial positions, with forces and reactions as arrows.

        Parameters
        ----------
        path : path, optional
            File that is written: a page for ``.html``, a picture for ``.png``, ``.svg`` or ``.pdf``.

        Returns
        -------
        EquilibriumPicture
            The page; a notebook shows it below the cell, and its ``save`` writes it to a file.

        Raises
        ------
        UsageError
            If the file cannot be written.
        """
        from mbdsl.viewing.equilibrium_picture import EquilibriumPicture

        start = None
        if self.start is not None:
            q, lam = self.start[None], np.zeros((1, len(self.lam)))
            start = PointsAtRest(self.system, np.array([self.t]), q, np.zeros_like(q), lam, {"status": "done"})
        picture = EquilibriumPicture(self.trajectory, start, self.stability)
        if path is not None:
            picture.save(path)
        return picture

    def __getitem__(self, name: str) -> float:
        return float(self.trajectory[name][0])

    def select(self, patterns: Sequence[str]) -> list[str]:
        """Select signals by their names; see ``mbdsl.Trajectory.select``.

        Parameters
        ----------
        patterns : sequence of str
            Names and glob patterns.

        Returns
        -------
        list of str

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        return self.trajectory.select(patterns)

    @property
    def poses(self) -> list[str]:
        """Names of the position signals of all bodies, and of both ends of flexible bodies."""
        names = []
        for c in self.scene.bodies():
            if self.scene.spatial:
                turns = len(c.kind.coordinates) > 3
                names += [f"{c.name}.{key}" for key in ("x", "y", "z", *(("p0", "p1", "p2", "p3") if turns else ()))]
                continue
            names += [f"{c.name}.{key}" for key in c.kind.coordinates]
            if len(c.coordinates) > len(c.kind.coordinates):
                names += [f"{c.name}.{end}.{key}" for end in "ab" for key in c.kind.coordinates]
        return names

    @property
    def reactions(self) -> list[str]:
        """Names of the reaction signals of all joints."""
        names = []
        for c in self.scene.components.values():
            if isinstance(c.kind, JointKind):
                names += [f"{c.name}.{key}" for key in c.kind.reaction]
        return [name for name in names if name in self.trajectory]

    def _head(self) -> str:
        known = {"held": "nothing can move"}.get(self.stability, self.stability)
        steps = count(self.iterations, "iteration")
        return f"{self.scene.name}: equilibrium at t = {self.t:g} s, {known} ({steps})"

    def _values(self) -> list[tuple[str, float, str]]:
        """Name, value and unit of positions and reactions."""
        names = (*self.poses, *(c.name for c in self.scene.states()), *self.reactions)
        return [(name, self[name], self.trajectory.unit(name)) for name in names]

    def __str__(self) -> str:
        return "\n".join(
            [self._head(), *listed(self._values(), self.scene.display), *(f"note: {text}" for text in self.notes)]
        )

    def __repr__(self) -> str:
        return f"<Equilibrium of {self._head()}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import TextTable
        from mbdsl.plotting.html_tables import fragment

        rows = [(name, f"{value:.6g}", unit) for name, value, unit in rounded(self._values(), self.scene.display)]
        found = TextTable("", ("signal", "value", "unit"), rows)
        return fragment(self._head(), (), [found], [f"note: {text}" for text in self.notes])


def listed(rows: Sequence[tuple[str, float, str]], display: UnitsOfSignals, most: int = 120) -> list[str]:
    """Lines ``name value unit`` in the units in which they are displayed, at most ``most``."""
    width = max((len(name) for name, *_ in rows), default=0)
    rows = rounded(rows, display)
    lines = [f"  {name:{width}} {value:13.6g} {unit}".rstrip() for name, value, unit in rows[:most]]
    return lines + ([f"  ... ({len(rows)} in all)"] if len(rows) > most else [])


def rounded(rows: Sequence[tuple[str, float, str]], display: UnitsOfSignals) -> list[tuple[str, float, str]]:
    """The rows in the units in which they are displayed.

    Values at the rounding level of the largest in the same unit are 0; files have all digits.
    """
    size = dict[str, float]()
    for _, value, unit in rows:
        size[unit] = max(size.get(unit, 0.0), abs(value))
    found = []
    for name, value, unit in rows:
        shown = display.of(unit, name)
        found.append((name, value / shown.factor if abs(value) > 1e-13 * size[unit] else 0.0, shown.symbol))
    return found


def prepare(
    model: Scene | Builder | str | PathLike,
    parameters: Mapping[str, str | float] | None,
    without: Sequence[str],
    announce: Callable[[str], None] | None,
    units: str | Iterable[str] | None = None,
) -> tuple[System, mechanism_graph.MechanismGraph]:
    """The System of a model as written, without contacts that are left out, with its code loaded or compiled, and its
    graph."""
    scene = as_scene(model, parameters, without)
    if scene.contacts and all(c.absent for c in scene.contacts):
        scene = scene.without_contacts()
    return prepared(in_units(scene, units), announce)


@blame_model
def static(
    model: Scene | Builder | str | PathLike,
    *,
    start: float | str | None = None,
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    units: str | Iterable[str] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Equilibrium:
    """Find the static equilibrium that overdamped motion reaches from the initial positions of a model.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    start : float or str, optional [s]
        Time at which drivers and forces are evaluated. Default: the model's start time.
    units : str or iterable of str, optional
        Units such as "deg, kN, mm" in which the Equilibrium is printed; its arrays are in SI units.
    without, parameters, announce : optional
        As for ``mbdsl.simulate``.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    InitialisationError
        If the mechanism cannot be assembled.
    EquilibriumError
        If no equilibrium is reached; the message names the bodies that keep moving.
    """
    given = seconds(start, "start")
    system, mechanism = prepare(model, parameters, without, announce, units)
    t = float(system.scene.experiment.start) if given is None else given
    if not np.isfinite(t):
        raise UsageError(f"start = {t} is not a finite number")
    return settle(system, t, initial_position(system, mechanism, t))


def settle(system: System, t: float, q: Array) -> Equilibrium:
    """The equilibrium of ``system`` at time ``t`` that overdamped motion reaches from ``q``."""
    notes, found = _at_rest(system, t, q), searched(system, t, q)
    return Equilibrium(
        system,
        t,
        found.q,
        found.lam,
        found.iterations,
        found.stability,
        found.stiffness,
        found.redundant,
        notes + found.notes,
        found.left_out,
        q,
        found.v,
    )


def _at_rest(system: System, t: float, q: Array) -> list[str]:
    """Notes on initial velocities that are ignored, and on nonholonomic constraints."""
    notes = []
    states = {c.name for c in system.scene.states()}
    given = [x for x in system.scene.initial if x.name not in states]
    moving = [x.name for x in given if is_velocity_level(x.target) and x.value != 0.0]
    names = system.constraint_names()
    rates = np.concatenate([system.Phi_t(t, q), system.Gam(t, q, np.zeros(system.n))])
    moving += list(dict.fromkeys(names[k].rsplit(".", 1)[0] for k in np.flatnonzero(rates)))
    if moving:
        notes.append(f"velocities set to zero at t = {t:g} s: {few(moving)}")
    if system.p:
        held = list(dict.fromkeys(name.rsplit(".", 1)[0] for name in names[system.m :]))
        one = len(held) == 1
        whose = f"constraint{'' if one else 's'} {few(f'`{name}`' for name in held)}"
        what = "the reaction of the" if one else "the reactions of the"
        notes.append(f"at rest, {what} velocity {whose} {'carries' if one else 'carry'} part of the load")
    return notes
