"""``--set NAME=VALUE``: values given by the caller, as modifiers of the main model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbdsl.errors import MbdslError, UsageError
from mbdsl.lang import syntax as s
from mbdsl.lang.given_values import mapping
from mbdsl.lang.inheritance import declarations, declared_names
from mbdsl.lang.instantiate import Instance
from mbdsl.lang.modifiers import Modifier, Modifiers
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.python_values import expression
from mbdsl.messages import did_you_mean


def merged(before: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The values of both; those that were ``given`` last have priority."""
    return {**before, **mapping(given, "parameters", 'give the values by name: `{"L": "2 m"}`')}


def read_overrides(overrides: Mapping[str, Any], instance: Instance) -> Modifiers:
    """Modifiers that set each named parameter; ``crank.m`` and ``link[3].m`` are parameters of components."""
    result: Modifiers = {}
    names = [name for m in instance.members for name in declared_names(m.item)]
    values = [
        m.item.name
        for m in instance.members
        if isinstance(m.item, s.Declaration)
        and (m.item.prefixes & {"parameter", "constant"} or ("input" in m.item.prefixes and m.item.value is not None))
    ]
    for name, given in overrides.items():
        try:
            target = parse_expression(name, "<name>") if isinstance(name, str) else None
        except MbdslError:
            target = None
        if not isinstance(target, s.Reference):
            raise UsageError(f"`{name}` is not the name of a parameter")
        first = target.steps[0].name
        if first not in names:
            hint = did_you_mean(first, values, "parameters") or did_you_mean(first, names)
            raise UsageError(f"the model has no parameter `{first}` to set", hint=hint)
        if len(target.steps) == 1 and first not in values:
            found = (d for m in instance.members for d in declarations(m.item) if d.name == first)
            is_input = any("input" in d.prefixes for d in found)
            right = f"set its value at the start: `{first}.start={given}`" if is_input else ""
            what = "an input" if is_input else "not a parameter"
            raise UsageError(f"`{first}` is {what}", hint=right or f"set one of its parameters: `{first}.name=value`")
        label = f"--set {name}"
        value = parse_expression(given, label) if isinstance(given, str) else expression(given, label)
        level = result
        element: Modifier | None = None
        for k, step in enumerate(target.steps):
            modifier = level.get(step.name)
            if modifier is None:
                modifier = level[step.name] = Modifier(s.Argument(step.name, at=value.at), instance.scope, 0)
            if step.indices:
                index = tuple(i.value for i in step.indices if isinstance(i, s.Number) and isinstance(i.value, int))
                if len(index) != len(step.indices) or k == len(target.steps) - 1:
                    raise UsageError(f"cannot set `{name}`", hint="an index is a number: `link[3].m`")
                element = modifier.elements.get(index)
                if element is None:
                    element = modifier.elements[index] = Modifier(s.Argument(step.name, at=value.at), instance.scope, 0)
                modifier = element
            if k == len(target.steps) - 1:
                modifier.value = value
            level = modifier.inner
    return result
