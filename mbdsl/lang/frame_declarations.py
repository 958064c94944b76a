"""Frames with names of their own: fixed to a body, relative to another frame, or an alias of a frame."""

from __future__ import annotations

from math import cos, sin

from mbdsl.elements.kind import is_point
from mbdsl.errors import ModelError
from mbdsl.lang import argument_checks, orientations, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import PortNode
from mbdsl.lang.entities import FrameMember
from mbdsl.lang.flat_component import FlatComponent, frame_at, is_body
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.mistakes import doubts
from mbdsl.lang.mistakes.names import in_braces
from mbdsl.lang.modifiers import Contexts, Modifiers, refuse_inner
from mbdsl.lang.positional import Positional
from mbdsl.lang.scope import as_frame
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.unparse import write
from mbdsl.mechanism.poses import SpatialPose
from mbdsl.mechanism.scene import Frame
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.messages import did_you_mean


def _base(base: Positional, contexts: Contexts) -> tuple[str, Frame | None]:
    """The body that a frame is fixed to, and the frame on it; None: the reference point, by the body's bare name."""
    entity = base.scope.resolve(base.e) if isinstance(base.e, s.Reference) else None
    if isinstance(entity, FlatComponent) and is_body(entity):
        return entity.name, None
    found = base.find(contexts)
    if not isinstance(found, Frame):
        message = f"`{write(base.e)}` is a port or connector, a Frame is fixed to a body or to its frames"
        raise ModelError(message, span_of(base.e.at))
    return found.body, found


def fixed_frame(name: str, base: Positional, modifiers: Modifiers, contexts: Contexts, at: At) -> Frame:
    """A frame at a given pose on a body, or relative to another frame."""
    if base.scope.namespace.assembly.spatial:
        return _in_space(name, base, modifiers, contexts, at)
    body, on = _base(base, contexts)
    x0, y0, phi0 = (0.0, 0.0, 0.0) if on is None else (on.x, on.y, on.phi)
    x = y = phi = 0.0
    if (r := modifiers.get("r")) is not None and r.value is not None:
        with placed(r.value.at):
            picked = r.pick(r.evaluate(), 1, contexts)
            if values.shape(picked) != (2,):
                right = in_braces(r.value, values.shape(picked))
                hint = f"write `r = {right}`" if right is not None else None
                what = f"found {values.describe(picked)}, expected a position {{x, y}}"
                raise ModelError(f"`r` of `{name}`: {what}", hint=hint)
            x, y, _ = argument_checks.pose(picked, f"`r` of `{name}`")
    if (angle := modifiers.get("phi")) is not None and angle.value is not None:
        with placed(angle.value.at):
            what = f"`phi` of `{name}`"
            value = angle.pick(angle.evaluate(), 0, contexts)
            q = argument_checks.fit(value, units.NUMBER, what, "rad", angle.value)
            doubts.angle(base.scope.namespace.assembly.warn, value, angle.value, what)
            phi = argument_checks.floats(q, what)
            if isinstance(phi, tuple):
                raise ModelError(f"{what}: found an array, expected a single angle")
    c, sn = cos(phi0), sin(phi0)
    return _checked(base, Frame(name, body, x0 + c * x - sn * y, y0 + sn * x + c * y, phi0 + phi, span_of(at)))


def _in_space(name: str, base: Positional, modifiers: Modifiers, contexts: Contexts, at: At) -> Frame:
    """As ``fixed_frame``, in space: see :mod:`mbdsl.lang.orientations`."""
    body, on = _base(base, contexts)
    pose, turn = (SpatialPose.of_axes(SpatialFrame.axes), 0.0) if on is None else (on.pose, on.phi)
    own, more = orientations.pose(f"`{name}`", modifiers, contexts, at, base.scope.namespace.assembly.warn)
    return _checked(base, frame_at(name, body, pose @ own, span_of(at), turn + more))


def _checked(base: Positional, frame: Frame) -> Frame:
    """The frame; at a point mass, it has to be at the point."""
    kind = base.scope.namespace.assembly.parts[frame.body].kind
    if any(frame.pose[: 3 if kind.spatial else 2]) and is_point(kind):
        raise ModelError(
            f"`{frame.name}` is not at the point mass `{frame.body}`, which has no extent",
            frame.span,
            f"leave out `r`, or write `Body {frame.body}(m = ..., I = ..., frames({frame.name} = ...))`",
        )
    return frame


def declared_frame(
    assembly: Assembly,
    name: str,
    contexts: Contexts,
    d: s.Declaration,
    arguments: list[Positional],
    modifiers: Modifiers,
    value: Positional | None,
) -> PortNode | FrameMember:
    """A connector, another name of a frame, or a frame that is fixed to a body."""
    if value is not None:
        if arguments or modifiers:
            where = arguments[0].e.at if arguments else next(iter(modifiers.values())).at
            raise ModelError(
                f"`{name}` is an alias of `{write(value.e)}` and takes no arguments",
                span_of(where),
                f"write a frame with another pose as `Frame {d.name}({write(value.e)}, r = {{x, y}});`",
            )
        member = FrameMember(assembly, name, lambda: alias(value, contexts), d.at)
        assembly.frames.append(member)
        return member
    if not arguments:
        if modifiers:
            first = next(iter(modifiers.values()))
            raise ModelError(
                f"`{name}` is a connector, it has no parameters",
                span_of(first.at),
                f"a frame fixed to a body names it first: `Frame {d.name}(ground, r = {{x, y}});`",
            )
        node = PortNode(name, d.at)
        assembly.frames.append(node)
        return node
    if len(arguments) > 1:
        raise ModelError("a Frame is fixed to one body or frame", span_of(arguments[1].e.at))
    known = tuple(orientations.PARAMETERS) if assembly.spatial else ("r", "phi")
    for key, modifier in modifiers.items():
        if key not in known:
            hint = did_you_mean(key, known, "a Frame has")
            if key in orientations.PARAMETERS:
                hint = "in a planar model a Frame has `r` and `phi`; models in space begin with `spatial model`"
            raise ModelError(f"a Frame has no `{key}`", span_of(modifier.at), hint)
        refuse_inner(modifier, f"`{key}` of Frame `{name}`", f"write `{key} = ...`")
    make = lambda: fixed_frame(name, arguments[0], modifiers, contexts, d.at)  # noqa: E731
    member = FrameMember(assembly, name, make, d.at, lambda: arguments[0].find(contexts))
    assembly.frames.append(member)
    return member


def alias(argument: Positional, contexts: Contexts) -> Frame | PortNode:
    found = argument.find(contexts)
    if isinstance(found, FlatComponent):
        found = as_frame(found, argument.e)
    if not isinstance(found, Frame | PortNode):
        raise ModelError(f"`{write(argument.e)}` is not a frame", span_of(argument.e.at))
    return found
