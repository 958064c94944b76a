"""Models of Modelica's MultiBody library that are in space, in a text that declares a model in the plane.

Advice about single lines would drop their z components. Therefore the first word that is missing is ``spatial``.
"""

from __future__ import annotations

from collections.abc import Iterator

from mbdsl.errors import ModelError
from mbdsl.lang import inheritance, modelica_names
from mbdsl.lang import syntax as s
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.mistakes import frames
from mbdsl.lang.mistakes.members import STARTS
from mbdsl.lang.mistakes.values import is_zero
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write_argument

#: vectors that have no z component in the plane
_VECTORS = ("r", "r_CM", "rRod_ia", "com", "f", "force", "F")
#: types whose axis ``n`` is that of a rotation, along z in the plane
_TURNING = ("Revolute", "FixedRotation")


def first_of_all(model: s.Model, unit: SourceUnit) -> ModelError | None:
    """The error of a model in the plane, if one of the models that it consists of has values outside of the plane."""
    for m in inheritance.reachable(model, unit):
        if m.spatial:
            continue
        for d in (d for item in m.items for d in inheritance.declarations(item)):
            for argument in _outside(d):
                return ModelError(
                    f"`{m.name}` is in space, but declared in the plane: it has no z axis",
                    span_of(m.at),
                    f"for a model in space write `spatial model {m.name}` first; in the plane leave z out",
                    ((f"`{write_argument(argument)}` of `{d.name}` is not in the plane", span_of(argument.at)),),
                )
    return None


def _outside(d: s.Declaration) -> Iterator[s.Argument]:
    """Arguments of a declaration that have no meaning in the plane."""
    kind = modelica_names.kind(d.type).rpartition(".")[2]
    for a in d.arguments:
        if a.name in ("I_31", "I_32") and not is_zero(a.value):
            yield a
        value = next((x.value for x in a.modifiers if x.name == "start"), a.value)
        if a.name in STARTS and isinstance(value, s.ArrayNode) and len(value.items) == 3:
            x, y, z = (not is_zero(item) for item in value.items)
            if (x or y) if a.name.endswith("_start") else z:
                yield a
        if not isinstance(a.value, s.ArrayNode) or len(a.value.items) != 3:
            continue
        x, y, z = (not is_zero(item) for item in a.value.items)
        if (a.name in _VECTORS and z) or (a.name == "n" and ((x or y) if kind in _TURNING else z)):
            yield a
    if kind == "FixedRotation":
        given = {a.name: a for a in d.arguments if a.value is not None}
        turned = frames.outside({a.name: a.value for a in d.arguments if a.value is not None})
        if turned is not None:
            yield given[turned]
