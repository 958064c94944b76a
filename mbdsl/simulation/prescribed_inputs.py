"""Inputs of a run that are functions of time: points, a function, or a column of a result file.

They take the place of the inputs in the laws of the model, as a ``Table`` of the model would: linear between points,
constant outside of them. Laws of time are known in advance, so that steps end at the points where they bend. A smooth
function becomes a spline, one with jumps or corners straight lines between many points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import TIME, Expr, const, substitute
from mbdsl.kernels.arrays import Array
from mbdsl.lang.given_values import value
from mbdsl.mechanism.reduction.drivers import rewritten
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.scene_parts import Table
from mbdsl.messages import did_you_mean

#: points of a function: at first, at most, and the largest difference of the function from the spline through them,
#: relative to its range
FIRST, MOST, CLOSE = 129, 4097, 1e-7


def with_inputs(scene: Scene, given: Mapping[str, Any], start: float, stop: float | None) -> Scene:
    """The Scene with functions of time in place of some of its inputs.

    Parameters
    ----------
    given : mapping
        Input -> a number or text with a unit, a pair (t, u) of arrays (N,), or a function of time; in SI units.
    start, stop : float [s]
        The run, in which functions are sampled.

    Raises
    ------
    UsageError
        If there is no such input, or its values are not numbers at ascending times.
    """
    laws: dict[str, Expr] = {}
    for name, what in given.items():
        if name not in scene.inputs:
            hint = did_you_mean(name, scene.inputs) or f"its inputs: {', '.join(scene.inputs) or 'none'}"
            raise UsageError(f"{scene.name} has no input `{name}`", hint=hint)
        laws[name] = _law(name, what, scene.inputs[name].unit, start, stop)

    def known(leaf: Expr) -> Expr | None:
        return laws.get(str(leaf.value)) if leaf.op == "input" else None

    return replace(
        scene,
        components={name: rewritten(c, known) for name, c in scene.components.items()},
        variables={name: substitute(x, known) for name, x in scene.variables.items()},
        inputs={name: x for name, x in scene.inputs.items() if name not in laws},
    )


def _law(name: str, what: Any, unit: str, start: float, stop: float | None) -> Expr:
    if isinstance(what, (int, float, str, np.number)):
        return const(value(what, unit, f"input {name}"))  # type: ignore[arg-type]
    if callable(what):
        if stop is None:
            raise UsageError(f"input `{name}`: a function of time needs a stop time", hint="give `stop`")
        t, u, smoothness = _sampled(name, what, start, stop)
    else:
        t, u, smoothness = *_points(name, what), "linear"
    if len(t) == 1 or not np.ptp(u):
        return const(float(u[0]))
    table = Table(f"input {name}", tuple(t.tolist()), tuple(u.tolist()), smoothness)
    return Expr("table", (TIME,), (table, 0))


def _points(name: str, what: Any) -> tuple[Array, Array]:
    hint = f"e.g. inputs={{{name!r}: ([0.0, 1.0], [0.0, 5.0])}}: times [s], and values in SI units"
    try:
        t, u = (np.array(x, float) for x in what)
    except (TypeError, ValueError):
        raise UsageError(f"input `{name}`: found {what!r}, expected a pair (t, u)", hint=hint) from None
    if t.ndim != 1 or t.shape != u.shape or not len(t):
        raise UsageError(f"input `{name}`: t and u have the shapes {t.shape} and {u.shape}", hint=hint)
    if not (np.isfinite(t).all() and np.isfinite(u).all()):
        raise UsageError(f"input `{name}` has values that are not finite numbers")
    if len(bad := np.flatnonzero(np.diff(t) <= 0.0)):
        k = int(bad[0])
        raise UsageError(f"input `{name}`: times must ascend, but {t[k + 1]:g} s follows {t[k]:g} s")
    return t, u


def _sampled(name: str, function: Callable[[float], float], start: float, stop: float) -> tuple[Array, Array, str]:
    """Points of a function, and how they are connected."""
    from scipy.interpolate import CubicSpline

    smoothness = "linear"
    try:
        t = np.linspace(start, stop, FIRST if stop > start else 1)
        u = np.array([float(function(x)) for x in t.tolist()])
        while 1 < len(t) < MOST and np.isfinite(u).all():
            middle = 0.5 * (t[1:] + t[:-1])
            between = np.array([float(function(x)) for x in middle.tolist()])
            off = np.abs(between - CubicSpline(t, u)(middle)).max()
            t, u = _merged(t, middle), _merged(u, between)
            if off <= CLOSE * np.ptp(u):
                smoothness = "cubic"
                break
    except (TypeError, ValueError) as problem:
        reason = f"input `{name}`: the function of time gives no number: {problem}"
        raise UsageError(reason, hint=f"e.g. inputs={{{name!r}: lambda t: 5.0*math.sin(t)}}") from problem
    if not all(map(math.isfinite, u)):
        raise UsageError(f"input `{name}`: the function of time has values that are not finite")
    return t, u, smoothness


def _merged(ends: Array, middle: Array) -> Array:
    found = np.empty(len(ends) + len(middle))
    found[::2], found[1::2] = ends, middle
    return found
