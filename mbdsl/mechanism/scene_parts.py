"""The parts of a Scene: components, frames, initial values, and what else a model declares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from mbdsl.elements.kind import BodyKind, JointKind, Kind
from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, expr, is_const
from mbdsl.mechanism.frozen_dict import freeze
from mbdsl.mechanism.poses import PlanarPose, SpatialPose
from mbdsl.messages import DisplayUnit


@dataclass(frozen=True)
class Table:
    """A function of one variable, given by points.

    ``smoothness`` is the interpolation: "linear", "cubic" (twice continuously differentiable spline) or "monotone"
    (shape-preserving cubic); ``extrapolation`` is "hold", "linear", "periodic" or "error".
    """

    name: str
    u: tuple[float, ...]
    y: tuple[float, ...]
    smoothness: str = "linear"
    extrapolation: str = "hold"


Value = float | int | bool | str | tuple | Expr | Table | None


@dataclass(frozen=True)
class Frame:
    """A frame fixed to a body or to the ground.

    Its pose (x, y, phi) [m, m, rad] is relative to the body's reference point (not its centre of mass), in the body's
    axes. With a ``motion``, which drivers prescribe, the pose is a function of time in world axes instead.
    """

    name: str
    body: str
    x: float = 0.0
    y: float = 0.0
    phi: float = 0.0
    span: Span | None = field(default=None, compare=False)
    motion: tuple[Expr, Expr, Expr] | None = None
    #: of a ``motion``: the driver that moves its body
    driver: Component | None = field(default=None, compare=False, repr=False, kw_only=True)

    @property
    def pose(self) -> Any:
        """A PlanarPose, or a SpatialPose (:mod:`mbdsl.mechanism.poses`)."""
        return PlanarPose(self.x, self.y, self.phi)


@dataclass(frozen=True)
class SpatialFrame(Frame):
    """A frame fixed to a body or to the ground of a model in space.

    Its origin x, y, z [m] and its axes x, y, z are relative to the body's reference point, in the body's axes. ``phi``
    [rad] is its angle about the z axis as the model gives it, with whole turns; joint angles are counted from it.
    """

    z: float = 0.0
    axes: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    rotor: int = 0  #: in a reduced scene, the number of the rotor on a gyrostat with which the frame turns; 0: none

    @property
    def pose(self) -> SpatialPose:
        return SpatialPose((self.x, self.y, self.z, *self.axes))


@dataclass(frozen=True, repr=False)
class Component:
    """One element of the mechanism, with complete ``values`` (defaults included) in SI units."""

    name: str
    kind: Kind
    values: Mapping[str, Any]  #: of type Value
    ports: Mapping[str, str] = field(default_factory=dict)  #: port name -> frame name
    #: names of its signals, which follow from kind and values; :meth:`Scene.signal_of` evaluates their formulas
    signals: tuple[str, ...] = field(default=(), compare=False)
    span: Span | None = field(default=None, compare=False)
    doc: str = field(default="", compare=False)
    energy: Expr | None = None  #: potential energy, if the kind has a formula for it
    velocity_constraints: tuple[Expr, ...] = ()  #: of joints: residuals Gamma(v, q, t)
    friction: Expr | None = None  #: of joints: resistance along ``kind.friction_along``
    friction_rows: tuple[Expr, ...] = ()  #: if this has several coordinates: those along each of them
    #: in space: port -> the frame that it is attached to, of ports whose frame has the axes of the component
    attached: Mapping[str, str] = field(default_factory=dict, compare=False)
    relations: tuple[Expr, ...] = ()  #: of joints without frames: functions g(q), which equal u(t) or zero
    units: Mapping[str, str] = field(default_factory=dict, compare=False)  #: of signals whose kind leaves them open

    def __post_init__(self) -> None:
        freeze(self, "values", "ports")

    def __repr__(self) -> str:
        ports = ", ".join(f"{port} = {frame}" for port, frame in self.ports.items())
        return f"<{self.kind.name} {self.name}{f'({ports})' if ports else ''}>"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of its generalised coordinates; those of flexible bodies depend on ``values``."""
        of = self.kind.coordinates_of if isinstance(self.kind, BodyKind) else None
        return of(self.values) if of is not None else self.kind.coordinates

    @property
    def moves_in_time(self) -> bool:
        """Whether it is a joint that prescribes a motion, which may add energy; a coupling only if its law varies."""
        law = self.kind.driver if isinstance(self.kind, JointKind) else None
        return law is not None and not (self.relations and is_const(expr(self.values[law])))

    @property
    def deforms(self) -> bool:
        """Whether it is a body with more coordinates than a pose, whose number depends on ``values``."""
        return isinstance(self.kind, BodyKind) and self.kind.coordinates_of is not None


@dataclass(frozen=True)
class InitialValue:
    """``target`` = ``value`` at the start: exactly if ``fixed``, else as a guess that the assembly may change."""

    name: str
    target: Expr
    value: float
    fixed: bool
    span: Span | None = field(default=None, compare=False)
    unit: DisplayUnit = field(default=DisplayUnit(), compare=False)


@dataclass(frozen=True)
class Experiment:
    """The settings of ``annotation(experiment(...))``; None if not given. Times in seconds."""

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
    doc: str = field(default="", compare=False)
    span: Span | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Input:
    """A value that the caller of a simulation sets; it is ``start`` (in SI units) until then."""

    name: str
    start: float = 0.0
    unit: str = ""
    doc: str = field(default="", compare=False)
    span: Span | None = field(default=None, compare=False)


class Description(NamedTuple):
    """The unit and the documentation of a variable, as declared."""

    unit: str = ""
    doc: str = ""


class Load(NamedTuple):
    """What an element exerts on a body: force [N] and torque [N.m] at the origin of a frame in world axes.

    ``point`` is the point of the body where it acts, if the element slides along it; else this is the origin.
    """

    element: str
    frame: str
    force: Sequence[Expr]
    torque: Sequence[Expr]
    point: Sequence[Expr] = ()
