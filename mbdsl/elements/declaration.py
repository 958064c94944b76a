"""What every declaration of a kind consists of: parameters, signals, and the kind itself."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

from mbdsl.elements.row import Row, Rows

#: effects that can be left out of a whole scene (levels of fidelity), and what a scene without them lacks
EFFECTS = {
    "friction": "friction in joints",
    "damping": "dampers, and what laws of springs and dampers say of velocities",
    "flexibility": "deformation of bodies",
    "gravity": "gravity",
    "contact": "contacts and stops",
}
RIGID = "rigid_"  #: beginning of the variants of contacts without stiffness
#: choice of all contacts -> the effect that scenes lack then, which is in no list of effects
CONTACTS = {"rigid": "compliance", "compliant": "rigidity"}
Shape = tuple[int | None, ...]  #: of an array; None: any number
K = TypeVar("K", bound="Kind")
REQUIRED = object()  #: default of a parameter that must be given
ANY = "any"  #: unit of a parameter that is a number of any dimension


@dataclass(frozen=True)
class Parameter:
    """A parameter of the components of a kind, given as a modifier.

    A value must have the dimension of ``unit`` ("1": a pure number; "": not a number, as for choices and frame lists;
    of a law: any unit, as ``ANY`` for other numbers). ``shape`` is () for a scalar, (2,) for a vector in the plane,
    (3,) for one in space, (None, 2) for any number of points. ``law`` parameters take expressions in time and signals,
    evaluated at every step. A default of None means that the parameter is optional.
    """

    name: str
    unit: str = "1"
    default: Any = REQUIRED
    doc: str = ""
    shape: Shape = ()
    or_shapes: tuple[Shape, ...] = ()  #: other shapes that are accepted
    law: bool = False
    minimum: float | None = None
    positive: bool = False
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class Signal:
    """A named quantity of a component.

    ``formula`` (:mod:`mbdsl.expressions.formulas`) is an expression over the ports' coordinates (``frame_a.x``,
    ``.y``, ``.phi``, ``.vx``, ``.vy``, ``.w``), the component's own numeric parameters and its other signals;
    ``der(s)`` is the time derivative of a position-level signal. The same formula serves outputs, force laws (with
    exact derivatives) and initial values.
    """

    name: str
    unit: str
    formula: str
    doc: str = ""


class Latch(NamedTuple):
    """A number of a component that an event sets: where ``condition`` becomes true, it becomes ``value`` (formulas).

    It does so if the value of ``target``, such as ``alpha[1]``, is None; then formulas contain a discrete number.
    """

    target: str
    condition: str
    value: str


class Touch(NamedTuple):
    """A rigid contact that is a part of a component: a ``Contact`` whose name ends with ``key``.

    ``gap`` and ``slips`` are formulas; it has slips if the component has friction. It exists if the parameter ``limit``
    is given. ``sense`` is the sign of its force in that of the component. ``aim``, of the first of five points of a
    cylinder: formulas of two components of the normal, along the axes in which its ``corner`` is a direction.
    """

    key: str
    gap: str
    slips: tuple[str, ...] = ()
    limit: str = ""
    sense: float = 1.0
    aim: tuple[str, ...] = ()


def power(formula: str) -> Signal:
    """The power of an element: what it does to the bodies at its frames."""
    return Signal("power", "W", formula, "power delivered to the mechanism")


@dataclass(eq=False, repr=False)
class Kind:
    """The declaration of a kind, which is a word of the language.

    ``ports`` are the frames that a component is attached to, in the order of its positional arguments; those in
    ``optional_ports`` default to the origin of the ground (a single given frame then belongs to the other port).
    ``energy`` is the potential energy as a formula like those of :class:`Signal`, "" for none.

    A kind is equal to itself only. Its fields cannot be assigned again; ``frozen=True`` would ensure this by methods
    that are generated at each start, which takes longer than reading a model.
    """

    name: str
    doc: str
    ports: tuple[str, ...] = ()
    optional_ports: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    signals: tuple[Signal, ...] = ()
    results: tuple[Signal, ...] = ()  #: forces and powers: further signals, which have no start
    energy: str = ""
    #: names of formulas that others contain, which are no signals
    terms: Mapping[str, str] = field(default_factory=dict)
    latches: tuple[Latch, ...] = ()  #: numbers that events set
    #: rigid contacts that its components consist of; in formulas, force[1], ... are signals of these
    contacts: tuple[Touch, ...] = ()
    coordinates: tuple[str, ...] = ()  #: names of the generalised coordinates, of bodies
    #: of joints without frames: the law parameters that are functions of positions; in a declaration they come first,
    #: in this order, with or without their names
    coupled: tuple[str, ...] = ()
    size: str = ""  #: the parameter that is a length of its components, from which the size of the mechanism follows
    rows: int = 0  #: scalar coordinates g(z) of two frames, of joints and forces
    spatial: bool = False  #: whether it belongs to models in space
    drawing: str = (
        ""  #: its symbol in pictures, one of ``SYMBOLS`` of :mod:`mbdsl.viewing.symbols` or of the one in space
    )
    variant: str = ""  #: the file of its kernels, if it is a variant of the kind that the language has by its name
    #: of kinds in space: values -> {port: axes (9 numbers)} of the frames that its kernels and formulas use instead of
    #: those of the ports, relative to them
    axes: Callable[[Mapping], Mapping[str, tuple[float, ...]]] = lambda values: {}
    in_loops: str = ""  #: of joints in space: the name of its variant in closed loops
    #: of joints in space: whether ``hessian`` has entries of rotations only, so that fewer entries couple the bodies
    curved_by_rotations: bool = False
    #: of kinds in space: whether its kernels count the turns of angles, the signals ``counted``: ``table`` begins with
    #: two numbers of each, the angle at the end of the last accepted step and that of the last evaluation
    counts_turns: bool = False
    counted: tuple[str, ...] = ("phi",)
    #: of kinds in space: signal -> formula of this angle at the start, up to less than half a turn; by default, phi is
    #: the angle of frame_b relative to frame_a
    first_angles: Mapping[str, str] = field(default_factory=dict)
    #: of kinds in space, "rotation" or "translation": attached to a joint, and unless n is given, their axis n is that
    #: of the joint's free motion of this sort
    follows: str = ""
    #: values (with defaults; of laws only: None or not) -> error text or None, for conditions that declarations lack
    check: Callable[[Mapping], str | None] = lambda values: None
    #: values -> the reason why valid values are probably not intended, or None
    doubt: Callable[[Mapping], str | None] = lambda values: None
    #: values -> values that follow from them (a rod's inertia), applied after ``check``
    derive: Callable[[Mapping], dict] = lambda values: {}
    #: values (after ``derive``) -> the ``variant`` that components with them are, if it has other formulas or rows
    specialised: Callable[[Mapping], str] | None = None
    #: effect (of ``EFFECTS``) -> function from values to those that change without the effect, {} if there is none
    effects: Mapping[str, Callable[[Mapping], dict]] = field(default_factory=dict)
    #: values -> the numbers of one component that its kernels read as ``p``
    table: Callable[[Mapping], tuple[float, ...]] = lambda values: ()

    def __setattr__(self, name: str, value: object) -> None:
        if name in vars(self) or name not in self.__dataclass_fields__:
            raise FrozenInstanceError(f"cannot assign to field {name!r}")
        vars(self)[name] = value

    def __delattr__(self, name: str) -> None:
        raise FrozenInstanceError(f"cannot delete field {name!r}")

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"

    @property
    def file(self) -> str:
        """The name of the file that declares it."""
        from mbdsl.elements import file_of

        return file_of(self.name)

    def parameter(self, name: str) -> Parameter | None:
        return self._by_name.get(name)

    @cached_property
    def _by_name(self) -> Mapping[str, Parameter]:
        return {p.name: p for p in reversed(self.parameters)}

    @cached_property
    def formulas(self) -> Mapping[str, str]:
        """Signal -> its formula, of everything that its components may have."""
        return {x.name: x.formula for x in (*self.signals, *self.results)}

    @property
    def computed(self) -> tuple[str, ...]:
        """Names of the signals whose expressions are among the values of a component."""
        return ()

    @cached_property
    def law_parameters(self) -> tuple[str, ...]:
        """Names of the parameters that take expressions."""
        return tuple(p.name for p in self.parameters if p.law)

    def unit_of(self, name: str) -> str | None:
        """The unit of a signal of its components; None if they have none of this name."""
        signals = {p.name: p.unit for p in self.parameters if p.law} | {
            x.name: x.unit for x in (*self.signals, *self.results)
        }
        return signals.get(name)

    @property
    def outputs(self) -> tuple[Signal, ...]:
        """Signals that have no start: reactions, forces and powers, and what sensors measure."""
        return self.results

    def __reduce__(self) -> str | tuple:
        """Pickled by name: its functions are those of the process that reads it."""
        from mbdsl.elements import declaring, find

        if self.variant and declaring(self).KIND is self:
            return _variant, (self.variant, self.spatial)
        return (
            (_named, (self.name, self.spatial))
            if find(self.name, self.spatial) is self
            else object.__reduce_ex__(self, 2)
        )


def _variant(file: str, spatial: bool) -> Kind:
    from mbdsl.elements import of_variant

    return of_variant(file, spatial).KIND


def _named(name: str, spatial: bool = False) -> Kind:
    """The kind with the name in a pickle."""
    from mbdsl.elements import find

    found = find(name, spatial)
    if found is None:
        raise LookupError(f"this version of mbdsl has no kind {name}")
    return found
