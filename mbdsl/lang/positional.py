"""A frame that a declaration names, as it is written: it is looked up when frames are known."""

from __future__ import annotations

from typing import Any

from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import PortNode
from mbdsl.lang.entities import Disabled, Many
from mbdsl.lang.flat_component import FlatComponent
from mbdsl.lang.modifiers import Contexts
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write
from mbdsl.mechanism.scene import Frame


class Positional:
    """A frame argument of a declaration; all elements of an array share it."""

    __slots__ = ("_found", "e", "level", "scope")

    def __init__(self, e: s.Expression, scope: Scope, level: int) -> None:
        self.e, self.scope, self.level = e, scope, level
        self._found: Any = None

    def find(self, contexts: Contexts) -> Frame | PortNode | FlatComponent:
        if self._found is None:
            self._found = self.scope.frame(self.e)
        found = self._found
        inside = contexts[self.level :]
        if isinstance(found, Many) and inside:
            index, size = inside[-1]
            if len(found.items) != size:
                raise ModelError(
                    f"`{write(self.e)}` names {len(found.items)} frames for {size} elements", span_of(self.e.at)
                )
            found = found.items[index]
        if isinstance(found, Many):
            raise ModelError(f"`{write(self.e)}` names {len(found.items)} frames, expected one", span_of(self.e.at))
        if isinstance(found, Disabled):
            raise ModelError(f"`{write(self.e)}`: `{found.name}` is switched off by its condition", span_of(self.e.at))
        return found
