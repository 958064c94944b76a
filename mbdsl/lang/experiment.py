"""The settings of a simulation in a model: ``annotation(experiment(StopTime = 2, ...))``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from mbdsl.elements.declaration import CONTACTS, EFFECTS
from mbdsl.errors import ModelError, UsageError
from mbdsl.lang import argument_checks, functions, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.mistakes.tokens import misread_argument
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import placed, span_of
from mbdsl.lang.unparse import write
from mbdsl.mechanism.scene import Experiment
from mbdsl.messages import did_you_mean
from mbdsl.numerics.tolerance import misfit

#: key -> (field of Experiment, unit; "" for a text)
KEYS = {
    "StartTime": ("start", "s"),
    "StopTime": ("stop", "s"),
    "Interval": ("interval", "s"),
    "Tolerance": ("tolerance", "1"),
    "Method": ("method", ""),
    "Step": ("step", "s"),
    "NumberOfIntervals": ("", "1"),
    "Without": ("without", ""),
}


def read_experiment(annotations: list[s.Annotation], scope: Scope) -> Experiment:
    """The settings in the annotations of a model; later annotations override earlier ones, others are ignored."""
    found: dict[str, Any] = {}
    places: dict[str, s.Argument] = {}
    for annotation in annotations:
        for part in annotation.arguments:
            call = part.value if isinstance(part.value, s.Call) and not part.name else None
            name = part.name or (write(call.function) if call else "")
            if name.lower() == "experiment":
                if part.name and part.value is not None:
                    hint = "write `experiment(StopTime = ...)`"
                    raise ModelError("`experiment` has no value", span_of(part.at), hint)
                here: set[str] = set()
                for argument in part.modifiers or (call.arguments if call else ()):
                    name = argument.name or write(argument.value)
                    if name.startswith("__"):  # a setting of another program (Modelica 3.6, section 18.1)
                        scope.namespace.assembly.passed.append(s.Passed(name, at=argument.at))
                        continue
                    _read(argument, scope, found)
                    if argument.name in here:
                        raise ModelError(f"`{argument.name}` is given twice", span_of(argument.at))
                    here.add(argument.name)
                    places[argument.name] = argument
    intervals = found.pop("", None)
    experiment = Experiment(**found)
    if intervals is not None and experiment.interval is None and experiment.stop is not None:
        found["interval"] = (experiment.stop - experiment.start) / intervals
        experiment = Experiment(**found)
    if experiment.stop is not None and experiment.stop <= experiment.start:
        raise ModelError(
            f"StopTime {experiment.stop:g} s is not after StartTime {experiment.start:g} s",
            span_of(places["StopTime"].at),
        )
    return experiment


def _read(argument: s.Argument, scope: Scope, found: dict[str, Any]) -> None:
    if not argument.name and argument.value is not None:
        mistake = misread_argument(argument.value, False)
        if mistake is not None:
            raise mistake
    if argument.name not in KEYS or argument.value is None:
        name = argument.name or write(argument.value)
        raise ModelError(f"experiment has no `{name}`", span_of(argument.at), did_you_mean(name, KEYS, "it has"))
    if argument.modifiers or argument.indices:
        at = argument.modifiers[0].at if argument.modifiers else argument.at
        raise ModelError(f"`{argument.name}` takes a value only", span_of(at), f"write `{argument.name} = ...`")
    field, unit = KEYS[argument.name]
    value = evaluate(argument.value, scope)
    with placed(argument.value.at or argument.at):
        found[field] = setting(argument.name, field, unit, value)


def setting(name: str, field: str, unit: str, value: values.Value) -> Any:
    """A checked value for one key of an experiment."""
    what = f"`{name}`"
    if field == "without":
        items = value if isinstance(value, tuple) else (value,)
        names = tuple(x.value for x in items if isinstance(x, values.Quantity) and isinstance(x.value, str))
        if len(names) < len(items):
            raise ModelError(f'{what}: found {values.describe(value)}, expected effects such as {{"friction"}}')
        return check_effects(names)
    if not unit:
        if isinstance(value, tuple) or not isinstance(value.value, str):
            raise ModelError(f'{what}: found {values.describe(value)}, expected a text such as "hht-si2"')
        return value.value
    if not field:
        number: float = functions.count(value, what)
    else:
        fitted = argument_checks.floats(argument_checks.fit(value, units.dimension(unit), what, unit), what)
        if isinstance(fitted, tuple):
            raise ModelError(f"{what}: found {values.describe(value)}, expected a single value")
        number = fitted
    if (field in ("tolerance", "step", "") and number <= 0) or (field == "interval" and number < 0):
        raise ModelError(f"{what} is {number:g}, it must be positive")
    if field == "tolerance" and (wrong := misfit(number)) is not None:
        raise ModelError(f"{what}: {wrong}")
    return number


def check_effects(given: Iterable[str], contacts: str | None = None) -> tuple[str, ...]:
    """Check the names of effects to leave out, one or several, and return them.

    ``contacts`` is a choice of all contacts, "rigid" or "compliant", and adds what scenes lack then.

    Raises
    ------
    ModelError, UsageError
        If there is no effect of a name, or no such choice.
    """
    if contacts is not None:
        if contacts not in CONTACTS:
            raise UsageError(f"contacts: found {contacts!r}, expected {' or '.join(map(repr, CONTACTS))}")
        return (*check_effects(given), CONTACTS[contacts])
    if not isinstance(given, Iterable):
        hint = f"the effects are {', '.join(EFFECTS)}"
        raise ModelError(f"found {given!r}, expected effects to leave out", hint=hint)
    names = (given,) if isinstance(given, str) else tuple(given)
    for name in names:
        if name not in EFFECTS and name not in CONTACTS.values():
            raise ModelError(f"there is no effect `{name}` to leave out", hint=did_you_mean(name, EFFECTS, "there are"))
    return names
