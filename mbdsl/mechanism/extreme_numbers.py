"""Arithmetic errors that extreme numbers of a model cause, such as a mass of 1e300 kg.

Such numbers are not forbidden: many models run with them. If a computation ends in an overflow, a division by zero or a
singular matrix, the model is searched for them, and the error names the most extreme one. If there is none, the error
is a defect of mbdsl and is raised unchanged.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from mbdsl.errors import ModelError, Span
from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.scene_parts import Table

#: sizes in SI units beyond which a number of a mechanism is suspected; its square is still a double
LARGE, SMALL = 1e25, 1e-25

P = ParamSpec("P")
R = TypeVar("R")


def blame_extremes(function: Callable[P, R], scene_of: Callable[..., Scene] | None = None) -> Callable[P, R]:
    """Decorate a function of a model: arithmetic errors are attributed to extreme numbers of the model, if it has any.

    The first argument that is a Scene is the model. If there is none, it is ``scene_of(model, parameters, without)``
    with the arguments of these names, or with those in the argument ``given`` or ``asked``.

    Raises
    ------
    ModelError
        In place of ArithmeticError, ValueError and numpy's LinAlgError (which is one), with the number's place.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def blaming(*args: P.args, **named: P.kwargs) -> R:
        try:
            return function(*args, **named)
        except (ArithmeticError, ValueError, RuntimeWarning) as problem:  # warnings, if they are set to be errors
            blamed = _blamed(signature.bind(*args, **named).arguments, problem, scene_of)
            if blamed is None:
                raise
            raise blamed from problem

    return blaming


def _blamed(arguments: dict[str, Any], problem: Exception, scene_of: Callable[..., Scene] | None) -> ModelError | None:
    scene = next((value for value in arguments.values() if isinstance(value, Scene)), None)
    if scene is None and scene_of is not None:
        named = {**arguments, **arguments.get("given", {})}
        if (asked := arguments.get("asked")) is not None:
            named |= vars(asked)
        scene = scene_of(arguments["model"], named.get("parameters"), named.get("without", ()))
    found = [entry for entry in _numbers(scene) if _extreme(entry[1])] if scene is not None else []
    if not found:
        return None
    given = [entry for entry in found if entry[0].startswith("`")]  # rather than positions that follow from them
    name, x, span = max(given or found, key=lambda entry: abs(math.log10(abs(entry[1]))))
    size = "large" if abs(x) > 1.0 else "small"
    return ModelError(
        f"{name} is {x:g}: numbers so {size} cannot be computed with ({' '.join(str(problem).split())})",
        span,
        "numbers are in SI units here; give sizes of a mechanism",
    )


def _extreme(x: float) -> bool:
    return math.isfinite(x) and x != 0.0 and not SMALL <= abs(x) <= LARGE


def _numbers(scene: Scene) -> Iterator[tuple[str, float, Span | None]]:
    """All numbers of a scene: name of the owner, value in SI, place."""
    for c in scene.components.values():
        for name, value in c.values.items():
            for x in _of(value):
                yield f"`{name}` of {c.kind.name} `{c.name}`", x, c.span
    for frame in scene.frames.values():
        for x in frame.pose[:3]:  # in space the axes follow, whose small components are rounding
            yield f"the place of frame `{frame.name}`", x, frame.span
    for initial in scene.initial:
        yield f"the initial value of `{initial.name}`", initial.value, initial.span
    for given in scene.inputs.values():
        yield f"the start of `{given.name}`", given.start, given.span
    for name, expression in scene.variables.items():
        for x in _of(expression):
            yield f"a number of `{name}`", x, None
    for name in ("start", "stop", "interval", "tolerance", "step"):
        for x in _of(getattr(scene.experiment, name)):
            yield f"`{name}` of the experiment", x, None


def _of(value: object) -> Iterator[float]:
    if isinstance(value, Expr):
        for node in walk(value):
            yield from _of(node.value[0] if node.op == "table" else node.value)
    elif isinstance(value, Table):
        yield from (*value.u, *value.y)
    elif isinstance(value, tuple):
        for inner in value:
            yield from _of(inner)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)
