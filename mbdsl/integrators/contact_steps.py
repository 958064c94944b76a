"""Steps of the method of Moreau and Jean; its equations are in :mod:`mbdsl.integrators.methods.moreau_jean`.

With C = theta h D + theta^2 h^2 K, where D = -Q_v and K = -Q_q, and J the rows of the constraints that are no contacts,
a step solves

    [[M + C, J^T - Q_lam], [J, 0]] [dv; h dlam] = [s + W^T P; c]

for s = h Q at first, and until it has converged for s = h Q(q_theta, v_theta) + C dv. The rows J in the first line are
those of q_theta; in the second line they are those of q_{n+1}, once a first solution is known. With X the solution for
s = W^T, c = 0, Delassus's matrix is G = W X, and the velocities of contacts are u = u_free + G P.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import IntegrationError, UsageError
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.integrators.backends import Problem
from mbdsl.integrators.contact_errors import unsolvable
from mbdsl.integrators.contact_record import ContactRecord, ContactStep
from mbdsl.integrators.step_equations import ClosedContacts, OwnForces, StepEquations, StepSolution, StepStart
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism.contacts import FRICTION
from mbdsl.numerics.contact_modes import OPEN, STICK, Contacts, Modes
from mbdsl.numerics.first_change import first_change
from mbdsl.numerics.impact import UnsolvableError, in_sequence, separating
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.accelerations import balance
from mbdsl.system.driven_contacts import drivers_at_fault

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
NO_SWITCHES = np.zeros(0, np.int64)

NEAR = 1e-9  #: gap, relative to the mechanism's size, below which a contact is closed
REST = 1e-10  #: speed of a gap, relative to the fastest motion, that counts as rest
AGREED = 1e-8  #: change of the velocities by the last iteration for forces, relative to that within the step
ROUNDING = 1e-13  #: this change relative to the velocities
ARRIVED = 1e-12  #: last correction of positions and velocities by the constraints, relative to size and speed
SEQUENCE = 40  #: impacts that are solved one after another in a step; the others are then solved at once
FROZEN, MOST = 8, 40  #: iterations with the same matrix; most iterations of a step
MEAN = 1e-12  #: tolerance for the weight of one of the two forces at a jump in their mean
NOT_FINITE = "the forces have values that are not finite"
SINGULAR = "the equations of motion are singular"
OF_SINGULAR = "a body without mass or inertia moves freely, or the pose is singular"
DIVERGES = "the iteration for the forces of a step does not converge"


class ContactSteps:
    """The steps of a run."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.system, self.events = problem, problem.system, problem.events
        system, theta = problem.system, problem.options["theta"]
        self.theta = 0.5 if theta is None else theta
        self.contacts = system.scene.contacts
        self.rows = system.tables.contact_rows
        self.normals = np.array([rows[0] for rows in self.rows], int)
        self.e = np.array([c.e for c in self.contacts])
        self.present = np.array([not c.absent for c in self.contacts], bool)
        self.mu, self.mu_s = (np.array([getattr(c, x) for c in self.contacts]) for x in ("mu", "mu_s"))
        self.sequential = all(c.sequential for c in self.contacts)
        out = {*problem.left_out, *(row for rows in self.rows for row in rows)}
        self.kept = np.array([row for row in range(system.m + system.p) if row not in out], int)
        self.lam = np.where(np.isin(np.arange(system.m + system.p), self.kept), problem.lam, 0.0)
        self.record = ContactRecord(system, problem.events, problem.stop - problem.start)
        self.modes = self.record.first_modes()  #: of the last step
        self.P = np.zeros(system.m + system.p)  #: impulses of contacts in the last step, at their rows
        self.scale = system.tables.scale
        own = {x.condition for x in self.contacts}
        #: which switches change forces
        self.jumps = np.array([x.of_force and x.node not in own for x in system.tables.switches], bool)
        self._balance: Array | None = None
        self._check_laws()

    def _check_laws(self) -> None:
        scene, own = self.system.scene, {c.name for c in self.contacts}
        cylinder = next((c for c in self.contacts if c.aim), None)
        if cylinder is not None:
            raise UsageError(
                f"time stepping does not support `{cylinder.name.rpartition('.')[0]}`, a rigid cylinder: the points on "
                "which it stands are set at events, which this method does not locate",
                cylinder.span,
                "use another method, such as hht-si2, or give it a stiffness `k`",
            )
        for c in scene.components.values():
            laws = [x for p in c.kind.parameters if p.law and isinstance(x := c.values[p.name], Expr)]
            read = {leaf.value[0] for leaf in leaves(*laws) if leaf.op == "multiplier"} & own
            if read and c.kind.name != FRICTION:
                raise UsageError(
                    f"time stepping solves the reaction of `{min(read)}` as an impulse: {c.kind.name} `{c.name}` "
                    "cannot read it",
                    c.span,
                    "take another method, such as hht-si2",
                )

    def states(self) -> Iterator[tuple[float, Array, Array, Array]]:
        """Yield t, q, v and lam at the ends of all steps."""
        problem, t, q, v = self.problem, self.problem.start, self.problem.q, self.problem.v
        switches = self._switches(t, q, v)
        for end in problem.times.tolist():
            with np.errstate(all="ignore"):
                try:
                    q, v = self.step(t, q, v, end - t)
                except UnsolvableError as error:
                    raise self._unsolved(t, q, v, error.which) from None
            t = end
            problem.counts["steps"] += 1
            if self.events is not None and self.events.events:
                found = self._switches(t, q, v)
                if (found != switches).any() or self.events.ticks_by(t + 1e-9 * problem.h):
                    self.events.reactions = self._lam(problem.h)
                    v = self.events.act(t, q, v, self._left_out)
                    problem.counts["events"] += 1
                    found = self._switches(t, q, v)
                switches = found
            yield t, q, v, self._lam(problem.h)

    def _unsolved(self, t: float, q: Array, v: Array, which: tuple[int, ...]) -> IntegrationError:
        """The error of a step from this state, with contacts (numbers) whose laws have no solution."""
        drivers = drivers_at_fault(self.system, t, q, v, self.normals[list(which)].tolist(), self._left_out)
        found = unsolvable("impulses", [self.contacts[i] for i in which], "", drivers)
        return IntegrationError(found.message, found.span, found.hint, found.notes)

    @property
    def _left_out(self) -> tuple[int, ...]:
        return tuple(np.setdiff1d(np.arange(self.system.m + self.system.p), self.kept).tolist())

    def _switches(self, t: float, q: Array, v: Array) -> Rows:
        return self.system.switches(t, q, v, self._lam(self.problem.h))

    def _lam(self, h: float) -> Array:
        """The multipliers (m + p,) of the last step."""
        return self.lam + self.record.multipliers / h

    # -- one step ------------------------------------------------------------------------------------------------------

    def step(self, t: float, q: Array, v: Array, h: float) -> tuple[Array, Array]:
        """q and v (n,) after a step.

        Raises
        ------
        IntegrationError
            If the equations have no solution, or an iteration does not converge.
        """
        system, far, start = self.system, self.theta * h, StepStart(t, q, v, h)
        f, phi, rate = self._at(t + far, system.moved(q, far * v), v)
        if not np.isfinite(f).all():
            raise IntegrationError(NOT_FINITE, hint="try a shorter step")
        matrix, linear = self._linear(t + far, h)
        which = np.flatnonzero((phi[self.normals] <= NEAR * system.tables.size) & self.present)
        rows = [row for i in which for row in self.rows[i]]
        s, c = h * f, -rate[self.kept]
        fastest = self._largest(v) + self._largest(linear.inverse[: system.n] @ np.concatenate([s, c]))
        W, slow = matrix[[system.n + row for row in rows], : system.n], REST * fastest * system.tables.size
        touching = ClosedContacts(which, rows, W, rate[rows], slow)
        found = self._struck(linear, touching, s, c)
        if len(self.kept) and (changed := self._constrained(start, linear, found)) is not None:
            linear, c = changed
            found = self._struck(linear, touching, s, c)
        linear, found = self._forced(start, linear, touching, found, c)
        q, v = self._projected(start, linear, found)
        self.lam[self.kept] = self._multipliers(found.x, h)
        self._keep(t + h, touching, found)
        return q, v

    def _keep(self, t: float, touching: ClosedContacts, found: StepSolution) -> None:
        """Enter what the contacts did in the step to time t, and remember it for the next step."""
        which, rows, W, u, slow = touching
        behind = u + W @ found.x[: self.system.n]
        self.record.enter(t, ContactStep(which, self._friction(which), u, behind, found.P, found.modes, slow))
        self.P[:], self.modes[:] = 0.0, OPEN
        self.P[rows], self.modes[which] = found.P, found.modes

    def _end(self, start: StepStart, x: Array) -> tuple[Array, Array]:
        dv = x[: self.system.n]
        return self.system.moved(start.q, start.h * (start.v + self.theta * dv)), start.v + dv

    def _multipliers(self, x: Array, h: float) -> Array:
        """Those (k,) of the constraints of a solution x."""
        change = x[self.system.n :] / h
        return change + self.lam[self.kept] if self.system.of_multipliers else change

    def _at(self, t: float, q: Array, v: Array, lam: Array | None = None) -> tuple[Array, Array, Array]:
        """Forces (n,), Phi (m,), and the rates of all constraints (m + p,) at a state."""
        system, n, m = self.system, self.system.n, self.system.m
        if lam is None and system.of_multipliers:
            lam = self.lam
        work = system._at(t, q, v, lam).vectors
        rate = np.concatenate([work[L.FORCE2, n : n + m], work[L.FORCE, n + m : system.unknowns]])
        self.problem.counts["evaluations"] += 1
        return work[L.FORCE, :n].copy(), work[L.FORCE, n : n + m].copy(), rate

    def _linear(self, t: float, h: float) -> tuple[Array, StepEquations]:
        """The matrix of M and all rows (n + m + p, n + m + p) at the last evaluated state, and the equations of a
        step."""
        system, n, far = self.system, self.system.n, self.theta * h
        C = dense(system.matrix(system.entries(t, cK=far * far, cD=far)))[:n, :n]
        matrix = dense(system.matrix(system.entries(t, cM=1.0, cP=1.0, cV=1.0, cL=1.0)))
        A, U, J = matrix[:n, :n] + C, matrix[:n, n + self.kept], matrix[n + self.kept, :n]
        self.problem.counts["matrix_evaluations"] += 1
        if self._balance is None:
            self._balance = balance(system, matrix.diagonal()[:n], J)
        return matrix, StepEquations(A, C, U, J, self._inverse(A, U, J))

    def _inverse(self, A: Array, U: Array, J: Array) -> Array:
        n, d = self.system.n, self._balance
        assert d is not None
        K = np.zeros((len(d), len(d)))
        K[:n, :n], K[:n, n:], K[n:, :n] = A, U, J
        self.problem.counts["factorisations"] += 1
        try:
            found = d[:, None] * np.linalg.inv(d[:, None] * K * d) * d
        except np.linalg.LinAlgError:
            found = np.full_like(K, np.nan)
        if not np.isfinite(found).all():
            raise IntegrationError(SINGULAR, hint=OF_SINGULAR)
        return found

    def _forced(
        self, start: StepStart, linear: StepEquations, touching: ClosedContacts, found: StepSolution, c: Array
    ) -> tuple[StepEquations, StepSolution]:
        """The equations and the solution with the forces of the step's own motion, from a solution with others."""
        before = found
        for k in range(1, MOST):
            new = self._own(start, linear, found).s
            if self._agrees(start, linear, new - found.s, found):
                return linear, found
            if k > FROZEN and (mean := self._on_jump(start, linear, touching, (before, found), c)) is not None:
                return linear, mean
            self.problem.counts["iterations"] += 1
            if k % FROZEN == 0:
                former, (_, linear) = linear, self._linear(start.t + self.theta * start.h, start.h)
                linear = self._with_rows(linear, former.J)
                new = new + (linear.C - former.C) @ found.x[: self.system.n]
                if self.system.of_multipliers:
                    new += (linear.U - former.U) @ found.x[self.system.n :]
            before, found = found, self._struck(linear, touching, new, c)
        raise IntegrationError(DIVERGES, hint="try a shorter step, or forces that change less abruptly")

    def _agrees(self, start: StepStart, linear: StepEquations, change: Array, found: StepSolution) -> bool:
        """Whether a ``change`` of s hardly changes the velocities of a solution."""
        n = self.system.n
        error = self._largest(linear.inverse[:n, :n] @ change)
        return error <= AGREED * self._largest(found.x[:n]) + ROUNDING * self._largest(start.v)

    def _own(self, start: StepStart, linear: StepEquations, found: StepSolution, sides: bool = False) -> OwnForces:
        """The forces of the motion of a solution; with ``sides``, also the states of the switches."""
        (t, q, v, h), system, lam = start, self.system, None
        dv, rest = found.x[: system.n], found.x[system.n :]
        middle = v + self.theta * dv
        if system.of_multipliers:
            lam = self.lam.copy()
            lam[self.kept] = self._multipliers(found.x, h)
        at = t + self.theta * h, system.moved(q, self.theta * h * middle), middle
        f, _, _ = self._at(*at, lam)
        s = h * f + linear.C @ dv
        if lam is not None:  # forces contain -J^T lam
            s += linear.U @ rest
        if not sides:
            return OwnForces(s, NO_SWITCHES, dv)
        side = system.switches(*at, self.lam if lam is None else lam)
        return OwnForces(s, side[self.jumps], system.quantities())

    def _on_jump(
        self,
        start: StepStart,
        linear: StepEquations,
        touching: ClosedContacts,
        ends: tuple[StepSolution, StepSolution],
        c: Array,
    ) -> StepSolution | None:
        """The solution at a jump of forces, where those on each side drive the motion to the other side: a weighted
        mean of both (A. F. Filippov); None if there is none. ``ends``: solutions on both sides."""
        own = [self._own(start, linear, x, True) for x in ends]
        for _ in range(FROZEN):
            one, two = own
            last = dict[bool, OwnForces]()

            def look(part: float) -> tuple[bool, Array]:
                s = (1.0 - part) * one.s + part * two.s  # noqa: B023
                found = self._own(start, linear, self._struck(linear, touching, s, c), True)
                last[same := bool((found.side == two.side).all())] = found  # noqa: B023
                return same, found.quantities

            (low, at_low), (high, at_high) = look(0.0), look(1.0)
            if not low or high:
                return None
            part = first_change(look, 0.0, 1.0, (at_low, at_high), (0.0, MEAN))
            found = self._struck(linear, touching, (1.0 - part) * one.s + part * two.s, c)
            own = [last[False], last[True]]
            change = (1.0 - part) * (own[0].s - one.s) + part * (own[1].s - two.s)
            if self._agrees(start, linear, change, found):
                return found
        return None

    def _largest(self, x: Array) -> float:
        return float(np.abs(x * self.scale).max(initial=0.0))

    def _constrained(
        self, start: StepStart, linear: StepEquations, first: StepSolution
    ) -> tuple[StepEquations, Array] | None:
        """The equations with the rows J of the constraints at the end of the step, which a first solution shows, and
        their right-hand side c; None if they do not change."""
        n, t = self.system.n, start.t + start.h
        _, _, rate = self._at(t, *self._end(start, first.x))
        J = dense(self.system.matrix(self.system.entries(t, cP=1.0, cV=1.0)))[n + self.kept, :n]
        if (J == linear.J).all():
            return None
        return self._with_rows(linear, J), J @ first.x[:n] - rate[self.kept]

    def _with_rows(self, linear: StepEquations, J: Array) -> StepEquations:
        return linear._replace(J=J, inverse=self._inverse(linear.A, linear.U, J))

    def _projected(self, start: StepStart, linear: StepEquations, found: StepSolution) -> tuple[Array, Array]:
        """q and v at the end of the step, on the constraints."""
        n, m, t = self.system.n, self.system.m, start.t + start.h
        q, v = self._end(start, found.x)
        if not len(self.kept):
            return q, v
        holonomic = self.kept < m
        for _ in range(MOST):
            _, phi, rate = self._at(t, q, v)
            c = np.zeros((len(self.kept), 2))
            c[holonomic, 0], c[:, 1] = -phi[self.kept[holonomic]], -rate[self.kept]
            dq, dv = (linear.inverse[:n, n:] @ c).T
            if self._largest(dq) <= ARRIVED and self._largest(dv) <= ARRIVED * (self._largest(v) + self._largest(dv)):
                return q, v
            q, v = self.system.moved(q, dq), v + dv
        raise IntegrationError("the constraints cannot be satisfied at the end of a step", hint="try a shorter step")

    # -- contacts ------------------------------------------------------------------------------------------------------

    def _struck(self, linear: StepEquations, touching: ClosedContacts, s: Array, c: Array) -> StepSolution:
        """The solution for s (n,) and c (k,), with the impulses of the contacts."""
        x = linear.inverse @ np.concatenate([s, c])
        if not len(touching.which):
            return StepSolution(s, x, np.zeros(0), ())
        n, W = self.system.n, touching.W
        X = linear.inverse[:, :n] @ W.T
        P, modes = self._impulses(touching, W @ X[:n], touching.u + W @ x[:n])
        return StepSolution(s, x + X @ P, P, modes)

    def _friction(self, which: Rows) -> Array:
        """Coefficients of friction in a step: static ones of contacts that stuck in the step before."""
        return np.where(self.modes[which] == STICK, self.mu_s[which], self.mu[which])

    def _impulses(self, touching: ClosedContacts, G: Array, free: Array) -> tuple[Array, Modes]:
        """Impulses and modes; ``free``: the velocities that the forces alone give."""
        which, rows, _, u, slow = touching
        laws = Contacts(G, tuple(len(self.rows[i]) for i in which), self._friction(which))
        N = np.array(laws.first)
        approach = np.where(u[N] < -slow, -u[N], 0.0)
        try:
            speeds = self.e[which] * approach
            if self.sequential and approach.any():
                first = in_sequence(laws, u, self.e[which], SEQUENCE).P
                speeds = np.where(first[N] > 0.0, np.maximum((u + G @ first)[N], 0.0), 0.0)
            found = separating(laws, free, speeds, tuple(self.modes[which].tolist()), self.P[rows])
            return found.P, found.modes
        except UnsolvableError as error:
            raise UnsolvableError(tuple(int(which[i]) for i in error.which)) from None
