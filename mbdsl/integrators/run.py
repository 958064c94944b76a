"""One integration in progress: the buffers, the compiled loop, and ``advance``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from mbdsl import jit, layout
from mbdsl.errors import InitialisationError, UsageError
from mbdsl.integrators import declared, driver, linear, modules, sparse
from mbdsl.integrators.method import Start
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.emit import EVALUATE, INERTIA, TANGENT

Array = NDArray[np.float64]

#: advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out)
ADVANCE = jit.Signature(
    (
        *(EVALUATE, TANGENT, INERTIA, "int", "vector", "vector", "ints"),
        *("matrix", "matrix", "matrix", "vector", "ints", "matrix", "int matrix", "vector", "matrix"),
    ),
    gives="int",
)
#: h^3 times the jerk at the start, relative to the mechanism, beyond which it belongs to a transient
TRANSIENT = 1e-4
#: h omega up to which M^{-1} Q is of use: beyond, reactions are wrong by percents, and soon by more than they are
STIFFEST = 300.0
#: largest system that the dense solver with pivoting may take over
PIVOTING_LIMIT = 2000


def check_options(
    name: str, options: Mapping[str, float | None], constrained: bool = False, force: bool = False
) -> dict[str, float | None]:
    """Options of a method with defaults filled in.

    Raises
    ------
    UsageError
        For a parameter that the method does not have, a value outside its interval, values that do not go together, or
        (not with ``force``) a choice known to fail on constrained models.
    """
    method = declared(name)
    parameters = method.parameters
    values: dict[str, float | None] = {key: option.default for key, option in parameters.items()}
    for key, value in options.items():
        if value is None:
            continue
        if key not in parameters:
            has = ", ".join(parameters) or "no parameters"
            raise UsageError(f"{name} has no parameter {key}", hint=f"it has {has}")
        low, high = parameters[key].lower, parameters[key].upper
        if not low - 1e-12 <= value <= high + 1e-12:
            raise UsageError(
                f"{key} = {value:g} is outside [{low:g}, {high:g}] for {name}", hint=f"{key}: {parameters[key].doc}"
            )
        values[key] = float(value)
    if (wrong := method.check(values)) is not None:
        raise UsageError(f"{name}: {wrong}")
    if constrained and not force and (wrong := method.check_constrained(values)) is not None:
        raise UsageError(f"{name}: {wrong}", hint="to see it happen: --force, in Python force=True")
    return values


def loop_name(method: str) -> str:
    """The name under which the compiled step loop of a method is kept."""
    return "mbdsl_method_" + modules()[method].__name__.rsplit(".", 1)[-1]


def compiled(name: str, module: ModuleType) -> Callable:
    """The step loop compiled for one method: its kernels are known to the compiler, the scene's are pointers."""
    short = module.__name__.rsplit(".", 1)[-1]
    if hasattr(module, "advance"):  # it brings a step loop of its own
        text = f'''"""Emitted by mbdsl: the step loop of {name}."""

from mbdsl.integrators import {short} as method


def advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out):
    return method.advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out)
'''
        return jit.functions(loop_name(name), text, {"advance": ADVANCE}, lambda: [module])[0]
    text = f'''"""Emitted by mbdsl: the step loop of {name}."""

from mbdsl.integrators import driver
from mbdsl.integrators import {short} as method


def advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out):
    return driver.advance(
        method.motion, method.residual, method.matrix, method.correct, method.finish,
        evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out,
    )
'''
    return jit.functions(loop_name(name), text, {"advance": ADVANCE}, lambda: [driver, module])[0]


def rate(after: Callable[[float], Array], now: Array, e: float) -> Array:
    """The rate of a quantity (n,) at the start, by one-sided differences over the time e; zero where there is none."""
    try:
        found = (4 * after(e) - after(2 * e) - 3 * now) / (2 * e)
    except InitialisationError:
        return np.zeros_like(now)
    return found if np.isfinite(found).all() else np.zeros_like(now)


