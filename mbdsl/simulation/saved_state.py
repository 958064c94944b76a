"""The complete state of a run with fixed steps, to save and to restore between steps, bit for bit."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.run import Integration
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.checkpoint import NOT_KEPT
from mbdsl.simulation.mechanism_run import Motion

Array = NDArray[np.float64]
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
    """

    time: float
    scene: Scene
    settings: tuple
    taken: int
    runs: tuple[dict[str, Any], ...]
    inputs: tuple[float, ...]
    in_force: tuple[float, ...]
    changes: tuple[list[tuple[int, tuple[float, ...]]], int]

    def __repr__(self) -> str:
        return f"<state of {self.scene.name} at t = {self.time:g} s>"

    def __getstate__(self) -> dict[str, Any]:
        """Without the rows of the records, and the changes of inputs, that were added later."""
        found = dict(vars(self))
        found["runs"] = tuple(
            run | {key: run[key][: run["integers"][loop_state.OUTPUT]].copy() for key in _SHARED} for run in self.runs
        )
        changes, count = self.changes
        found["changes"] = changes[:count], count
        return found


def snapshot(motion: Motion) -> tuple[dict[str, Any], ...]:
    """A copy of the state of every run."""
    return tuple(_kept(p.integration) for p in motion.parts)  # type: ignore[arg-type]


def restore(motion: Motion, taken: int, runs: tuple[dict[str, Any], ...]) -> None:
    """Return to a state of the same motion, or of one with the same model and settings.

    Raises
    ------
    UsageError
        If the state belongs to another motion.
    """
    if len(runs) != len(motion.parts):
        raise UsageError("the state belongs to another model, or to other settings")
    for p, kept in zip(motion.parts, runs, strict=True):
        assert isinstance(p.integration, Integration)
        _put_back(p.integration, kept)
    motion._taken, motion.failed, motion._failure = taken, None, loop_state.DONE


def _kept(run: Integration) -> dict[str, Any]:
    found = {}
    for key, value in vars(run).items():
        if key in _SHARED:
            found[key] = value
        elif key not in NOT_KEPT:
            found[key] = value.copy() if isinstance(value, np.ndarray | list) else value
    return found


def _put_back(run: Integration, kept: dict[str, Any]) -> None:
    if kept["solver"] != run.solver:
        run.use_solver(kept["solver"])
    written = int(kept["integers"][loop_state.OUTPUT])
    if kept["out"] is not run.out or run.written != written:
        # rows after the state may belong to other states: the run continues in a record of its own
        room = max(len(kept["times"]), written)
        times, out = np.full(room, np.inf), np.empty((room, kept["out"].shape[1]))
        times[: len(kept["times"])], out[:written] = kept["times"], kept["out"][:written]
        run.times, run.out = times, out
    for key, value in kept.items():
        if isinstance(value, np.ndarray) and key not in _SHARED:
            present = getattr(run, key)
            if present.shape == value.shape and present.flags.writeable:
                present[...] = value
            else:
                setattr(run, key, value.copy())
        elif key not in _SHARED:
            setattr(run, key, copy(value))
    if hasattr(run, "jumps") and run.jumps.next[0] != (due := float(run.reals[loop_state.NEXT_EVENT])):
        run.jumps.rejoin(due)
