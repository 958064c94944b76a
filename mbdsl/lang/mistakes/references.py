"""References that name nothing, or something that has no value in a model."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from mbdsl.errors import ModelError
from mbdsl.lang import functions
from mbdsl.lang.entities import Disabled
from mbdsl.lang.flat_component import FlatComponent
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.source import At, span_of
from mbdsl.messages import did_you_mean

if TYPE_CHECKING:
    from mbdsl.lang.scope import Scope


def unknown(scope: Scope, name: str, at: At) -> ModelError:
    known = [*scope.locals, *scope.namespace.names(), *functions.CONSTANTS, "time"]
    if scope.owner is not None:
        known += scope.owner.known_names()
        if scope.owner.output_only(name):
            return output_only(f"{scope.owner.name}.{name}", at)
    if name in ("ground", "world") and scope.namespace.assembly.ground is None:
        return ModelError(f"unknown name `{name}`", span_of(at), f"declare it: `Ground {name};`")
    where = f" in `{scope.namespace.name}`" if scope.namespace.name else ""
    above = scope.namespace.parent
    if above is not None and above.find(name) is not None:
        hint = "a sub-model does not see the names around it; pass it as a parameter or connector"
        if isinstance(above.find(name), FlatComponent) and name == getattr(scope.namespace.assembly.ground, "name", ""):
            hint = f"a sub-model sees the world if it declares `outer Ground {name};`"
        return ModelError(f"unknown name `{name}`{where}", span_of(at), hint)
    if name in ("ground", "world") and scope.namespace.assembly.ground is not None:
        called = scope.namespace.assembly.ground.name
        return ModelError(f"unknown name `{name}`{where}", span_of(at), f"the ground is called `{called}` here")
    hint = did_you_mean(name, known)
    if hint is None and name in functions.FUNCTIONS:
        hint = f"{name}(...) is a function"
    hint = hint or other_names.FUNCTIONS.get(name)
    return ModelError(f"unknown name `{name}`{where}", span_of(at), hint)


def output_only(name: str, at: At) -> ModelError:
    return ModelError(
        f"`{name}` is a result of the simulation, it cannot be used in the model",
        span_of(at),
        "accelerations can be written out, but laws may depend on positions, velocities and reactions only, and "
        "initial values are those of positions, velocities and states",
    )


def size(name: str, known: Collection[str], vector: str, at: At) -> ModelError:
    """The error of a size in a law, with the expression of the components."""
    found = [f"{name}{i}" for i in "xyz" if f"{vector}{i}" in known]
    written = f"hypot({', '.join(found)})" if len(found) == 2 else f"sqrt({' + '.join(f'{x}^2' for x in found)})"
    message = f"`{name}` is a result of the simulation, it cannot be used in the model"
    return ModelError(message, span_of(at), f"write `{written}`")


def disabled(entity: Disabled, name: str) -> ModelError:
    return ModelError(
        f"`{name}` does not exist here: `{entity.name}` is switched off by its condition",
        notes=(("declared here", span_of(entity.at)),) if entity.at else (),
    )
