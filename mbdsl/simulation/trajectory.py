"""Trajectory: the results of a simulation, as named signals that are computed on first access."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.symbolic import leaves
from mbdsl.initial.consistent import Moved
from mbdsl.mechanism.scene import ENERGIES, Scene
from mbdsl.mechanism.signal_names import ACCELERATIONS, SignalNames
from mbdsl.simulation import derived_signals
from mbdsl.system.signals import values
from mbdsl.system.system import System

if TYPE_CHECKING:
    import pandas
    import xarray

    from mbdsl.plotting.signal_plots import Plot
    from mbdsl.simulation.signal_table import Signals
    from mbdsl.viewing.animation import Animation

Array = NDArray[np.float64]


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

    def _repr_html_(self) -> str:
        from mbdsl.simulation.signal_table import of_trajectory

        return of_trajectory(self)

    def __len__(self) -> int:
        return len(self.t)

    def __getstate__(self) -> dict:
        """The state without signals, which are computed again on access."""
        found = {k: x for k, x in vars(self).items() if not isinstance(getattr(type(self), k, None), cached_property)}
        return {**found, "_known": {}}

    # -- names -------------------------------------------------------------------------------------------------
    @cached_property
    def _names(self) -> SignalNames:
        return SignalNames(self.scene)

    @property
    def names(self) -> list[str]:
        """Names of all signals, "time" first."""
        return self._names.names

    @property
    def signals(self) -> Signals:
        """Names of all signals with units and meanings; ``print`` and notebooks show a table."""
        from mbdsl.simulation.signal_table import signals

        return signals(self)

    @property
    def default_names(self) -> list[str]:
        """Names of the coordinates and velocities of all bodies."""
        return self._names.defaults

    @property
    def elastic_names(self) -> list[str]:
        """Names of the coordinates of bodies that deform and of their rates."""
        return self._names.elastic

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
        return self._names.select(patterns)

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
        return self._names.unit(name)

    # -- values ------------------------------------------------------------------------------------------------
    def __contains__(self, name: str) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> Array:
        if name == "time":
            return self.t
        if name not in self._known:
            if name in self._names.expressions:
                root = self._names.expressions[name][0]
                lam = self._multipliers([leaf.value for leaf in leaves(root) if leaf.op == "multiplier"])
                (value,) = values(self.system, [root], self.t, self.q, self.v, lam, self.inputs)
                self._known[name] = np.array(value)
                self._known[name].flags.writeable = False
            elif name in self._names.computed:
                self._compute(name)
            else:
                raise self._names.unknown(name)
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
        if name not in self._names.expressions:
            return name in self._names.computed and name.rpartition(".")[2] not in ACCELERATIONS
        needed: list = [leaf.value for leaf in leaves(self._names.expressions[name][0]) if leaf.op == "multiplier"]
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
            found = derived_signals.flexible_energies(self.system, self.t, self.q, self.v, self.inputs)
            self._known.update(zip(ENERGIES, found, strict=True))
            return
        if key in ACCELERATIONS:
            d, body = self.system.tables.coordinates[owner], self.system.tables.models[owner]
            if body.deforms:
                a = derived_signals.centre_accelerations(self.system, owner, self.q, self.v, self.a)
            else:
                a = self.a[:, d : d + body.n]
            self._known.update({f"{owner}.{which}": a[:, k] for k, which in enumerate(ACCELERATIONS) if k < a.shape[1]})
            return
        if owner in self._names.flexible:
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

    @cached_property
    def _motion(self) -> tuple[Array, Array]:
        """Accelerations (N, n) and multipliers (N, m + p) that satisfy the equations of motion at each (t, q, v)."""
        a, lam, undetermined = derived_signals.motion(self.system, self.t, self.q, self.v, self.left_out, self._numbers)
        self.undetermined += undetermined
        return a, lam

    @cached_property
    def _numbers(self) -> dict[int, Array]:
        """Inputs and reference angles (N,) that the equations depend on, by their index in the table F."""
        tables = self.system.tables
        found = {tables.inputs[name]: value for name, value in self.inputs.items() if name in tables.inputs}
        return found | {tables.models[body].counter: angle for body, angle in self.turns.items()}

    @cached_property
    def turns(self) -> dict[str, Array]:
        """Reference angles (N,) for counting turns, by body, for bodies whose coordinates do not contain the turns."""
        return derived_signals.turns(self.system, self.t, self.q, self.v)

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
        return derived_signals.residuals(self.system, self.t, self.q, self.v, self._numbers)

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

    def plot(
        self,
        patterns: str | Iterable[str] | None = None,
        others: Iterable[Trajectory | str | PathLike] = (),
        *,
        against: str | None = None,
        difference: bool = False,
        spectrum: bool = False,
        out: str | PathLike | None = None,
    ) -> Plot:
        """Plot signals.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``select``. Default: the coordinates of the first three bodies, without constant ones.
        others : iterable of Trajectory or path, optional
            Further results and result files in the same plot.
        against : str, optional
            Name of the signal on the horizontal axis. Default: the time.
        difference : bool, optional
            Plot the ``others`` minus this result, interpolated to its times.
        spectrum : bool, optional
            Plot amplitude spectra: a sine of amplitude A shows A.
        out : path, optional
            A file to write: .svg, .html, or .png and .pdf, which require matplotlib.

        Returns
        -------
        Plot
            The plot: ``print`` shows it in characters, a notebook below the cell, and ``save`` writes it.

        Raises
        ------
        UsageError
            If a pattern matches no signal, results do not fit together, a signal has no spectrum, or the file cannot
            be written.
        """
        from mbdsl.plotting.signal_plots import plot
        from mbdsl.results.stored import of_trajectory, open_result

        results = [of_trajectory(self, self.scene.name)]
        for other in others:
            if isinstance(other, Trajectory):
                results.append(of_trajectory(other, other.scene.name))
            else:
                results.append(open_result(other))
        chosen = [patterns] if isinstance(patterns, str) else None if patterns is None else list(patterns)
        found = plot(results, chosen, against=against, difference=difference, spectrum=spectrum)
        if out is not None:
            found.save(out)
        return found

    def animate(
        self,
        path: str | PathLike | None = None,
        signals: str | Iterable[str] | None = None,
        traces: str | Sequence[str] = (),
        ghost: Trajectory | None = None,
        arrows: str | Sequence[str] = ("forces",),
    ) -> Animation:
        """Animate the mechanism, as one HTML page that loads nothing.

        Parameters
        ----------
        path : path, optional
            File that the page is written to, ``.html``.
        signals : str or iterable of str, optional
            Names and glob patterns of the signals that are plotted with the motion. Default: coordinates, velocities
            and signals of elements that change.
        traces : str or sequence of str, optional
            Names of frames and bodies whose path is drawn.
        ghost : Trajectory, optional
            Another motion, such as that of another parameter, which is drawn pale behind the first at the same time.
        arrows : str or sequence of str, optional
            Arrows in a film, or in a page when it opens: any of "forces" and "reactions".

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

        found = animate(self, signals, traces, ghost, arrows)
        if path is not None:
            found.save(path)
        return found
