"""Friction that sticks: which joints of a run slide, and which are held.

At an event, joints that are at rest are held or begin to slide. A set of modes fits if the accelerations that follow
from it do: no joint that is held needs more than mu_s N, and no joint that slides is accelerated against its sliding.
The modes with the fewest changes are tried first; joints that arrive at rest count as held. Friction and reactions are
those of the equations of motion at this state.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.integrators.start_values import onto_constraints
from mbdsl.mechanism.sticking import EDGE, HELD, MARGIN, PLACE, SLIDING, number
from mbdsl.numerics.saddle_point import dense
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.signals import gradients, values

Array = NDArray[np.float64]
Modes = tuple[int, ...]

#: joints at rest up to which all modes are tried; with more of them, one joint after the other changes its mode
MOST_TRIED = 5
#: speed that counts as rest: this part of the size of the mechanism over the run, and of its largest velocity
OF_SIZE, OF_SPEED = 1e-9, 1e-10
#: part of it that is left by rounding where joints were stopped
ROUNDED = 1e-3
DEPENDENT = 1e-9  #: singular value of rows of length one that counts as zero
#: acceleration against the sliding, relative to the largest, that is rounding
ROUNDING = 1e-9


class UndecidedFrictionError(InitialisationError):
    """No modes of joints at rest fit, or their friction is not unique."""


class FrictionSet:
    """The joints of ``system`` whose friction sticks, in a run."""

    def __init__(self, system: System) -> None:
        self.system, self.joints = system, system.scene.sticking
        self.rows = [system.tables.rows[x.row] for x in self.joints]
        self.span = 1.0

    def begin(self, t: float, span: float, q: Array, v: Array, state: dict[str, float]) -> None:
        """Set the sense of sliding at the start of a run of ``span`` [s]; nothing is held before the first event."""
        self.span = span or 1.0
        rates, slow = self._rates(t, q, v), self._slow(v)
        for x, rate in zip(self.joints, rates, strict=True):
            state[number(x.name, SLIDING)] = float(np.sign(rate)) if abs(rate) > slow else 0.0

    def left_out(self, left_out: tuple[int, ...], state: dict[str, float]) -> tuple[int, ...]:
        """The rows that are left out: those of ``left_out`` that hold no joint, and of joints that are not held."""
        inactive = (row for x, row in zip(self.joints, self.rows, strict=True) if not state[number(x.name, HELD)])
        return tuple(sorted({*(row for row in left_out if row not in self.rows), *inactive}))

    def act(self, t: float, q: Array, v: Array, left_out: tuple[int, ...], state: dict[str, float]) -> Array:
        """The velocities (n,) behind the event at time t; sets modes and places in ``state``.

        Raises
        ------
        UndecidedFrictionError
            If no modes fit.
        """
        rates, slow = self._rates(t, q, v), self._slow(v)
        before = [int(state[number(x.name, SLIDING)]) for x in self.joints]
        resting = [k for k, (s, rate) in enumerate(zip(before, rates, strict=True)) if s == 0 or s * rate <= slow]
        edges = dict.fromkeys((number(x.name, EDGE) for x in self.joints), slow)
        if not resting:
            state.update(edges)
            return v
        places = values(self.system, [x.coordinate for x in self.joints], np.array([t]), q[None], v[None])
        for k in resting:
            if not state[number(self.joints[k].name, HELD)]:
                state[number(self.joints[k].name, PLACE)] = float(places[k][0])
        moving = np.abs(rates[resting]).max() > ROUNDED * slow
        at_rest = self._stopped(t, q, v, left_out, state, resting) if moving else v
        # a joint that has just begun to slide is at rest as well, but goes on
        past = [before[k] if before[k] * rates[k] >= 0.0 else 0 for k in resting]
        for modes in self._tried(past):
            self._set(state, resting, modes, edges)
            if self._fits(t, q, at_rest, left_out, state, resting, modes):
                return at_rest
        names = ", ".join(f"`{self.joints[k].name}`" for k in resting)
        raise UndecidedFrictionError(
            f"friction of {names} at t = {t:.9g} s: neither rest nor sliding agrees with the reactions",
            self.joints[resting[0]].span,
            "with large coefficients of friction there may be no solution (Painleve's paradox)",
        )

    def _tried(self, past: list[int]) -> Iterator[Modes]:
        """The modes of joints at rest, those with the fewest changes first."""
        if len(past) <= MOST_TRIED:
            every = product((0, 1, -1), repeat=len(past))
            yield from sorted(every, key=lambda modes: sum(a != b for a, b in zip(modes, past, strict=True)))
            return
        self._advice: list[int] | None = None
        modes = list(past)
        for _ in range(3 * len(past)):
            yield tuple(modes)
            if self._advice is None:
                return
            modes, self._advice = self._advice, None

    def _set(self, state: dict[str, float], which: list[int], modes: Modes, edges: dict[str, float]) -> None:
        state.update(edges)
        for k, mode in zip(which, modes, strict=True):
            name = self.joints[k].name
            state[number(name, SLIDING)], state[number(name, HELD)] = float(mode), float(mode == 0)

    def _fits(
        self,
        t: float,
        q: Array,
        v: Array,
        left_out: tuple[int, ...],
        state: dict[str, float],
        which: list[int],
        modes: Modes,
    ) -> bool:
        """Whether accelerations and reactions agree with modes of the joints ``which``; they are set in ``state``."""
        system, joints = self.system, [self.joints[k] for k in which]
        rows = self.left_out(left_out, state)
        self._put(state, rows)
        if sum(mode == 0 for mode in modes) > 1:
            self._check_unique(t, q, v, rows, [k for k, mode in zip(which, modes, strict=True) if mode == 0])
        try:
            a, lam = accelerations(system, t, q, v, rows)
        except InitialisationError:
            return False
        inputs = {name: np.array([x]) for name, x in state.items()}
        found = values(system, [x.normal for x in joints], np.array([t]), q[None], v[None], lam[None], inputs)
        normal = [float(x[0]) for x in found]
        rate_of_rate = self._accelerations(t, q, v, a)
        tiny = float(np.finfo(float).tiny)
        largest = max(float(np.abs(a * system.tables.scale).max(initial=0.0)) * system.tables.size, tiny)
        advice, worst = list(modes), 0.0
        for i, (k, mode) in enumerate(zip(which, modes, strict=True)):
            if mode:
                over = -mode * rate_of_rate[k] / largest - ROUNDING
            else:
                force = float(lam[self.rows[k]])
                most = self.joints[k].mu_s * normal[i]
                over = abs(force) - most * (1.0 + 0.5 * MARGIN)
                over /= max(most, abs(force), tiny)
            if over > worst:
                advice, worst = list(modes), over
                advice[i] = 0 if mode else int(np.sign(lam[self.rows[k]]))
        self._advice = advice if worst > 0.0 else None
        return worst <= 0.0

    def _check_unique(self, t: float, q: Array, v: Array, left_out: tuple[int, ...], held: list[int]) -> None:
        """Check that joints which are held together are held by independent rows.

        Raises
        ------
        UndecidedFrictionError
            If not: their friction is not unique.
        """
        kept = np.delete(np.arange(self.system.m + self.system.p), left_out)
        J = dense(self.system.velocity_jacobian(t, q, v))[kept] / self.system.tables.scale
        J = J / np.maximum(np.linalg.norm(J, axis=1, keepdims=True), np.finfo(float).tiny)
        if np.linalg.matrix_rank(J, tol=DEPENDENT) < len(kept):
            names = ", ".join(f"`{self.joints[k].name}`" for k in held)
            raise UndecidedFrictionError(
                f"friction of {names} at t = {t:.9g} s is not unique: they hold the same motion",
                self.joints[held[0]].span,
                "let only one of them stick, with the friction of all of them",
            )

    def _put(self, state: dict[str, float], left_out: tuple[int, ...]) -> None:
        """Set rows and numbers of the System."""
        self.system.activate(left_out)
        for name in self.system.tables.inputs:
            if name in state:
                self.system.set_input(name, state[name])

    def _rates(self, t: float, q: Array, v: Array) -> Array:
        found = values(self.system, [x.rate for x in self.joints], np.array([t]), q[None], v[None])
        return np.array([float(x[0]) for x in found])

    def _slow(self, v: Array) -> float:
        """The speed of sliding that counts as rest, in m/s or rad/s."""
        size, scale = self.system.tables.size, self.system.tables.scale
        fastest = float(np.abs(v * scale).max(initial=0.0))
        return size * (OF_SIZE / self.span + OF_SPEED * fastest)

    def _stopped(
        self, t: float, q: Array, v: Array, left_out: tuple[int, ...], state: dict[str, float], which: list[int]
    ) -> Array:
        """The velocities with the joints ``which`` at rest; they are slow already."""
        held = {number(self.joints[k].name, HELD): 1.0 for k in which}
        rows = self.left_out(left_out, {**state, **held})
        self._put(state, rows)
        return onto_constraints(self.system, t, q, v, rows)[1]

    def _accelerations(self, t: float, q: Array, v: Array, a: Array) -> Array:
        """The rates of the rates of all joints, at accelerations a (n,)."""
        _, d_q, d_v = gradients(self.system, [x.rate for x in self.joints], t, q, v)
        return np.asarray(d_q @ v + d_v @ a, float)
