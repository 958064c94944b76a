"""Handles: what the methods of a Builder return, for use as arguments of other methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, SupportsFloat, TypeAlias, TypedDict

from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import Expr
from mbdsl.messages import did_you_mean


class Owner(Protocol):
    """The model that a handle belongs to."""

    name: str

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates of a frame."""

    def names_of(self, handle: Handle) -> Sequence[str]:
        """Names of the attributes of a component."""


class Handle:
    """A component, frame or signal of a model under construction.

    Its attributes are its frames, ports and signals: ``rod.b``, ``rod.b.x``, ``pin.phi``. ``str()`` returns its full
    name. Handles are made by the methods of ``Builder``; those of another Builder and those of removed components are
    refused as arguments.

    Parameters
    ----------
    owner : Owner
        The model.
    root : str
        Name of the component.
    serial : int
        Number of its declaration; a component that is added after a removal has another number.
    path : str, optional
        Name of the frame or signal in the component, such as "b.x".
    """

    __slots__ = ("_owner", "_path", "_root", "_serial")

    def __init__(self, owner: Owner, root: str, serial: int, path: str = "") -> None:
        self._owner, self._root, self._serial, self._path = owner, root, serial, path

    def __getattr__(self, name: str) -> Handle:
        if name.startswith("__") or name in ("_owner", "_root", "_serial", "_path"):
            raise AttributeError(name)
        known = self._names()
        if name not in known:
            hint = did_you_mean(name, known, "it has")
            raise AttributeError(f"`{self}` has no `{name}`" + (f"; {hint}" if hint else ""))
        return Handle(self._owner, self._root, self._serial, f"{self._path}.{name}" if self._path else name)

    def __setattr__(self, name: str, value: object) -> None:
        if name not in Handle.__slots__:
            hint = (
                f"values are given where it is declared; to change it, declare `{self._root}` again with replace=True"
            )
            raise UsageError(f"`{self}.{name}` cannot be assigned", hint=hint)
        object.__setattr__(self, name, value)

    def _names(self) -> Sequence[str]:
        if not self._path:
            return self._owner.names_of(self)
        coordinates = self._owner.coordinates
        return () if self._path.split(".")[-1] in coordinates else coordinates

    def __dir__(self) -> list[str]:
        return list(self._names())

    def __str__(self) -> str:
        return f"{self._root}.{self._path}" if self._path else self._root

    def __repr__(self) -> str:
        return f"<{self} of {self._owner.name}>"


def _no_expression(self: Handle, *others: object) -> Handle:
    """Raise the error of a calculation with handles.

    Raises
    ------
    UsageError
        Always.
    """
    hint = f'write it as a text, such as "2*{self}"; an f-string has it by `{{...}}`'
    raise UsageError(f"`{self}` is a name of the model: Python cannot calculate with it or compare it", hint=hint)


for _operator in "neg add radd sub rsub mul rmul truediv rtruediv pow rpow lt le gt ge".split():
    setattr(Handle, f"__{_operator}__", _no_expression)


class Convertible(Protocol):
    """An array of numpy, a column of pandas."""

    def tolist(self) -> Any: ...


class StartValue(TypedDict, total=False):
    """The initial value of a signal; without ``fixed``, assembly may change it."""

    start: Number
    fixed: bool | str


#: a number in SI units, a text with its unit, or a parameter
Number: TypeAlias = SupportsFloat | str | Handle
#: a text or an expression of time and signals
Law: TypeAlias = SupportsFloat | str | Handle | Expr
Vector: TypeAlias = Sequence[SupportsFloat | str | Handle] | Convertible | str | Handle
#: a frame or port, as a handle or by its name
Place: TypeAlias = Handle | str
Places: TypeAlias = Place | Sequence[Place]
Frames: TypeAlias = Mapping[str, Vector | Mapping[str, Number | Vector]]
