"""The values of a component: its parameters, evaluated, completed and checked."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from mbdsl.elements.declaration import CONTACTS, REQUIRED, Parameter
from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.errors import ModelError
from mbdsl.lang import argument_checks, orientations, values
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes import doubts
from mbdsl.lang.modifiers import Modifier
from mbdsl.lang.paths import frames_over
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.unparse import write
from mbdsl.mechanism.frozen_dict import FrozenDict

if TYPE_CHECKING:
    from mbdsl.lang.flat_component import FlatComponent


def _check_quoted(part: FlatComponent, parameter: Parameter, modifier: Modifier) -> None:
    """Refuse ``axes = world``, where a text was meant."""
    found = write(modifier.value) if isinstance(modifier.value, s.Reference) else ""
    if found in parameter.choices and isinstance(parameter.default, str):
        message = f"`{parameter.name}` of `{part.name}` is a text"
        raise ModelError(message, modifier.value_span(), f'write it in quotes: `{parameter.name} = "{found}"`')


def values_of(part: FlatComponent) -> dict:
    """All parameters of a component except laws, checked, in SI, with defaults and derived values."""
    same = True
    found: dict = {}
    for parameter in part.kind.parameters:
        if parameter.law:
            if parameter.default is REQUIRED and part.modifier(parameter.name) is None:
                raise _missing(part, parameter)
            found[parameter.name] = None
            continue
        if parameter.name == "frames":
            found["frames"], equal = _user_frames(part)
            same = same and equal
            continue
        modifier = part.modifier(parameter.name)
        if modifier is None:
            if parameter.default is REQUIRED:
                raise _missing(part, parameter)
            found[parameter.name] = parameter.default
            continue
        if parameter.name == "over":
            found["over"] = tuple(x.name for x in frames_over(modifier))
            continue
        _check_quoted(part, parameter, modifier)
        value = modifier.evaluate()
        with placed(modifier.value_at):
            picked = modifier.pick(value, _rank(part, parameter, modifier, values.shape(value)), part.contexts)
            found[parameter.name] = argument_checks.argument(
                parameter, picked, part.name, modifier.value, part.assembly.spatial
            )
        if parameter.unit == "rad":
            doubts.angle(part.assembly.warn, picked, modifier.value, f"`{parameter.name}` of `{part.name}`")
        if parameter.name == "pitch":
            doubts.pitch_per_angle(part.assembly.warn, part.name, picked, modifier.value)
        same = same and picked is value
    doubts.damping_alone(part.assembly.warn, part.kind, part.name, part.template.modifiers)
    laws = {p.name: modifier for p in part.kind.parameters if p.law and (modifier := part.modifier(p.name))}
    problem_text = part.kind.check({**found, **laws} if laws else found)
    if problem_text:
        problem, _, hint = problem_text.partition("\n")
        place = span_of(_place_of(part, problem))
        raise ModelError(f"{part.kind.name} `{part.name}`: {problem}", place, hint or None)
    if (doubt := part.kind.doubt(found)) is not None:
        message = f"no body has the moments of inertia I of {part.kind.name} `{part.name}`: {doubt}"
        hint = "check their order and the axes: a moment is at most the sum of the two others"
        part.assembly.warn(message, _place_of(part, message), hint)
    try:
        found.update(part.kind.derive(found))
    except ArithmeticError:
        raise ModelError(f"{part.kind.name} `{part.name}`: its values are too large", span_of(part.at)) from None
    for effect in part.assembly.without:
        if effect in part.kind.effects and (changed := part.kind.effects[effect](found)):
            found.update(changed)
            part.lacks.add(effect)
    if CONTACTS["compliant"] in part.assembly.without:
        _check_stiffness(part, found)
    found = FrozenDict(found)  # components share it
    if same:
        part.template.shared = (found, part.poses(found), part.lacks)
    return found


def _check_stiffness(part: FlatComponent, found: dict) -> None:
    """Refuse a contact without stiffness where all must have one."""
    if isinstance(part.kind, JointKind) and part.kind.unilateral:
        hint = "write it as a stop, PointContact, CircleContact, ..., with `k`"
        raise ModelError(f"{part.kind.name} `{part.name}` is always rigid, not compliant", span_of(part.at), hint)
    if isinstance(part.kind, ForceKind) and part.kind.touching and found["k"] is None:
        message = f"{part.kind.name} `{part.name}` has no stiffness, which compliant contacts need"
        raise ModelError(message, span_of(part.at), "give `k`")


def _rank(part: FlatComponent, parameter: Parameter, modifier: Modifier, shape: tuple[int, ...]) -> int:
    """Number of dimensions of the value of one component; of an array, values without `each` are one by one."""
    accepted, inside = (parameter.shape, *parameter.or_shapes), part.contexts[modifier.level :]
    if len(accepted) == 1 or (shape not in accepted and modifier.each):
        return len(parameter.shape)
    if not inside or modifier.each or shape[1:] not in accepted or shape[:1] != (inside[-1][1],):
        return len(shape)
    if shape in accepted and modifier.value is not None:
        doubts.one_by_one(part.assembly.warn, parameter.name, part.name, len(shape) - 1, modifier.value)
    return len(shape) - 1


def _place_of(part: FlatComponent, problem: str) -> At:
    """The value of the only parameter that a problem names, if it is a kind in space; else the component."""
    words = set(re.findall(r"[A-Za-z]\w*", problem)) if part.kind.spatial else ()
    named = [modifier for p in part.kind.parameters if p.name in words and (modifier := part.modifier(p.name))]
    return named[0].value.at if len(named) == 1 and named[0].value is not None else part.at


def _missing(part: FlatComponent, parameter: Parameter) -> ModelError:
    unit = "" if parameter.unit in ("", "1") else f" [{parameter.unit}]"
    examples = {"kg": "1 kg", "m": "1 m", "rad": "2*time", "N.m": "1 N.m", "": "crank.w + 2*rod.w"}
    if isinstance(part.kind, JointKind) and part.kind.of_position:
        examples[""] = "x^2 + y^2 - (1 m)^2"
    if parameter.name in part.kind.coupled:
        examples |= {"": "pin.phi", "rad": "pin.phi"}
    return ModelError(
        f"{part.kind.name} `{part.name}` needs `{parameter.name}`: {parameter.doc}{unit}",
        span_of(part.at),
        f"write `{parameter.name} = {examples.get(parameter.unit, '...')}`",
    )


def _user_frames(part: FlatComponent) -> tuple[tuple, bool]:
    given = part.template.modifiers.get("frames")
    if given is None:
        return (), True
    if given.value is not None or not given.inner:
        raise ModelError(
            f"`frames` of `{part.name}` is a list of named frames",
            span_of(given.at),
            "write `frames(tip = {x, y})`",
        )
    found, same = [], True
    orientations.refuse_loose(given.inner, part.name, part.assembly.spatial)
    for name, modifier in given.inner.items():
        what = f"frame `{name}` of `{part.name}`"
        if modifier.value is None and modifier.inner and part.assembly.spatial:
            pose, turn = orientations.pose(what, modifier.inner, part.contexts, modifier.at, part.assembly.warn)
            found.append((name, (*pose, turn)))
            same = same and not part.contexts
            continue
        if modifier.value is None:
            raise ModelError(f"{what} has no position", span_of(modifier.at), f"write `{name} = {{x, y}}`")
        value = modifier.evaluate()
        with placed(modifier.value.at):
            picked = modifier.pick(value, 1, part.contexts)
            read = argument_checks.spatial_pose if part.assembly.spatial else argument_checks.pose
            found.append((name, read(picked, what)))
            if isinstance(picked, tuple) and len(picked) == 3:
                doubts.angle(part.assembly.warn, picked[2], modifier.value, f"phi of {what}")
        same = same and picked is value
    return tuple(found), same
