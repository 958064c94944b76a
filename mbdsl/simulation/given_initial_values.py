"""Initial values that a program gives: a mapping of signals to values, or the final state of another run."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from mbdsl.errors import ModelError, UsageError
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.spatial_coordinates import CARDAN
from mbdsl.expressions.symbolic import Expr, coordinate
from mbdsl.lang.given_values import value
from mbdsl.lang.initial_values import check_target
from mbdsl.mechanism.given_attitudes import given_attitudes
from mbdsl.mechanism.scene import InitialValue, Scene
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.simulation.state_signals import StateSignals

GUESS = "guess"  #: key of a mapping of guesses
SHAPES = "shapes"  #: key of the coordinates of bodies that deform
STATIC = "static"  #: in place of initial values: the equilibrium
FINAL = "final state"  #: key of the final state of a run: guesses that replace all initial values of the model
#: as in the docstring of ``mbdsl.simulate``
Initial = Mapping[str, Any] | StateSignals


def as_mapping(scene: Scene, initial: Initial | str) -> dict[str, Any]:
    """Initial values as a mapping; the final state of a run is a guess for the positions and velocities of all bodies,
    in space also for the angles that count turns. Bodies that deform begin at the coordinates of a run that is at rest.

    The assembly changes them by the residuals of the constraints at the end of the run.

    Raises
    ------
    UsageError
        If a run is empty or has other bodies, or a body deforms.
    """
    if isinstance(initial, Mapping):
        return dict(initial)
    if not isinstance(initial, StateSignals):
        raise UsageError(
            f'initial: found {initial!r}, expected a mapping of signals to values, or "static", the equilibrium',
            hint='e.g. initial={"crank.phi": "30 deg"}, or the Trajectory of another run',
        )
    if not len(initial.t):
        raise UsageError("initial: the trajectory is empty, it has no final state")
    bent, shapes = [body.name for body in scene.bodies() if body.deforms], dict[str, float]()
    if bent and not initial.v[-1].any():
        coordinates = zip(initial.system.names(), initial.q[-1], strict=True)
        shapes = {name: float(x) for name, x in coordinates if name.rpartition(".")[0] in bent}
    elif bent:
        raise UsageError(
            f"initial: `{bent[0]}` deforms, and a run of it cannot begin at the final state of another run",
            hint="`mbdsl.Simulation` saves and restores its `state`",
        )
    known = SignalNames(scene)
    names = known.motion
    if lacking := [name for name in names if name not in initial]:
        raise UsageError(f"initial: the run of {initial.scene.name} has no signal `{lacking[0]}`")
    if scene.spatial:  # attitudes do not contain the turns
        angles = (x for x in known.expressions if ".phi" in x and x.rpartition(".")[2] not in CARDAN and x in initial)
        names += [name for name in angles if known.expressions[name][0].op == "angle"]
    found: dict[str, Any] = {FINAL: {name: float(initial._signal(name)[-1]) for name in names}}
    return found | {SHAPES: shapes} if shapes else found


def with_initial(scene: Scene, initial: Initial | str | None) -> Scene:
    """A scene with these initial values, which replace those of the same signals; "static" is its equilibrium.

    Raises
    ------
    UsageError
        If a signal is unknown or has no initial value, or a value has the wrong dimension.
    """
    if initial is None:
        return scene
    if isinstance(initial, str) and initial == STATIC:
        return replace(scene, steady=True)
    fixed = as_mapping(scene, initial)
    final, guesses, shapes = fixed.pop(FINAL, {}), fixed.pop(GUESS, {}), fixed.pop(SHAPES, {})
    if not isinstance(guesses, Mapping):
        raise UsageError(f'initial: found {guesses!r} for "guess", expected a mapping of signals to values')
    known = SignalNames(scene)
    given = [_value(known, name, x, False) for name, x in {**final, **guesses}.items()]
    given += [_value(known, name, x, True) for name, x in fixed.items()]
    new = {item.target: item for item in given}
    scene = _without_rates(scene, set(new))
    kept = [] if final else [new.pop(item.target, item) for item in scene.initial]
    found = replace(scene, initial=(*kept, *new.values()), deformed=shapes, steady=False)
    try:
        given_attitudes(found.initial)  # it checks them
    except ModelError as problem:
        raise UsageError(f"initial: {problem.message}", hint=problem.hint) from None
    return found


def _without_rates(scene: Scene, given: Collection[Expr]) -> Scene:
    """The scene in which states with a given value do not begin with a given derivative."""
    free = [c for c in scene.states() if c.values["rate"] is not None and coordinate(f"{c.name}.c", "vx") in given]
    if not free:
        return scene
    changed = {c.name: replace(c, values={**c.values, "rate": None}) for c in free}
    return replace(scene, components={**scene.components, **changed})


def _value(known: SignalNames, name: str, given: str | float, fixed: bool) -> InitialValue:
    target, unit = _target(known, name)
    number = value(given, unit, f"the initial value of `{name}`")
    if not math.isfinite(number):
        raise UsageError(f"the initial value of `{name}` is {number}, expected a finite number")
    return InitialValue(name, target, number, fixed)


def _target(known: SignalNames, name: str) -> tuple[Expr, str]:
    """The signal ``name``, or the rate of a signal in ``der(...)``, and its unit."""
    if not isinstance(name, str):
        raise UsageError(f"initial: found {name!r}, expected the name of a signal")
    inner = name[4:-1].strip() if name.startswith("der(") and name.endswith(")") else None
    try:
        if inner is None:
            target, unit = known.scene.signal(name), known.unit(name) or "1"
        else:
            target, unit = der(known.scene.signal(inner)), f"{known.unit(inner) or '1'}/s"
        check_target(name, target, None)
    except ModelError as problem:
        raise UsageError(f"initial: {problem.message}", hint=problem.hint) from None
    except ValueError as problem:
        raise UsageError(f"initial: `{name}`: {problem}") from None
    return target, unit
