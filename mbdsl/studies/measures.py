"""Measures of a model: one number, such as the largest value of a signal in a run, written as ``max(pin.fx)``.

Measures belong to a run, to the static equilibrium (``static(pin.fy)``) or to a mode (``frequency(1)``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.lang import units
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.functions import FUNCTIONS as LANGUAGE
from mbdsl.messages import did_you_mean, few
from mbdsl.results import selection
from mbdsl.simulation.extremes import OUTPUTS, Extreme, value_at
from mbdsl.studies import conditions
from mbdsl.studies.conditions import StudyCondition

if TYPE_CHECKING:
    from mbdsl.simulation.trajectory import Trajectory

MOST = 200  #: largest number of measures
NEVER, NO_MODE = "the condition never holds", "there is no such mode"
FIRST, LAST, TIMES = "first", "last", "count"
RUN, STATIC, MODES = "run", "static", "modes"  #: what measures belong to
_CALL = re.compile(r"\s*([A-Za-z_]\w*)\s*\((.*)\)\s*", re.DOTALL)


def _mean(t: Array, x: Array) -> float:
    """The mean over time, by the trapezoidal rule."""
    if len(t) < 2 or t[-1] == t[0]:
        return float(x.mean())
    return float(np.diff(t) @ (x[1:] + x[:-1]) / (2.0 * (t[-1] - t[0])))


def _period(t: Array, x: Array) -> float:
    """The mean time between upward crossings of the middle between the least and the largest value; nan without two."""
    y = x - 0.5 * (x.min() + x.max())
    k = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
    if len(k) < 2:
        return float("nan")
    at = t[k] - y[k] * (t[k + 1] - t[k]) / (y[k + 1] - y[k])
    return float((at[-1] - at[0]) / (len(at) - 1))


@dataclass(frozen=True)
class SignalFunction:
    """A function of signals.

    Its value follows from the times and the values (N,) of its signals; further are its explanation, its unit ("": that
    of the signal), what it belongs to (a run, the equilibrium, or modes, where its argument is the number of a mode),
    the form of its arguments, and why it may have no value.
    """

    value: Callable[..., float]
    doc: str
    unit: str = ""
    of: str = RUN
    form: str = "SIGNAL"
    lacking: str = ""


def _only(t: Array, x: Array) -> float:
    """The single value."""
    return float(x[-1])


FUNCTIONS = {
    "final": SignalFunction(lambda t, x: float(x[-1]), "last value"),
    "min": SignalFunction(lambda t, x: float(x.min()), "least value"),
    "max": SignalFunction(lambda t, x: float(x.max()), "largest value"),
    "maxabs": SignalFunction(lambda t, x: float(np.abs(x).max()), "largest absolute value"),
    "mean": SignalFunction(_mean, "mean over time"),
    "rms": SignalFunction(lambda t, x: float(np.sqrt(_mean(t, x * x))), "root of the mean square over time"),
    "amplitude": SignalFunction(lambda t, x: float(0.5 * (x.max() - x.min())), "half of largest minus least value"),
    "period": SignalFunction(
        _period,
        "mean time between upward crossings of the middle of the range",
        "s",
        lacking="the signal passes the middle of its range upwards less than twice",
    ),
    "time_of_max": SignalFunction(lambda t, x: float(t[x.argmax()]), "time of the largest value", "s"),
    "time_of_min": SignalFunction(lambda t, x: float(t[x.argmin()]), "time of the least value", "s"),
    "time_when": SignalFunction(
        _only,
        "first time at which a condition holds; `last`: the last one; `count`: how many times it begins to hold",
        "s",
        form="CONDITION, first|last|count",
    ),
    "at": SignalFunction(
        _only,
        "value at a time, or at the first or last time at which a condition holds",
        form="SIGNAL, TIME|CONDITION, first|last",
    ),
    "at_max": SignalFunction(
        lambda t, a, b: float(a[b.argmax()]), "value where another signal is largest", form="SIGNAL, OTHER"
    ),
    "at_min": SignalFunction(
        lambda t, a, b: float(a[b.argmin()]), "value where another signal is least", form="SIGNAL, OTHER"
    ),
    "static": SignalFunction(_only, "value at the static equilibrium", of=STATIC),
    "frequency": SignalFunction(_only, "undamped frequency of a mode, such as 1", "Hz", MODES, "N", NO_MODE),
    "damped_frequency": SignalFunction(_only, "frequency of the damped vibration of a mode", "Hz", MODES, "N", NO_MODE),
    "damping": SignalFunction(_only, "damping ratio of a mode", "", MODES, "N", NO_MODE),
}


#: functions of the extremes of a signal over all steps of a run
OF_EXTREMES: dict[str, Callable[[Extreme], float]] = {
    "min": lambda x: x.least,
    "max": lambda x: x.largest,
    "maxabs": lambda x: max(abs(x.least), abs(x.largest)),
    "mean": lambda x: x.mean,
    "rms": lambda x: x.rms,
    "amplitude": lambda x: 0.5 * (x.largest - x.least),
    "time_of_max": lambda x: x.time_of_largest,
    "time_of_min": lambda x: x.time_of_least,
}
#: functions of a signal where another one is extreme
WHERE: dict[str, Callable[[Extreme], float]] = {
    "at_max": lambda x: x.time_of_largest,
    "at_min": lambda x: x.time_of_least,
}


@dataclass(frozen=True)
class Measure:
    """A function of a signal, such as ``max(pin.fx)``, which is its text.

    Attributes
    ----------
    function, signal : str
        Names; in place of a signal the number of a mode, or a condition.
    unit : str
        Unit of its value; "" if it has none.
    further : tuple of str
        Texts of the further arguments.
    when : When or float or None
        The condition, or the time [s], at which the signal is asked for.
    """

    function: str
    signal: str
    unit: str = ""
    further: tuple[str, ...] = ()
    when: StudyCondition | float | None = None

    def __str__(self) -> str:
        return f"{self.function}({', '.join([self.signal, *self.further])})"

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals, or expressions of signals, whose values it follows from."""
        if self.function == "time_when":
            assert isinstance(self.when, StudyCondition)
            return self.when.differences
        if isinstance(self.when, StudyCondition):
            return self.signal, *self.when.differences
        return (self.signal, *self.further) if self.when is None else (self.signal,)

    @property
    def of(self) -> str:
        """What it belongs to: "run", "static" (the equilibrium) or "modes"."""
        return FUNCTIONS[self.function].of

    @property
    def lacking(self) -> str:
        """Why it may have no value in a run that is complete; "" if that is not known."""
        if self.when is not None:
            return NEVER if isinstance(self.when, StudyCondition) else "the time is outside of the run"
        return FUNCTIONS[self.function].lacking

    def of_run(self, run: Trajectory) -> float:
        """Evaluate the measure of a run: extremes and means over all of its steps, others from its rows.

        Parameters
        ----------
        run : Trajectory
            A run, or a part of it.

        Returns
        -------
        float
            As for ``value``.
        """
        found = self.value(run.t, *(np.asarray(run[name], float) for name in self.signals))
        if np.isfinite(found) and self.function in OF_EXTREMES:
            return OF_EXTREMES[self.function](run.extremes([self.signal])[self.signal])
        if np.isfinite(found) and self.function in WHERE:
            other = run.extremes([self.further[0]])[self.further[0]]
            return found if other.of == OUTPUTS else value_at(run, self.signal, WHERE[self.function](other))
        return found

    def value(self, t: Array, *xs: Array) -> float:
        """Evaluate the measure from rows.

        Parameters
        ----------
        t : (N,) [s]
            Times.
        xs : (N,)
            Values of its ``signals``.

        Returns
        -------
        float
            nan if there is no value, or one of them is nan.
        """
        if not len(t) or any(np.isnan(x).any() for x in xs):
            return float("nan")
        if self.when is None:
            return FUNCTIONS[self.function].value(t, *xs)
        if not isinstance(self.when, StudyCondition):
            return float(np.interp(self.when, t, xs[0])) if t[0] <= self.when <= t[-1] else float("nan")
        own = self.function != "time_when"
        spans = self.when.spans(t, xs[own:])
        which = self.further[-1] if self.further else FIRST
        if which == TIMES:
            return float(len(spans))
        if not len(spans):
            return float("nan")
        time = spans[-1, 1] if which == LAST else spans[0, 0]
        return float(np.interp(time, t, xs[0]) if own else time)


