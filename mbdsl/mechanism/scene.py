"""The Scene: a flat list of components with numbers resolved to SI and source places kept.

Text (:mod:`mbdsl.lang`) and the library API (:class:`mbdsl.lang.builder.Builder`) both produce it; everything
downstream reads only the Scene.

A Scene is a value. It cannot be changed (``dataclasses.replace`` makes another one), it is equal to scenes of the same
content, it can be pickled, and nothing in it refers to the text that it was read from except positions for messages.
Positions, documentation and source files do not count in comparisons.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Protocol

from mbdsl.display_unit import OWN, UnitsOfSignals
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, PairKind, SensorKind
from mbdsl.errors import ModelError, ModelWarning, Span, UsageError
from mbdsl.expressions import formulas, spatial_coordinates
from mbdsl.expressions.symbolic import COORDINATES, RATE, Expr, coordinate, der, substitute
from mbdsl.mechanism import contacts as rigid
from mbdsl.mechanism import wrenches
from mbdsl.mechanism.canonical_text import canonical_text
from mbdsl.mechanism.contacts import Contact, contact_of, is_contact
from mbdsl.mechanism.drawn_shapes import DrawnShape
from mbdsl.mechanism.events import Events
from mbdsl.mechanism.frozen_dict import freeze
from mbdsl.mechanism.scene_parts import (
    Component,
    Description,
    Experiment,
    Frame,
    InitialValue,
    Input,
    Load,
    ParameterValue,
)
from mbdsl.mechanism.signals import Formulas
from mbdsl.mechanism.sticking import Sticking, in_loops, sticks
from mbdsl.messages import did_you_mean

#: signals that every model has; no variable of a model may have one of these names
ENERGIES = ("energy.kinetic", "energy.potential", "energy.total")
STATE, RATE_OF_STATE = "state", "state_rate"  #: the variants of kinds of states, and of their equations


def is_rate(component: Component) -> bool:
    """Whether a component is the equation of a state."""
    return component.kind.variant == RATE_OF_STATE


def is_state(component: Component) -> bool:
    """Whether a component with a coordinate is a state, and not a body."""
    return component.kind.variant == STATE


class Origin(Protocol):
    """The text or the Builder that a Scene was made from. It is a value, too: later changes do not reach it."""

    @property
    def overrides(self) -> Mapping[str, Any]:
        """The values that replaced those of its parameters."""

    def scene(self, parameters: Mapping[str, Any], without: Sequence[str] = ()) -> Scene:
        """The Scene with other values of parameters, and with more effects left out."""


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """A model as a value: its components and frames by full name, in the order of their declaration.

    Scenes are made by ``mbdsl.load``, ``mbdsl.parse`` and ``Builder.scene``. They are equal if their canonical texts
    (``mbdsl.mechanism.canonical_text``) are.

    Parameters
    ----------
    name : str
        Name of the model.
    components : mapping of str to Component
        Ground, bodies, joints and forces.
    frames : mapping of str to Frame
        Frames fixed to bodies or to the ground.
    initial : tuple of InitialValue
        Initial values.
    experiment : Experiment
        Defaults of a simulation.
    parameters : mapping of str to ParameterValue
        Parameters of the top-level model.
    doc : str
        Description, one line.
    files : mapping of str to str
        Source files, the main one first, and their texts as read.
    variables : mapping of str to Expr
        Named expressions, such as ``Real F = 2*time;``.
    descriptions : mapping of str to Description
        Units and documentation of variables.
    inputs : mapping of str to Input
        Inputs.
    events : Events
        Discrete variables and when-equations.
    without : mapping of str to tuple of str
        Effects that are left out, and the components that would have them.
    aliases : mapping of str to str
        Other names of frames, such as ``Frame F = rod.b;`` and connectors.
    shapes : mapping of str to tuple of DrawnShape
        Shapes of bodies in pictures; a body without an entry is drawn by its frames.
    warnings : tuple of ModelWarning
        Values in the text that are probably not as intended.
    spatial : bool
        Whether it is a model in space.
    steady : bool
        Whether simulations start at the static equilibrium that is reached from the initial positions.
    deformed : mapping of str to float
        Coordinates at which bodies that deform begin, by the names of a System; without them they begin undeformed.
    display : UnitsOfSignals
        The units in which values are displayed.
    """

    name: str
    components: Mapping[str, Component]
    frames: Mapping[str, Frame]
    initial: tuple[InitialValue, ...] = ()
    experiment: Experiment = field(default_factory=Experiment)
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)
    doc: str = field(default="", compare=False)
    files: Mapping[str, str] = field(default_factory=dict, compare=False)
    variables: Mapping[str, Expr] = field(default_factory=dict)
    descriptions: Mapping[str, Description] = field(default_factory=dict, compare=False)
    inputs: Mapping[str, Input] = field(default_factory=dict)
    events: Events = field(default_factory=Events)
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    aliases: Mapping[str, str] = field(default_factory=dict)
    shapes: Mapping[str, tuple[DrawnShape, ...]] = field(default_factory=dict)
    warnings: tuple[ModelWarning, ...] = field(default=(), compare=False)
    spatial: bool = False  #: whether it is a model in space; its frames are of the type SpatialFrame
    steady: bool = False
    deformed: Mapping[str, float] = field(default_factory=dict)
    display: UnitsOfSignals = field(default=OWN, compare=False)
    #: None for scenes of other origin; ``dataclasses.replace`` does not copy it, as it would not describe the result
    _origin: Origin | None = field(default=None, init=False, compare=False)

    def __post_init__(self) -> None:
        freeze(self, *(f.name for f in fields(self) if isinstance(getattr(self, f.name), Mapping)))

    def __eq__(self, other: object) -> bool:
        return self._content == other._content if isinstance(other, Scene) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._content)

    def __getstate__(self) -> dict:
        """Fields only; cached values are computed again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def __repr__(self) -> str:
        kinds = [c.kind for c in self.components.values()]
        families = {"joint": JointKind, "force": ForceKind, "sensor": SensorKind}
        counts = {"body": len(self.bodies())}
        counts |= {word: sum(isinstance(kind, of) for kind in kinds) for word, of in families.items()}
        plural = {"body": "bodies"}
        words = [f"{n} {what if n == 1 else plural.get(what, what + 's')}" for what, n in counts.items() if n]
        return f"<Scene {self.name}: {', '.join(words) or 'empty'}>"

    def _repr_html_(self) -> str:
        from mbdsl.mechanism.scene_tables import of_scene

        return of_scene(self)

    @cached_property
    def sticking(self) -> tuple[Sticking, ...]:
        """The joints whose friction sticks."""
        own = [c for c in self.components.values() if sticks(c.kind, c.values) and c.friction is not None]
        found = [self._formulas_alone(c).sticking._replace(span=c.span) for c in own]
        looped = in_loops(self, [c.name for c in own]) if sum(len(x.holds) for x in found) > 1 else ()
        rows = tuple(row for x in found if x.name in looped for row in x.rows)
        return tuple(x.sharing(rows) if x.name in looped and len(rows) > 1 else x for x in found)

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """The rigid contacts."""
        return tuple(contact_of(c) for c in self.components.values() if is_contact(c))

    @property
    def has_events(self) -> bool:
        """Whether something acts at events: when-equations, rigid contacts, or friction that sticks."""
        return bool(self.events or self.contacts or self.sticking)

    @property
    def first_event(self) -> Span | None:
        """The place of the first of them, of a scene that has one."""
        if self.events:
            return self.events.branches[0].span
        return self.contacts[0].span if self.contacts else self.sticking[0].span

    @property
    def kind_of_events(self) -> str:
        """What acts at events, for messages."""
        if self.events:
            return f"the `when` of {self.name}"
        if self.contacts:
            return f"the rigid contact `{self.contacts[0].name}`"
        return f"friction that sticks, of `{self.sticking[0].name}`"

    @property
    def conditions(self) -> list[Expr]:
        """The conditions at whose changes something acts."""
        own = [*(c.condition for c in self.contacts), *(x.condition for x in self.sticking)]
        return [*self.events.conditions, *own]

    def without_contacts(self) -> Scene:
        """The scene while all rigid contacts are open.

        Returns
        -------
        Scene
            This scene without them.
        """
        return replace(self, components={name: c for name, c in self.components.items() if not is_contact(c)})

    @property
    def discrete_starts(self) -> dict[str, float]:
        """Discrete variables, and the numbers of rigid contacts and of joints that stick -> their values at the
        start."""
        starts = {name: x.start for name, x in self.events.variables.items()}
        starts |= {rigid.number(c.name, what): 0.0 for c in self.contacts for what in rigid.NUMBERS}
        return starts | {name: start for x in self.sticking for name, start in x.starts.items()}

    @property
    def number_starts(self) -> dict[str, float]:
        """Inputs and discrete variables -> their values at the start."""
        return {name: x.start for name, x in self.inputs.items()} | self.discrete_starts

    @cached_property
    def _content(self) -> str:
        return canonical_text(self)

    @cached_property
    def fingerprint(self) -> str:
        """The canonical text of all data that determine the motion: the key of a stored run is a digest of it.

        It is the text of this scene without parameters (the components that use them hold their values), without shapes
        and without the times and the method of the experiment, which the arguments of a run replace.
        """
        said = self.experiment
        experiment = Experiment(tolerance=said.tolerance, step=said.step, without=said.without)
        return canonical_text(replace(self, parameters={}, experiment=experiment, shapes={}))

    def made_from(self, origin: Origin) -> Scene:
        """Set the origin of a new scene.

        Parameters
        ----------
        origin : Origin
            Where ``with_parameters`` makes other scenes from.

        Returns
        -------
        Scene
            This scene.
        """
        object.__setattr__(self, "_origin", origin)
        return self

    @property
    def origin(self) -> Origin | None:
        """The text or the Builder that it was made from; None if it was assembled otherwise."""
        return self._origin

    def with_parameters(self, parameters: Mapping[str, Any] = {}, /, **named: Any) -> Scene:
        """The model with other values of its parameters.

        It is read again from the text or the Builder that this scene was made from: whatever depends on the parameters
        is evaluated again.

        Parameters
        ----------
        parameters : mapping, optional
            Values by name, as numbers in SI units or as texts with units; ``"crank.m"`` is a parameter of a component.
        **named
            Values by name, ``L="2 m"``.

        Returns
        -------
        Scene
            A new scene. Values that were given before are kept: ``scene.with_parameters(L=2).with_parameters(m=3)``
            has both.

        Raises
        ------
        UsageError
            If a name is not a parameter, or if this scene was not made from a text or a Builder.
        ModelError
            If a value is invalid.
        """
        if named and not isinstance(parameters, Mapping):
            raise UsageError(f"parameters: found {parameters!r}, expected a mapping")
        return self.changed({**parameters, **named} if named else parameters)

    def changed(self, parameters: Mapping[str, Any], without: Sequence[str] = ()) -> Scene:
        """The model with other values of its parameters and with more effects left out.

        Parameters
        ----------
        parameters : mapping
            As for ``with_parameters``.
        without : sequence of str, optional
            Effects to leave out, in addition to those that this scene lacks.

        Returns
        -------
        Scene
            A new scene.

        Raises
        ------
        UsageError
            As ``with_parameters`` does.
        """
        if self._origin is None:
            raise UsageError(
                "this Scene was made neither from a text nor by a Builder: it can only be used as it is",
                hint="change the Scene that it was made from",
            )
        return self._origin.scene(parameters, without)

    def bodies(self) -> list[Component]:
        """Bodies with coordinates.

        Returns
        -------
        list of Component
            In the order of their declaration, without the ground and without states.
        """
        return [c for c in self.with_coordinates() if c.kind.variant != STATE]

    def states(self) -> list[Component]:
        """Variables with a derivative, `der(x) = f`.

        Returns
        -------
        list of Component
            In the order of their declaration.
        """
        return [c for c in self.components.values() if c.kind.variant == STATE]

    def with_coordinates(self) -> list[Component]:
        """Bodies and states, which have the coordinates of the equations.

        Returns
        -------
        list of Component
            In the order of their declaration, the states last.
        """
        found = [c for c in self.components.values() if isinstance(c.kind, BodyKind) and c.kind.coordinates]
        return sorted(found, key=lambda c: c.kind.variant == STATE)

    def signals(self) -> dict[str, Expr]:
        """Signals of all components, and the variables; those of frames are not listed.

        Returns
        -------
        dict
            Full name -> expression over frames and time, in SI units.
        """
        found = {f"{c.name}.{key}": e for c in self.components.values() for key, e in self.signals_of(c).items()}
        return found | dict(self.variables)

    def signals_of(self, c: Component) -> dict[str, Expr]:
        """All signals of a component, which are formulas of its kind.

        Parameters
        ----------
        c : Component
            A component of this scene.

        Returns
        -------
        dict
            Name, without that of the component -> expression over frames and time, in SI.
        """
        of = self._formulas(c)
        return {key: self._moved(of.signal(key)) for key in c.signals}

    def signal_of(self, c: Component, key: str) -> Expr | None:
        """One signal of a component.

        Parameters
        ----------
        c : Component
            A component of this scene.
        key : str
            The signal's name without that of the component.

        Returns
        -------
        Expr or None
            None if the component has no such signal.
        """
        return self._moved(self._formulas(c).signal(key)) if key in c.signals else None

    def alignment(self, c: Component) -> Expr | None:
        """A number that is positive if the axes of a joint in space have the same sense, and negative if opposite ones.

        Parameters
        ----------
        c : Component
            A component of this scene.

        Returns
        -------
        Expr or None
            None of kinds for which the sense does not matter.
        """
        if not getattr(c.kind, "aligned", ""):
            return None
        return self._moved(self._formulas(c).aligned())

    def signal(self, name: str) -> Expr:
        """A signal by its full name.

        Parameters
        ----------
        name : str
            Name of a signal of a component (``spring.s``), of a signal of a frame (``rod.b.x``), or of a variable.

        Returns
        -------
        Expr
            Expression over frames and time, in SI units.

        Raises
        ------
        ModelError
            If there is none of this name; the message lists the closest.
        """
        if name in self.variables:
            return self.variables[name]
        owner, _, key = name.rpartition(".")
        component = self.components.get(owner)
        if component is not None and key in component.signals:
            return self._moved(self._formulas(component).signal(key))
        frame = self.frames.get(self.aliases.get(owner, owner))
        if frame is None and component is not None and isinstance(component.kind, BodyKind) and component.kind.is_frame:
            frame = self.frames.get(f"{owner}.c")
        if frame is not None and key in (spatial_coordinates.NAMES if self.spatial else COORDINATES):
            return self._coordinate(frame.name, key)
        raise ModelError(f"there is no signal `{name}`", hint=self._closest(name, owner))

    def on_port(self, c: Component, port: str) -> tuple[list[Expr], list[Expr]]:
        """What a joint or force exerts on the body at one of its ports.

        Parameters
        ----------
        c : Component
            A joint or force of this scene.
        port : str
            "frame_a" or "frame_b".

        Returns
        -------
        force, torque : list of Expr [N, N.m]
            At the origin of the frame in world axes: two and one, in space three and three components.
        """
        force, torque = wrenches.on_port(self._formulas(c), port)
        return [self._moved(x) for x in force], [self._moved(x) for x in torque]

    def loads(self, frames: Collection[str]) -> list[Load]:
        """What all joints and forces exert on bodies at some frames.

        Parameters
        ----------
        frames : collection of str
            Names of frames.

        Returns
        -------
        list of Load
            In the order of the components; joints by expressions, such as couplings, act on all frames in these.
        """
        found: list[Load] = []
        for c in self.components.values():
            kind = c.kind
            if isinstance(kind, JointKind) and kind.is_expression:
                rows = c.relations, c.velocity_constraints
                loads = wrenches.of_expressions(c.name, *rows, self.spatial)
                found += [Load(c.name, x, *loads[x]) for x in loads if x in frames]
            elif isinstance(kind, PairKind):
                for port in (port for port, x in c.ports.items() if x in frames):
                    point = kind.touches if port == "frame_a" else ()
                    place = [self._moved(formulas.evaluate(x, self._formulas(c))) for x in point]
                    found.append(Load(c.name, c.ports[port], *self.on_port(c, port), place))
        return found

    def in_axes(self, force: Sequence[Expr], torque: Sequence[Expr], frame: str) -> dict[str, Expr]:
        """A wrench in world axes by its components in the axes of a frame: fx, fy, tau, in space also fz, tx, ty, tz.

        Parameters
        ----------
        force, torque : list of Expr [N, N.m]
            As of ``on_port``.
        frame : str
            Name of the frame.

        Returns
        -------
        dict
            Name of the component -> expression.
        """
        return wrenches.in_axes(force, torque, lambda key: self._moved(self._coordinate(frame, key)))

    def _formulas(self, c: Component) -> Formulas:
        found = self._formulas_alone(c)
        if found.sticks:
            found.share(self.sticking)
        return found

    def _formulas_alone(self, c: Component) -> Formulas:
        def frame_coordinate(port: str, key: str) -> Expr:
            # of frames that drivers move: as in laws, so that a law contains the nodes of the signals that it uses
            return self._moved(self._coordinate(f"{c.name}.c" if port == "c" else c.ports[port], key))

        return Formulas(c.kind, c.name, c.values.__getitem__, frame_coordinate)

    def _coordinate(self, frame: str, key: str) -> Expr:
        if self.spatial:
            return spatial_coordinates.named(frame, key)
        return coordinate(frame, key)

    def _moved(self, expression: Expr) -> Expr:
        return substitute(expression, self.prescribed) if self._prescribed_frames else expression

    @cached_property
    def _prescribed_frames(self) -> dict[str, tuple[Expr, Expr, Expr]]:
        return {name: frame.motion for name, frame in self.frames.items() if frame.motion is not None}

    def prescribed(self, leaf: Expr) -> Expr | None:
        """A coordinate of a frame that drivers move, as a function of time.

        Parameters
        ----------
        leaf : Expr
            A leaf of an expression.

        Returns
        -------
        Expr or None
            None for leaves that are not such a coordinate.
        """
        if leaf.op != "coordinate":
            return None
        frame, key = leaf.value
        motion = self._prescribed_frames.get(frame)
        if motion is None:
            return None
        return motion[list(RATE).index(key)] if key in RATE else der(motion[list(RATE.values()).index(key)])

    def _closest(self, name: str, owner: str) -> str | None:
        if owner in self.components and (own := [f"{owner}.{key}" for key in self.components[owner].signals]):
            return did_you_mean(name, own, f"`{owner}` has")
        if owner in self.frames or owner in self.aliases:
            return did_you_mean(name, [f"{owner}.{key}" for key in COORDINATES], "it has")
        close = did_you_mean(owner, [*self.components, *self.frames, *self.aliases], "components")
        return close or did_you_mean(name, self.variables)
