"""The Scene: a flat list of components with numbers resolved to SI and source places kept.

Text (:mod:`mbdsl.lang`) and the library API (:class:`mbdsl.lang.builder.Builder`) both produce it; everything
downstream reads only the Scene.

A Scene is a value. It cannot be changed (``dataclasses.replace`` makes another one), it is equal to scenes of the same
content, it can be pickled, and nothing in it refers to the text that it was read from except positions for messages.
Positions, documentation and source files do not count in comparisons.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Protocol

from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, SensorKind
from mbdsl.errors import ModelWarning, Span, UsageError
from mbdsl.expressions.symbolic import Expr, const, substitute
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
    ParameterValue,
)
from mbdsl.mechanism.scene_signals import SceneSignals
from mbdsl.mechanism.sticking import Sticking, in_loops, sticks
from mbdsl.messages import OWN, UnitsOfSignals

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
class Scene(SceneSignals):
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
    def kinds_of_events(self) -> dict[str, tuple[str, Span | None]]:
        """What acts at events, "when", "contacts" or "sticking": a description for messages, and the first place."""
        found: dict[str, tuple[str, Span | None]] = {}
        if self.events:
            found["when"] = f"the `when` of {self.name}", self.events.branches[0].span
        if self.contacts:
            found["contacts"] = f"the rigid contact `{self.contacts[0].name}`", self.contacts[0].span
        if self.sticking:
            found["sticking"] = f"friction that sticks, of `{self.sticking[0].name}`", self.sticking[0].span
        return found

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
            This scene without them and without when-equations; laws read reactions of zero, and no impacts.
        """
        gone = {c.name for c in self.contacts}
        numbers = {name for c in self.contacts for name in c.starts}

        def law(x: Any) -> Any:
            return substitute(x, lambda leaf: const(0.0) if reads(leaf) else None) if isinstance(x, Expr) else x

        def reads(leaf: Expr) -> bool:
            return leaf.value in numbers if leaf.op == "input" else leaf.op == "multiplier" and leaf.value[0] in gone

        components = {
            name: replace(c, values={key: law(x) for key, x in c.values.items()})
            for name, c in self.components.items()
            if name not in gone
        }
        return replace(self, components=components, events=replace(self.events, clocks=(), whens=()))

    @property
    def discrete_starts(self) -> dict[str, float]:
        """Discrete variables, and the numbers of rigid contacts and of joints that stick -> their values at the
        start."""
        starts = {name: x.start for name, x in self.events.variables.items()}
        starts |= {name: start for c in self.contacts for name, start in c.starts.items()}
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
