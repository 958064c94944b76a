"""The flat model under construction: collects parts, connections and initial values, then makes a Scene of them.

Both front-ends use it, the text (:mod:`mbdsl.lang.instantiate`) and the library (:mod:`mbdsl.lang.builder`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from mbdsl.elements.kind import BodyKind, Kind, PairKind
from mbdsl.errors import ModelError, ModelNote, ModelWarning
from mbdsl.expressions import spatial_coordinates, symbolic
from mbdsl.lang import declared_display, limits, units
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import NotConnected, PortNode, connect
from mbdsl.lang.display_units import declare
from mbdsl.lang.entities import Disabled, FrameMember, Many, Namespace, Slot
from mbdsl.lang.evaluate import Budget
from mbdsl.lang.events import EventsOfModel
from mbdsl.lang.flat_component import FlatComponent, is_body
from mbdsl.lang.initial_values import InitialValues, check_steady, is_steady
from mbdsl.lang.mistakes import doubts
from mbdsl.lang.modifiers import Contexts
from mbdsl.lang.positional import Positional
from mbdsl.lang.scene_components import components_of, latches_of
from mbdsl.lang.scene_values import values_of
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.states import States
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity
from mbdsl.mechanism.drawn_shapes import DrawnShape
from mbdsl.mechanism.loop_rows import with_rows_in_axes
from mbdsl.mechanism.point_masses import turned_by_joints
from mbdsl.mechanism.scene import Component, Experiment, Frame, Scene
from mbdsl.messages import count, few

if TYPE_CHECKING:
    from mbdsl.lang.library import Library

_COORDINATE_UNIT = {"x": "m", "y": "m", "phi": "rad", "vx": "m/s", "vy": "m/s", "w": "rad/s"}
_COORDINATE_DIMENSION = {key: units.dimension(unit) for key, unit in _COORDINATE_UNIT.items()}


class Assembly:
    """All components, connections and initial values of a model."""

    def __init__(self, spatial: bool = False) -> None:
        self.spatial = spatial
        self.budget = Budget()
        self.parts: dict[str, FlatComponent] = {}
        #: what components without modifiers share, of each kind: as Template.shared
        self.plain: dict[Kind, tuple[dict, dict, set[str]]] = {}
        self.frames: list[FrameMember | PortNode] = []
        self.slots: list[Slot] = []
        self.states = States(spatial)
        self.events = EventsOfModel(self.states)
        self.ground: FlatComponent | None = None
        self.without: tuple[str, ...] = ()  #: effects to leave out
        self.library: Library | None = None  #: the files of a model that was read from a text
        self._active: dict[object, tuple[str, At]] = {}
        self._attachments: list[tuple[FlatComponent, list[Positional]]] = []
        self._connectors: list[tuple[PortNode, Positional, Contexts]] = []
        self._connects: list[tuple[s.Expression, s.Expression, Scope, At]] = []
        self._initial: list[tuple[s.Initial, Scope]] = []
        self._steady: s.Initial | None = None  # that lets the model start at its equilibrium
        self.passed: list[s.Passed] = []  #: statements and settings without an effect
        self._warnings: dict[object, ModelWarning] = {}

    # -- collecting --------------------------------------------------------------------------------------------

    @contextmanager
    def defining(self, key: object, label: str, at: At) -> Iterator[None]:
        """While the block runs, a second request for ``key`` is an error that shows the cycle."""
        if key in self._active:
            names = list(self._active.values())
            circle = names[list(self._active).index(key) :]
            shown = " -> ".join(name for name, _ in [*circle, circle[0]])
            notes = tuple((f"{name} is defined here", span_of(where)) for name, where in circle[1:] if where)
            varies = any(isinstance(x, Slot) and not x.constant for x in [*self._active][-len(circle) :])
            name = circle[0][0].strip("`")
            hint = f"break the circle by a state, `der(y) = ({name} - y)/T`, or by `pre({name})` in a `when`"
            raise ModelError(f"cyclic definition: {shown}", span_of(circle[0][1]), hint if varies else None, notes[:5])
        self._active[key] = (label, at)
        try:
            with placed(at):
                yield
        finally:
            del self._active[key]

    def add(self, part: FlatComponent, positional: list[Positional]) -> None:
        """Add a component with its positional arguments."""
        if len(self.parts) >= limits.COMPONENTS:
            raise ModelError(f"more than {limits.COMPONENTS} components", span_of(part.at))
        if positional and is_body(part):
            p = positional[0]
            if not isinstance(p.e, s.Reference) and part.kind.parameters:
                first = part.kind.parameters[0].name
                raise ModelError(
                    f"found the value `{write(p.e)}` without a name",
                    span_of(p.e.at),
                    f"write `{first} = {write(p.e)}`",
                )
            raise ModelError(
                f"{part.kind.name} `{part.name}` is a body and takes no frames",
                span_of(p.e.at),
                "give its parameters by name, and hold it with joints",
            )
        if isinstance(part.kind, BodyKind) and not part.kind.coordinates:
            if self.ground is not None:
                raise ModelError(
                    f"a second {part.kind.name} `{part.name}`: there is one world",
                    span_of(part.at),
                    f"fix points of it with `Frame p({self.ground.name}, r = {{x, y}});`; "
                    f"sub-models share it by `outer Ground {self.ground.name};`",
                    (("the first one is here", span_of(self.ground.at)),) if self.ground.at else (),
                )
            self.ground = part
        self.parts[part.name] = part
        if positional or any(port in part.template.modifiers for port in part.kind.ports):
            self._attachments.append((part, positional))

    def attach_connector(self, node: PortNode, positional: Positional, contexts: Contexts) -> None:
        self._connectors.append((node, positional, contexts))

    def connect(self, first: s.Expression, second: s.Expression, scope: Scope, at: At) -> None:
        self._connects.append((first, second, scope, at))

    def initial(self, item: s.Initial, scope: Scope) -> None:
        if item.mode != "state":
            self._initial.append((item, scope))
        elif (steady := is_steady(item)) and scope.namespace.name:
            hint = "the main model says whether the whole mechanism starts at its equilibrium"
            self.warn(f"`initial(state = steady)` of `{scope.namespace.name}` does not count here", item.at, hint)
        elif not scope.namespace.name:
            self._steady = item if steady else None

    def warn(self, message: str, at: At, hint: str) -> None:
        """Add a warning, unless there is one about this place."""
        span = span_of(at)
        self._warnings.setdefault(span or message, ModelWarning(message, span, hint))

    def _note_passed(self) -> None:
        """Add one note about all that was passed over."""
        if self.passed:
            shown = few(dict.fromkeys(f"`{item.text}`" for item in self.passed))
            hint = (
                "imports of Modelica's library and settings for animation, states, flanges, checks or other programs "
                "do not change the motion"
            )
            self._warnings[self] = ModelNote(f"ignored: {shown}", span_of(self.passed[0].at), hint)

    # -- frames ------------------------------------------------------------------------------------------------

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates of a frame."""
        return spatial_coordinates.NAMES if self.spatial else symbolic.COORDINATES

    def coordinate(self, frame: Frame, key: str) -> Quantity:
        """A coordinate of a frame as an expression."""
        if self.spatial:
            unit = spatial_coordinates.UNITS[key]
            return Quantity(spatial_coordinates.named(frame.name, key), units.dimension(unit))
        return Quantity(symbolic.coordinate(frame.name, key), _COORDINATE_DIMENSION[key])

    def connect_new(self) -> None:
        """Make the connections that were declared since the last call."""
        attachments, connectors, connects = self._attachments, self._connectors, self._connects
        self._attachments, self._connectors, self._connects = [], [], []
        for part, positional in attachments:
            self._attach(part, positional)
        for node, argument, contexts in connectors:
            found = argument.find(contexts)
            if isinstance(found, FlatComponent):
                raise ModelError(
                    f"`{found.name}` is a {found.kind.name}, expected a frame for `{node.name}`", span_of(argument.e.at)
                )
            connect(node, found, argument.e.at)
        for first, second, scope, at in connects:
            self._connect(self._ends(first, scope), self._ends(second, scope), at, scope.namespace.name)

    def connect_all(self) -> None:
        """Determine the frame of every port."""
        self.connect_new()
        for part in self.parts.values():
            for port in part.kind.optional_ports:
                if part.nodes[port].frame is None:
                    connect(part.nodes[port], self.world(part), part.at)

    def world(self, part: FlatComponent) -> Frame:
        """The frame of an optional port that is not connected."""
        if self.ground is None:
            raise NotConnected(
                f"{part.kind.name} `{part.name}` acts from the ground, but none is declared",
                span_of(part.at),
                "declare it: `Ground ground;`",
            )
        return self.ground.frames["c"]

    def _attach(self, part: FlatComponent, positional: list[Positional]) -> None:
        kind = part.kind
        found = [(p.find(part.contexts), p.e.at) for p in positional]
        named = [port for port in kind.ports if port in part.template.modifiers]
        if len(found) == 1 and isinstance(kind, PairKind) and kind.ports and isinstance(found[0][0], FlatComponent):
            other, at = found[0]
            assert isinstance(other, FlatComponent)
            if other is part:
                raise ModelError(f"`{part.name}` cannot be attached to itself", span_of(at))
            if not other.nodes:
                raise ModelError(
                    f"`{other.name}` is a {other.kind.name} and has no frames, expected those of a joint", span_of(at)
                )
            part.follow(other)
            for port in kind.ports:
                connect(part.nodes[port], other.nodes[port], at)
            return
        free = [port for port in kind.ports if port not in named]
        if len(found) == 1 and kind.optional_ports and len(free) == len(kind.ports):
            free = [port for port in free if port not in kind.optional_ports]
        if len(found) > len(free):
            frames = f"its frames are {' and '.join(kind.ports)}; everything else" if kind.ports else "everything"
            hint = f"write a {kind.name} for each frame" if len(kind.ports) == 1 else f"{frames} is given by name"
            raise ModelError(
                f"{kind.name} `{part.name}` takes {count(len(kind.ports), 'frame')}, found {len(found) + len(named)}",
                span_of(found[len(free)][1]),
                hint,
            )
        for port, (frame, at) in zip(free, found, strict=False):
            if isinstance(frame, FlatComponent):
                both = f"; alone, as `{kind.name} {part.name}({frame.name})`, it stands for both"
                raise ModelError(
                    f"`{frame.name}` is a {frame.kind.name}, expected a frame for `{port}` of `{part.name}`",
                    span_of(at),
                    f"its ports are {', '.join(f'{frame.name}.{p}' for p in frame.nodes)}"
                    + (both if isinstance(kind, PairKind) else ""),
                )
            connect(part.nodes[port], frame, at)
        for port in named:
            modifier = part.template.modifiers[port]
            if modifier.value is None:
                raise ModelError(f"`{port}` of `{part.name}` takes a frame", span_of(modifier.at))
            frame = Positional(modifier.value, modifier.scope, modifier.level).find(part.contexts)
            if isinstance(frame, FlatComponent):
                raise ModelError(
                    f"`{frame.name}` is a {frame.kind.name}, expected a frame for `{port}`", modifier.value_span()
                )
            connect(part.nodes[port], frame, modifier.value.at)

    def _ends(self, e: s.Expression, scope: Scope) -> list[tuple[Frame | PortNode | None, At]]:
        found = scope.frame(e)
        ends: list[tuple[Frame | PortNode | None, At]] = []
        for item in found.items if isinstance(found, Many) else [found]:
            if isinstance(item, FlatComponent):
                raise ModelError(
                    f"`{item.name}` is a {item.kind.name}, expected one of its ports",
                    span_of(e.at),
                    f"its ports: {', '.join(f'{item.name}.{p}' for p in item.nodes)}",
                )
            ends.append((None if isinstance(item, Disabled) else item, e.at))
        return ends

    def _connect(self, first: list, second: list, at: At, inside: str) -> None:
        if len(first) != len(second):
            raise ModelError(f"connect() of {len(first)} frames with {len(second)}", span_of(at))
        for (a, _), (b, where) in zip(first, second, strict=True):
            if a is not None and b is not None:  # connections of disabled components are ignored
                connect(a, b, where, inside)

    # -- the result --------------------------------------------------------------------------------------------

    def _leave_out(self, effects: Iterable[str]) -> None:
        """Leave out further effects; values that depend on them are forgotten."""
        left_out = tuple(dict.fromkeys((*self.without, *effects)))
        if left_out != self.without:
            self.without = left_out
            self.plain.clear()
            for part in self.parts.values():
                part.forget()

    def _declared_frames(self) -> tuple[dict[str, Frame], dict[str, str]]:
        """Frames that have been declared, and other names of frames."""
        frames, aliases = dict[str, Frame](), dict[str, str]()
        for member in self.frames:
            found = member.target() if isinstance(member, FrameMember) else member
            frame = found.frame if isinstance(found, PortNode) else found
            if frame is not None and frame.name == member.name:
                frames[frame.name] = frame
            elif frame is not None:
                aliases[member.name] = frame.name
        return frames, aliases

    def scene(self, root: Namespace, name: str, doc: str = "", experiment: Experiment | None = None) -> Scene:
        """Complete the checks and make the Scene."""
        self._leave_out(experiment.without if experiment else ())
        for part in self.parts.values():
            part.values  # noqa: B018  errors in values come before those of connections
        self.connect_all()
        if self.ground is None:
            first = next((p for p in self.parts.values() if is_body(p)), None)
            message = "the model has no ground" if first or self.parts else "the model has no components"
            where = span_of(first.at) if first is not None else None
            raise NotConnected(message, where, "declare it: `Ground ground;`")
        parameters, variables, descriptions, inputs, display = values_of(self.slots, root)
        components: dict[str, Component] = {c.name: c for part in self.parts.values() for c in components_of(part)}
        frames = {frame.name: frame for part in self.parts.values() if is_body(part) for frame in part.frames.values()}
        if self.spatial:
            turned = (part.own_frame(port) for part in self.parts.values() for port in part.nodes)
            frames |= {frame.name: frame for frame in turned if frame.name not in frames}
        declared, aliases = self._declared_frames()
        frames |= declared
        initial = tuple(InitialValues(self.parts.values(), self._initial, self.warn, self.states).values())
        if self.states:
            for state, rate, description in self.states.variables():
                variables[state], descriptions[state] = rate, description
            components |= self.states.components(self.ground.frames["c"])
            frames |= self.states.frames()
            initial = (*initial, *self.states.initial({x.name: x for x in initial}))
        if self._steady is not None:
            check_steady(self._steady, initial, {self.states.value(x) for x in self.states})
        self.events.refuse_instants(components.values())
        self._doubt_names()
        self._note_passed()
        components = turned_by_joints(components, frames)
        return Scene(
            name,
            with_rows_in_axes(components, frames) if self.spatial else components,
            frames,
            initial,
            experiment or Experiment(),
            parameters,
            doc,
            self.library.files if self.library is not None else {},  # now that all tables have been read
            variables=variables,
            descriptions=descriptions,
            inputs=inputs,
            without={x: tuple(p.name for p in self.parts.values() if x in p.lacks) for x in self.without},
            aliases=aliases,
            shapes=self._shapes(),
            warnings=tuple(self._warnings.values()),
            spatial=self.spatial,
            steady=self._steady is not None,
            events=self.events.finished(
                {x.name for x in frames.values() if x.motion is None and not components[x.body].coordinates}
            ).latching((*x, span_of(part.at)) for part in self.parts.values() for x in latches_of(part)),
            display=declare(display | declared_display.of_signals(self.parts.values())),
        )

    def _doubt_names(self) -> None:
        for slot in self.slots:
            doubts.hidden_pi(self.warn, slot.name, slot.value(), slot.at)
        for item in (*self.parts.values(), *self.frames):
            doubts.hidden_pi(self.warn, item.name, None, item.at)

    def _shapes(self) -> dict[str, tuple[DrawnShape, ...]]:
        """Shapes of bodies by their names; elements of an array share theirs."""
        found: dict[str, tuple[DrawnShape, ...]] = {}
        known: dict[tuple[int, int], tuple[DrawnShape, ...] | None] = {}
        points = 0
        for part in self.parts.values():
            for arguments, scope in part.drawn:
                from mbdsl.lang.shapes import read_shapes, total

                key = id(arguments), id(scope)
                if key not in known:
                    known[key] = read_shapes(arguments, scope)
                if (shapes := known[key]) is not None:
                    points = total(shapes, points, part.at)
                    found[part.name] = found.get(part.name, ()) + shapes
        return found
