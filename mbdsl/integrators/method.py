"""The declaration of an integration method, its start values, and the interface of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array

if TYPE_CHECKING:
    from mbdsl.system import System


#: kernels of a method with the common step, and their parameters; see :mod:`mbdsl.integrators.loop.multistep`
KERNELS = {
    "motion": "h, run",
    "residual": "h, run",
    "matrix": "t, h, run",
    "correct": "k, h, run",
    "finish": "h, run",
}
#: kernels of a method with its own step, recognised by ``take``; see :mod:`mbdsl.integrators.loop.driver`
STEP_KERNELS = {
    "trial_length": "run",
    "take": "t0, h, formulas, run",
    "interpolate": "k, x, h, out, run",
    "store": "h, run",
    "next_length": "error, h, times, formulas, run",
}
#: kernels of controlled steps, with defaults in :mod:`mbdsl.integrators.loop.step_control`
OPTIONAL_KERNELS = {"local_error": "h, last, c, jerk, snap", "change_step": "h, run"}


@dataclass(frozen=True)
class Option:
    """A parameter of a method: default (None: computed from the other parameters), bounds, and description."""

    default: float | None
    lower: float
    upper: float
    doc: str


@dataclass(frozen=True)
class Start:
    """The consistent initial state of a method at t_0: q, v, a (n,), lam (m + p,), and fa = M^{-1} Q (n,).

    Q excludes the constraint forces of Phi. ``jerk`` and ``fa_rate`` (n,) are the rates of a and fa. If the start is
    ``stiff``, a belongs to a transient that ends long before the first step does, and both rates are set to zero.
    """

    h: float
    q: Array
    v: Array
    a: Array
    lam: Array
    fa: Array
    jerk: Array
    fa_rate: Array
    stiff: bool


@dataclass(frozen=True)
class Method:
    """Declaration of an integration method.

    ``coefficients`` maps checked options to the numbers c that the kernels read; no kernel changes them. ``check``
    returns an error message if the values of the options do not go together, or None. ``check_constrained`` does so for
    constrained models; a user may override it (``force``). ``begin(c, start)`` returns the history that the first step
    needs: rows of ``vectors``, as vectors of n or N entries by row. ``memory(c, start)`` returns the other numbers that
    the method carries from step to step.

    ``sets`` is the number of sets of multipliers: lam in f; mu in Phi_q^T mu; psi in Phi_q^T psi with Phi_q at the
    start of the step. ``multipliers`` are the rows of ``vectors`` with lam, with mu, and with the multipliers that
    force laws read; psi is always in UNKNOWN. ``own_reactions`` is False if reactions have to be computed from the
    acceleration-level equations; ``inverts_mass`` is True if every coordinate needs a mass. Users can only choose
    methods that are ``chosen``. ``steps`` are "fixed", "controlled" (by an error estimate), or both. A method with
    both is error-controlled if neither a step nor a tolerance is given; if "controlled" comes first, it ignores the
    model's Step.

    A third-party integrator (see :mod:`mbdsl.integrators.backends`) has neither ``coefficients`` nor ``begin``. Its
    ``own_reactions`` is True if it yields multipliers, and ``needs`` names the software to be installed. If its order
    varies, ``order`` is the highest. ``knows`` are the kinds of events that it serves, of "when", "contacts" and
    "sticking"; compiled methods serve all. ``searches`` is True if its steps end in all ``Problem.zones`` and are
    searched for peaks of laws that depend on the state (:mod:`mbdsl.system.peaks_along_motion`).

    ``relative_step`` is the step size, relative to that of hht-si2, below which errors decrease with the order;
    verification scales its steps by it. ``stable`` is the largest h |lambda| at which steps are stable, lambda an
    eigenvalue of the equations; infinite for methods without such a limit. ``longest`` is the longest controlled step
    relative to the run, for models without expressions. ``diverges`` is appended to the error message if Newton's
    iteration diverges for a constrained model.
    """

    name: str
    doc: str
    order: int
    index: int
    enforces: tuple[str, ...]  #: constraint levels that are satisfied: "Phi", "dPhi"
    source: str
    coefficients: Callable[[Mapping[str, float | None]], tuple[float, ...]] = lambda options: ()
    memory: Callable[[Array, Start], tuple[float, ...]] = lambda c, start: ()
    begin: Callable[[Array, Start], Mapping[int, Array | list[float]]] = lambda c, start: {}
    parameters: Mapping[str, Option] = field(default_factory=dict)
    check: Callable[[Mapping[str, float | None]], str | None] = lambda options: None
    check_constrained: Callable[[Mapping[str, float | None]], str | None] = lambda options: None
    matrices: int = 1  #: number of iteration matrices, of ``run.matrices``
    coupled: bool = False  #: whether its two systems are solved as one where bodies in space turn far within a step
    multipliers: tuple[int, int, int] = (L.UNKNOWN, L.UNKNOWN2, L.UNKNOWN)
    sets: int = 1
    own_reactions: bool = True
    inverts_mass: bool = False
    mass_row: int = (
        L.POSITION  #: row of the coordinates at which M is evaluated; a row other than POSITION is read once a step
    )
    inertia_rows: tuple[int, int] = (L.UNKNOWN, L.UNKNOWN2)  #: rows that M multiplies
    tangent_row: int = L.UNKNOWN  #: x in (M x)_q of the iteration matrix
    chosen: bool = True
    steps: tuple[str, ...] = ("fixed",)
    needs: str = ""
    searches: bool = False
    family: str = ""  #: methods of one family may have similar errors; empty: a family of its own
    relative_step: float = 1.0
    stable: float = float("inf")
    longest: float = 0.02
    diverges: str = ""
    knows: tuple[str, ...] = ()
    spatial: bool = False  #: whether a third-party integrator serves models in space, too; compiled methods do
    second_rates: bool = False  #: whether accelerations of rotations are those of rotation vectors, psi''
    past_positions: int = 0  #: row of ``vectors`` with the positions at the start of the previous step; 0: none
    rows: int = 0  #: number of the method's own rows of ``vectors``, after the common ones
    older: int = 0  #: 2: unknowns are predicted from the last six steps instead of the last four
    acceleration_row: int = L.UNKNOWN  #: UNKNOWN or UNKNOWN2: its differences over steps are those of accelerations
    node: Callable[[Array], float] = lambda c: 1.0  #: time within a step that this acceleration belongs to [steps]
    mass_weight: Callable[[Array], float] = lambda c: 1.0  #: factor on M in the (first) iteration matrix
    damping_weight: Callable[[Array], float] = lambda c: 2 / 3  #: factor on h D in that matrix

    @property
    def explicit(self) -> bool:
        """Whether its steps need no iteration; their length is then limited by stability."""
        return self.stable < float("inf")


class Run(Protocol):
    """The interface of a run: the integration of one system by some method; a motion has a run for each part."""

    system: System
    method: str
    #: (outputs, n + n + m + p): q, v, lam at the output times after the start; the first ``written`` rows are filled
    out: Array
    times: Array  #: (outputs,): the output times; if every step is output, the times at the ends of the steps
    pivoting_from: float | None  #: time since which the linear solver searches for pivots
    searched: Array  #: (3,): what the search for peaks keeps (:mod:`mbdsl.system.peaks_along_motion`)

    @property
    def time(self) -> float:
        """The time reached [s]."""

    @property
    def steps(self) -> int:
        """Steps taken."""

    @property
    def written(self) -> int:
        """Outputs written."""

    def count(self, what: str) -> int:
        """Number of "rejected", "events", "iterations", "evaluations", "matrix_evaluations", "factorisations"; 0 if not
        counted."""

    def begin(self, q: Array, v: Array, a: Array, lam: Array, left_out: tuple[int, ...] = ()) -> None:
        """Set the consistent initial state, and the redundant constraints that are left out."""

    def advance(self, steps: int) -> int:
        """Take at most ``steps`` steps; return a status of :mod:`mbdsl.integrators.loop.loop_state`."""

    def state(self) -> tuple[Array, Array, Array]:
        """The present q, v (n,) and lam (m + p,), as views."""

    def synchronise(self) -> None:
        """Set inputs and counted turns of the system to those of the run; other evaluations may have changed them."""

    def change_inputs(self, inputs: Mapping[str, float]) -> int:
        """Set inputs to new values from the present time on; a status."""
