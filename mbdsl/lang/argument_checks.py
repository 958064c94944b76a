"""Checks of values against declarations: dimension, shape, type and range."""

from __future__ import annotations

import math
from typing import Any, TypeGuard, overload

from mbdsl.elements.declaration import ANY, Parameter, Shape
from mbdsl.errors import ModelError
from mbdsl.expressions import symbolic
from mbdsl.lang import quantities, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.mistakes import units as unit_mistakes
from mbdsl.lang.units import Dimension
from mbdsl.lang.values import Quantity, Value, describe
from mbdsl.messages import did_you_mean


@overload
def fit(
    value: Quantity, dimension: Dimension | None, what: str, unit: str = "", e: s.Expression | None = None
) -> Quantity: ...
@overload
def fit(
    value: Value, dimension: Dimension | None, what: str, unit: str = "", e: s.Expression | None = None
) -> Value: ...
def fit(value: Value, dimension: Dimension | None, what: str, unit: str = "", e: s.Expression | None = None) -> Value:
    """``value`` of the expression ``e`` as a number (or array) of ``dimension``, which bare numbers adopt."""
    if isinstance(value, tuple):
        return tuple(fit(v, dimension, what, unit) for v in value)
    if not value.number:
        expected = quantities.words(dimension, unit) if dimension is not None else "a number"
        hint = None
        if isinstance(value.value, str) and value.value[:1].isdigit():
            hint = f"write it without quotes: `{value.value}`"
        raise ModelError(f"{what}: found {describe(value)}, expected {expected}", hint=hint)
    if dimension is None or value.dimension == dimension:
        return value
    if value.dimension is None:
        return Quantity(value.value, dimension)
    hint = unit_mistakes.remedy(value.dimension, dimension, unit, e)
    raise ModelError(f"{what}: found {describe(value)}, expected {quantities.words(dimension, unit)}", hint=hint)


def shape_words(shape: Shape) -> str:
    if not shape:
        return "a single value"
    return "an array of " + " x ".join("n" if x is None else str(x) for x in shape) + " values"


def _has(found: tuple[int, ...], shape: Shape) -> bool:
    """Whether a shape is the declared one, in which None is any number."""
    return len(found) == len(shape) and all(x is None or x == y for x, y in zip(shape, found, strict=True))


def number(q: Quantity, what: str) -> float:
    """A finite float that is known before the start."""
    value = q.value
    if isinstance(value, symbolic.Expr) and symbolic.is_const(value):
        value = value.value
    if isinstance(value, symbolic.Expr):
        raise ModelError(f"{what} must be known before the start; it depends on time or signals")
    try:
        result = float(value)
    except OverflowError:  # a large integer
        result = math.inf
    if not math.isfinite(result):
        raise ModelError(f"{what} is not a finite number")
    return result


def is_vector(value: Value) -> TypeGuard[tuple[Quantity, ...]]:
    """Whether it is an array of single values."""
    return isinstance(value, tuple) and not any(isinstance(x, tuple) for x in value)


def floats(value: Value, what: str) -> Any:
    if isinstance(value, tuple):
        return tuple(floats(v, what) for v in value)
    return number(value, what)


def argument(
    parameter: Parameter, value: Value, owner: str, e: s.Expression | None = None, spatial: bool = False
) -> Any:
    """The value of a component's parameter in SI, checked against its declaration; ``spatial``: of a model in space."""
    return argument_of(parameter, value, f"`{parameter.name}` of `{owner}`", e, spatial)


def argument_of(
    parameter: Parameter, value: Value, what: str, e: s.Expression | None = None, spatial: bool = False
) -> Any:
    """As ``argument``; ``what`` is the parameter in messages."""
    if isinstance(parameter.default, bool):
        if isinstance(value, tuple) or not isinstance(value.value, bool):
            raise ModelError(f"{what}: found {describe(value)}, expected true or false")
        return value.value
    if parameter.choices or parameter.unit == "":
        if isinstance(value, tuple) or not isinstance(value.value, str):
            raise ModelError(f"{what}: found {describe(value)}, expected a text")
        if parameter.choices and value.value not in parameter.choices:
            shown = ", ".join(f'"{c}"' for c in parameter.choices)
            hint = did_you_mean(value.value, parameter.choices)
            raise ModelError(f'{what}: found "{value.value}", expected one of {shown}', hint=hint)
        return value.value
    dimension = None if parameter.unit == ANY else units.dimension(parameter.unit)
    value = fit(value, dimension, what, parameter.unit, e)
    found = values.shape(value)
    if parameter.shape == (3,) and found == (2,) and parameter.unit in ("m", "1"):
        assert isinstance(value, tuple)
        value, found = (*value, Quantity(0.0, units.dimension(parameter.unit))), (3,)  # a vector of the plane: z = 0
    if not any(_has(found, shape) for shape in (parameter.shape, *parameter.or_shapes)):
        right = other_names.in_braces(e, found) if parameter.shape == (2,) else None
        hint = f"a vector of the plane is written `{right}`" if right is not None else _form(parameter, value, spatial)
        raise ModelError(f"{what}: found {shape_words(found)}, expected {shape_words(parameter.shape)}", hint=hint)
    result = floats(value, what)
    for k, x in enumerate(result if isinstance(result, tuple) else (result,)):
        given = value[k] if isinstance(value, tuple) else value
        if parameter.positive and not x > 0.0:
            raise ModelError(f"{what} is {in_unit(x, given)}, it must be positive")
        if parameter.minimum is not None and x < parameter.minimum:
            raise ModelError(f"{what} is {in_unit(x, given)}, it must be at least {in_unit(parameter.minimum, given)}")
    return result


