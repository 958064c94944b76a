"""The Scene: a flat list of components with numbers resolved to SI and source places kept.

Text (:mod:`mbdsl.lang`) and the library API (:class:`mbdsl.lang.builder.Builder`) both end here; everything
downstream reads only this.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mbdsl.elements.kind import BodyKind, Kind
from mbdsl.errors import ModelError, Span
from mbdsl.expressions.symbolic import COORDINATES, Expr, const, coordinate
from mbdsl.messages import did_you_mean

#: signals that every model has; no variable of a model may have one of these names
ENERGIES = ("energy.kinetic", "energy.potential", "energy.total")


@dataclass(frozen=True)
class Table:
    """Points of a function of one variable, with the way it goes between and beyond them.

    ``smoothness`` is "linear", "cubic" (twice continuously differentiable spline) or "monotone" (shape-preserving
    cubic); ``extrapolation`` is "hold", "linear", "periodic" or "error".
    """

    name: str
    u: tuple[float, ...]
    y: tuple[float, ...]
    smoothness: str = "linear"
    extrapolation: str = "hold"


Value = float | int | bool | str | tuple | Expr | Table | None


@dataclass(frozen=True)
class Frame:
    """A frame fixed to a body (or to the ground): pose (x, y, phi) [m, m, rad] in the body's own axes, from the
    body's reference point (not from its centre of mass). With a ``motion`` the pose is a function of time instead:
    of what a driver moves, in world axes."""

    name: str
    body: str
    x: float = 0.0
    y: float = 0.0
    phi: float = 0.0
    span: Span | None = None
    motion: tuple[Expr, Expr, Expr] | None = None


@dataclass(frozen=True)
class Component:
    """One element of the mechanism, ``values`` complete (defaults filled in) and in SI."""

    name: str
    kind: Kind
    values: Mapping[str, Any]  #: of type Value
    ports: Mapping[str, str] = field(default_factory=dict)  #: port name -> frame name
    signals: Mapping[str, Expr] = field(default_factory=dict)  #: full signal name -> expression over frames
    span: Span | None = None
    doc: str = ""
    energy: Expr | None = None  #: potential energy, where the kind has a formula for it
    velocity_constraints: tuple[Expr, ...] = ()  #: of joints: what vanishes at velocity level, Gamma(v, q, t) = 0
    friction: Expr | None = None  #: of joints: what resists the growth of the coordinate ``kind.friction_along``

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of its generalised coordinates; those of bodies that deform depend on how that is resolved."""
        of = self.kind.coordinates_of if isinstance(self.kind, BodyKind) else None
        return of(self.values) if of is not None else self.kind.coordinates


@dataclass(frozen=True)
class InitialValue:
    """``target`` = ``value`` at the start; kept exactly if ``fixed``, else a guess that assembly may move."""

    name: str
    target: Expr
    value: float
    fixed: bool
    span: Span | None = None


@dataclass(frozen=True)
class Experiment:
    """What ``annotation(experiment(...))`` says; None where it says nothing. Times in seconds."""

    start: float = 0.0
    stop: float | None = None
    interval: float | None = None
    tolerance: float | None = None
    method: str | None = None
    step: float | None = None
    without: tuple[str, ...] = ()  #: effects to leave out


@dataclass(frozen=True)
class ParameterValue:
    """A resolved parameter of the top-level model, for ``--set`` and for listings."""

    name: str
    value: Value
    unit: str = ""
    doc: str = ""
    span: Span | None = None


@dataclass(frozen=True)
class Input:
    """A value that comes from outside at every instant; ``start`` (in SI) until somebody says more."""

    name: str
    start: float = 0.0
    unit: str = ""
    doc: str = ""
    span: Span | None = None


@dataclass(frozen=True)
class Scene:
    """A mechanism: components and frames by full name, in the order of their declaration."""

    name: str
    components: Mapping[str, Component]
    frames: Mapping[str, Frame]
    initial: tuple[InitialValue, ...] = ()
    experiment: Experiment = Experiment()
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)
    doc: str = ""
    files: Mapping[str, str] = field(default_factory=dict)  #: source files, the main one first -> their text as read
    variables: Mapping[str, Expr] = field(default_factory=dict)  #: ``Real F = 2*time;``: names for expressions
    inputs: Mapping[str, Input] = field(default_factory=dict)  #: by name, in the order of their declaration
    #: effects that were left out on purpose -> the components that would have them
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    #: ``Frame F = rod.b;`` and connectors: other names of frames
    aliases: Mapping[str, str] = field(default_factory=dict)

    def bodies(self) -> list[Component]:
        """Components that have coordinates, in order (the ground has none)."""
        return [c for c in self.components.values() if isinstance(c.kind, BodyKind) and c.kind.coordinates]

    def signals(self) -> dict[str, Expr]:
        """Every named signal that is an expression over frames and time; those of frames are not listed."""
        found = {name: e for c in self.components.values() for name, e in c.signals.items()}
        return found | dict(self.variables)

    def signal(self, name: str) -> Expr:
        """A signal by its full name: of a component (``spring.s``), of a frame (``rod.b.x``), or a variable.

        Raises
        ------
        ModelError
            If there is none of this name; the message lists the closest.
        """
        if name in self.variables:
            return self.variables[name]
        owner, _, key = name.rpartition(".")
        component = self.components.get(owner)
        if component is not None and name in component.signals:
            return component.signals[name]
        frame = self.frames.get(self.aliases.get(owner, owner))
        if frame is None and component is not None and isinstance(component.kind, BodyKind) and component.kind.is_frame:
            frame = self.frames.get(f"{owner}.c")
        if frame is not None and key in COORDINATES:
            kind = self.components[frame.body].kind
            if key in ("phi", "w") and isinstance(kind, BodyKind) and "phi" not in (kind.coordinates or ("phi",)):
                return const(0.0)  # a point mass does not turn
            return coordinate(frame.name, key)
        raise ModelError(f"there is no signal `{name}`", hint=self._closest(name, owner))

    def _closest(self, name: str, owner: str) -> str | None:
        if owner in self.components and (own := list(self.components[owner].signals)):
            return did_you_mean(name, own, f"`{owner}` has")
        if owner in self.frames or owner in self.aliases:
            return did_you_mean(name, [f"{owner}.{key}" for key in COORDINATES], "it has")
        close = did_you_mean(owner, [*self.components, *self.frames, *self.aliases], "components")
        return close or did_you_mean(name, self.variables)
