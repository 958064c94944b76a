"""The influence of each effect of a scene on a signal, measured by runs without the effect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.elements.declaration import EFFECTS
from mbdsl.errors import MbdslError, UsageError
from mbdsl.lang.model_argument import as_scene
from mbdsl.lang.units import measure
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.plan import DEFAULT_STEP
from mbdsl.simulation.run_options import RunOptions, takes_options
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbdsl.lang.builder import Builder
    from mbdsl.simulation.run_options import GivenOptions


@dataclass(frozen=True)
class Without:
    """The scene without some effects."""

    effects: tuple[str, ...]
    change: float | None  #: largest change of the signal, in its unit; None if the run failed
    time: float | None  #: run time relative to that of the complete scene
    problem: str = ""


@dataclass(frozen=True)
class EffectsStudy:
    """The change of a signal when effects are left out; ``str()`` returns a table.

    Attributes
    ----------
    scene : Scene
        The complete model.
    signal, unit : str
        Name and unit of the signal.
    low, high : float
        Range of the signal.
    error : float
        Discretisation error of the signal in the complete model, from a run with half the step. Smaller changes are
        not significant.
    seconds : float [s]
        Time of the step loop of a run of the complete model.
    rows : tuple of Without
        The model without each of its effects.
    absent : tuple of str
        Effects that the model does not contain.
    tol : float or None
        Allowed change of the signal.
    together : Without or None
        The model without all effects that can be left out within ``tol``.
    """

    scene: Scene
    signal: str
    unit: str
    low: float
    high: float
    error: float
    seconds: float
    rows: tuple[Without, ...]
    absent: tuple[str, ...]
    tol: float | None = None
    together: Without | None = None

    @property
    def dispensable(self) -> tuple[str, ...] | None:
        """Effects that can be left out together within ``tol``; None without a tolerance."""
        return None if self.tol is None else () if self.together is None else self.together.effects

    def __str__(self) -> str:
        return _text(self)

    def __repr__(self) -> str:
        names = [", ".join(row.effects) for row in self.rows]
        return f"<EffectsStudy of {self.signal} in {self.scene.name}: {'; '.join(names) or 'no effects'}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import preformatted

        return preformatted(str(self))


@takes_options("tol method step stop parameters without contacts announce".split())
def effects(
    model: Scene | Builder | str | PathLike,
    signal: str,
    *,
    repeats: int = 5,
    **given: Unpack[GivenOptions],
) -> EffectsStudy:
    """Leave out each effect of a model in turn and measure the change of a signal.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    signal : str
        Name of a signal, such as "crank.phi" or "O.fx".
    tol : float or str, optional
        Allowed change, in the signal's SI unit, or a text with a unit ("1 mm") or relative to the signal's range
        ("1 %").
    method, step, stop, parameters, without, contacts, announce : optional
        As for ``mbdsl.simulate``.
    repeats : int, optional
        Number of timed runs of each variant, in alternation; their medians are compared.

    Returns
    -------
    EffectsStudy

    Raises
    ------
    UsageError
        If the arguments are invalid.
    MbdslError
        If the complete model cannot be simulated.
    KeyboardInterrupt
        If a run is interrupted.
    """
    if repeats < 1:
        raise UsageError(f"repeats = {repeats}: a time needs one run or more")
    tol = given.pop("tol", None)
    asked = RunOptions.of(given)
    return _measured(as_scene(model, asked.parameters, asked.without), signal, asked, tol, repeats)


def _measured(base: Scene, signal: str, asked: RunOptions, tol: float | str | None, repeats: int) -> EffectsStudy:
    """Make the runs of :func:`effects`."""

    def run(scene: Scene, part: float = 1.0) -> Trajectory:
        h = asked.step or scene.experiment.step or DEFAULT_STEP
        # if every step is output, runs are compared at the times of the complete model
        interval = h if scene.experiment.interval == 0.0 else None
        how = replace(asked, parameters=None, without=(), step=h * part, interval=interval)
        found = simulated(scene, how)
        if found.status == "interrupted":
            raise KeyboardInterrupt
        return found

    whole = run(base)
    S, unit = whole[signal], whole.unit(signal)
    finer = run(base, 0.5)[signal]
    error = float(np.abs(finer - S).max()) * 4.0 / 3.0  # for order 2; slightly too large for higher orders
    low, high = float(S.min()), float(S.max())
    allowed = None if tol is None else tolerance(tol, unit, high - low)

    def compared(names: tuple[str, ...]) -> Without:
        return _compare(run, whole, signal, names, base.changed({}, names), repeats)

    others = {name: base.changed({}, (name,)).without[name] for name in EFFECTS if name not in base.without}
    rows = [compared((name,)) for name, there in others.items() if there]
    together = None if allowed is None else _together(compared, rows, allowed)
    absent = tuple(name for name, there in others.items() if not there)
    seconds = whole.stats["seconds"]["integrate"]
    return EffectsStudy(base, signal, unit, low, high, error, seconds, tuple(rows), absent, allowed, together)


def _together(
    compared: Callable[[tuple[str, ...]], Without], rows: Sequence[Without], allowed: float
) -> Without | None:
    """The model without as many effects as the allowed change permits, the least important ones first.

    The joint change may exceed the sum of the single ones.
    """
    small = sorted((r for r in rows if r.change is not None and r.change <= allowed), key=lambda r: r.change or 0.0)
    for k in range(len(small), 0, -1):
        found = compared(tuple(r.effects[0] for r in small[:k]))
        if found.change is not None and found.change <= allowed:
            return found
    return None


def tolerance(tol: float | str, unit: str, extent: float, name: str = "tol") -> float:
    """A tolerance in the unit of a signal with the range ``extent``: 1e-3, "1 mm", "1 %"; ``name`` is for messages."""
    text = str(tol).strip()
    try:
        found = measure(text[:-1], "1") / 100 * extent if text.endswith("%") else measure(text, unit or "1")
    except ValueError as problem:
        raise UsageError(f"{name}: {problem}") from None
    if not 0.0 < found < float("inf"):
        raise UsageError(f"{name} = {text} leaves no room: it has to be above zero")
    return found


def _compare(
    run: Callable[[Scene], Trajectory],
    whole: Trajectory,
    signal: str,
    names: tuple[str, ...],
    scene: Scene,
    repeats: int,
) -> Without:
    ratios = []
    try:
        found = run(scene)  # with compilation
        for _ in range(repeats):
            one, other = run(scene), run(whole.scene)
            ratios.append(one.stats["seconds"]["integrate"] / max(other.stats["seconds"]["integrate"], 1e-9))
    except MbdslError as problem:
        return Without(names, None, None, f"does not run: {problem.message}")
    if signal not in found.names:
        return Without(names, None, None, "it has no such signal")
    change = float(np.abs(found[signal] - whole[signal]).max(initial=0.0))
    return Without(names, change, median(ratios))


def _text(s: EffectsStudy) -> str:
    unit = f" {s.unit}" if s.unit else ""
    lines = [
        f"{s.scene.name}: {s.signal} from {s.low:.6g} to {s.high:.6g}{unit}, "
        f"known to {s.error:.1e}{unit} at this step; a run takes {1e3 * s.seconds:.3g} ms",
        "",
        f"{'without':24} {'it changes by':>18} {'time':>7}",
    ]
    for r in s.rows:
        lines.append(_row(r, s, unit))
    if s.together is not None and len(s.together.effects) > 1:
        lines.append(_row(s.together, s, unit))
    if s.absent:
        lines.append(f"not in the scene: {', '.join(s.absent)}")
    if s.tol is not None:
        tried = [r for r in s.rows if r.change is not None]
        needed = [r.effects[0] for r in tried if r.effects[0] not in (s.dispensable or ())]
        lines += ["", f"within {s.tol:.3g}{unit}, the result needs: {', '.join(needed) or 'none of them'}"]
        if s.dispensable:
            lines.append(f"it does not need: {', '.join(s.dispensable)}  (--without {','.join(s.dispensable)})")
        if s.error > s.tol:
            lines.append(f"the step is too large for a decision: its own error is {s.error:.1e}{unit}")
    return "\n".join(lines)


def _row(r: Without, s: EffectsStudy, unit: str) -> str:
    name = ", ".join(r.effects)
    if r.change is None or r.time is None:
        return f"{name:24} {r.problem}"
    size = f"{r.change:.3e}{unit}"
    doubt = "   less than the step's own error" if r.change <= s.error else ""
    return f"{name:24} {size:>18} {100 * r.time:5.0f} %{doubt}"
