"""The options of ``mbdsl.sweep`` and ``mbdsl.solve``: those of their runs, and how the runs are made."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import TYPE_CHECKING, Any

from mbdsl.analysis.operating_points import At, checked
from mbdsl.errors import UsageError
from mbdsl.lang.display_units import asked as asked_units
from mbdsl.lang.experiment import check_effects
from mbdsl.lang.given_values import mapping
from mbdsl.lang.overrides import merged
from mbdsl.simulation.run_options import converted
from mbdsl.studies.store import Store
from mbdsl.studies.sweep_runs import PointRunner, SweepSetting

if TYPE_CHECKING:
    from typing import TypedDict

    from mbdsl.studies.runner import StudyProgress

    class GivenSweepOptions(TypedDict, total=False):
        """The options as a program gives them: numbers may be texts with units."""

        after: float | str | None
        method: str | None
        step: float | str | None
        tol: float | str | None
        start: float | str | None
        stop: float | str | None
        interval: float | str | None
        options: Mapping[str, float | None] | None
        parameters: Mapping[str, str | float] | None
        without: Sequence[str]
        contacts: str | None
        at: At
        limit: float | str | None
        workers: int | None
        store: str | PathLike | None
        fresh: bool
        units: str | Iterable[str] | None
        tell: Callable[[StudyProgress], None] | None
        announce: Callable[[str], None] | None


@dataclass(frozen=True)
class SweepOptions:
    """The options, checked, with numbers in SI units; the docstring of ``mbdsl.sweep`` describes them."""

    after: float | None = field(default=None, metadata={"unit": "s"})
    method: str | None = None
    step: float | None = None
    tol: float | None = None
    start: float | None = None
    stop: float | None = None
    interval: float | None = None
    options: Mapping[str, float | None] | None = None
    parameters: Mapping[str, str | float] | None = None
    without: Sequence[str] = ()
    contacts: str | None = None
    at: At = "static"
    limit: float | None = field(default=None, metadata={"unit": "s"})
    workers: int | None = None
    store: str | PathLike | None = None
    fresh: bool = False
    units: str | Iterable[str] | None = None
    tell: Callable[[StudyProgress], None] | None = None
    announce: Callable[[str], None] | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> SweepOptions:
        """The options that a program gives.

        Raises
        ------
        UsageError
            If a value is invalid.
        """
        found = cls(**converted(cls, given))
        asked_units(found.units)
        if found.limit is not None and not found.limit > 0.0:
            raise UsageError(f"a time limit of {found.limit:g} s leaves no time for a run")
        return replace(
            found,
            parameters=merged({}, found.parameters or {}),
            options=mapping(found.options, "options", 'give them by name: `{"alpha": -0.1}`'),
            without=check_effects(found.without, found.contacts),
            at=checked(found.at),
        )

    @property
    def times(self) -> dict[str, float | None]:
        """Start, stop and output interval [s]; None: the model's."""
        return {"start": self.start, "stop": self.stop, "interval": self.interval}

    def runner(self, of: SweepSetting) -> PointRunner:
        """A runner of points, with the store, the time limit and the displays of progress."""
        limit = math.inf if self.limit is None else self.limit
        store = Store(None if self.store is None else os.fspath(self.store), self.fresh)
        return PointRunner(of, store, limit, workers=self.workers, tell=self.tell, announce=self.announce)
