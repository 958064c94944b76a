"""Check of a method's parameters, and defaults for those that are not given."""

from __future__ import annotations

from collections.abc import Mapping

from mbdsl.errors import UsageError
from mbdsl.integrators import declared


def check_options(
    name: str, options: Mapping[str, float | None], constrained: bool = False, force: bool = False
) -> dict[str, float | None]:
    """The given options of a method, completed by defaults.

    Raises
    ------
    UsageError
        If the method does not have a parameter, a value is outside its bounds, values do not go together, or (unless
        ``force``) the values are known to fail on constrained models.
    """
    method = declared(name)
    parameters = method.parameters
    values: dict[str, float | None] = {key: option.default for key, option in parameters.items()}
    if not isinstance(options, Mapping):
        hint = 'give them by name: `{"alpha": -0.1}`'
        raise UsageError(f"options: found {options!r}, expected a mapping", hint=hint)
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
