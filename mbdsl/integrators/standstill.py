"""Detection of runs that stand still: steps so short that the stop time is out of reach.

A force that changes its sign within a velocity of rounding size, as tanh(v/v_s) with a tiny v_s or a condition that
rounding decides, holds the motion at the change. Steps resolve it only if they are as short as the change; each is
accepted, none is an event, and the run seems to go on. A run is examined after every ``WINDOW`` steps and ended

- if their mean is below ``SHORT`` of the longest allowed step, the rest of the run would take more than ``MANY`` steps
  of that size, and a force jumps back and forth between steps, which shows that the steps do not resolve it; or
- if ``PATIENCE`` examinations in succession find that steps advance it by less than ``NOTHING`` of its length, or if
  one finds that the time has not changed.

Steps that resolve a fast motion (an impact, a stiff transient, a high frequency) see no jumps, and a fast motion that
decays takes fewer steps than ``PATIENCE`` examinations, however long the run is. A force that jumps as a function of
time, such as a pulsed one, is resolved at each jump: it is left out, which its values in a single state show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mbdsl.expressions.symbolic import Expr
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run_state import RunState
from mbdsl.kernels.arrays import Array
from mbdsl.system import System
from mbdsl.system.signals import values
from mbdsl.system.switches import Switch

#: status of a run that stands still, in addition to those of :mod:`mbdsl.integrators.loop.loop_state`
STALLED = 100
#: number of steps between examinations
WINDOW = 5000
#: mean step relative to the longest allowed one; number of steps for the rest of the run
SHORT, MANY = 1e-6, 1e7
#: part of the run's length; number of examinations (200,000 steps: 3,000 periods that decay take half of them)
NOTHING, PATIENCE = 1e-8, 40
#: steps in which forces are compared; part of them that jumps; size of a jump relative to the range of the force
SAMPLE, OFTEN, JUMP = 128, 0.05, 0.5


@dataclass(frozen=True)
class Stall:
    """A run that stands still."""

    steps: int  #: number of the last steps
    advance: float  #: [s] the time by which they advance the run
    law: str = ""  #: name of a component whose force jumps between them; "" if none is known
    switches: tuple[Switch, ...] = ()  #: conditions that change between them
    coordinate: str = ""  #: if no law is known: the coordinate on which a force jumps; "" if none does


class Standstill:
    """Examines a run with controlled steps; ``found`` is the reason if it stands still."""

    def __init__(self, run: RunState) -> None:
        self._run = run
        self._since = run.steps, run.time
        self._idle = 0  # number of the last examinations in succession that have found less than NOTHING
        self.found: Stall | None = None

    def look(self, status: int, call: Callable[[int], int]) -> int:
        """The status of the run, STALLED if it stands still; ``call(n)`` takes n more steps and returns a status."""
        run = self._run
        (steps, t), span = self._since, run.span
        taken, advance = run.steps - steps, run.time - t
        if status != S.RUNNING or 0 <= taken < WINDOW:
            return status
        self._since = run.steps, run.time
        mean = advance / taken if taken > 0 else np.inf  # the run may have returned to an earlier step
        self._idle = self._idle + 1 if advance < NOTHING * span and taken > 0 else 0
        if taken > 0 and run.time == t:
            self._idle = PATIENCE  # steps below the rounding error of time
        if mean > SHORT * run.reals[S.MOST_H] or run.stop - run.time < MANY * mean:
            return status
        rows = [self._row()]
        for _ in range(SAMPLE):
            status = call(1)
            if status != S.RUNNING:
                return status
            if run.time > rows[-1][0]:  # no attempt that was rejected
                rows.append(self._row())
        self.found = self._cause(np.array(rows), taken, advance)
        if self.found.law or self.found.coordinate or self._idle >= PATIENCE:
            return STALLED
        return status

    def _row(self) -> Array:
        return np.concatenate([[self._run.time], *self._run.state()])

    def _cause(self, rows: Array, steps: int, advance: float) -> Stall:
        """The force that jumps most often in the recorded states (N, 1 + 2 n + m + p)."""
        run, system = self._run, self._run.system
        run.synchronise()
        t, q, v, lam = np.split(rows, np.cumsum([1, system.n, system.n]), axis=1)
        t = t[:, 0]
        owners = laws(system)
        inputs = {name: np.full(len(t), run.numbers[at]) for name, at in system.tables.inputs.items()}
        expressions = [law for _, law in owners]
        found = values(system, expressions, t, q, v, lam, inputs)
        last_q, last_v, last_lam = (np.ascontiguousarray(np.broadcast_to(x[-1], x.shape)) for x in (q, v, lam))
        held = values(system, expressions, t, last_q, last_v, last_lam, inputs)
        often = [_of_state(force, of_time) for force, of_time in zip(found, held, strict=True)]
        if often and max(often) > OFTEN * len(t):
            law = owners[int(np.argmax(often))][0]
            states = np.array([system.switches(*state) for state in zip(t, q, v, lam, strict=True)])
            changing = (states != states[:1]).any(axis=0) if states.size else ()
            known = zip(system.tables.switches, changing, strict=True)
            return Stall(steps, advance, law, tuple(switch for switch, changes in known if changes))
        forces = np.array([system.Q(*state) for state in zip(t, q, v, strict=True)])
        held = np.array([system.Q(time, q[-1], v[-1]) for time in t])
        often = [_of_state(force, of_time) for force, of_time in zip(forces.T, held.T, strict=True)]
        name = system.names()[int(np.argmax(often))] if often and max(often) > OFTEN * len(t) else ""
        return Stall(steps, advance, coordinate=name)


def laws(system: System) -> list[tuple[str, Expr]]:
    """Names of components, and the expressions that give their forces."""
    found = [
        (c.name, law)
        for c in system.scene.components.values()
        for law in (*(c.values[p.name] for p in c.kind.parameters if p.law), c.friction)
    ]
    return [(name, law) for name, law in found if isinstance(law, Expr)]


def _of_state(force: Array, held: Array) -> int:
    """Number of jumps of a force (N,); 0 if it jumps while the state is ``held``, as a function of time."""
    return 0 if _jumps(held) > OFTEN * len(held) else _jumps(force)


def _jumps(force: Array) -> int:
    """How often a force (N,) jumps back: by more than JUMP of its range, and against the jump before."""
    change, size = np.diff(force), np.abs(force).max(initial=0.0)
    width = float(np.ptp(force))
    if not width > JUMP * size:  # nan as well; a small change of a large force moves nothing
        return 0
    jumps = np.sign(change[np.abs(change) > JUMP * width])
    return int((jumps[1:] != jumps[:-1]).sum())
