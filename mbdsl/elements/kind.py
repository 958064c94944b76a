"""The declaration of an element kind.

An element file contains a ``KIND`` (the data for the language, the docs and the checks) and its kernels: plain
functions on arrays. ``mbdsl check`` reads declarations without loading numerics; therefore kernels are only marked
there, with :mod:`mbdsl.kernels.marks`, and compiled later, by :mod:`mbdsl.compilation.code_cache`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeVar

from mbdsl.elements.declaration import K, Kind, Signal, Touch
from mbdsl.elements.row import Row, Rows


def wrench(fx: str = "", fy: str = "", tau: str = "") -> tuple[Signal, ...]:
    """The reactions of a joint by their formulas; components that it does not transmit are omitted."""
    given = (("fx", "N", fx, "force along x"), ("fy", "N", fy, "force along y"), ("tau", "N.m", tau, "torque"))
    return tuple(Signal(name, unit, formula, doc) for name, unit, formula, doc in given if formula)


#: what velocity rows that exert forces and torques contain
_VELOCITY, _SPIN = re.compile(r"frame_b\.v|der\(|\bv\b"), re.compile(r"frame_b\.w|(?<!\.)\bw\b")
#: ``touches`` of kinds in the plane that act on the body of frame_a at the origin of frame_b
AT_B = ("frame_b.x", "frame_b.y")
AT_B_IN_SPACE = (*AT_B, "frame_b.z")
AXIAL = Signal("force", "N", "lam[1]", "axial force, positive in tension")


@dataclass(eq=False, repr=False)
class BodyKind(Kind):
    """A kind with coordinates that carries frames (the ground: without coordinates).

    The frame "c" (centre of mass) always exists; if ``is_frame``, the bare name of a component denotes it.
    ``frames(values)`` gives the other frames that every such component has, as {name: (x, y, phi)} in the body's own
    axes from its reference point; the parameter ``frames`` adds the user's. ``com(values)`` is the centre of mass from
    the same reference point.

    The file of a kind with coordinates names the kernels of its bodies (see :mod:`mbdsl.bodies.contract`) as
    ``motion``: a module, or a function of the values, whose possible results ``MOTIONS`` lists.
    """

    frames: Callable[[Mapping], Mapping[str, tuple[float, ...]]] = lambda values: {}
    com: Callable[[Mapping], tuple[float, ...]] = lambda values: (0.0, 0.0)
    is_frame: bool = False
    #: values -> names of the generalised coordinates, if they differ from ``coordinates``
    coordinates_of: Callable[[Mapping], tuple[str, ...]] | None = None


def is_point(kind: Kind) -> bool:
    """Whether it is a body that does not turn, whose name denotes its only frame."""
    return isinstance(kind, BodyKind) and kind.is_frame and bool(kind.coordinates)


@dataclass(eq=False, repr=False)
class PairKind(Kind):
    """A kind between two frames, described by ``rows`` scalar coordinates g(z) of them.

    Kernels of its file, for one component with frames ``a``, ``b`` (rows of the table ``frames``: x, y, phi, vx, vy,
    w) and parameters ``p`` (a row of floats, from ``table``), with z = (z_a, z_b):

    ``gradient(frames, a, b, p, G)``   G[0:rows, 0:6] = dg/dz, G[0:rows, VALUE] = g(z); entries always 0 are not written
    ``hessian(frames, a, b, p, s, H)`` H[0:6, 0:6] += d(G^T s)/dz; omitted if G is constant

    They are made from ``g``, formulas of the coordinates, if these are given (:mod:`mbdsl.system.row_kernels`).
    ``rows`` and ``table`` follow from them.
    """

    ports: tuple[str, ...] = ("frame_a", "frame_b")
    g: tuple[Row, ...] = ()  #: the coordinates by their formulas in the plane and in space
    #: what a force, or friction in a joint, exerts, as (formula of its size, signal whose growth it resists)
    resists: tuple[tuple[str, str], ...] = ()
    #: the same without such a signal: formulas of the wrench on frame_b, at its origin in world axes, by the names of
    #: reactions
    exerts: Mapping[str, str] = field(default_factory=dict)
    reacts: bool = True  #: whether the opposite wrench acts on frame_a
    #: formulas of the point, in world axes, at which it acts on the body of frame_a, if this is not the origin of
    #: frame_a: of kinds that slide or roll along this body
    touches: tuple[str, ...] = ()
    #: (values, distance of the frame origins at the start) -> why they do not fit together, or None; the kind
    #: constrains angles about a line of centres, which does not exist at zero distance
    misfit: Callable[[Mapping, float], str | None] | None = None

    def __post_init__(self) -> None:
        if self.g:
            counted, names = 2 * self.held.counted, self.held.parameters
            reserved = counted + sum((n + 1) * (n + 2) // 2 for n in self._arguments)
            vars(self).update(rows=len(self.held.formulas), counts_turns=counted > 0)
            vars(self)["table"] = lambda v: (*[0.0] * reserved, *(_number(v, name) for name in names))

    @cached_property
    def held(self) -> Rows:
        """Its rows by formulas, those that do not hold identically, in the plane or in space."""
        return Rows(self.g, self.spatial)

    @property
    def _arguments(self) -> tuple[int, ...]:
        """Numbers of arguments of the functions of coordinates in its rows."""
        return ()


@dataclass(eq=False, repr=False)
class SensorKind(Kind):
    """A kind that measures at a frame and acts on nothing; ``signals`` are what laws can use."""

    ports: tuple[str, ...] = ("frame",)
    #: what only results have: the wrench on the frame, and the accelerometer; without formulas
    measured: tuple[Signal, ...] = ()

    @property
    def outputs(self) -> tuple[Signal, ...]:
        return (*self.results, *self.measured)


@dataclass(frozen=True)
class Placing:
    """What a joint leaves free: how it places its bodies at the start, and which axes drivers on it have."""

    #: (values, s) -> pose (x, y, phi) of frame_b in frame_a, s being the signal named ``free`` ("": nothing is free);
    #: None if a joint leaves more than one coordinate free, or has several solutions
    pose: Callable | None = None
    free: str = ""
    #: for the initial placement of bodies: the names of signals or parameters that are the angle of frame_b relative to
    #: frame_a, and its position along the x axis of frame_a; the first of them that has a value is used. A driver whose
    #: ``driver`` is among them drives this coordinate of every joint between the same frames
    angle: tuple[str, ...] = ()
    along: tuple[str, ...] = ()
    #: in space, for the same purpose: motions of frame_b from frame_a, one after the other, as (signal, way), along the
    #: axes x, y, z of the frame moved so far, or about them: rx, ry, rz; by default those of ``along`` and ``angle``
    moves: tuple[tuple[str, str], ...] = ()
    #: in space: "rotation" or "translation", if the joint leaves it free about or along one axis -> the parameter that
    #: is this axis. For None, the axes of the joint's own frames are used: x of frame_b turns about z of frame_a, or
    #: its origin moves along x
    free_axes: Mapping[str, str | None] = field(default_factory=dict)
    keeps_attitude: bool = False  #: whether frame_b keeps the attitude relative to frame_a that the model gives it
    #: in space, a formula that is positive in the intended poses of frame_b and negative in mirrored ones, in which the
    #: constraints hold as well because axes have opposite senses
    aligned: str = ""
    crossing: bool = False  #: in space, whether it has no meaning if the z axes of its frames are parallel at the start


_TORQUES = ("rotational_spring_damper", "torque", "sliding_in_socket")


@dataclass(eq=False, repr=False)
class JointKind(PairKind):
    """A kind that requires g(z) = 0, or g(z) = u(t) in its last row if ``driver`` names the law parameter u, and
    Gamma = 0 for its ``velocity_rows``.

    Its multipliers lam belong to its ``rows``, then to its ``velocity_rows``; the constraint force is -Phi_q^T lam.
    """

    driver: str | None = None
    #: functions in its rows: ((law parameter, signals of positions), ...). The rows contain f itself: of each function,
    #: the kernels read its value, its derivatives with respect to the signals, and the second ones, 11, 12, ..., 22,
    #: ..., from p[0] on, which ``table`` reserves; in formulas, slope[1], ... are the first derivatives of all of them
    functions: tuple[tuple[str, tuple[str, ...]], ...] = ()
    #: of joints without frames: formulas of g for their ``rows``, like those of signals, in place of kernels; in them,
    #: a name of both a law parameter and a signal denotes the law
    relations: tuple[str, ...] = ()
    #: whether its row is an inequality g >= 0, a rigid contact: the row is left out while the contact is open
    unilateral: bool = False
    #: formulas of Gamma, like those of signals; in them, a name of both a law parameter and a signal denotes the law
    velocity_rows: tuple[str, ...] = ()
    #: the wrench that it transmits to frame_b, at its origin in world axes, as formulas over lam[1], lam[2], ...; that
    #: of rows ``g`` follows from these, without formulas
    reactions: tuple[Signal, ...] = ()
    tau: str = ""  #: in space, formula of the reaction ``tau``, the torque about n, of kinds that transmit one about n
    #: formula, also over lam, of a force or torque that resists growth of the scalar coordinate whose kernels are those
    #: of the element module ``friction_along``; it does not act if the parameter ``mu_s`` is zero
    friction: str = ""
    friction_along: str = ""
    #: of kinds whose friction can stick: the normal force in ``friction``, or its torque; the rates of sliding;
    #: positions place[1], ... where the joint is held, by default those with these rates; and the rows that hold it,
    #: over these, by default their changes
    normal: str = ""
    slides: tuple[str, ...] = ()
    places: tuple[str, ...] = ()
    holds: tuple[str, ...] = ()
    #: friction along ``slides`` while it is held, over the multipliers grip[1], ... of ``holds``; by default these
    grips: tuple[str, ...] = ()
    #: ``friction_rows`` of friction that sticks, over its components rub[1], ... along ``slides``; by default these
    sticking_rows: tuple[str, ...] = ()
    #: if the module has several coordinates: formulas of the resistances along them, in which ``friction`` is its size;
    #: in ``exerts``, drag[1], ... are these, whether friction sticks or not
    friction_rows: tuple[str, ...] = ()
    placing: Placing = Placing()  #: what it leaves free

    def __post_init__(self) -> None:
        super().__post_init__()
        if (
            self.ports
            and (self.g or self.velocity_rows)
            and not any(x.formula for x in self.reactions if x.name != "tau")
        ):
            vars(self).update(reactions=self._reactions())
        if self.g:
            if self.spatial:
                looped = any(row.turned for row in self.g)
                vars(self).update(
                    curved_by_rotations=self.held.curved_by_rotations,
                    in_loops=f"{self.file}_in_axes" if looped else "",
                )

    def _reactions(self) -> tuple[Signal, ...]:
        """The components of the wrench of its rows, which are those of a force, a torque, or both."""
        rates = "".join(self.velocity_rows)
        force, torque = self.held.acts
        force, torque = force or bool(_VELOCITY.search(rates)), torque or bool(_SPIN.search(rates))
        if not self.spatial:
            known = {x.name: x for x in wrench(" ", " ", " ")}
            return tuple(replace(known[key], formula="") for key in ("fx", "fy") * force + ("tau",) * torque)
        found = [Signal(f"f{i}", "N", "", f"force along {i}") for i in "xyz" * force]
        found += [Signal(f"t{i}", "N.m", "", f"torque about {i}") for i in "xyz" * torque]
        meaning = "torque about the axis n" if self.tau else "torque about the z axis of the world"
        return (*found, *[Signal("tau", "N.m", self.tau, meaning)] * torque)

    def in_axes(self, variant: str) -> JointKind:
        """The variant of a joint in space whose rows are R_a^T (r_b - r_a) in place of r_b - r_a.

        Joints in loops of moving bodies have these rows. The hinges of a planar loop hold its bodies in their plane
        several times over: one row along the normal of the plane is redundant, whatever the pose. In axes of the world
        this row is another one as soon as a carrier has turned the loop, and a choice of rows that was right at the
        start becomes singular. In axes of the joint, the redundant row remains the same. In a tree no row is
        redundant, and a planar loop with the ground as a link keeps its plane: there the rows are in axes of the
        world, in which they are linear and cost less.
        """
        given = {x.name: getattr(self, x.name) for x in fields(self)}
        rows = tuple(row._replace(space=row.turned or row.space, turned="") for row in self.g)
        return JointKind(**{**given, "g": rows, "variant": variant})

    @property
    def _arguments(self) -> tuple[int, ...]:
        return tuple(len(signals) for _, signals in self.functions)

    @cached_property
    def formulas(self) -> Mapping[str, str]:
        return {x.name: x.formula for x in (*self.signals, *self.reactions, *self.results, *self.resistance)}

    @property
    def coupling(self) -> tuple[str, str] | None:
        """The law parameter and the signal of a kind whose row contains a function of one signal."""
        (law, signals), *others = self.functions or (("", ()),)
        return None if others or len(signals) != 1 else (law, signals[0])

    @property
    def of_position(self) -> bool:
        """Whether its rows contain functions of several signals, such as the coordinates of a point."""
        return bool(self.functions) and self.coupling is None

    @property
    def is_expression(self) -> bool:
        """Whether its rows are expressions of models, which may contain the coordinates of any frame."""
        return not self.ports or bool(self.velocity_rows and self.law_parameters)

    @property
    def reaction(self) -> tuple[str, ...]:
        """Names of the reactions."""
        return tuple(signal.name for signal in self.reactions)

    @property
    def outputs(self) -> tuple[Signal, ...]:
        return (*self.reactions, *self.results)

    @cached_property
    def resistance(self) -> tuple[Signal, ...]:
        """The signal of its friction, if it may have friction."""
        unit = "N.m" if self.friction_along in _TORQUES else "N"
        return (Signal("friction", unit, self.friction, "friction, with `mu`"),) if self.friction else ()

    def unit_of(self, name: str) -> str | None:
        own = (*self.reactions, *self.resistance)
        return next((x.unit for x in own if x.name == name), None) or super().unit_of(name)


@dataclass(eq=False, repr=False)
class ForceKind(PairKind):
    """A kind that applies the wrench ``sign`` G^T s to its frames.

    The magnitudes s are the expressions in the parameters named in ``laws`` (one a row) where the first of them is
    given, else linear: s_k = k_k (g_k - g0_k) + c_k dg_k/dt with (k, c, g0) from ``springs(values)``. Without
    ``springs``, a law that is not given is the formula of the signal of its name.
    """

    laws: tuple[str, ...] = ()
    sign: float = -1.0
    springs: Callable[[Mapping], tuple[tuple[float, float, float], ...]] | None = None
    touching: tuple[Touch, ...] = ()  #: the rigid contacts that its components without a stiffness `k` are
    #: of kinds that may run over further frames, the parameter ``over``: (values, coordinates of each frame, spatial)
    #: -> a :class:`mbdsl.elements.rope_path.Path`. It replaces the formulas of the signals, which are those of a
    #: component between two points. Every span of the path is a component of the kind
    path: Callable | None = None
    #: the formula, by its name, that is searched for peaks within a step in place of the laws: "" for these themselves
    searched: str = ""

    @property
    def computed(self) -> tuple[str, ...]:
        return () if self.path is None else tuple(x.name for x in (*self.signals, *self.results))


def in_space(kind: K, motion: Callable[[K], Mapping] = lambda kind: {}, **changes: object) -> K:
    """The declaration of a kind in space: that in the plane with the changes of a ``motion`` of
    :mod:`mbdsl.elements.motions` and with ``changes``. If no check is among them, an axis n must have a direction."""
    given = {x.name: getattr(kind, x.name) for x in fields(kind)} | {"spatial": True}
    if "placing" in given:  # a pose in the plane
        given["placing"] = replace(given["placing"], pose=None, free="")
    if given.get("touches") == AT_B:
        given["touches"] = AT_B_IN_SPACE
    given = {name: given[name] for name in kind.__dataclass_fields__} | dict(motion(kind)) | changes
    made = type(kind)(**given)
    if made.parameter("n") is None or "check" in changes or not isinstance(made, PairKind):
        return made
    return type(kind)(**given | {"check": lambda values: made.check(values) or axis_given(values)})


def axis_given(values: Mapping) -> str | None:
    """A ``check`` of the axis n."""
    return None if any(values["n"]) else "the axis n is zero, expected a direction such as {0, 0, 1}"


def zero(*names: str) -> Callable[[Mapping], dict]:
    """An effect that is left out by setting the parameters ``names`` to zero."""

    def without(values: Mapping) -> dict:
        off = {name: tuple(0.0 for _ in values[name]) if isinstance(values[name], tuple) else 0.0 for name in names}
        return off if any(values[name] not in (None, off[name]) for name in names) else {}

    return without


def _number(values: Mapping, name: str) -> float:
    """A number by its name in formulas: ``k``, or ``k[1]`` of several."""
    name, _, index = name.partition("[")
    return values[name][int(index[:-1]) - 1] if index else values[name]


def law_or_spring(law: str) -> Callable[[Mapping], str | None]:
    """A ``check`` for springs and dampers that a law replaces; the free length stays, as laws use it."""

    def check(values: Mapping) -> str | None:
        if values[law] is not None and (values["k"] or values["c"]):
            return f"`{law}` replaces k and c: give one or the other"
        return None

    return check
