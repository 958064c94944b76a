"""The options of a run: one table, which ``mbdsl.simulate``, ``mbdsl.Simulation`` and the command line share.

A field of :class:`RunOptions` is an option: its name, type and default. ``OPTIONS`` has the units of numbers, and for
the command line placeholders, ranges and help. Options are checked and completed once, by :meth:`RunOptions.of`; below
the functions of users one object is passed on.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import Field, dataclass, fields
from functools import wraps
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from mbdsl.lang.experiment import check_effects
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
        contacts: str | None
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


class OptionText(NamedTuple):
    """What is known of an option besides its name, type and default."""

    unit: str = ""  #: unit of its number, which may also be given as a text with a unit; "" if it is no number
    #: name of its value, and help, on the command line; a flag has no value
    metavar: str = ""
    text: str = ""
    within: str = ANY  #: range of the number on the command line


#: option -> what is known of it; the others have no number, and no common form on the command line
OPTIONS: dict[str, OptionText] = {
    "method": OptionText(
        "", "NAME", "integrator, or a Python file that defines one (NAME.py); default: the model's, else hht-si2"
    ),
    "step": OptionText("s", "H", "fixed step size, no longer than the run; default: the model's", POSITIVE),
    "tol": OptionText(
        "1",
        "TOL",
        "error-controlled steps, to this tolerance; default without a step: the model's, else 1e-4 (methods of high "
        "order and backends: 1e-6)",
        TOLERANCE,
    ),
    "accuracy": OptionText(
        "1", "E", "find method and step for this relative error of positions and velocities", TOLERANCE
    ),
    "budget": OptionText(
        "s",
        "T",
        "time budget of --verify, or of the check of --accuracy; default: ten times the run, at least 10 s "
        "(--accuracy: twice that)",
        POSITIVE,
    ),
    "start": OptionText("s", "T0", "start time; default: the model's, else 0"),
    "stop": OptionText("s", "T", "stop time, hit exactly; default: the model's"),
    "interval": OptionText("s", "DT", "output interval; default (stop - start)/500; 0 writes every step", NOT_NEGATIVE),
    "force": OptionText(text="allow parameters known to fail on constrained models"),
    "general": OptionText(text="solve the unreduced equations with general code, for comparison"),
    "without": OptionText("", "EFFECT,...", "leave effects out: friction, damping, flexibility, gravity, contact"),
    "contacts": OptionText(
        "",
        "KIND",
        "rigid: without the stiffness of contacts and stops that can be rigid; or compliant: refuse those without one",
    ),
}


@dataclass(frozen=True)
class RunOptions:
    """The options of a run: arguments of ``mbdsl.simulate``, as numbers in SI units or as texts with units.

    Attributes
    ----------
    method : str, optional
        Name of an integration method (`mbdsl methods` lists them). Default: the model's Method; else
        "hht-si2" with fixed steps, and with a tolerance the fastest for it of "hht-si2", "radau5" and "dop853".
    step : float or str, optional [s]
        Fixed step size, at most the duration of the run. Default: the model's Step. If the duration is not a multiple
        of it, all steps are shortened equally, so that the last one ends at ``stop``. Methods with error-controlled
        steps by default, those of high order, ignore the model's Step. Methods with fixed steps only default to 1 ms.
    tol : float or str, optional
        Limit of the global error, for error-controlled steps; excludes ``step``. The error is the maximum over all
        output times and coordinates: positions relative to the size of the mechanism, angles in radians, velocities
        relative to the largest velocity of the run (at least the size of the mechanism, or one radian, per duration
        of the run). Default, if neither the caller nor the model gives a step: the model's Tolerance, else 1e-4. With
        methods of high order and third-party integrators: the model's Tolerance, else 1e-6, even if the model has a
        Step. Calibration runs with larger tolerances come first. ``stats["error"]`` is the error estimate that they
        give; ``stats["horizon"]`` is the time up to which the tolerance holds (None: up to the end).
    accuracy : float or str, optional
        Limit of the error of positions, relative to the size of the mechanism, and of velocities, relative to the
        largest velocity; excludes ``step`` and ``tol``. Several runs determine the step and, unless it is given, the
        method. ``stats["accuracy"]`` describes the result (``mbdsl.studies.accuracy``).
    budget : float or str, optional [s]
        Time limit of the check of an ``accuracy`` by another method. Default: twenty times the duration of the runs
        before it, and at least 20 s.
    start, stop : float or str, optional [s]
        Start and stop time. Default: those of the model.
    interval : float or str, optional [s]
        Output interval. Default: (stop - start)/500; 0 stores every step.
    times : (N,) array or sequence of str, optional [s]
        Output times after the start, ascending; the last is the stop time. Excludes ``interval``.
    options : mapping, optional
        Parameters of the method, such as {"alpha": -0.1}.
    force : bool, optional
        Allow combinations that are known to fail, such as the trapezoidal rule on constrained models.
    general : bool, optional
        Solve the unreduced equations with code that contains every kind of element: no bodies are merged, no parts are
        split off or solved beforehand. For comparison with the specialised code.
    without : sequence of str, optional
        Effects to leave out ("friction", "damping", "flexibility", "gravity", "contact").
    contacts : "rigid" or "compliant", optional
        "rigid": contacts and stops that can be rigid have no stiffness. "compliant": an error names those that have
        none. Default: as each of them is given.
    parameters : mapping, optional
        Values that replace those of the model's parameters, as numbers in SI units or as texts with units
        ("120 N/mm").
    signals : str or sequence of str, optional
        Names and glob patterns of signals, which are checked before the run. The trajectory is then a selection: it
        lists, shows, plots and writes these signals. Default: all signals are listed, and coordinates and velocities
        are written.
    initial : mapping, Trajectory or "static", optional
        Initial values by signal, as numbers in SI units or as texts with units: ``{"crank.phi": "30 deg"}``. They are
        fixed, as in the model's ``initial equation``, and replace its values for the same signals; the other values
        remain. An entry "guess" is a mapping of values that the assembly may change. A Trajectory stands for the
        positions and velocities of all bodies at its end, which replace all initial values of the model; give its
        last time as ``start`` if forces or drivers depend on time. "static" is the equilibrium that ``mbdsl.static``
        finds at the start time: the run begins there, at rest, and the initial values of the model are where the search
        begins.
    progress : callable, optional
        Called about ten times a second with a ``Progress``.
    announce : callable, optional
        Called with a text before a phase that takes long, such as compilation. Default: in a terminal and in a
        notebook, a line on standard error announces a compilation.
    checkpoint : path or Checkpoint, optional
        Checkpoint file, written every minute and when the run is interrupted; ``mbdsl.resume`` continues from it.
        The file remains after the run. Not available with ``accuracy`` or with third-party integrators.
    inputs : mapping, optional
        Functions of time in place of inputs of the model: a pair (t, u) of arrays, linear between the points and
        constant outside of them; a function of time, which is sampled; or a number; in SI units. Others have their
        start values.
    """

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
    contacts: str | None = None
    parameters: Mapping[str, str | float] | None = None
    signals: str | Sequence[str] | None = None
    initial: Mapping[str, Any] | Trajectory | str | None = None
    progress: Callable[[Progress], None] | None = None
    announce: Callable[[str], None] | None = None
    checkpoint: Checkpoint | str | PathLike | None = None
    inputs: Mapping[str, Any] | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> RunOptions:
        """Return the options that a program gives, as numbers in SI units.

        Parameters
        ----------
        given : mapping
            Options by name; numbers may be texts with units.

        Raises
        ------
        TypeError
            If there is no option of a name.
        UsageError
            If a value is not a number with a unit of its dimension, or none of those that are possible.
        """
        found = converted(cls, given)
        if isinstance(found.get("times"), (list, tuple)):
            found["times"] = values(found["times"], "s", "times")
        if found.get("contacts") is not None:
            found["without"] = check_effects(found.get("without", ()), found["contacts"])
        return cls(**found)

    def repeatable(self) -> dict[str, Any]:
        """Return the options that determine the results, as values that JSON can store.

        Returns
        -------
        dict
            Option -> value, without initial values.
        """
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
    return option.metadata.get("unit") or OPTIONS.get(option.name, OptionText()).unit


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
    """Decorate a function with ``**given``: its signature and its help show these options, others are refused.

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

        checked.__doc__ = described(function.__doc__, {x.name for x in known})
        return checked  # type: ignore[return-value]

    return decorate


def described(doc: str | None, names: Collection[str]) -> str | None:
    """A docstring with the descriptions of options in place of its entry ``**given``."""
    entry = re.search(r"^    \*\*given\n(?:        .*\n)+", doc or "", re.MULTILINE)
    if doc is None or entry is None or RunOptions.__doc__ is None:  # as with python -OO
        return doc
    _, _, listed = RunOptions.__doc__.partition("----------\n")
    texts = re.split(r"^(?=    \w)", listed.rstrip() + "\n", flags=re.MULTILINE)
    own = (text for text in texts if {*text.partition(" : ")[0].replace(",", " ").split()} & {*names})
    return doc[: entry.start()] + "".join(own) + doc[entry.end() :]


def _parameter(option: Field) -> inspect.Parameter:
    """An option as an argument of a function; numbers may be texts with units."""
    given = str(option.type)
    if unit_of(option):
        given = given.replace("float", "float | str")
    return inspect.Parameter(option.name, inspect.Parameter.KEYWORD_ONLY, default=option.default, annotation=given)
