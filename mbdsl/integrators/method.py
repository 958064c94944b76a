"""What a method declares about itself; see any file of a method for how it is used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation.buffer_layout import POSITION, UNKNOWN, UNKNOWN2

if TYPE_CHECKING:
    from mbdsl.system import System

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Option:
    """A parameter of a method: default (None: it follows from the others) and the interval it is allowed in."""

    default: float | None
    lower: float
    upper: float
    doc: str


@dataclass(frozen=True)
class Start:
    """A consistent state from which a method begins: q, v, a (n,), lam (m + p,); ``fa`` = M^{-1} Q (n,), Q without
    constraint forces of Phi; all at t_0.

    ``jerk`` and ``fa_rate`` (n,) are the rates of a and fa. Where the start is ``stiff``, they are zero, and a
    belongs to a transient that is over long before the first step ends.
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

    ``coefficients`` turns checked options into the numbers c that the kernels read, and that no kernel changes;
    ``check`` says what is wrong with options together, on a model that is constrained or not (None: nothing; "forced"
    problems may be overruled). ``begin(c, start)`` gives the rows of ``vectors`` that the first step needs, vectors of
    n or N entries by row, and ``memory(c, start)`` the numbers that the method carries from step to step in addition.

    ``multipliers`` are the rows of ``vectors`` with the multipliers in f, in Phi_q^T mu, and as force laws read them.
    Of these ``sets``, the third is that in Phi_q^T psi with Phi_q of the start of the step, always in UNKNOWN.
    ``own_reactions`` is False where reactions have to be found from the acceleration-level equations; ``inverts_mass``
    tells that every coordinate needs a mass. What nobody can choose is not ``chosen``. ``steps`` are "fixed",
    "controlled" (by an estimate of their error), or both, the first of which is taken if nobody asks for the other.

    A method that is not of this package (see :mod:`mbdsl.integrators.backends`) has neither ``coefficients`` nor
    ``begin``, ``own_reactions`` if it yields multipliers, and says what ``needs`` to be installed. Where its order
    varies, ``order`` is the highest. ``searches`` says that its steps end in all ``Problem.zones`` and are searched for
    peaks of laws that depend on the state (``System.on_the_way``).

    ``relative_step`` is the length of a step, relative to one of hht-si2, from which the errors fall with the order;
    verification takes its steps from it. ``diverges`` completes the message of a constrained model for which Newton's
    iteration diverges.
    """

    name: str
    doc: str
    order: int
    index: int
    enforces: tuple[str, ...]  #: of "Phi", "dPhi"
    source: str
    coefficients: Callable[[Mapping[str, float | None]], tuple[float, ...]] = lambda options: ()
    memory: Callable[[Array, Start], tuple[float, ...]] = lambda c, start: ()
    begin: Callable[[Array, Start], Mapping[int, Array | list[float]]] = lambda c, start: {}
    parameters: Mapping[str, Option] = field(default_factory=dict)
    check: Callable[[Mapping[str, float | None]], str | None] = lambda options: None
    check_constrained: Callable[[Mapping[str, float | None]], str | None] = lambda options: None
    matrices: int = 1
    multipliers: tuple[int, int, int] = (UNKNOWN, UNKNOWN2, UNKNOWN)
    sets: int = 1
    own_reactions: bool = True
    inverts_mass: bool = False
    mass_row: int = (
        POSITION  #: row with the coordinates that M is evaluated at; another than POSITION is read once a step
    )
    inertia_rows: tuple[int, int] = (UNKNOWN, UNKNOWN2)  #: rows that M is multiplied with
    tangent_row: int = UNKNOWN  #: x in (M x)_q of the iteration matrix
    chosen: bool = True
    steps: tuple[str, ...] = ("fixed",)
    needs: str = ""
    searches: bool = False
    family: str = ""  #: of methods whose errors may agree with each other; empty: the method is one of its own
    relative_step: float = 1.0
    diverges: str = ""
    rows: int = 0  #: rows of ``vectors`` that are the method's own, behind the common ones
    acceleration_row: int = UNKNOWN  #: UNKNOWN or UNKNOWN2: differences of that over steps are those of accelerations
    node: Callable[[Array], float] = lambda c: 1.0  #: when in a step that acceleration is, in parts of the step
    mass_weight: Callable[[Array], float] = lambda c: 1.0  #: factor on M in the (first) iteration matrix
    damping_weight: Callable[[Array], float] = lambda c: 2 / 3  #: the same on h D


class Run(Protocol):
    """A system on its way by some method: what a motion asks of each of its parts.

    Attributes
    ----------
    out : (outputs, n + n + m + p)
        q, v, lam at the output times after the start; the first ``written`` rows are filled.
    times : (outputs,)
        Those times; where every step is output, those of the steps.
    pivoting_from : float or None
        Since when pivots are searched for.
    """

    system: System
    method: str
    out: Array
    times: Array
    pivoting_from: float | None

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
        """How many "rejected", "events", "iterations", "matrix_evaluations", "factorisations"; 0 where none counts."""

    def begin(self, q: Array, v: Array, a: Array, lam: Array, left_out: tuple[int, ...] = ()) -> None:
        """Set the consistent state at the start, and the redundant constraints that are not solved for."""

    def advance(self, steps: int) -> int:
        """Take at most so many steps; a status of :mod:`mbdsl.integrators.loop.loop_state`."""

    def state(self) -> tuple[Array, Array, Array]:
        """q, v (n,) and lam (m + p,) as they are now; views."""

    def change_inputs(self, inputs: Mapping[str, float]) -> None:
        """From here on the inputs have other values."""
