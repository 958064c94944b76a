"""Results of any length: rows are taken from a run while it goes on, and their signals are written to a scratch file.

Only a window of rows is in memory. Signals are computed for blocks of rows, of which the last has between one and two
times the usual size: a block never has so few rows that signals would be computed in another way than for the whole
trajectory (``mbdsl.system.batch_accelerations``), and the results are equal bit for bit.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from mbdsl.errors import IntegrationError, UsageError
from mbdsl.integrators import backend
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.hermite import between
from mbdsl.results.rows_file import RowsFile
from mbdsl.simulation.diagnostics.fixed_steps import Watch
from mbdsl.simulation.ladder_constants import LADDER
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.parts_output import Rows
from mbdsl.simulation.plan import in_memory, width
from mbdsl.simulation.result_checks import check_bending, check_left_out, check_lines_of_centres, failed
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.batch_accelerations import MANY

LEAST = 2**22  #: quantity of numbers up to which the results of a run are held in memory
BLOCK, NUMBERS = 4096, 2**21  #: rows of a block, and numbers in it; at least FEWEST rows
FEWEST = MANY


class Stream:
    """Takes the rows of a run and writes their signals to a scratch file.

    Parameters
    ----------
    near : path
        A file; the scratch file is in its folder. With ``kept`` it is the scratch file, which remains.
    choose : callable
        Returns the names of the signals, given a trajectory.
    kept : bool, optional
        Whether the file has a name, so that a resumed run continues it.

    Attributes
    ----------
    file : RowsFile or None
        The signals, "time" first; None if the results are in memory.
    undetermined : list of float [s]
        As those of a trajectory.
    problem : str
        Reason why rows could not be written, such as a full disk; the run ends then.
    reached : float [s]
        Time of the last row that was written.
    """

    def __init__(self, near: str | os.PathLike, choose: Callable[[Trajectory], list[str]], kept: bool = False) -> None:
        self._near, self._choose, self._kept = near, choose, kept
        self.file: RowsFile | None = None
        self._restored = False
        self._reset()

    def _reset(self) -> None:
        self._released = -1  # rows after the start that were taken; -1: not even the start
        self._brackets: list[tuple[Array, Array, Array, Array]] = []  # last known row of each part
        self._pending: list[Rows] = []
        self._watch: Watch | None = None
        self._wrong: tuple[str, Any, str | None] | None = None  # message, place and remedy of the first violation
        self.undetermined: list[float] = []
        self.problem, self.reached = "", 0.0
        if self.file is not None:
            self.file.remove()
            self.file = None

    def close(self, keep: bool = False) -> None:
        """Remove the scratch file; ``keep`` one that has a name."""
        if self.file is not None and keep:
            self.file.close()
        elif self.file is not None:
            self.file.remove()

    def settle(self, motion: MechanismRun) -> None:
        """Decide whether the rows of a motion that is not prepared yet are streamed, and how many are in memory."""
        plan, tables = motion.plan, motion.system.tables
        columns = width(motion.system.scene)
        short = not plan.every and (plan.count <= LADDER.most_compared or plan.count * columns <= LEAST)
        # angles that count turns depend on all earlier rows
        turns = motion.system.counts_angles or any(body.counter >= 0 for body in tables.models.values())
        if short or backend(plan.method) is not None or turns:
            motion.plan = in_memory(plan, motion.system.scene)
            return
        self._block = max(FEWEST, min(BLOCK, NUMBERS // max(1, columns)))
        if plan.rows is not None:
            step = plan.h / plan.rows.spacing if plan.tol is None else LADDER.dense
            motion.plan = replace(plan, rows=replace(plan.rows, window=max(self._block, 4 * int(np.ceil(step)) + 8)))

    # -- while the run goes on ---------------------------------------------------------------------------------
    def begin(self, motion: MechanismRun) -> None:
        """At the start of a run, which may be the repetition of another one."""
        if not self._restored:
            self._reset()
        self._restored = False

    def pause(self, motion: MechanismRun) -> None:
        """Between steps: take the rows that all parts have reached."""
        while (rows := self._taken(motion)) is not None:
            self._pending.append(rows)
            while not self.problem and sum(len(part[0]) for part in self._pending) >= 2 * self._block:
                whole = _joined(self._pending)
                self._emit(motion, _cut(whole, 0, self._block))
                self._pending = [_cut(whole, self._block, len(whole[0]))]

    def end(self, motion: MechanismRun, partial: bool) -> Rows:
        """Write all rows that are left, and return them; ``partial`` as for ``MechanismRun.output``."""
        if motion.plan.streamed:
            self.pause(motion)
            if partial and not motion.plan.every and (rows := self._last(motion)) is not None:
                self._pending.append(rows)
        else:  # a calibration run that was interrupted
            self._reset()
            self._pending.append(motion.output(partial))
        found = _joined(self._pending)
        self._pending = []
        self._emit(motion, found)
        return found

    def _emit(self, motion: MechanismRun, rows: Rows) -> None:
        t, q, v, lam, states = rows
        own = lam if motion.own_reactions else None
        h = motion.plan.h if motion.plan.tol is None else None
        numbers = {} if motion.event_set is None else motion.event_set.at(t)
        trajectory = Trajectory(motion.system, t, q, v, own, {"status": "done", "h": h}, (), motion.left_out, numbers)
        if self.file is None:
            names = [name for name in self._choose(trajectory) if name != "time"]
            self.file = RowsFile(["time", *names], self._near, self._kept)
        if not self.problem:
            try:
                self.file.append([trajectory[name] for name in self.file.names])
                self.reached = float(t[-1])
            except UsageError as problem:
                self.problem = problem.message
        self.undetermined += trajectory.undetermined
        if self._wrong is None:
            try:
                check_left_out(motion, trajectory, states)
                check_bending(trajectory)
                check_lines_of_centres(trajectory)
            except IntegrationError as problem:
                self._wrong = problem.message, problem.span, problem.hint
        self.watched(motion).add(trajectory, states)

    def watched(self, motion: MechanismRun) -> Watch:
        """The search for symptoms of too long steps in all rows so far."""
        if self._watch is None:
            self._watch = Watch(motion)
        return self._watch

    def check(self, trajectory: Trajectory) -> None:
        """Raise the error of the first row that violates a constraint or the range of a theory."""
        if self._wrong is not None:
            raise failed(trajectory, *self._wrong)

    # -- rows of the parts -------------------------------------------------------------------------------------
    def _taken(self, motion: MechanismRun) -> Rows | None:
        """The rows that all parts have reached, and that were not taken before; the start first."""
        plan = motion.plan
        if plan.every and len(motion.parts) > 1:
            return self._between_steps(motion)
        before, starts = max(0, self._released), self._released < 0
        if motion.parts:
            done = min(p.integration.written for p in motion.parts)
        else:
            assert plan.rows is not None
            ahead = plan.rows.part(before, min(before + plan.rows.window, plan.rows.count))
            done = before + int((ahead <= motion.time + 1e-9 * plan.h).sum())
        if done == before and not starts:
            return None
        states, times = [], np.zeros(0)
        for p in motion.parts:
            run = p.integration
            assert isinstance(run, MethodRun)
            times, rows = run.release(done - before)
            states.append(p.split(np.concatenate([p.first, rows]) if starts else rows))
        if plan.rows is not None:
            times = plan.rows.part(before, done)
        if starts:
            times = np.append(plan.start, times)
        self._released = done
        return motion.rows(times, states)

    def _between_steps(self, motion: MechanismRun) -> Rows | None:
        """For parts with steps of their own: at the steps of all parts, up to the time that all have reached."""
        starts = self._released < 0
        if starts:
            self._released = 0
            self._brackets = [(np.array([motion.plan.start]), *p.split(p.first)) for p in motion.parts]
        known = []
        for p, bracket in zip(motion.parts, self._brackets, strict=True):
            run = p.integration
            assert isinstance(run, MethodRun)
            t, rows = run.release(run.written - run.released)
            known.append(tuple(np.concatenate([a, b]) for a, b in zip(bracket, (t, *p.split(rows)), strict=True)))
        end, begin = min(own[0][-1] for own in known), self._reached if not starts else -np.inf
        times = np.unique(np.concatenate([own[0] for own in known]))
        times = times[(times > begin) & (times <= end)]
        turning = [p.system.tables.rotations[:, 0] for p in motion.parts]
        states = [between(times, own[0], own[1], own[2], own[3], d) for own, d in zip(known, turning, strict=True)]
        self._reached = float(end)
        self._brackets = []
        for own in known:  # from the last row before the end on
            k = max(0, int(np.searchsorted(own[0], end, side="right")) - 1)
            self._brackets.append(tuple(x[k:].copy() for x in own))
        return motion.rows(times, states) if len(times) else None

    def _last(self, motion: MechanismRun) -> Rows | None:
        """The last step reached, if it is not an output time and all parts have reached it."""
        plan, reached = motion.plan, motion.time
        assert plan.rows is not None
        last = plan.rows.part(self._released - 1, self._released)[0] if self._released > 0 else plan.start
        if not reached > last + 1e-9 * plan.h or any(p.integration.time != reached for p in motion.parts):
            return None
        return motion.rows(np.array([reached]), [p.split(p.last) for p in motion.parts])

    # -- checkpoints -------------------------------------------------------------------------------------------
    def state(self, motion: MechanismRun) -> dict[str, Any]:
        """The state for a checkpoint; the rows that were written are on the disk then."""
        if self.file is not None:
            self.file.flush()
        joined = _joined(self._pending) if self._pending else None
        return {
            "names": None if self.file is None else self.file.names,
            "count": 0 if self.file is None else self.file.count,
            "released": self._released,
            "reached": getattr(self, "_reached", None),
            "brackets": [list(x) for x in self._brackets],
            "pending": None if joined is None else [*joined[:4], [list(x) for x in joined[4]]],
            "wrong": None if self._wrong is None else [self._wrong[0], self._wrong[2]],
            "undetermined": list(self.undetermined),
            "watch": None if self._watch is None else self._watch.state(),
        }

    def restore(self, motion: MechanismRun, known: dict[str, Any]) -> None:
        """Continue from a state."""
        self._reset()
        self._released, self._brackets = int(known["released"]), [tuple(x) for x in known["brackets"]]
        if known["reached"] is not None:
            self._reached = float(known["reached"])
        if known["pending"] is not None:
            *rows, states = known["pending"]
            self._pending = [(*rows, [tuple(x) for x in states])]
        if known["wrong"] is not None:
            self._wrong = known["wrong"][0], None, known["wrong"][1]
        self.undetermined = [float(t) for t in known["undetermined"]]
        if known["watch"] is not None:
            self.watched(motion).restore(known["watch"])
        if known["names"] is not None:
            self.file = RowsFile([str(x) for x in known["names"]], self._near, True, int(known["count"]))
        self._restored = True


def _joined(parts: list[Rows]) -> Rows:
    if len(parts) == 1:
        return parts[0]
    t, q, v, lam = (np.concatenate([rows[k] for rows in parts]) for k in range(4))
    states = [
        (np.concatenate([rows[4][k][0] for rows in parts]), np.concatenate([rows[4][k][1] for rows in parts]))
        for k in range(len(parts[0][4]))
    ]
    return t, q, v, lam, states


def _cut(rows: Rows, first: int, end: int) -> Rows:
    own = slice(first, end)
    t, q, v, lam, states = rows
    return t[own], q[own], v[own], lam[own], [(x[own], y[own]) for x, y in states]
