"""The runs of a study: cases (a method with its step or tolerance), and their common setting."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.integrators import available, declared, uncompiled
from mbdsl.integrators.method_files import spelled
from mbdsl.lang.library import Allowed, allowed_now
from mbdsl.lang.load import chosen_now
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.plan import DEFAULT_METHOD, DEFAULT_STEP, NO_STOP
from mbdsl.simulation.simulate import simulate

POINTS = 100  #: number of output points at which runs are compared, if the steps allow it
LEVELS = 9  #: number of steps of a ladder, each half of the previous one
LONGER = (8, 4, 2)  #: factors of the longest step of a ladder, for methods of order above 2
FEW = 10  #: least number of such steps in a run
ENDS = 500  #: largest number of ends of steps that are stored of a run
TOLS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)


@dataclass(frozen=True)
class Case:
    """A method with a fixed step [s] or a tolerance.

    With ``ends`` its output is at the ends of its steps, else at the times that all cases have in common.
    """

    method: str
    step: float | None = None
    tol: float | None = None
    options: tuple[tuple[str, float], ...] = ()
    ends: bool = False

    @classmethod
    def of(cls, method: str, fixed: bool, size: float) -> Case:
        """A method with fixed steps of a ``size`` [s], or else with this tolerance."""
        return cls(method, step=size) if fixed else cls(method, tol=size)

    @property
    def growth(self) -> float:
        """The exponent r of the run time, which is proportional to size^(-r): 1, or with a tolerance 1/(p + 1) with the
        order p of the method."""
        return 1.0 if self.tol is None else 1.0 / (available()[self.method].order + 1.0)

    @property
    def series(self) -> str:
        """The common name of all cases on one line of a figure."""
        given = "".join(f" --{name} {value:g}" for name, value in self.options)
        both = self.tol is not None and "fixed" in available()[self.method].steps
        return f"{self.method}{given}{' --tol' if both else ''}"

    @property
    def size(self) -> float:
        """The step or the tolerance."""
        size = self.step if self.tol is None else self.tol
        assert size is not None
        return size

    @property
    def arguments(self) -> str:
        """The options of the command line that select the case."""
        given = "".join(f" --{name} {value!r}" for name, value in self.options)
        how = f"--step {self.step!r}" if self.tol is None else f"--tol {self.tol!r}"
        return f"--method {shlex.quote(spelled(self.method))}{given} {how}"

    def __str__(self) -> str:
        return f"{self.series}, {f'h = {self.step:.4g} s' if self.tol is None else f'tol = {self.tol:.1g}'}"


@dataclass(frozen=True)
class Setting:
    """The scene and the times of all runs of a study, and how it was loaded, for commands that repeat the study."""

    scene: Scene
    start: float
    stop: float
    points: int
    path: str | None = None
    parameters: Mapping[str, str | float] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    allow_imports: Allowed = False  #: see :func:`mbdsl.load`
    model_name: str | None = None  #: the model of a file with several, if it was chosen by its name

    @property
    def words(self) -> list[str]:
        """The options of the command line that select the model and set its parameters and effects."""
        found = ["--model", self.model_name] if self.model_name else []
        found += [word for name, value in self.parameters.items() for word in ("--set", f"{name}={value}")]
        return found + (["--without", ",".join(self.without)] if self.without else [])

    @property
    def span(self) -> float:
        return self.stop - self.start

    @property
    def interval(self) -> float:
        return self.span / self.points

    @property
    def times(self) -> np.ndarray:
        """Output times (points + 1,) [s]."""
        return self.start + self.interval * np.arange(self.points + 1)


def setting(
    model,
    stop: float | None = None,
    parameters: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    points: int = POINTS,
) -> Setting:
    """The setting of runs of ``model``, from its start to ``stop`` (default: the stop time of the model)."""
    scene = as_scene(model, parameters, without)
    start, end = scene.experiment.start, scene.experiment.stop if stop is None else stop
    if end is None:
        raise UsageError(f"no stop time: {scene.name} has none in its experiment annotation", hint=NO_STOP)
    if not start < end < math.inf:
        raise UsageError(f"a study needs a stop time after its start, not {start:g} to {end:g} s")
    path = str(model) if isinstance(model, (str, PathLike)) else None
    changes = dict(parameters or {}), tuple(without), allowed_now(), chosen_now()
    return Setting(scene, start, float(end), points, path, *changes)


def assemble(of: Setting, announce: Callable[[str], None] | None = None) -> float:
    """Build the model and take a step, so that its errors are raised once and not as failures of every run.

    Returns
    -------
    float [s]
        The time of compilation.

    Raises
    ------
    ModelError, InitialisationError
    """
    step = own_step(of)
    first = simulate(
        of.scene, method=DEFAULT_METHOD, step=step, start=of.start, stop=of.start + step, announce=announce
    )
    return first.stats["seconds"]["compile"]


def chosen(names: Iterable[str] | None, scene: Scene | None = None) -> list[str]:
    """Names of methods, checked; if None is given all methods, or all that serve ``scene``, but for mbdsl's own whose
    steps are not compiled: these are for scenes that are all impact."""
    there = available(scene is not None and scene.spatial)
    found = list(names) if names is not None else [name for name in there if name not in uncompiled()]
    for name in found:
        declared(name)
    if not found:
        raise UsageError("a study needs a method", hint=f"methods: {', '.join(available())}")
    return list(dict.fromkeys(found))


def own_step(of: Setting) -> float:
    """The step of the model [s], else 1 ms; shorter if the run would have too few steps."""
    return min(of.scene.experiment.step or DEFAULT_STEP, of.interval)


def step_ladder(of: Setting, levels: int = LEVELS) -> list[float]:
    """Steps [s] around that of the model (else 1 ms), from about ten times longer, each half of the previous one.

    The output interval is a multiple of all of them.
    """
    coarsest = max(1, round(of.interval / (10.0 * own_step(of))))
    return [of.interval / (coarsest * 2**k) for k in range(levels)]


def longer_steps(of: Setting, steps: Sequence[float]) -> list[float]:
    """The ladder of methods of order above 2: as many steps as ``steps``, of which the first are longer.

    With the shortest steps of a ladder, the errors of these methods are rounding errors.
    """
    longer = [factor * steps[0] for factor in LONGER if FEW * factor * steps[0] <= of.span]
    return [*longer, *steps[: len(steps) - len(longer)]]


def count(span: float, step: float) -> int:
    """Number of steps of a run: if ``step`` does not divide the duration, all steps are shortened equally."""
    return max(1, math.ceil(span / step * (1 - 1e-12) - 1e-9))


def taken(span: float, step: float) -> float:
    """The actual step [s] of a run with the requested ``step``."""
    exact = span / count(span, step)
    return step if abs(exact - step) <= 1e-9 * step else exact


def reaches(of: Setting, case: Case) -> bool:
    """Whether steps end at all output times; steps of controlled size generally do not."""
    return case.step is not None and count(of.span, case.step) % of.points == 0


def output_interval(of: Setting, case: Case) -> float:
    """The output interval of a run [s]; 0: every step."""
    if not case.ends:
        return of.interval
    if case.step is None:
        return 0.0
    steps = count(of.span, case.step)
    return of.span / steps * math.ceil(steps / ENDS)


def common_points(span: float, steps: Sequence[float], most: int = 2 * POINTS) -> int:
    """Number of output points that all steps reach, at most ``most``; the usual number if there are too few."""
    counts = [count(span, h) for h in steps]
    shared = math.gcd(*counts) if counts else 0
    fitting = [n for n in range(10, most + 1) if shared % n == 0] if shared else []
    return max(fitting, default=min([POINTS, *[n for n in counts if n >= 10]]))


def cases(
    names: Sequence[str],
    steps: Sequence[float] | None,
    tols: Sequence[float] | None,
    both: bool = False,
    high: Sequence[float] | None = None,
) -> tuple[list[Case], list[tuple[str, str]]]:
    """Cases of every method at every step or tolerance that it supports, coarse ones first; and methods without a case.

    If neither steps nor tols are given, this is called with both ladders and ``both``: a method with fixed steps then
    has cases with fixed steps only, unless ``both`` is true. ``high`` are the steps of methods of order above 2, if
    they differ.
    """
    for what, sizes in (("step", steps), ("tolerance", tols)):
        for size in sizes or ():
            if not 0.0 < size < (math.inf if what == "step" else 1.0):
                raise UsageError(f"{size:g} is not a {what}")
    found: list[Case] = []
    refused: list[tuple[str, str]] = []
    for name in names:
        can = available()[name].steps
        ladder = high if high is not None and available()[name].order > 2 else steps
        own = [Case(name, step=h) for h in sorted(ladder or (), reverse=True) if "fixed" in can]
        if tols and "controlled" in can and (both or not own):
            own += [Case(name, tol=tol) for tol in sorted(tols, reverse=True)]
        if not own:
            refused.append((name, f"it has no {'fixed' if 'fixed' not in can else 'error-controlled'} steps"))
        found += own
    return found, refused
