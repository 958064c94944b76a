"""Signals of a trajectory by their names: lists, selections, parts between two times, ranges, and arrays of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.lang.display_units import asked
from mbdsl.lang.given_values import seconds
from mbdsl.simulation import time_slices
from mbdsl.simulation.cut_peaks import CutPeak, cut_peaks
from mbdsl.simulation.extremes import Extremes, extremes
from mbdsl.simulation.shown_signals import shown
from mbdsl.simulation.state_signals import StateSignals

if TYPE_CHECKING:
    from typing_extensions import Self


class NamedSignals(StateSignals):
    """The part of ``mbdsl.Trajectory`` that gives access to its signals."""

    def __len__(self) -> int:
        return len(self.t)

    @property
    def time(self) -> Array:
        """Times (N,) [s]; the same as ``t``."""
        return self.t

    # -- names -------------------------------------------------------------------------------------------------
    @property
    def names(self) -> list[str]:
        """Names of all signals, or of those of a selection, "time" first."""
        return self._names.names if self._chosen is None else ["time", *self._chosen]

    @property
    def default_names(self) -> list[str]:
        """Names of the coordinates and velocities of all bodies, of states and of discrete variables, or of the signals
        of a selection."""
        return self._names.defaults if self._chosen is None else [*self._chosen]

    @property
    def motion_names(self) -> list[str]:
        """As ``default_names``, without discrete variables."""
        discrete = {*self.scene.events.typed}
        return [name for name in self.default_names if name not in discrete]

    @property
    def shown_names(self) -> list[list[str]]:
        """The signals that plots show by default, of which the first group is that of joints, drivers and free bodies.

        Of a selection, there is one group: its signals.
        """
        return [list(self._chosen)] if self._chosen is not None else shown(self.system.graph)

    @property
    def elastic_names(self) -> list[str]:
        """Names of the coordinates of bodies that deform and of their rates; none for a selection."""
        return self._names.elastic if self._chosen is None else []

    # -- parts -------------------------------------------------------------------------------------------------
    def __iter__(self) -> Iterator[str]:
        """The ``names``, without "time"."""
        return iter(self.names[1:])

    @overload
    def __getitem__(self, key: str) -> Any: ...  # an array, or a selection for a pattern
    @overload
    def __getitem__(self, key: slice | Sequence[str]) -> Self: ...
    def __getitem__(self, key: str | slice | Sequence[str]) -> Array | Self:
        """A signal by its name, a selection by a pattern or a list, or the part between two times."""
        if isinstance(key, str):
            if key not in self._known and key not in self and set(key) & set("*?"):
                return self._selected([key])
            return self._signal(key)
        if isinstance(key, slice):
            kept = time_slices.rows(self.t, key)
            whole = (self, kept) if self.turns or self.system.counts_angles else None
            return self._with(
                {
                    **time_slices.part({**vars(self), "turns": self.turns}, kept),
                    "_whole": whole,
                    "_extremes": {},
                    "_since": None,
                }
            )
        if isinstance(key, (list, tuple)) and all(isinstance(name, str) for name in key):
            return self._selected(key)
        hint = "`trajectory.q[k]` is row k of the coordinates; `trajectory.state(time)` is the state at a time"
        raise UsageError(f"found [{key!r}], expected a name, a list of names or a slice of times [0.5:1.0]", hint=hint)

    def _ipython_key_completions_(self) -> list[str]:
        """What a notebook offers after ``trajectory["``."""
        return self.select("*")

    def _with(self, attributes: dict[str, Any]) -> Self:
        """A trajectory of this class with these attributes, which may include computed ones."""
        found = object.__new__(type(self))
        vars(found).update(attributes)
        return found

    def in_units(self, units: str | Iterable[str] | None) -> Self:
        """Return the same trajectory, which is drawn and printed in other units.

        Arrays of signals and result files remain in SI units.

        Parameters
        ----------
        units : str or iterable of str, or None
            Units such as "deg, rpm, kN, mm", each for all values of its quantity; None: no others.

        Returns
        -------
        Trajectory

        Raises
        ------
        UsageError
            If a text is not a unit, or two are units of one quantity.
        """
        return self._with({**vars(self), "_display": asked(units, self.display)}) if units else self

    def _selected(self, patterns: Iterable[str]) -> Self:
        chosen = tuple(name for name in self.select(patterns) if name != "time")
        return self._with({**vars(self), "_chosen": chosen})

    def state(self, time: float | str) -> tuple[Array, Array]:
        """Return the stored state nearest to a time.

        Parameters
        ----------
        time : float or str [s]
            A number, or a text with a unit such as "10 ms".

        Returns
        -------
        q : (n,) [m, rad]
            Coordinates.
        v : (n,) [m/s, rad/s]
            Velocities.
        """
        k = int(np.abs(self.t - seconds(time, "time")).argmin())
        return self.q[k], self.v[k]

    def extremes(
        self, patterns: str | Iterable[str] | None = None, units: str | Iterable[str] | None = None
    ) -> Extremes:
        """Return least and largest values of signals with their times, means and root mean squares.

        They are those of all steps of the run with the motion between their ends, not those of the outputs; where the
        steps are not known, ``of`` of an extreme says so.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``to_dict``.
        units : str or iterable of str, optional
            Units of the printed table, as for ``in_units``; the numbers of an ``Extreme`` are in SI units.

        Returns
        -------
        Extremes
            Name -> ``Extreme``; ``print`` shows a table.

        Raises
        ------
        UsageError
            If a pattern matches no name, or the units are invalid.
        """
        display = asked(units, self.display)
        chosen = self.select(patterns) if patterns is not None else self.default_names
        chosen = [name for name in chosen if name != "time"]
        if missing := [name for name in chosen if name not in self._extremes]:
            self._extremes.update(extremes(self, missing))
        return Extremes((self._extremes[name] for name in chosen), display, self.descriptions)

    def cut_peaks(self, patterns: str | Iterable[str] | None = None) -> list[CutPeak]:
        """Return the peaks of signals that the outputs cut.

        These are extremes over all steps, above the outputs by more than 2 % of the range of the signal.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``to_dict``.

        Returns
        -------
        list of CutPeak
            With the signal, its value and the time; empty if the steps are not known.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        chosen = self.select(patterns) if patterns is not None else self.default_names
        return cut_peaks(self, chosen, self.extremes)

    # -- other forms -------------------------------------------------------------------------------------------
    def to_dict(self, patterns: str | Iterable[str] | None = None) -> dict[str, Array]:
        """Return signals as arrays.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``select``. Default: coordinates and velocities of all bodies, or the signals of a selection.

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

    def to_numpy(self, patterns: str | Iterable[str] | None = None) -> Array:
        """Return signals as the columns of an array.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``to_dict``.

        Returns
        -------
        (N, k) array
            One column per signal in SI units, without the time.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        _, *columns = self.to_dict(patterns).values()
        return np.column_stack(columns) if columns else np.zeros((len(self.t), 0))
