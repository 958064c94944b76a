"""Trajectory: the results of a simulation, as named signals that are computed on first access."""

from __future__ import annotations

import difflib
import fnmatch
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.errors import InitialisationError, UsageError
from mbdsl.expressions.symbolic import Expr, const, coordinate, leaves
from mbdsl.initial.consistent import Moved
from mbdsl.mechanism.scene import ENERGIES, Scene
from mbdsl.system.accelerations import accelerations
from mbdsl.system.batch_accelerations import sampled
from mbdsl.system.signals import values
from mbdsl.system.system import System
from mbdsl.system.tables import gravity

if TYPE_CHECKING:
    import pandas
    import xarray

    from mbdsl.viewing.animation import Animation

Array = NDArray[np.float64]

UNITS = {"x": "m", "y": "m", "phi": "rad", "vx": "m/s", "vy": "m/s", "w": "rad/s"}
ACCELERATIONS = {"ax": "m/s2", "ay": "m/s2", "alpha": "rad/s2"}


class Trajectory:
    """States over time, and every signal of the model by name.

    ``trajectory["crank.phi"]`` is the (N,) array of a signal in SI units, ``trajectory["time"]`` that of the times;
    ``trajectory.names`` lists the signals.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    t : (N,) [s]
        Times.
    q, v : (N, n) [m, rad; m/s, rad/s]
        Generalised coordinates and velocities, in the order of ``system.names()``.
    lam : (N, m + p)
        Multipliers.
    inputs : dict of (N,)
        Values of the model's inputs.
    message : str
        Reason for a ``status`` other than "done".
    stats : dict
        Settings, counts, times of the phases, and error estimates.
    undetermined : list of float [s]
        Times at which accelerations and reactions are not unique (singular poses); their values there are nan.
    moved : tuple of Moved
        Guesses of initial values, and the values after assembly.
    left_out : tuple of int
        Redundant constraint rows, whose multipliers are zero.
    """

    def __init__(
        self,
        system: System,
        t: Array,
        q: Array,
        v: Array,
        lam: Array | None,
        stats: dict,
        moved: tuple[Moved, ...] = (),
        left_out: tuple[int, ...] = (),
        inputs: Mapping[str, Array] | None = None,
    ) -> None:
        self.system, self.t, self.q, self.v, self.stats, self.moved = system, t, q, v, stats, moved
        self.left_out = left_out
        self.inputs = dict(inputs or {})
        self._lam = lam
        self.message = ""
        self.undetermined: list[float] = []
        self._known: dict[str, Array] = {}

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.system.scene

    @property
    def status(self) -> str:
        """One of "done", "interrupted", "failed", or "inaccurate" if the tolerance was not reached."""
        return self.stats["status"]

    def __repr__(self) -> str:
        span = f"{self.t[0]:g} ... {self.t[-1]:g} s" if len(self.t) else "empty"
        return f"<Trajectory of {self.scene.name}: {len(self.t)} points, {span}, {self.status}>"

    def __len__(self) -> int:
        return len(self.t)

    def __getstate__(self) -> dict:
        """The state without signals, which are computed again on access."""
        found = {k: x for k, x in vars(self).items() if not isinstance(getattr(type(self), k, None), cached_property)}
        return {**found, "_known": {}}

    # -- names -------------------------------------------------------------------------------------------------
    @cached_property
    def _expressions(self) -> dict[str, tuple[Expr, str]]:
        """Signal name -> (expression, unit), of signals that are functions of q, v, lam and t."""
        scene = self.scene
        found: dict[str, tuple[Expr, str]] = {}
        for c in scene.components.values():
            for key, expression in scene.signals_of(c).items():
                found[f"{c.name}.{key}"] = (expression, c.kind.unit_of(key) or "")
        for name in scene.frames:
            for key, unit in UNITS.items():
                found.setdefault(f"{name}.{key}", (coordinate(name, key), unit))
        for name, frame in scene.aliases.items():
            for key, unit in UNITS.items():
                found.setdefault(f"{name}.{key}", (coordinate(frame, key), unit))
        for name, expression in scene.variables.items():
            unit = scene.inputs[name].unit if name in scene.inputs else ""
            found.setdefault(name, (expression, unit))
        if not self._flexible:
            for name, energy in zip(ENERGIES, _energies(scene), strict=True):
                found[name] = (energy, "J")
        return found

    @cached_property
    def _flexible(self) -> list[str]:
        """Bodies that deform."""
        return [name for name, body in self.system.tables.models.items() if body.deforms]

    @cached_property
    def _computed(self) -> dict[str, str]:
        """Signal name -> unit, of signals without an expression: accelerations and residuals of constraints."""
        found = {}
        for c in self.scene.components.values():
            if isinstance(c.kind, BodyKind) and c.kind.coordinates:
                for key, unit in zip(ACCELERATIONS, ACCELERATIONS.values(), strict=True):
                    if key != "alpha" or "phi" in c.kind.coordinates:
                        found[f"{c.name}.{key}"] = unit
                if c.name in self._flexible:
                    count = len(c.coordinates)
                    found.update({f"{c.name}.{q}[{k + 1}]": "" for q in ("q", "dq") for k in range(count)})
            elif isinstance(c.kind, JointKind):
                for k in range(c.kind.rows):
                    found[f"{c.name}.Phi[{k + 1}]"] = ""
                    found[f"{c.name}.dPhi[{k + 1}]"] = ""
                for k in range(len(c.velocity_constraints)):
                    found[f"{c.name}.Gam[{k + 1}]"] = ""
        return found | (dict.fromkeys(ENERGIES, "J") if self._flexible else {})

    @property
    def names(self) -> list[str]:
        """Names of all signals, "time" first."""
        return ["time", *self._expressions, *self._computed]

    @property
    def default_names(self) -> list[str]:
        """Names of the coordinates and velocities of all bodies."""
        keys = {"x": "vx", "y": "vy", "phi": "w"}
        bodies = self.scene.bodies()
        found = [f"{b.name}.{key}" for b in bodies for key in b.kind.coordinates]
        return found + [f"{b.name}.{keys[key]}" for b in bodies for key in b.kind.coordinates]

    @property
    def elastic_names(self) -> list[str]:
        """Names of the coordinates of bodies that deform and of their rates."""
        counts = {name: len(self.scene.components[name].coordinates) for name in self._flexible}
        return [f"{name}.{q}[{k + 1}]" for name, count in counts.items() for q in ("q", "dq") for k in range(count)]

    def animate(
        self,
        path: str | PathLike | None = None,
        signals: Iterable[str] | None = None,
        traces: Sequence[str] = (),
        ghost: Trajectory | None = None,
    ) -> Animation:
        """Animate the mechanism, as one HTML page that loads nothing.

        Parameters
        ----------
        path : path, optional
            File that the page is written to, ``.html``.
        signals : iterable of str, optional
            Names and glob patterns of the signals that are plotted with the motion. Default: coordinates, velocities
            and signals of elements that change.
        traces : sequence of str, optional
            Names of frames and bodies whose path is drawn.
        ghost : Trajectory, optional
            Another motion, such as that of another parameter, which is drawn pale behind the first at the same time.

        Returns
        -------
        Animation
            The page; a notebook shows it below the cell, and its ``save`` writes it to a file.

        Raises
        ------
        UsageError
            If the trajectory is empty, a name is unknown, or the file cannot be written.
        """
        from mbdsl.viewing.animation import animate

        found = animate(self, signals, traces, ghost)
        if path is not None:
            found.save(path)
        return found

    def select(self, patterns: Iterable[str]) -> list[str]:
        """Select signals by their names.

        Parameters
        ----------
        patterns : iterable of str
            Names and glob patterns such as "crank.*"; in ``q[1]`` the brackets are an index.

        Returns
        -------
        list of str
            Names that match at least one pattern, without duplicates.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        names, chosen = self.names, {}
        known = set(names)
        for pattern in patterns:
            if pattern in known:
                chosen[pattern] = None
                continue
            # brackets are read as an index first, and as a set of characters if no name matches
            literal = pattern.replace("[", "[[]")
            found = fnmatch.filter(names, literal) or fnmatch.filter(names, pattern)
            if not found:
                raise self._unknown(pattern)
            chosen.update(dict.fromkeys(found))
        return list(chosen)

    def _unknown(self, name: str) -> UsageError:
        near = difflib.get_close_matches(name, self.names, n=3)
        hint = f"did you mean {' or '.join(near)}?" if near else "`*` matches all; `Trajectory.names` lists them"
        return UsageError(f"there is no signal `{name}` in {self.scene.name}", hint=hint)

    def unit(self, name: str) -> str:
        """Return the SI unit of a signal.

        Parameters
        ----------
        name : str
            Name of a signal.

        Returns
        -------
        str
            "" if the signal is a pure number or its unit is unknown.
        """
        if name == "time":
            return "s"
        unit = self._expressions[name][1] if name in self._expressions else self._computed.get(name, "")
        return "" if unit == "1" else unit

    # -- values ------------------------------------------------------------------------------------------------
    def __contains__(self, name: str) -> bool:
        return name == "time" or name in self._expressions or name in self._computed

    def __getitem__(self, name: str) -> Array:
        if name == "time":
            return self.t
        if name not in self._known:
            if name in self._expressions:
                root = self._expressions[name][0]
                lam = self._multipliers([leaf.value for leaf in leaves(root) if leaf.op == "multiplier"])
                (value,) = values(self.system, [root], self.t, self.q, self.v, lam, self.inputs)
                self._known[name] = np.array(value)
                self._known[name].flags.writeable = False
            elif name in self._computed:
                self._compute(name)
            else:
                raise self._unknown(name)
        return self._known[name]

    def is_at_hand(self, name: str) -> bool:
        """Whether a signal is known without solving the equations of motion for accelerations and multipliers.

        Parameters
        ----------
        name : str
            Name of a signal.

        Returns
        -------
        bool
            False also if there is no such signal.
        """
        if name in self._known or name == "time":
            return True
        if name not in self._expressions:
            return name in self._computed and name.rpartition(".")[2] not in ACCELERATIONS
        needed: list = [leaf.value for leaf in leaves(self._expressions[name][0]) if leaf.op == "multiplier"]
        if not needed or "lam" in vars(self):
            return True
        columns = [self.system.tables.multipliers[key] - self.system.n for key in needed]
        return self._lam is not None and not np.isnan(self._lam[:, columns]).any()

    def supply(self, values: Mapping[str, Array]) -> None:
        """Set signals whose values are stored elsewhere, so that they are not computed again.

        Parameters
        ----------
        values : mapping of str to (N,)
            Name -> values; names that are no signals are ignored.
        """
        self._known.update(
            {name: np.asarray(x, float) for name, x in values.items() if name != "time" and name in self}
        )

    def _compute(self, name: str) -> None:
        owner, key = name.rsplit(".", 1)
        if name in ENERGIES:
            self._known.update(zip(ENERGIES, self._energy(), strict=True))
            return
        if key in ACCELERATIONS:
            d, body = self.system.tables.coordinates[owner], self.system.tables.models[owner]
            a = self.a[:, d : d + body.n]
            if owner in self._flexible:
                a = self._of_middle(owner, a)
            self._known.update({f"{owner}.{which}": a[:, k] for k, which in enumerate(ACCELERATIONS) if k < a.shape[1]})
            return
        if owner in self._flexible:
            k = self.system.tables.coordinates[owner] + int(key[key.index("[") + 1 : -1]) - 1
            self._known[name] = (self.v if key.startswith("dq") else self.q)[:, k]
            return
        Phi, dPhi, Gam = self._constraints
        tables, component = self.system.tables, self.scene.components[owner]
        assert isinstance(component.kind, JointKind)
        for k in range(component.kind.rows):
            row = tables.rows[owner] + k
            self._known[f"{owner}.Phi[{k + 1}]"] = Phi[:, row]
            self._known[f"{owner}.dPhi[{k + 1}]"] = dPhi[:, row]
        for k in range(len(component.velocity_constraints)):
            self._known[f"{owner}.Gam[{k + 1}]"] = Gam[:, tables.velocity_rows[owner] - self.system.m + k]

    def _of_middle(self, owner: str, a: Array) -> Array:
        """Accelerations (N, 3) of a flexible body's centre frame, from those of its coordinates (N, n)."""
        d, body = self.system.tables.coordinates[owner], self.system.tables.models[owner]
        found = np.zeros((len(a), 3))
        for i, (q, v) in enumerate(zip(self.q[:, d : d + body.n], self.v[:, d : d + body.n], strict=True)):
            B, rate = body.gradient((0.0, 0.0, 0.0), q, v)
            found[i] = B @ a[i] + rate @ v
        return found

    def _energy(self) -> tuple[Array, Array, Array]:
        """Kinetic, potential energy and their sum (N,) of a model with bodies that deform."""
        tables = self.system.tables
        rigid = _energies(self.scene, self._flexible)
        kinetic, potential, _ = values(self.system, rigid, self.t, self.q, self.v, None, self.inputs)
        g = gravity(self.scene)
        for name in self._flexible:
            d, body = tables.coordinates[name], tables.models[name]
            T, U = body.energies(self.q[:, d : d + body.n], self.v[:, d : d + body.n], g)
            kinetic, potential = kinetic + T, potential + U
        return kinetic, potential, kinetic + potential

    @cached_property
    def _motion(self) -> tuple[Array, Array]:
        """Accelerations (N, n) and multipliers (N, m + p) that satisfy the equations of motion at each (t, q, v)."""
        system, N = self.system, len(self.t)
        known = sampled(system, self.t, self.q, self.v, self.left_out, self._numbers)
        if known is not None:
            a, lam, done = known
        else:
            a, lam, done = np.zeros((N, system.n)), np.zeros((N, system.m + system.p)), np.zeros(N, bool)
        for i in map(int, np.flatnonzero(~done)):
            self._set_inputs(i)
            t = self.t[i]
            try:
                a[i], lam[i] = accelerations(system, t, self.q[i], self.v[i], self.left_out)
            except InitialisationError:  # singular pose: no solution, or more than one
                a[i], lam[i] = np.nan, np.nan
                self.undetermined.append(float(t))
        return a, lam

    @cached_property
    def _numbers(self) -> dict[int, Array]:
        """Inputs and reference angles (N,) that the equations depend on, by their index in the table F."""
        tables = self.system.tables
        found = {tables.inputs[name]: value for name, value in self.inputs.items() if name in tables.inputs}
        return found | {tables.models[body].counter: angle for body, angle in self.turns.items()}

    def _set_inputs(self, i: int) -> None:
        for at, value in self._numbers.items():
            self.system.set_number(at, float(value[i]))

    @cached_property
    def turns(self) -> dict[str, Array]:
        """Reference angles (N,) for counting turns, by body, for bodies whose coordinates do not contain the turns."""
        found = {}
        for name in self._flexible:
            d, body = self.system.tables.coordinates[name], self.system.tables.models[name]
            if body.counter >= 0:
                q, v = self.q[:, d : d + body.n], self.v[:, d : d + body.n]
                found[name] = body.turned(body.turn, q, v, self.t)
        return found

    @property
    def a(self) -> Array:
        """Generalised accelerations (N, n) [m/s2, rad/s2], from the equations of motion at each (t, q, v)."""
        return self._motion[0]

    @cached_property
    def lam(self) -> Array:
        """Multipliers (N, m + p), in the order of ``system.constraint_names()``.

        The constraint force is -Phi_q^T lam - Gam_v^T nu, where lam and nu are the first m and the last p columns.
        Multipliers that the method does not compute (those of welds), or computes at a lower order than q and v, are
        found from the equations of motion at (t, q, v) on first access.
        """
        if self._lam is None:
            return self._motion[1]
        missing = np.isnan(self._lam).all(axis=0)
        return np.where(missing, self._motion[1], self._lam) if missing.any() else self._lam

    def _multipliers(self, needed: list) -> Array | None:
        """``lam``, or the method's own multipliers if these contain all that are ``needed``; None if none is needed."""
        if not needed or self._lam is None or not len(self.t):
            return self.lam if needed else None
        own = self._lam[0, [self.system.tables.multipliers[key] - self.system.n for key in needed]]
        return self.lam if np.isnan(own).any() else self._lam

    @cached_property
    def _constraints(self) -> tuple[Array, Array, Array]:
        """Phi (N, m), Phi_q v + Phi_t (N, m), Gam (N, p)."""
        system, N = self.system, len(self.t)
        Phi, dPhi, Gam = np.zeros((N, system.m)), np.zeros((N, system.m)), np.zeros((N, system.p))
        for i in range(N):
            self._set_inputs(i)
            _, Phi[i], dPhi[i] = system.evaluate(self.t[i], self.q[i], self.v[i])
            if system.p:
                Gam[i] = system.Gam(self.t[i], self.q[i], self.v[i])
        return Phi, dPhi, Gam

    def state(self, time: float) -> tuple[Array, Array]:
        """Return the stored state nearest to a time.

        Parameters
        ----------
        time : float [s]

        Returns
        -------
        q : (n,) [m, rad]
            Coordinates.
        v : (n,) [m/s, rad/s]
            Velocities.
        """
        k = int(np.abs(self.t - time).argmin())
        return self.q[k], self.v[k]

    def to_dict(self, patterns: Iterable[str] | None = None) -> dict[str, Array]:
        """Return signals as arrays.

        Parameters
        ----------
        patterns : iterable of str, optional
            As for ``select``. Default: coordinates and velocities of all bodies.

        Returns
        -------
        dict of (N,)
            Name -> values in SI units, "time" first.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        chosen = self.select(patterns) if patterns is not None else self.default_names
        return {"time": self.t, **{name: self[name] for name in chosen if name != "time"}}

    def to_pandas(self, patterns: Iterable[str] | None = None) -> pandas.DataFrame:
        """Return signals as a data frame; requires pandas.

        Parameters
        ----------
        patterns : iterable of str, optional
            As for ``to_dict``.

        Returns
        -------
        pandas.DataFrame
            One column a signal, indexed by time.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        import pandas

        data = self.to_dict(patterns)
        return pandas.DataFrame({k: v for k, v in data.items() if k != "time"}, index=pandas.Index(self.t, name="time"))

    def to_xarray(self, patterns: Iterable[str] | None = None) -> xarray.Dataset:
        """Return signals as a data set; requires xarray.

        Parameters
        ----------
        patterns : iterable of str, optional
            As for ``to_dict``.

        Returns
        -------
        xarray.Dataset
            One variable a signal over the dimension "time", with the attribute "units".

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        import xarray

        data = self.to_dict(patterns)
        variables = {k: ("time", v, {"units": self.unit(k)}) for k, v in data.items() if k != "time"}
        return xarray.Dataset(variables, coords={"time": ("time", self.t, {"units": "s"})})


def _energies(scene: Scene, excluded: Collection[str] = ()) -> tuple[Expr, Expr, Expr]:
    """Kinetic energy, potential energy and their sum, without the ``excluded`` bodies.

    The potential energy is that of gravity (zero at the origin of the ground) and of linear springs; forces given by
    expressions have none.
    """
    kinetic, potential = const(0.0), const(0.0)
    g = gravity(scene)
    for c in scene.components.values():
        if isinstance(c.kind, BodyKind) and c.kind.coordinates:
            if c.name in excluded:
                continue
            masses = c.kind.table(dict(c.values))
            for key, rate, mass in zip(("x", "y", "phi"), ("vx", "vy", "w"), masses, strict=False):
                speed = coordinate(f"{c.name}.c", rate)
                kinetic = kinetic + 0.5 * mass * (speed * speed)
                if key != "phi":
                    potential = potential - mass * float(g["xy".index(key)]) * coordinate(f"{c.name}.c", key)
        elif isinstance(c.kind, ForceKind) and c.energy is not None:
            potential = potential + c.energy
    return kinetic, potential, kinetic + potential
