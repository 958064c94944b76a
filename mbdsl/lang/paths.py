"""Components along a path over several frames, such as ropes: the frames in `over`, and a component for each span."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

from mbdsl.elements.kind import ForceKind, is_point
from mbdsl.errors import ModelError
from mbdsl.expressions.symbolic import Expr
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import NotConnected, PortNode
from mbdsl.lang.entities import Disabled, Many
from mbdsl.lang.modifiers import Modifier
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write
from mbdsl.mechanism.scene import Component, Frame

if TYPE_CHECKING:
    from mbdsl.elements.rope_path import Path
    from mbdsl.lang.flat_component import FlatComponent


HINT = "name frames at the centres of the discs, or bodies: `over = {wheel, block.sheave}`"


def frames_over(modifier: Modifier | None) -> list[Frame | PortNode]:
    """The frames that the parameter `over` names; a body stands for its centre of mass.

    Raises
    ------
    ModelError
        If one of the names is neither a frame nor a body.
    """
    if modifier is None or modifier.value is None:
        return []
    items = modifier.value.items if isinstance(modifier.value, s.ArrayNode) else (modifier.value,)
    return [found for e in items for found in _named(e, modifier)]


def _named(e: s.Expression, modifier: Modifier) -> Iterator[Frame | PortNode]:
    if not isinstance(e, s.Reference):
        raise ModelError(f"`over`: found `{write(e)}`, expected a frame or a body", span_of(e.at), HINT)
    found = modifier.scope.frame(e, centred=True)
    for x in found.items if isinstance(found, Many) else [found]:
        if isinstance(x, Disabled):
            raise ModelError(f"`{write(e)}`: `{x.name}` is switched off by its condition", span_of(e.at))
        if not isinstance(x, Frame | PortNode):
            what = f"`over`: `{write(e)}` is a {x.kind.name}, expected a body or one of its frames"
            raise ModelError(what, span_of(e.at), HINT)
        yield x


def _frames(part: FlatComponent, over: Modifier | None) -> list[Frame]:
    found = []
    for x in frames_over(over):
        frame = x.frame if isinstance(x, PortNode) else x
        if frame is None:
            raise NotConnected(f"`{x.name}`, which `{part.name}` runs over, is not connected", span_of(part.at))
        found.append(frame)
    frames = [part.port_frame("frame_a"), *found, part.port_frame("frame_b")]
    for a, b in pairwise(frames):
        if a.name == b.name:
            where = over.value_span() if over is not None else span_of(part.at)
            raise ModelError(f"{part.kind.name} `{part.name}` runs from `{a.name}` to the same frame", where)
    return frames


def path_of(part: FlatComponent, over: Modifier | None) -> Path:
    """The path of a part, over the frames that its parameter `over` names."""
    frames = _frames(part, over)
    if part.values["mu"] is None:
        for frame in frames[1:-1]:
            body = part.assembly.parts[frame.body].kind
            if not body.coordinates or is_point(body):
                assert over is not None
                what = f"{part.kind.name} `{part.name}` cannot turn the disc at `{frame.name}`"
                raise ModelError(
                    f"{what}: a {body.name} does not turn",
                    over.value_span(),
                    "`mu = 0.3` lets it slide with friction, `mu = 0` without",
                )

    def coordinate(frame: Frame, key: str) -> Expr:
        return part.assembly.coordinate(frame, key).expression

    at: list[Callable[[str], Expr]] = [partial(coordinate, frame) for frame in frames]
    assert isinstance(part.kind, ForceKind) and part.kind.path is not None
    return part.kind.path(part.values, at, part.assembly.spatial)


def spans(part: FlatComponent, over: Modifier | None) -> list[Component]:
    """A component for each span of the path: the first has the name and the signals of the part."""
    path, frames = part.path, _frames(part, over)
    made: list[Component] = []
    own = [f"{part.name}.span{j + 1}" if j else part.name for j in range(len(path.spans))]
    for j, span in enumerate(path.spans):
        values = {**part.values, "ends": (span.a.radius, span.b.radius), "searched": path.searched}
        values |= {"straight": span.straight, "longer": path.longer(j), "last": own[-1]}
        values |= {"wrap": path.wraps[j - 1]} if j else {}
        values |= path.of_span(j) if j else path.signals
        ports = {"frame_a": frames[j].name, "frame_b": frames[j + 1].name}
        names, doc = (("tension", "s"), "") if j else (part.signal_names(), part.doc)
        made.append(Component(own[j], part.kind, values, ports, names, span_of(part.at), doc))
    return [replace(made[0], energy=path.energy), *made[1:]]
