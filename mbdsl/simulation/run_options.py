"""The options of a run: one table, which ``mbdsl.simulate``, ``mbdsl.Simulation`` and the command line share.

A field of :class:`RunOptions` is an option: its name, type and default. ``OPTIONS`` has the units of numbers, and for
the command line placeholders, ranges and help. Options are checked and completed once, by :meth:`RunOptions.of`; below
the functions of users one object is passed on.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import Field, dataclass, fields
from functools import wraps
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from mbdsl.lang.given_values import optional, values
from mbdsl.messages import did_you_mean

if TYPE_CHECKING:
    from typing import TypedDict

    from numpy.typing import ArrayLike

    from mbdsl.simulation.checkpoint import Checkpoint
    from mbdsl.simulation.progress import Progress
    from mbdsl.simulation.trajectory import Trajectory

    class GivenOptions(TypedDict, total=False):
        """The options as a program gives them: numbers may be texts with units."""

        method: str | None
        step: float | str | None
        tol: float | str | None
        accuracy: float | str | None
        budget: float | str | None
        start: float | str | None
        stop: float | str | None
        interval: float | str | None
        times: ArrayLike | Sequence[str] | None
        options: Mapping[str, float | None] | None
        force: bool
        general: bool
        without: Sequence[str]
        parameters: Mapping[str, str | float] | None
        signals: str | Sequence[str] | None
        initial: Mapping[str, Any] | Trajectory | str | None
        progress: Callable[[Progress], None] | None
        announce: Callable[[str], None] | None
        checkpoint: Checkpoint | str | PathLike | None
        inputs: Mapping[str, Any] | None


F = TypeVar("F", bound=Callable)
#: ranges of numbers on the command line
ANY, POSITIVE, NOT_NEGATIVE, TOLERANCE = "any", "above 0", "of 0 or more", "between 0 and 1"


class Option(NamedTuple):
    """What is known of an option besides its name, type and default.

    Attributes
    ----------
    unit : str
        Unit of its number, which may also be given as a text with a unit; "" if it is no number.
    metavar, text : str
        Placeholder and help on the command line; a flag has no placeholder.
    within : str
        Range of the number on the command line.
    """

    unit: str = ""
    metavar: str = ""
    text: str = ""
    within: str = ANY


#: option -> what is known of it; the others have no number, and no common form on the command line
OPTIONS: dict[str, Option] = {
    "method": Option(
        "", "NAME", "integrator, or a Python file that defines one (NAME.py); default: the model's, else hht-si2"
    ),
    "step": Option("s", "H", "fixed step size, no longer than the run; default: the model's", POSITIVE),
    "tol": Option(
        "1",
        "TOL",
        "error-controlled steps, to this tolerance; default without a step: the model's, else 1e-4 (methods of high "
        "order and backends: 1e-6)",
        TOLERANCE,
    ),
    "accuracy": Option("1", "E", "find method and step for this relative error of positions and velocities", TOLERANCE),
    "budget": Option(
        "s",
        "T",
        "time budget of --verify, or of the check of --accuracy; default: ten times the run, at least 10 s "
        "(--accuracy: twice that)",
        POSITIVE,
    ),
    "start": Option("s", "T0", "start time; default: the model's, else 0"),
    "stop": Option("s", "T", "stop time, hit exactly; default: the model's"),
    "interval": Option("s", "DT", "output interval; default (stop - start)/500; 0 writes every step", NOT_NEGATIVE),
    "force": Option(text="allow parameters known to fail on constrained models"),
    "general": Option(text="solve the unreduced equations with general code, for comparison"),
    "without": Option("", "EFFECT,...", "leave effects out: friction, damping, flexibility, gravity"),
}


@dataclass(frozen=True)
class RunOptions:
    """The options of a run, with numbers in SI units; the docstring of ``mbdsl.simulate`` describes them."""

    method: str | None = None
    step: float | None = None
    tol: float | None = None
    accuracy: float | None = None
    budget: float | None = None
    start: float | None = None
    stop: float | None = None
    interval: float | None = None
    times: ArrayLike | None = None
    options: Mapping[str, float | None] | None = None
    force: bool = False
    general: bool = False
    without: Sequence[str] = ()
    parameters: Mapping[str, str | float] | None = None
    signals: str | Sequence[str] | None = None
    initial: Mapping[str, Any] | Trajectory | str | None = None
    progress: Callable[[Progress], None] | None = None
    announce: Callable[[str], None] | None = None
    checkpoint: Checkpoint | str | PathLike | None = None
    inputs: Mapping[str, Any] | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> RunOptions:
        """The options that a program gives, as numbers in SI units or as texts with units.

        Raises
        ------
        TypeError
            If there is no option of a name.
        UsageError
            If a value is not a number with a unit of its dimension.
        """
        found = converted(cls, given)
        if isinstance(found.get("times"), (list, tuple)):
            found["times"] = values(found["times"], "s", "times")
        return cls(**found)

    def repeatable(self) -> dict[str, Any]:
        """The options that determine the results, as values that JSON can store; initial values are added to them."""
        import numpy as np

        found = {name: getattr(self, name) for name in REPEATED}
        found["times"] = None if self.times is None else np.asarray(self.times).tolist()
        found["options"], found["parameters"] = dict(self.options or {}), dict(self.parameters or {})
        return found | {"without": list(self.without)}


UNASKED = RunOptions()  #: all options are those of the model, or the defaults
#: options with which a run is repeated from its checkpoint; ``initial`` is stored in another form
REPEATED = tuple("method step tol start stop interval options times force general parameters without".split())


def unit_of(option: Field) -> str:
    """The unit of an option that is a number; "" of others."""
    return option.metadata.get("unit") or OPTIONS.get(option.name, Option()).unit


def converted(table: type, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options that a program gives, with numbers in the units of the fields of ``table``.

    Raises
    ------
    UsageError
        If a value is not a number with a unit of its dimension.
    """
    units = {x.name: unit_of(x) for x in fields(table)}
    return {name: optional(x, units[name], name) if units.get(name) else x for name, x in given.items()}


def takes_options(names: Iterable[str] | None = None, table: type = RunOptions) -> Callable[[F], F]:
    """Decorate a function with ``**given``: its signature shows these options, and other names are refused.

    The options are the fields of the dataclass ``table``, all or those with ``names``.

    Raises
    ------
    TypeError
        As Python does for an unexpected argument, with the nearest name.
    """

    def decorate(function: F) -> F:
        own = inspect.signature(function)
        known = [x for x in own.parameters.values() if x.kind is not inspect.Parameter.VAR_KEYWORD]
        known += [_parameter(x) for x in fields(table) if names is None or x.name in names]
        function.__signature__ = own.replace(parameters=known)  # type: ignore[attr-defined]
        allowed = [x.name for x in known]

        @wraps(function)
        def checked(*args: Any, **given: Any) -> Any:
            for name in (x for x in given if x not in allowed):
                nearest = did_you_mean(name, allowed)
                wrong = f"{function.__qualname__}() got an unexpected keyword argument '{name}'"
                raise TypeError(f"{wrong}; {nearest}" if nearest else wrong)
            return function(*args, **given)

        return checked  # type: ignore[return-value]

    return decorate


def _parameter(option: Field) -> inspect.Parameter:
    """An option as an argument of a function; numbers may be texts with units."""
    given = str(option.type)
    if unit_of(option):
        given = given.replace("float", "float | str")
    return inspect.Parameter(option.name, inspect.Parameter.KEYWORD_ONLY, default=option.default, annotation=given)
