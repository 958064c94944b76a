"""The complete state of a run with fixed steps, to save and to restore between steps, bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import Expr
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.integrators.saved_runs import checked, checked_events
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.mechanism_run import MechanismRun

#: the records of a run are shared with the state; their rows up to that of the state do not change
_SHARED = ("out", "times")


@dataclass(frozen=True, eq=False)
class SavedState:
    """The state of a ``Simulation``, from its attribute ``state``; it can be pickled.

    Attributes
    ----------
    time : float [s]
        Time reached.
    scene : Scene
        The model.
    settings : tuple
        Method, step, start, options and whether steps are recorded, which have to be the same.
    taken : int
        Number of steps, if no part of the model is solved for.
    runs : tuple of dict
        The buffers of every part.
    inputs, in_force : tuple of float
        Values of the inputs, and those of the last step.
    changes : tuple
        The changes of inputs so far: a list of (steps before it, values), and its length then.
    turns : dict
        The counters of angles between axes in space: expression -> (angle, time, rate).
    """

    time: float
    scene: Scene
    settings: tuple
    taken: int
    runs: tuple[dict[str, Any], ...]
    inputs: tuple[float, ...]
    in_force: tuple[float, ...]
    changes: tuple[list[tuple[int, tuple[float, ...]]], int]
    turns: dict[Expr, tuple[float, float, float]] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<state of {self.scene.name} at t = {self.time:g} s>"

    def __getstate__(self) -> dict[str, Any]:
        """Without the rows of the records, and the changes of inputs, that were added later."""
        found = dict(vars(self))
        found["runs"] = tuple(
            run | {key: run[key][: run["integers"][S.OUTPUT]].copy() for key in _SHARED} for run in self.runs
        )
        changes, count = self.changes
        found["changes"] = changes[:count], count
        return found


def snapshot(motion: MechanismRun) -> tuple[dict[str, Any], ...]:
    """A copy of the state of every run."""
    return tuple(_saved(p.integration) for p in motion.parts)  # type: ignore[arg-type]


def _saved(run: MethodRun) -> dict[str, Any]:
    return run.saved(*_SHARED) | ({"events": run.events.saved()} if hasattr(run, "events") else {})


def restore(motion: MechanismRun, taken: int, runs: tuple[dict[str, Any], ...]) -> None:
    """Return to a state of the same motion, or of one with the same model and settings.

    Raises
    ------
    UsageError
        If the state belongs to another motion.
    """
    if len(runs) != len(motion.parts):
        raise UsageError("the state belongs to another model, or to other settings")
    try:
        found = [_checked(p.integration, kept) for p, kept in zip(motion.parts, runs, strict=True)]  # type: ignore
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as problem:
        raise UsageError(f"the state is damaged: {problem}") from problem
    for p, kept, made in zip(motion.parts, runs, found, strict=True):
        assert isinstance(p.integration, MethodRun)
        _put_back(p.integration, kept, made)
    motion._taken, motion.failed, motion._failure = taken, None, S.DONE


def _checked(run: MethodRun, kept: dict[str, Any]) -> dict[str, Any]:
    times, out = kept["times"], kept["out"]
    if not (out.dtype == times.dtype == np.float64 and times.ndim == 1 and out.shape[1:] == run.out.shape[1:]):
        raise ValueError("its rows do not have the size or type that this model needs")
    written = int(kept["integers"][S.OUTPUT])
    if not 0 <= written <= min(len(out), len(times)):
        raise ValueError("it does not have the rows that were written")
    made = checked(run, kept, written)
    if hasattr(run, "events"):
        made["events"] = checked_events(run.events, kept["events"])
    return made


def _put_back(run: MethodRun, kept: dict[str, Any], made: dict[str, Any]) -> None:
    written = int(made["integers"][S.OUTPUT])
    if kept["out"] is not run.out or run.written != written:
        # rows after the state may belong to other states: the run continues in a record of its own
        room = max(len(kept["times"]), written)
        times, out = np.full(room, np.inf), np.empty((room, kept["out"].shape[1]))
        times[: len(kept["times"])], out[:written] = kept["times"], kept["out"][:written]
        run.times, run.out = times, out
    of_events = made.pop("events", {})
    for key, value in made.items():
        present = getattr(run, key)
        if isinstance(value, np.ndarray) and present.shape == value.shape and present.flags.writeable:
            present[...] = value
        else:
            setattr(run, key, value)
    if hasattr(run, "events") and run.events.set is not None:
        vars(run.events).update(of_events)
        run.set_stop(min(max(float(kept["reals"][S.STOP]), run.start), run.stop))
        run.events.set.restore(run, kept["events"]["set"])
        run.events.rejoin()
    if hasattr(run, "jumps") and run.jumps.next[0] != (due := float(run.reals[S.NEXT_EVENT])):
        run.jumps.rejoin(due)