def read(texts: Iterable[str], names: AskedSignals) -> list[Measure]:
    """Measures from their texts.

    Parameters
    ----------
    texts : iterable of str
        ``FUNCTION(SIGNAL)``, where a glob pattern stands for all signals that it matches, and an expression such as
        ``hypot(pin.fx, pin.fy)`` for its value; a name alone is its last value.
    names : AskedSignals
        The signals of the model.

    Returns
    -------
    list of Measure
        Each once.

    Raises
    ------
    UsageError
        If a text is not a measure, or there is no such function or signal.
    """
    found: dict[str, Measure] = {}
    for text in texts if isinstance(texts, Iterable) else (texts,):
        if not isinstance(text, str):
            hint = f"{_hint()}; for another function, simulate with each value and apply it to the results"
            raise UsageError(f"measures: found {text!r}, expected a text", hint=hint)
        function, pattern = _split(text)
        if FUNCTIONS[function].of == MODES:
            if not (pattern.isdecimal() and int(pattern)):
                raise UsageError(
                    f"`{text}`: found `{pattern}`, expected the number of a mode",
                    hint=f"modes are counted from 1, by ascending frequency: {function}(1)",
                )
            found.setdefault(
                f"{function}({int(pattern)})", Measure(function, str(int(pattern)), FUNCTIONS[function].unit)
            )
            continue
        for measure in _read(text, function, split(pattern), names):
            found.setdefault(str(measure), measure)
    if len(found) > MOST:
        raise UsageError(f"{len(found)} measures are too many: at most {MOST}", hint="name the signals")
    return list(found.values())


