"""The motion of a run at and between the ends of its steps, from which extremes and means of signals follow.

Between two ends, coordinates are cubic Hermite polynomials, by which the methods with short steps interpolate as well.
Methods with several stages take long steps, and interpolate by polynomials of higher degree. Of these, the polynomials
here have degree 5, with the accelerations that the equations of motion give at the ends. Multipliers of a method are
linear, plus the deviation of those of the equations of motion from a straight line.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics.hermite import between
from mbdsl.simulation import derived_signals
from mbdsl.simulation.state_signals import StateSignals

NO_JUMPS = np.empty(0)
TOGETHER = 16  #: least number of states whose equations are solved together: a sweep does so thousands of times

if TYPE_CHECKING:
    Array = NDArray[np.float64]


class Steps:
    """The states at the ends of steps, and on both sides of jumps of forces.

    Parameters
    ----------
    ends : StateSignals
        These states, at ascending times.
    precise : bool
        Whether polynomials between them have degree 5.
    numbers : callable, optional
        Times (N,) -> the discrete variables of the model then.
    jumps : (K,) array, optional
        Times [s] at which one of these changes.
    """

    def __init__(
        self,
        ends: StateSignals,
        precise: bool,
        numbers: Callable[[Array], Mapping[str, Array]] = lambda t: {},
        jumps: Array = NO_JUMPS,
    ) -> None:
        self.ends, self.precise, self.numbers, self.jumps = ends, precise, numbers, jumps

    def at(self, t: Array, reactions: bool) -> StateSignals:
        """The motion at ascending times t (N,) [s], which the steps enclose; with ``reactions`` also those."""
        ends, system = self.ends, self.ends.system
        k = np.clip(np.searchsorted(ends.t, t, side="right") - 1, 0, max(0, len(ends.t) - 2))
        solve = self.precise or reactions
        if solve:
            self._solve(np.unique(np.concatenate([k, np.minimum(k + 1, len(ends.t) - 1)])))
        own = ends._lam
        known = np.zeros((len(ends.t), 0)) if own is None else own
        if reactions:
            known = np.concatenate([known, self._solved[1]], axis=1)
        a = self._solved[0] if self.precise else None
        q, v, lam = between(t, ends.t, ends.q, ends.v, known, system.tables.rotations[:, 0], a)
        found = StateSignals(system, t, q, v, None, ends.stats, (), ends.left_out, self.numbers(t))
        found._names, found._together = ends._names, TOGETHER
        if own is not None and reactions:
            linear, deviation = lam[:, : own.shape[1]], found._motion[1] - lam[:, own.shape[1] :]
            found._lam = np.where(np.isfinite(deviation), linear + deviation, linear)
        return found

    @cached_property
    def _solved(self) -> tuple[Array, Array]:
        """Accelerations (N, n) and multipliers (N, m + p) of the equations of motion, nan where they are not known."""
        system, N = self.ends.system, len(self.ends.t)
        return np.full((N, system.n), np.nan), np.full((N, system.m + system.p), np.nan)

    @cached_property
    def _done(self) -> NDArray[np.bool_]:
        return np.zeros(len(self.ends.t), bool)

    def _solve(self, k: NDArray[np.int64]) -> None:
        """Solve the equations of motion at the ends k."""
        k, ends = k[~self._done[k]], self.ends
        if not len(k):
            return
        numbers = {at: x[k] for at, x in ends._numbers.items()}
        a, lam, _ = derived_signals.motion(
            ends.system, ends.t[k], ends.q[k], ends.v[k], ends.left_out, numbers, TOGETHER
        )
        self._solved[0][k], self._solved[1][k], self._done[k] = a, lam, True