@dataclass
class Integration:
    """Buffers and compiled functions of one run from a consistent initial state.

    ``h`` is the step and divides stop - start; with a tolerance ``tol`` it is the longest step.
    """

    system: System
    method: str
    h: float
    start: float
    stop: float
    times: Array  #: output times after the start
    options: Mapping[str, float | None] = field(default_factory=dict)
    left_out: tuple[int, ...] = ()
    tol: float | None = None
    pivoting_from: float | None = None  #: since when pivots are searched for, as the order from the graph lost one

    def __post_init__(self) -> None:
        module = modules()[self.method]
        declaration = module.METHOD
        self.matrices = declaration.matrices
        self._use(linear.SPARSE_LU)
        options = check_options(self.method, self.options, force=True)
        self.c = np.array(declaration.coefficients(options), float)
        self.K = np.zeros(driver.K_SIZE)
        self.J = np.zeros(driver.J_SIZE, np.int64)
        self.out = np.zeros((len(self.times), self.system.n + self.system.unknowns))
        steps = round((self.stop - self.start) / self.h)
        self.K[driver.START], self.K[driver.STOP], self.K[driver.H] = self.start, self.stop, self.h
        self.K[driver.T] = self.K[driver.NOW] = self.start
        self.K[driver.TOL] = self.tol or 0.0
        self.K[driver.CONTRACTION] = 0.1
        # parts of h times the speed, of the local error, and of the size: where a rings, its differences say nothing
        # (All but the stabilised index-2 methods find reactions from what 1/h^2 magnifies.)
        self.K[driver.VELOCITY_TOL : driver.LOOSEST + 1] = 8e-12, 1e-5 if declaration.sets == 2 else 1e-6, 1e-11
        # What turns unknowns and residuals into positions; the largest change of an unknown from step to step, as a
        # position, that means anything: of an acceleration, no motion worth following has it.
        self.K[driver.UNIT], self.K[driver.WILD] = self.h**2, 25.0
        if declaration.order == 0:
            # There is no local error, and nothing that is left adds up over steps; but there are other assemblies, and
            # who makes steps so large may end up in one.
            self.K[driver.RELATIVE_TOL : driver.WILD + 1] = 1e300, 4e-15, 1.0, 0.5
        self.J[driver.LAST_STEP] = steps
        self.J[driver.STABILISED] = declaration.sets > 1
        sets = declaration.sets
        code, loop = self.system.module_name(sets), loop_name(self.method)
        # What has to be compiled is compiled side by side: the scene's code elsewhere, the method's loop here.
        both = not jit.is_compiled(code) and not jit.is_compiled(loop)
        other = self.system.compile_beside(sets) if both else None
        self._advance = compiled(self.method, module)
        if other is not None:
            other.wait()
        kernels = self.system.kernels(sets)
        self.evaluate, self.tangent, self.inertia = kernels.evaluate, kernels.tangent, kernels.inertia

    def _use(self, solver: int) -> None:
        """Lay out the buffers for a solver; the vectors keep their content."""
        system, N = self.system, self.system.unknowns
        rows, columns = system.tables.pattern
        if solver == linear.SPARSE_LU:
            pattern = sparse.analyse(N, rows, columns, system.elimination_order())
            slots, size, length, table = pattern.slots, pattern.size, pattern.length, pattern.table
        else:
            slots, size, table = rows * N + columns, N * N, np.empty(0, np.int64)
            length = size + 2 * N  # the scales of rows and columns
        method = modules()[self.method].METHOD
        work = system.workspace(slots, layout.ROWS + method.rows)
        kept = self.I[layout.KEEP] if hasattr(self, "I") else 0
        if hasattr(self, "Y"):
            work.Y[:], work.Z[:], work.C[:], work.F[:] = self.Y, self.Z, self.C, self.F
        self.Y, self.Z, self.C, self.F = work.Y, work.Z, work.C, work.F
        self.I = np.concatenate([work.I, table])
        self.I[layout.SOLVER], self.I[layout.SPARSE], self.I[layout.SIZE] = solver, len(work.I), size
        self.I[layout.LAM_ROW], self.I[layout.MU_ROW], self.I[layout.LAW_ROW] = method.multipliers
        self.I[layout.INERTIA_ROW], self.I[layout.INERTIA_ROW2] = method.inertia_rows
        self.I[layout.MASS_ROW], self.I[layout.TANGENT_ROW] = method.mass_row, method.tangent_row
        self.I[layout.PSI_ROW], self.I[layout.KEEP] = layout.X, kept
        self.A = np.zeros((self.matrices, length + 1))  # the last entry is the method's own
        self.P = np.zeros((self.matrices, max(N, 2 * size + 1)), np.int64)  # pivots, or rows and columns of entries
        self.solver = solver
        self._leave_out()

    def _leave_out(self) -> None:
        m = self.system.m
        for row in self.left_out:
            if row < m:
                self.I[self.I[layout.PAIRS] + layout.PAIR * row + 5] = 1
            else:
                self.I[self.I[self.I[layout.GAMMAS] + row - m] + 3] = 1

    def begin(self, q: Array, v: Array, a: Array, lam: Array, left_out: tuple[int, ...] = ()) -> None:
        """Set the consistent state at the start, and the redundant constraints that are not solved for.

        Raises
        ------
        InitialisationError
            If the method needs a mass for every coordinate and one has none.
        """
        self.left_out = left_out
        self._leave_out()
        system, t0, Y, e = self.system, self.start, self.Y, 1e-3 * self.h
        n, mass, scale = system.n, system.mass(), system.tables.scale
        method = modules()[self.method].METHOD
        if method.inverts_mass and not (mass > 0.0).all():
            name = system.names()[int(np.flatnonzero(~(mass > 0.0))[0])]
            raise InitialisationError(
                f"{self.method} divides forces by masses, but {name} has none",
                hint="give it a mass, or take another method",
            )
        if method.inverts_mass:
            self._check_stiffness(q, v, lam)

        def motion(s: float) -> tuple[Array, Array]:
            return q + s * v + s * s / 2 * a, v + s * a

        def applied(s: float) -> Array:
            return self._applied(t0 + s, *motion(s), lam)

        def largest(x: Array) -> float:
            return float(np.abs(x * scale).max(initial=0.0))

        fa = applied(0.0)
        jerk = rate(lambda s: accelerations(system, t0 + s, *motion(s), left_out)[0], a, e)
        fa_rate = rate(applied, fa, e)
        stiff = self.h * largest(jerk) > largest(a) and self.h**3 * largest(jerk) > TRANSIENT
        if stiff:  # a method damps what it cannot follow, but must not be thrown off by it
            jerk, fa_rate = np.zeros(n), np.zeros(n)
        Y[layout.Q0, :n] = Y[layout.Q, :n] = q
        Y[layout.V0, :n] = Y[layout.V, :n] = v
        Y[layout.F0, :n] = system.M(t0, q) @ a
        start = Start(self.h, q, v, a, lam, fa, jerk, fa_rate, stiff)
        for row, vector in method.begin(self.c, start).items():
            Y[row, : len(vector)] = vector
        Y[layout.X] = Y[layout.XA]
        Y[layout.X2] = Y[layout.XA + layout.PAST]
        # what the start's own evaluation finds is the past of the first step
        self.evaluate(t0, Y, self.Z, self.C, self.F, self.I)
        self.I[layout.KEEP] = 1
        self.J[driver.HISTORY] = 1

    def _check_stiffness(self, q: Array, v: Array, lam: Array) -> None:
        """What M^{-1} Q makes of the rounding of q must be less than what the reactions are."""
        system = self.system
        K, M = system.stiffness(self.start, q, v, lam).diagonal(), system.M(self.start, q).diagonal()
        fastest = np.sqrt(np.maximum(K / M, 0.0))
        k = int(fastest.argmax()) if system.n else 0
        if system.n and self.h * fastest[k] > STIFFEST:
            raise InitialisationError(
                f"{self.method} finds reactions from M^-1 Q, where rounding is magnified by what is stiff: of "
                f"{system.names()[k]} with {fastest[k]:.1e} rad/s, {self.h * fastest[k]:.0f} times 1/h",
                hint=f"a step below {STIFFEST / fastest[k]:.2g} s, no such (axial?) mode, or another method",
            )

    def _applied(self, t: float, q: Array, v: Array, lam: Array) -> Array:
        """fa = M^{-1} Q (n,), with the forces of nonholonomic constraints."""
        force = self.system.evaluate(t, q, v, lam)[0] + self.system.constraint_force(t, q, lam[: self.system.m])
        return self.system.solve_mass(t, q, force)

    def change_inputs(self, inputs: Mapping[str, float]) -> None:
        """From here on the inputs have other values; accelerations and forces jump by what that makes of them.

        What a method keeps of the past is linear in them, so that order 2 is kept over any number of jumps.
        """
        system, Y, n = self.system, self.Y, self.system.n
        t, q, v = self.time, Y[layout.Q0, :n], Y[layout.V0, :n]
        used = {name: value for name, value in inputs.items() if name in system.tables.inputs}
        for name, at in system.tables.inputs.items():
            system.set_input(name, self.F[at])  # whoever looked at another time has left it there
        for body in system.tables.models.values():
            for at in body.turns:
                system.set_number(at, self.F[at])
        before = accelerations(system, t, q, v, self.left_out)
        fa = self._applied(t, q, v, before[1])
        for name, value in used.items():
            system.set_input(name, value)
            self.F[system.tables.inputs[name]] = value
        after = accelerations(system, t, q, v, self.left_out)
        a, lam = after[0] - before[0], after[1] - before[1]
        fa = self._applied(t, q, v, after[1]) - fa
        nothing = np.zeros(n)
        jump = Start(self.h, nothing, nothing, a, lam, fa, nothing, nothing, False)
        rows = {layout.F0: system.M(t, q) @ a, **modules()[self.method].METHOD.begin(self.c.copy(), jump)}
        for row, change in rows.items():
            past = layout.PAST if row in (layout.XA, layout.XA + layout.PAST) else 1
            Y[row : row + past, : len(change)] += change

    @property
    def time(self) -> float:
        """The time reached [s]."""
        return float(self.K[driver.NOW] if self.tol else self.K[driver.START] + self.J[driver.STEP] * self.h)

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self.J[driver.STEP])

    @property
    def written(self) -> int:
        """Outputs written to ``out``."""
        return int(self.J[driver.OUTPUT])

    def count(self, what: str) -> int:
        """How many "rejected", "iterations", "matrix_evaluations" or "factorisations"."""
        return int(self.J[driver.COUNTERS[what]]) if what in driver.COUNTERS else 0

    def state(self) -> tuple[Array, Array, Array]:
        """q, v (n,) and lam (m + p,) as they are now; views."""
        n, Y = self.system.n, self.Y
        return Y[layout.Q0, :n], Y[layout.V0, :n], Y[layout.XA, n : self.system.unknowns]

    def advance(self, steps: int = sys.maxsize) -> int:
        """Take at most ``steps`` steps; a status of :mod:`mbdsl.integrators.driver`."""
        status = self._call(steps)
        if status == driver.SINGULAR and self.solver == linear.SPARSE_LU and self.system.unknowns <= PIVOTING_LIMIT:
            # The order from the graph gave no usable pivots here: go on with a solver that searches for them.
            self._use(linear.DENSE)
            self.pivoting_from = self.time
            self.J[driver.FRESH] = 0
            status = self._call(steps)
        return status

    def _call(self, steps: int) -> int:
        return int(
            self._advance(
                self.evaluate,
                self.tangent,
                self.inertia,
                steps,
                self.c,
                self.K,
                self.J,
                self.Y,
                self.Z,
                self.C,
                self.F,
                self.I,
                self.A,
                self.P,
                self.times,
                self.out,
            )
        )