def _read(text: str, function: str, arguments: list[str], names: AskedSignals) -> Iterator[Measure]:
    """The measures of a call, one for each signal that its first argument matches."""
    form, unit = FUNCTIONS[function].form, FUNCTIONS[function].unit
    first, *further = arguments
    asked = form.split(", ")[1:]
    choices = asked[-1].split("|") if asked and FIRST in asked[-1] else []
    which = further.pop() if choices and further and further[-1] in choices else None
    if len(further) != len(asked) - bool(choices):
        expected = f"{function}({form.replace(', first', '[, first') + ']' * bool(choices)})"
        raise UsageError(f"`{text}` is not a measure: expected {expected}", hint=_hint())
    last = () if which is None else (which,)
    if function == "time_when":
        yield Measure(function, first, "" if which == TIMES else unit, last, conditions.read(first, names))
        return
    when: StudyCondition | float | None = None
    if function == "at":
        when = _time(further[0])
        when = conditions.read(further[0], names) if when is None else when
    elif further:
        further = names.select(further)
        if len(further) > 1:
            raise UsageError(f"`{text}`: the second argument is one signal, found {few(further)}")
    for signal in names.select([first]):
        yield Measure(function, signal, unit or names.unit(signal), (*further, *last), when)


def _time(text: str) -> float | None:
    """A time [s]; None if the text is not a number with a unit."""
    if not re.match(r"[-+]?[.\d][^<>]*$", text):
        return None
    try:
        return units.measure(text, "s")
    except ValueError as problem:
        raise UsageError(f"at: {problem}", hint="write a time, 2 s, or a condition, mass.x > 0.5 m") from None


def _split(text: str) -> tuple[str, str]:
    match = _CALL.fullmatch(text)
    if match is None or (match[1] not in FUNCTIONS and match[1] in LANGUAGE):  # an expression such as abs(pin.fx)
        if not text.strip() or not _closed(text):
            raise UsageError(f"`{text}` is not a measure", hint=_hint())
        return "final", text.strip()
    function, signal = match[1], match[2].strip()
    if function not in FUNCTIONS:
        raise UsageError(
            f"there is no measure `{function}`", hint=did_you_mean(function, FUNCTIONS, "measures") or _hint()
        )
    inner = _CALL.fullmatch(signal)
    nested = inner is not None and inner[1] in FUNCTIONS and len(split(inner[2])) == 1
    alone = FUNCTIONS[function].form in ("SIGNAL", "N")
    if (alone and len(split(signal)) != 1) or not split(signal) or nested or not _closed(signal):
        raise UsageError(f"`{text}` is not a measure: expected one signal in the parentheses", hint=_hint())
    return function, signal


def _closed(text: str) -> bool:
    """Whether every closing parenthesis has an opening one before it: ``a) - min(b`` is not the inside of a call."""
    depth = 0
    for c in text:
        depth += (c == "(") - (c == ")")
        if depth < 0:
            return False
    return depth == 0


def _hint() -> str:
    return f"a measure is written max(pin.fx); functions: {', '.join(FUNCTIONS)}"


def split(text: str) -> list[str]:
    """Measures separated by commas, without empty ones."""
    return [part for part in selection.split(text) if part]


def usual(names: AskedSignals) -> Sequence[str]:
    """The measures without a request: least and largest value of the coordinates of the first body."""
    bodies = names.scene.bodies()
    found = [f"{bodies[0].name}.{key}" for key in bodies[0].coordinates if f"{bodies[0].name}.{key}" in names]
    if not found:
        raise UsageError("a sweep needs a measure", hint=f"give --measure; {_hint()}")
    return [f"{function}({name})" for name in found[:3] for function in ("min", "max")]
