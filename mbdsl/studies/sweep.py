"""Sweep: a run for each combination of values of parameters, and measures of the signals of each run."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from os import PathLike
from typing import TYPE_CHECKING

from mbdsl.errors import MbdslError, UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.display_units import asked as asked_units
from mbdsl.lang.given_values import mapping
from mbdsl.lang.library import allowed_now
from mbdsl.lang.load import load
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism.canonical_text import canonical_text
from mbdsl.mechanism.scene import Description, ParameterValue, Scene
from mbdsl.simulation.plan import DEFAULT_METHOD, Plan, plan
from mbdsl.simulation.run_options import RunOptions, takes_options
from mbdsl.studies import measures as measuring
from mbdsl.studies.cases import chosen
from mbdsl.studies.followed_modes import Follower, followed
from mbdsl.studies.followed_modes import notes as followed_notes
from mbdsl.studies.followed_modes import values as followed_values
from mbdsl.studies.measures import MODES, RUN, Measure
from mbdsl.studies.store import Computed
from mbdsl.studies.sweep_options import SweepOptions
from mbdsl.studies.sweep_results import Sweep
from mbdsl.studies.sweep_runs import PointRunner, SweepPoint, SweepSetting, times
from mbdsl.studies.sweep_values import FORMS, MOST, Varied, half, number_text, varied

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbdsl.lang.builder import Builder
    from mbdsl.studies.sweep_options import GivenSweepOptions


@takes_options(table=SweepOptions)
def sweep(
    model: Scene | Builder | str | PathLike,
    vary: Mapping[str, str | Iterable],
    measures: str | Sequence[str] | None = None,
    *,
    paired: bool = False,
    **given: Unpack[GivenSweepOptions],
) -> Sweep:
    """Run a model with each combination of values of parameters, on all cores, and measure signals of each run.

    Completed runs are stored; a sweep that was interrupted continues when it is called again.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism, as for ``mbdsl.simulate``. A Scene has to be made from a text or by a Builder.
    vary : mapping
        Parameter -> its values: a text "start:stop:count" or "start:stop:count:log", with a unit after it ("1:10:5
        N/mm"), a text "1, 2, 5", or a sequence of numbers in SI units, Booleans or texts with units.
    measures : str or sequence of str, optional
        Measures of each run, such as ``max(pin.fx)``; functions are final, min, max, maxabs, mean, rms, amplitude,
        period, time_of_max and time_of_min; glob patterns stand for several signals. ``time_when(mass.x > 0.5 m)`` is
        the first time at which a condition holds (with ``, last`` the last, with ``, count`` how often),
        ``at(mass.vx, mass.x > 0.5 m)`` or ``at(mass.vx, 2 s)`` the value at a time, ``at_max(mass.y, rod.fy)`` and
        ``at_min`` that where another signal is largest or least. ``static(pin.fx)`` is the value at
        the equilibrium that ``mbdsl.static`` finds; frequency(1), damped_frequency(1) and damping(1) are those of the
        first mode of ``mbdsl.eigen`` at the first point, which is followed from point to point by its shape. Models are
        simulated only if a measure needs it. Default: least and largest value of the coordinates of the first body.
    paired : bool, optional
        Whether the first values of all parameters belong together, then the second, and so on. Default: all
        combinations.
    after : float or str, optional [s]
        Values before this time do not count.
    method, step, tol, start, stop, options, parameters, without, contacts, announce : optional
        As for ``mbdsl.simulate``.
    interval : float or str, optional [s]
        Output interval. Default: (stop - start)/2000. Measures are those of the output.
    at : str, float or mapping, optional
        State about which modes are computed, as for ``mbdsl.eigen``.
    limit : float or str, optional [s]
        Time limit of a run. A run that exceeds it has no values and is not stored.
    workers : int, optional
        Number of processes. Default: the number of cores.
    store : path, optional
        Folder of stored runs. Default: a subfolder of mbdsl's cache folder.
    fresh : bool, optional
        Whether to ignore stored runs.
    units : str or iterable of str, optional
        Units of measures in tables and pictures such as "deg, kN, mm"; columns are in SI units.
    tell : callable, optional
        Called with the progress of the sweep.

    Returns
    -------
    Sweep
        A run that failed has a row with the reason.

    Raises
    ------
    UsageError, ModelError
        If the arguments are invalid, or the model is invalid with all values.
    KeyboardInterrupt
        If it is interrupted; completed runs are stored.
    """
    options = SweepOptions.of(given)
    ranges = [varied(name, values) for name, values in mapping(vary, "vary", _by_name(vary)).items()]
    indices = _indices(ranges, paired)
    points = [tuple((p.name, p.texts[j]) for p, j in zip(ranges, row, strict=True)) for row in indices]
    asked = measuring.split(measures) if isinstance(measures, str) else measures
    of, case, _ = setting(model, points, asked, options)
    runner = options.runner(of)
    cases = [replace(case, values=values) for values in points]
    runs = runner.runs(cases)
    rows, notes = [runs[case] for case in cases], list[str]()
    if of.asks_for(MODES):
        rows, notes = _followed(runner, of, cases[0], ranges, indices, rows, paired)
    known = (of.scene.descriptions.get(m.signal, Description()).doc for m in of.measures)
    notes += dict.fromkeys(f"{m.signal}: {doc}." for m, doc in zip(of.measures, known, strict=True) if doc)
    return made(of, runner, options, ranges, indices, rows, paired, notes)


def made(
    of: SweepSetting,
    runner: PointRunner,
    options: SweepOptions,
    ranges: Sequence[Varied],
    indices: Sequence[tuple[int, ...]],
    rows: Sequence[Computed],
    paired: bool = True,
    notes: Sequence[str] = (),
) -> Sweep:
    """The runs of a setting as a Sweep."""
    shown = tuple(with_unit(p, of.scene) for p in ranges)
    display = asked_units(options.units, of.scene.display)
    return Sweep(
        of.scene.name, shown, of.measures, list(indices), tuple(rows), paired, runner.limit, runner.found,
        list(notes), display,
    )  # fmt: skip


def _followed(
    runner: PointRunner,
    of: SweepSetting,
    case: SweepPoint,
    ranges: Sequence[Varied],
    indices: Sequence[tuple[int, ...]],
    runs: Sequence[Computed],
    paired: bool,
) -> tuple[list[Computed], list[str]]:
    """The runs with the measures of modes in the order in which they are followed, and sentences about it."""
    modal = replace(of, measures=tuple(m for m in of.measures if m.of == MODES))
    added = PointRunner(modal, runner.store, runner.limit, workers=1, announce=runner.announce)

    def place(row: Sequence[int]) -> tuple:
        return tuple(p.texts[j] if p.numbers is None else p.numbers[j] for p, j in zip(ranges, row, strict=True))

    def between(a: tuple, b: tuple) -> tuple[tuple, Computed] | None:
        halves = [half(p, x, y) for p, x, y in zip(ranges, a, b, strict=True)]
        middle = tuple(x for x in halves if x is not None)
        if len(middle) < len(halves):
            return None
        texts = [
            x if isinstance(x, str) else f"{number_text(x)} {p.unit}".strip()
            for p, x in zip(ranges, middle, strict=True)
        ]
        point = replace(case, values=tuple(zip([p.name for p in ranges], texts, strict=True)))
        return middle, added.runs([point])[point]

    follower = Follower(max(int(m.signal) for m in modal.measures), between)
    shapes, uncertain = followed(follower, indices, [place(row) for row in indices], runs, paired)
    rows = [
        replace(run, stats={**run.stats, "values": followed_values(of.measures, x, run)}) if run.done else run
        for run, x in zip(runs, shapes, strict=True)
    ]
    return rows, followed_notes(ranges, indices, shapes, uncertain, follower)


def setting(
    model: Scene | Builder | str | PathLike,
    points: Sequence[tuple[tuple[str, str], ...]],
    asked: Sequence[str] | None,
    options: SweepOptions,
) -> tuple[SweepSetting, SweepPoint, Plan | None]:
    """What the runs of a sweep have in common, a point without values, and the plan of a run, if there is a run.

    Raises
    ------
    UsageError, ModelError
        As :func:`sweep`.
    """
    path = os.fspath(model) if isinstance(model, (str, PathLike)) else None
    base = None if isinstance(model, (str, PathLike)) else as_scene(model)
    fixed, without = dict(options.parameters or {}), tuple(options.without)
    for name, _ in points[0]:
        if name in fixed:
            raise UsageError(f"`{name}` is set and varied", hint="leave one of them out")

    def read(values: Mapping[str, str]) -> Scene:
        changes = {**fixed, **values}
        if base is not None:
            return base.changed(changes, without)
        assert path is not None
        return load(path, changes, without=without)

    scene, chosen_measures = _readable(read, points, asked)
    name = scene.experiment.method or DEFAULT_METHOD if options.method is None else chosen([options.method])[0]
    of = SweepSetting(
        scene,
        scene.experiment.start if options.start is None else options.start,
        math.nan,
        0,
        path,
        fixed,
        without,
        allowed_now(),
        times_asked=options.times,
        measures=tuple(chosen_measures),
        after=-math.inf if options.after is None else options.after,
        base=base,
        base_text="" if base is None or base.origin is None else canonical_text(base.origin),
        at=options.at,
    )
    given = {key: float(x) for key, x in sorted((options.options or {}).items()) if x is not None}
    case = SweepPoint(name, options.step, options.tol, tuple(given.items()))
    if not of.asks_for(RUN):
        return of, case, None
    how = RunOptions(name, options.step, options.tol, options=options.options, **times(of, scene))
    run = plan(scene, how)
    if options.after is not None and not options.after < run.stop:
        raise UsageError(
            f"no values after {options.after:g} s: the runs end at {run.stop:g} s", hint="give an earlier time"
        )
    return of, case, run


def _by_name(vary: object) -> str:
    """How the values of a list of mappings, one for each run, are written."""
    runs = vary if isinstance(vary, Sequence) and all(isinstance(run, Mapping) for run in vary) else ()
    names = dict.fromkeys(name for run in runs for name in run)
    if not names or any(run.keys() != names.keys() for run in runs):
        return 'give the values by name: `{"L": [1, 2]}`, with paired=True for one run from each position'
    shown = ", ".join(f"{name!r}: {[run[name] for run in runs]!r}" for name in names)
    return f"write {{{shown}}}{', paired=True' if len(names) > 1 else ''}"


def _indices(ranges: Sequence[Varied], paired: bool) -> list[tuple[int, ...]]:
    """Indices of the values of each row."""
    if not ranges:
        raise UsageError("a sweep varies a parameter", hint=f"give --vary, such as {FORMS}")
    sizes = [len(p) for p in ranges]
    if paired:
        if len(set(sizes)) > 1:
            said = ", ".join(f"{p.name} has {len(p)}" for p in ranges)
            raise UsageError(f"paired parameters have the same number of values: {said}")
        return [(k,) * len(ranges) for k in range(sizes[0])]
    if math.prod(sizes) > MOST:
        said = " x ".join(map(str, sizes))
        raise UsageError(
            f"{said} = {math.prod(sizes)} runs are too many: a sweep has at most {MOST}",
            hint="give fewer values, or several sweeps",
        )
    return list(product(*map(range, sizes)))


def _readable(
    read: Callable[[Mapping[str, str]], Scene],
    points: Sequence[tuple[tuple[str, str], ...]],
    asked: Sequence[str] | None,
) -> tuple[Scene, list[Measure]]:
    """The model at the first, the last or the middle point at which it is valid and has all signals, and the measures.

    Raises
    ------
    MbdslError
        If there is no such point: that of the first.
    """
    first: MbdslError | None = None
    for values in dict.fromkeys((points[0], points[-1], points[len(points) // 2])):
        try:
            scene = read(dict(values))
            names = AskedSignals(scene)
            return scene, measuring.read(asked or measuring.usual(names), names)
        except MbdslError as problem:
            first = first or problem
    assert first is not None
    raise first


def with_unit(p: Varied, scene: Scene) -> Varied:
    """The parameter with the unit of its declaration, if its values have none."""
    owner, _, name = p.name.rpartition(".")
    declared = scene.parameters.get(p.name, ParameterValue("", None)).unit
    if owner in scene.components:
        declared = next((x.unit for x in scene.components[owner].kind.parameters if x.name == name), "")
    if p.unit or p.numbers is None or declared in ("", "1"):
        return p
    return Varied(p.name, p.texts, p.numbers, declared, p.log)
