"""A part of a scene with its equations and its run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from mbdsl.initial.consistent import InitialState
from mbdsl.integrators import Run, backend
from mbdsl.integrators.loop.compiled_loop import controls_locally
from mbdsl.integrators.run import MethodRun
from mbdsl.integrators.single_steps import STEPS
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.reduction import Part
from mbdsl.simulation import derived_signals
from mbdsl.simulation.plan import Plan
from mbdsl.system import System

KINEMATIC = "kinematic"
#: tolerances of runs with fixed steps that end at events: errors shorten no step; of methods with a step of their own
NOMINAL, LOOSE = 1e-6, 1e6
#: q, v (N, n) and lam (N, m + p)
State = tuple[Array, Array, Array]


@dataclass
class PartRun:
    """A part with its equations."""

    part: Part
    system: System
    method: str
    initial: InitialState
    integration: Run

    @property
    def first(self) -> Array:
        """The row (1, 2 n + m + p) of outputs at the start, behind the event there."""
        begun = getattr(self.integration, "begun", None)
        return np.concatenate(begun or (self.initial.q, self.initial.v, self.initial.lam))[None]

    @property
    def last(self) -> Array:
        """The row (1, 2 n + m + p) at the present time."""
        return np.concatenate(self.integration.state())[None]

    def split(self, rows: Array) -> State:
        """q, v (N, n) and lam (N, m + p) of rows of outputs."""
        n = self.system.n
        return rows[:, :n], rows[:, n : 2 * n], rows[:, 2 * n :]

    def accelerations(self, t: Array, q: Array, v: Array) -> Array | None:
        """Those (N, n) of the equations of motion at N states; None if they depend on more than the states."""
        if self.system.tables.inputs or self.system.counts_angles or self.method == KINEMATIC:
            return None
        return derived_signals.motion(self.system, t, q, v, self.initial.redundant, {})[0]


def run_of(system: System, method: str, plan: Plan, options: Mapping[str, float | None], keeps: bool = False) -> Run:
    """A part's run, by compiled code, which may keep its steps, or by a backend."""
    arguments = system, method, plan.h, plan.start, plan.stop, plan.times, options
    if backend(method) is not None:
        from mbdsl.integrators.backends import External

        return External(*arguments, tol=plan.tol, every=plan.every, longest=plan.longest)
    tol, grid, longest = plan.tol, 0.0, plan.longest
    span = STEPS * plan.h if plan.single else 0.0
    if tol is None and system.scene.has_events:  # steps of a fixed size, which events shorten
        if controls_locally(method):
            tol, grid = NOMINAL, plan.h
        else:
            tol, longest = LOOSE, min(longest, plan.h)
    own = partial(MethodRun, *arguments, tol=tol, every=plan.every, longest=longest)
    return own(grid=grid, span=span, rows=plan.rows, keeps=keeps)
