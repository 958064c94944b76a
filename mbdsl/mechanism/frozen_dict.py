"""An immutable mapping, for immutable values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """A dict without the methods that change it. It is hashable if its values are; ``copy()`` is a plain dict."""

    def _refuse(self, *args: Any, **kwargs: Any) -> NoReturn:
        raise TypeError("a scene cannot be changed; make another one, with `dataclasses.replace`")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple:
        return FrozenDict, (dict(self),)


def freeze(owner: object, *fields: str) -> None:
    """Replace the mappings in these fields of a frozen dataclass by immutable ones."""
    for name in fields:
        given: Mapping = getattr(owner, name)
        if not isinstance(given, FrozenDict):
            object.__setattr__(owner, name, FrozenDict(given))