def _form(parameter: Parameter, value: Value, spatial: bool) -> str | None:
    """How a parameter of three values is written, or of one value for which a vector was found."""
    found = values.shape(value)
    if parameter.shape == (3,) and (3, 3) in parameter.or_shapes:
        return f"write `{parameter.name} = {{Ixx, Iyy, Izz}}`, or the matrix with three rows of three values"
    if parameter.shape == (3,) and parameter.unit in ("m", "1"):
        return f"a vector is written `{parameter.name} = {{x, y, z}}`"
    if parameter.name == "g" and found in ((2,), (3,)):
        vector = floats(value, "g")
        if size := math.hypot(*vector):
            along = ", ".join(f"{x / size:.6g}" for x in vector)
            return f"g is the size of the acceleration, n its direction: write `g = {size:g} m/s2, n = {{{along}}}`"
    if not spatial and parameter.shape in ((), (2,)) and found in ((3,), (3, 3)):
        return "for a model in space write `spatial model`"
    return None


def in_unit(x: float, like: Value) -> str:
    """A number in SI units, in the unit that the value ``like`` was written with, if there is one."""
    unit = None if isinstance(like, tuple) else like.unit
    return f"{x:g}" if unit is None else f"{x / unit.factor:g} {unit.text}"


def law(parameter: Parameter, value: Value, owner: str, e: s.Expression | None = None) -> symbolic.Expr:
    """The expression of a component's law, checked against its declaration."""
    what = f"`{parameter.name}` of `{owner}`"
    value = fit(value, units.dimension(parameter.unit) if parameter.unit else None, what, parameter.unit, e)
    if isinstance(value, tuple):
        raise ModelError(f"{what}: found {describe(value)}, expected a single value")
    if isinstance(value.value, symbolic.Expr):
        return value.value
    return symbolic.const(number(value, what))


def spatial_pose(value: Value, what: str) -> tuple[float, ...]:
    """``{x, y}``, ``{x, y, z}``, or ``{x, y, phi}`` with an angle about the z axis: origin and axes (12 numbers)."""
    if not is_vector(value) or len(value) not in (2, 3):
        raise ModelError(f"{what}: found {describe(value)}, expected a position {{x, y, z}}")
    last = value[2] if len(value) == 3 else Quantity(0.0)
    if last.dimension == units.dimension("rad"):  # no number without unit, which adopts one
        x, y, phi = pose(value, what)
        c, s_ = math.cos(phi), math.sin(phi)
        return x, y, 0.0, c, s_, 0.0, -s_, c, 0.0, 0.0, 0.0, 1.0
    fitted = [
        number(fit(p, units.dimension("m"), f"{name} of {what}", "m"), f"{name} of {what}")
        for p, name in zip((*value[:2], last), "xyz", strict=True)
    ]
    return *fitted, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0


def pose(value: Value, what: str) -> tuple[float, float, float]:
    """``{x, y}`` or ``{x, y, phi}``"""
    if not is_vector(value) or len(value) not in (2, 3):
        raise ModelError(f"{what}: found {describe(value)}, expected a position {{x, y}} or a pose {{x, y, phi}}")
    parts = [*value, Quantity(0.0)] if len(value) == 2 else list(value)
    fitted = [
        number(fit(p, units.dimension(unit), f"{name} of {what}", unit), f"{name} of {what}")
        for p, unit, name in zip(parts, ("m", "m", "rad"), ("x", "y", "phi"), strict=True)
    ]
    return fitted[0], fitted[1], fitted[2]
