"""The runs of a sweep: one run a point, or its equilibrium or modes, of which only the measures are kept, in the store
of the studies.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from mbdsl.analysis.eigenmodes import Modes, eigen
from mbdsl.analysis.equilibria import static
from mbdsl.analysis.operating_points import At
from mbdsl.errors import UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.load import load
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.provenance import code
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case, Setting
from mbdsl.studies.compute import attempted, compute
from mbdsl.studies.followed_modes import with_modes
from mbdsl.studies.measures import MODES, RUN, STATIC, Measure
from mbdsl.studies.runner import Runner
from mbdsl.studies.store import CHANGED, Computed, Store, key_of, method_code
from mbdsl.studies.time_limits import limited

FURTHER = 8  #: number of modes above those of the measures, which may become lower ones along a sweep
POINTS = 2000  #: number of output times of a run, unless an interval is given


@dataclass(frozen=True)
class SweepPoint(Case):
    """A run of a sweep: a case with the values of the parameters, as texts."""

    values: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        return ", ".join(f"{name} = {text}" for name, text in self.values)


@dataclass(frozen=True)
class SweepSetting(Setting):
    """The setting of a sweep.

    Attributes
    ----------
    scene : Scene
        The model at one of the points, for names and units.
    times_asked : mapping
        ``start``, ``stop`` and ``interval`` [s]; None: the model's.
    measures : tuple of Measure
        Measures of each run.
    after : float [s]
        Times before it do not count.
    base : Scene, optional
        The model without the values of a point, if it was not given by its path.
    base_text : str
        All that it was made from.
    at : str, float or mapping
        State about which modes are computed, as for ``mbdsl.eigen``.
    """

    times_asked: Mapping[str, float | None] = field(default_factory=dict)
    measures: tuple[Measure, ...] = ()
    after: float = -math.inf
    base: Scene | None = None
    base_text: str = ""
    at: At = "static"

    def asks_for(self, what: str) -> bool:
        """Whether a measure belongs to a run, to the equilibrium or to modes."""
        return any(m.of == what for m in self.measures)


def scene_at(of: SweepSetting, point: SweepPoint) -> Scene:
    """The model with the parameters of a point.

    Raises
    ------
    MbdslError
        If the model is invalid with these values, or its files have changed since the sweep began.
    """
    changes = {**of.parameters, **dict(point.values)}
    if of.base is not None:
        return of.base.changed(changes, of.without)
    assert of.path is not None
    found = load(of.path, changes, of.scene.name, of.without, of.allow_imports)
    if of.scene.files and dict(found.files) != dict(of.scene.files):
        raise FilesChanged
    return found


class FilesChanged(Exception):
    """A file of the model has changed during a sweep."""


@key_of.register
def _(of: SweepSetting, case: SweepPoint, code_of: Callable[[str], str] = method_code) -> str:
    """The digest of the texts that the model is made from, the parameters, the settings of the run and the measures.

    Scenes are not part of it: they are built where they run.
    """
    asked = {
        "model": of.scene.name,
        "files": of.base_text or list(of.scene.files.values()),
        "parameters": {name: str(value) for name, value in {**of.parameters, **dict(case.values)}.items()},
        "without": sorted(of.without),
        "case": [case.method, case.step, case.tol, case.options],
        "times": dict(of.times_asked),
        "after": of.after,
        "at": of.at,
        "measures": sorted(map(str, of.measures)),
    }
    said = ["sweep", code(), code_of(case.method), json.dumps(asked, default=float, sort_keys=True)]
    return hashlib.sha256("\0".join(said).encode()).hexdigest()[:32]


@compute.register
def _(
    of: SweepSetting,
    case: SweepPoint,
    limit: float = math.inf,
    announce=None,
    left: float = math.inf,
    compiling: float = 0.0,
) -> Computed:
    def run() -> Computed:
        scene = scene_at(of, case)
        values, modes = _at_rest(of, scene, announce)
        stats: dict[str, Any] = {"values": values}
        if of.asks_for(RUN):
            asked: dict[str, Any] = {"method": case.method, "step": case.step, "tol": case.tol}
            names = AskedSignals(scene)
            asked["signals"] = [name for m in of.measures if m.of == RUN for name in m.signals if name in names]
            asked |= {"options": dict(case.options), "announce": announce, **times(of, scene)}
            trajectory = limited(scene, min(limit, left), **asked)
            stats |= {key: trajectory.stats[key] for key in ("method", "h", "tol", "steps", "seconds")}
            stats["values"] |= measured(of, trajectory)
            stats["warnings"] = list(trajectory.stats.get("warnings", ()))
        found = Computed(case, stats=stats)
        return found if modes is None else with_modes(found, modes)

    try:
        return attempted(case, run)
    except FilesChanged:
        return Computed(case, problem=CHANGED)


def times(of: SweepSetting, scene: Scene) -> dict[str, Any]:
    """Start, stop and output interval of a run."""
    asked, said = dict(of.times_asked), scene.experiment
    if asked.get("interval") is None:
        start = said.start if asked.get("start") is None else asked["start"]
        stop = said.stop if asked.get("stop") is None else asked["stop"]
        if start is not None and stop is not None and stop > start:
            interval = (stop - start) / POINTS
            asked["interval"] = interval if said.interval is None else min(interval, said.interval)
    return asked


def measured(of: SweepSetting, found: Trajectory) -> dict[str, float]:
    """The value of each measure of a run; nan if a signal does not exist at this point, or is not determined."""
    after = found.t >= of.after
    part = found if after.all() else found[float(of.after) :] if after.any() else None
    values = {}
    for m in of.measures:
        if m.of == RUN:
            known = all(name in found for name in m.signals)
            values[str(m)] = m.of_run(part) if known and part is not None else math.nan
    return values


def _at_rest(
    of: SweepSetting, scene: Scene, announce: Callable[[str], None] | None
) -> tuple[dict[str, float], Modes | None]:
    """The value of each measure of the equilibrium and of modes by frequency, and these modes.

    A value is nan if there is no such signal or mode.
    """
    values: dict[str, float] = {}
    modes = None
    if of.asks_for(STATIC):
        rest = static(scene, start=of.times_asked.get("start"), announce=announce).trajectory
        for m in of.measures:
            if m.of == STATIC:
                values[str(m)] = float(rest[m.signal][0]) if m.signal in rest else math.nan
    if of.asks_for(MODES):
        asked = [m for m in of.measures if m.of == MODES]
        modes = eigen(scene, of.at, FURTHER + max(int(m.signal) for m in asked), announce=announce)
        for m in asked:
            k = int(m.signal) - 1
            values[str(m)] = float(getattr(modes[k], m.function)) if k < len(modes) else math.nan
    return values, modes


class PointRunner(Runner):
    """Runs the points of a sweep, each within ``limit`` [s]."""

    def __init__(self, of: SweepSetting, store: Store, limit: float, **given: Any) -> None:
        super().__init__(of, store, ordered=False, **given)
        self.limit = limit

    def runs(self, points: Iterable[SweepPoint]) -> dict[SweepPoint, Computed]:
        """All runs, from the store or computed.

        Raises
        ------
        UsageError
            If the files of the model have changed between the runs.
        """
        found = self.compute(list(dict.fromkeys(points)), limit=self.limit)
        if any(run.problem == CHANGED for run in found.values()):
            raise UsageError(f"{CHANGED}, so that its runs do not belong together", hint="run it again")
        return found  # type: ignore[return-value]
