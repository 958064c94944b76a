"""Connections of ports and frames: ports that are connected share one frame."""

from __future__ import annotations

import re

from mbdsl.errors import ModelError
from mbdsl.lang.source import At, span_of
from mbdsl.mechanism.scene import Frame


class NotConnected(ModelError):
    """A port has no frame. While a model is built from Python, it may be connected later."""


class PortNode:
    """A port of a joint or force, or a connector of a sub-model; after all connections it has a frame."""

    __slots__ = ("_above", "_at", "_frame", "at", "name")

    def __init__(self, name: str, at: At = None) -> None:
        self.name = name
        self.at = at
        self._above: PortNode | None = None
        self._frame: Frame | None = None
        self._at: At = None

    def _top(self) -> PortNode:
        top = self
        while top._above is not None:
            top = top._above
        while self is not top:  # path compression
            self._above, self = top, self._above
        return top

    @property
    def frame(self) -> Frame | None:
        return self._top()._frame


def connect(a: PortNode | Frame, b: PortNode | Frame, at: At, inside: str = "") -> None:
    """Record that ``a`` and ``b`` are the same frame; ``inside`` is the sub-model of the connection, for messages.

    Raises
    ------
    ModelError
        If they are already two different frames.
    """
    if isinstance(a, Frame) and isinstance(b, Frame):
        if a is not b:
            raise _rigid(a, b, at, inside)
        return
    if isinstance(a, Frame):
        a, b = b, a
    assert isinstance(a, PortNode)
    top = a._top()
    if isinstance(b, Frame):
        if top._frame is None:
            top._frame, top._at = b, at
        elif top._frame is not b:
            raise _twice(a.name, top._frame, top._at, b, at, inside)
        return
    other = b._top()
    if other is top:
        return
    if top._frame is not None and other._frame is not None and top._frame is not other._frame:
        raise _twice(b.name, other._frame, other._at, top._frame, at, inside)
    if top._frame is None:
        top._frame, top._at = other._frame, other._at
    other._above = top


def _rigid(a: Frame, b: Frame, at: At, inside: str) -> ModelError:
    """The error of a connection without a joint, which in Modelica is rigid."""
    if a.body == b.body:
        return ModelError(
            f"`{a.name}` and `{b.name}` are frames of the same body, they cannot be connected",
            span_of(at),
            "delete this connection",
        )
    return ModelError(
        f"`{a.name}` and `{b.name}` are frames of bodies, they cannot be connected directly",
        span_of(at),
        f"rigidly, as in Modelica: delete this connection and declare `{_weld(a, b, inside)}`; or declare a joint",
    )


def _weld(a: Frame, b: Frame, inside: str) -> str:
    """The weld that stands for a rigid connection, with the names of the sub-model in which it is."""
    bodies, frames = ([x.removeprefix(f"{inside}.") for x in names] for names in ((a.body, b.body), (a.name, b.name)))
    name = re.sub(r"\W+", "_", "_".join(bodies)).strip("_")
    return f"Fixed {name}({', '.join(frames)});"


def _twice(name: str, first: Frame, first_at: At, second: Frame, at: At, inside: str) -> ModelError:
    place = span_of(first_at)
    hint = "a port sits on one frame; bodies meet through joints"
    if first.body != second.body:
        hint += f"; rigidly, as in Modelica: delete this connection and declare `{_weld(first, second, inside)}`"
    return ModelError(
        f"`{name}` is connected twice: to `{first.name}` and to `{second.name}`",
        span_of(at),
        hint,
        (("first connected here", place),) if place else (),
    )
