"""The signals of a trajectory with their units and meanings, and the trajectory itself, as tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.mechanism.signal_meanings import meaning
from mbdsl.messages import count, did_you_mean, duration
from mbdsl.results.selection import select

if TYPE_CHECKING:
    from mbdsl.simulation.trajectory import Trajectory

COLUMNS = ("signal", "unit", "meaning")
MOST = 24  #: signals of a trajectory whose ranges are shown


class SignalInfo(NamedTuple):
    """Unit and meaning of a signal.

    Attributes
    ----------
    unit : str
        SI unit; "" for a pure number, or if it is unknown.
    doc : str
        Meaning.
    """

    unit: str
    doc: str


class Signals(Mapping[str, SignalInfo]):
    """The names of all signals of a model, with their units and meanings; a notebook shows a table.

    ``Trajectory.signals`` makes it.

    Parameters
    ----------
    model : str
        Name of the model.
    entries : mapping of str to SignalInfo
        Name -> unit and meaning.

    Examples
    --------
    ``trajectory.signals["crank.w"].unit`` is "rad/s"; ``print(trajectory.signals.select("crank.*"))`` prints a table.
    """

    def __init__(self, model: str, entries: Mapping[str, SignalInfo]) -> None:
        self.model = model
        self._entries = dict(entries)

    def __getitem__(self, name: str) -> SignalInfo:
        if name not in self._entries:
            hint = did_you_mean(name, self._entries)
            raise UsageError(f"there is no signal `{name}` in {self.model}", hint=hint)
        return self._entries[name]

    def get(self, name: str, default: Any = None) -> Any:
        """Return the unit and the meaning of a signal, or a default.

        Parameters
        ----------
        name : str
            Name of a signal.
        default : optional
            Value if there is no such signal.

        Returns
        -------
        SignalInfo
            Or ``default``.
        """
        return self._entries.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def select(self, patterns: str | Iterable[str]) -> Signals:
        """Select signals by their names.

        Parameters
        ----------
        patterns : str or iterable of str
            Names and glob patterns such as "crank.*".

        Returns
        -------
        Signals
            Those that match at least one pattern.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        chosen = select([patterns] if isinstance(patterns, str) else list(patterns), list(self), self.model)
        return Signals(self.model, {name: self[name] for name in chosen})

    def __repr__(self) -> str:
        return f"<Signals of {self.model}: {count(len(self), 'name')}>"

    def _rows(self) -> list[tuple[str, str, str]]:
        return [(name, info.unit, info.doc) for name, info in self._entries.items()]

    def __str__(self) -> str:
        rows = [COLUMNS, *self._rows()]
        first, second = (max(len(row[k]) for row in rows) for k in (0, 1))
        return "\n".join(f"{name:{first}}  {unit:{second}}  {doc}".rstrip() for name, unit, doc in rows)

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import TextTable
        from mbdsl.plotting.html_tables import fragment

        return fragment(f"{self.model}: {count(len(self), 'signal')}", (), [TextTable("", COLUMNS, self._rows())])


def signals(trajectory: Trajectory) -> Signals:
    """The signals of a trajectory, "time" first."""
    scene = trajectory.scene
    named = {name: meaning(scene, name) for name in trajectory.names}
    return Signals(scene.name, {name: SignalInfo(trajectory.unit(name), doc) for name, doc in named.items()})


def of_trajectory(trajectory: Trajectory) -> str:
    """A trajectory as HTML: its run, and the ranges of the coordinates and velocities of its bodies."""
    from mbdsl.plotting.figures import TextTable
    from mbdsl.plotting.html_tables import fragment

    stats, t = trajectory.stats, trajectory.t
    said = f"{count(len(t), 'point')}, {f'{t[0]:g} ... {t[-1]:g} s, ' if len(t) else ''}{trajectory.status}"
    run = [str(stats["method"])] if stats.get("method") else []
    run += [f"step {duration(stats['h'])}"] if stats.get("h") else []
    run += [f"tolerance {stats['tol']:g}"] if stats.get("tol") else []
    run += [count(stats["steps"], "step")] if stats.get("steps") else []
    run += [f"estimated error {stats['error']:.1e}"] if stats.get("error") else []
    kinds = [f"{n} {kind}" for kind, n in stats.get("kinds of events", {}).items()]
    lines = [", ".join(run)] if run else []
    lines += [f"events: {', '.join(kinds)}"] if kinds else []
    lines += [f"ended by terminate: {stats['terminated']}"] if stats.get("terminated") else []
    names = trajectory.default_names
    notes = [f"{len(names) - MOST} more of its signals"] if len(names) > MOST else []
    notes += [f"{count(len(trajectory.names), 'signal')}: trajectory.signals lists them with units and meanings"]
    warned = any(trajectory.message in text for text in stats.get("warnings", ()))
    notes += [trajectory.message] if trajectory.message and not warned else []
    notes += [f"warning: {text}" for text in stats.get("warnings", ())]
    rows = [_range(trajectory, name) for name in names[:MOST]] if len(t) else []
    table = TextTable("", ("signal", "unit", "start", "end", "least", "largest"), rows)
    return fragment(f"{trajectory.scene.name}: {said}", lines, [table], notes)


def _range(trajectory: Trajectory, name: str) -> tuple[str, ...]:
    x = trajectory[name]
    finite = x[np.isfinite(x)]
    ends = (finite.min(), finite.max()) if len(finite) else (np.nan, np.nan)
    unit = trajectory.display.of(trajectory.unit(name), name)
    return name, unit.symbol, *(f"{value / unit.factor:.6g}" for value in (x[0], x[-1], *ends))
