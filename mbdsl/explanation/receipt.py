"""The receipt of a scene: the effects that it contains, the cost of each, and the reductions that avoid further costs.

``explain`` compares the reduced parts, which are solved, with the scene, and measures the run time of every statement
of the emitted code and of a whole run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING

from mbdsl.elements import declaring, kinds
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, is_velocity_level, leaves
from mbdsl.integrators import backend, declared
from mbdsl.kernels import buffer_layout as L
from mbdsl.lang import given_values
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.reduction import Note
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.mechanism.signal_names import ACCELERATIONS, ACCELERATIONS_IN_SPACE, SignalNames
from mbdsl.messages import few
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import DEFAULT_METHOD, DEFAULT_STEP, Plan, plan
from mbdsl.simulation.run_options import RunOptions
from mbdsl.simulation.steady_start import settled
from mbdsl.storage.compilation_notice import announce_compilation
from mbdsl.system.emit import evaluate_lines, tangent_lines
from mbdsl.system.structure import by_law

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder


@dataclass
class Entry:
    """One effect on the receipt.

    Attributes
    ----------
    effect : str
        Name, such as "friction".
    present : bool
        Whether the model contains the effect.
    why : str
        Components that require the effect, or a statement that none does.
    span : Span or None
        Place of the first of them in the source text.
    unknowns : int
        Number of coordinates or multipliers due to the effect.
    kernels : tuple of str
        Compiled functions due to the effect.
    share : float or None
        Part of the time of a step, 0 to 1; None if it was not measured.
    """

    effect: str
    present: bool
    why: str
    span: Span | None = None
    unknowns: int = 0
    kernels: tuple[str, ...] = ()
    share: float | None = None


@dataclass
class Receipt:
    """The effects of a model and their costs; ``str()`` returns the text that ``mbdsl explain`` prints.

    Attributes
    ----------
    scene : Scene
        The model.
    plan : Plan
        Settings of the run.
    entries : list of Entry
        The effects.
    notes : tuple of Note
        Reductions: bodies that were merged, moved by drivers, or split off.
    sizes : dict
        "n", "m", "p" -> (number as written, number as solved).
    parts : int
        Number of independent parts.
    methods : tuple of str
        Methods by which the parts are solved.
    hoisted : list of str
        Computations that are done once, before the first step.
    outputs : list of (str, str)
        Requested signals, and the computation that each requires.
    step : float or None [s]
        Measured run time of a step of all parts.
    remainder : float or None
        Share of the method and its linear algebra, 0 to 1; None if it cannot be measured.
    """

    scene: Scene
    plan: Plan
    entries: list[Entry]
    notes: tuple[Note, ...]
    sizes: Mapping[str, tuple[int, int]]
    parts: int
    methods: tuple[str, ...] = ()
    hoisted: list[str] = field(default_factory=list)
    outputs: list[tuple[str, str]] = field(default_factory=list)
    step: float | None = None
    remainder: float | None = None

    def __str__(self) -> str:
        from mbdsl.explanation.receipt_text import text

        return text(self)

    def __repr__(self) -> str:
        from mbdsl.explanation.receipt_text import solved_for

        return f"<Receipt of {self.scene.name}: {solved_for(self)}>"

    def _repr_html_(self) -> str:
        from mbdsl.explanation.receipt_text import as_written, before, cells, few_kernels, of_step, solved_for, split
        from mbdsl.plotting.figures import Table
        from mbdsl.plotting.html_tables import fragment

        head, *rows = cells(self)
        code = [(e.effect, few_kernels(e.kernels)) for e in self.entries if e.kernels]
        tables = [
            Table("", head, rows, of_step(self)),
            Table("Code", ("effect", "functions"), code),
            Table("Before the first step", ("", ""), [split(line) for line in before(self)]),
            Table("Outputs, computed on access", ("signal", "computation"), self.outputs),
        ]
        return fragment(f"{self.scene.name}: {as_written(self)}", [f"solved for: {solved_for(self)}"], tables)


@blame_model
def explain(
    model: Scene | Builder | str | PathLike,
    *,
    method: str | None = None,
    step: float | str | None = None,
    signals: Sequence[str] | None = None,
    measured: bool = True,
    parameters: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    announce: Callable[[str], None] | None = None,
) -> Receipt:
    """List the effects that a model contains, and the cost of each.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    method, parameters, without, announce : optional
        As for ``mbdsl.simulate``.
    step : float or str, optional [s]
        Size of the steps that are timed. Default: the model's Step, else 1 ms.
    signals : sequence of str, optional
        Names and patterns of output signals to include.
    measured : bool, optional
        Whether to run the model for some tenths of a second and time every statement of its code.

    Returns
    -------
    Receipt

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    InitialisationError
        If no consistent initial state is found.
    """
    step = given_values.seconds(step, "step")
    scene = as_scene(model, parameters, without)
    stop = scene.experiment.stop if scene.experiment.stop is not None else scene.experiment.start + 1.0
    method = method or scene.experiment.method or DEFAULT_METHOD
    if step is None and declared(method).steps[0] == "fixed":  # the cost of a step does not depend on its length
        step = min(scene.experiment.step or DEFAULT_STEP, stop - scene.experiment.start)
    scene, _ = settled(scene)
    asked = RunOptions(method=method, step=step, stop=stop, interval=stop - scene.experiment.start)
    motion = MechanismRun(scene, plan(scene, asked))
    announce_compilation(announce, motion.uncompiled)
    motion.prepare()
    return _receipt(motion, measured, signals)


def _receipt(motion: MechanismRun, measured: bool, signals: Sequence[str] | None) -> Receipt:
    scene, system = motion.system.scene, motion.system
    sizes = {key: (getattr(system, key), motion.sizes[key]) for key in ("n", "m", "p")}
    entries = list(_Effects(motion).entries())
    used = tuple(dict.fromkeys(p.method for p in motion.parts))
    notes = motion.reduction.notes
    found = Receipt(scene, motion.plan, entries, notes, sizes, len(motion.parts), used, _hoisted(motion))
    if signals is not None:
        names = SignalNames(scene)
        found.outputs = [(name, _takes(motion, names, name)) for name in names.select(signals) if name != "time"]
    if measured and motion.parts and all(backend(method) is None for method in used):
        _share(motion, found)
    return found


# -- effects -------------------------------------------------------------------------------------


def _solved(motion: MechanismRun) -> list[Component]:
    """Components that remain in some part."""
    return [c for p in motion.parts for c in p.system.scene.components.values()]


def _module(c: Component) -> str:
    return declaring(c.kind).__name__.rsplit(".", 1)[-1]


class _Effects:
    """The effects of a motion, each with the components that have it and the compiled functions due to it."""

    def __init__(self, motion: MechanismRun) -> None:
        self.motion, self.scene, self.solved = motion, motion.system.scene, _solved(motion)
        self.functions: list[tuple[str, str]] = []
        for p in motion.parts:
            t, sets = p.system.tables, declared(p.method).sets
            for line in (*evaluate_lines(t.blocks, t.has_tape, sets), *tangent_lines(t.blocks, t.has_tape, sets)):
                self.functions.append((line.effect, line.text.split("(")[0]))

    def entries(self) -> Iterator[Entry]:
        n, m, p = (sum(getattr(part.system, key) for part in self.motion.parts) for key in "nmp")
        joints = [c for c in self.solved if isinstance(c.kind, JointKind) and c.kind.rows]
        bodies = [c for c in self.solved if isinstance(c.kind, BodyKind) and c.kind.coordinates]
        laws = [c for c in self.solved if isinstance(c.kind, ForceKind) and by_law(c)]
        rolling = [c for c in self.solved if c.velocity_constraints]
        nothing = "everything is fixed, or moved by drivers"
        yield self.entry("bodies", bodies, nothing, self.kernels("bodies"), n)
        yield self.entry("joints", joints, "no constraint is left", self.kernels("joints"), m)
        yield from self.redundant()
        kernels = self.kernels("nonholonomic rows", "expressions")
        yield self.entry("nonholonomic rows", rolling, "no constraint of velocities", kernels, p)
        yield from self.drivers()
        found = [c for c in self.scene.components.values() if c.kind.name == "Ground" and c.values["g"]]
        yield self.entry("gravity", found, self.without("gravity", "the ground has g = 0"), ("a constant vector",))
        yield from self.forces()
        nothing = "no force is given by an expression"
        yield self.entry("forces by expression", laws, nothing, self.kernels("laws", "expressions"))
        found = [c for c in self.scene.components.values() if _damps(c)]
        nothing = self.without("damping", "no force depends on velocities")
        yield self.entry("velocity-dependent forces", found, nothing, ("within those of the forces",))
        yield self.friction()
        found = [c for c in self.solved if "contact" in c.kind.effects and c.values["k"]]
        nothing = self.without("contact", "no stop or contact")
        yield self.entry("contact", found, nothing, self.kernels("laws", "expressions"))
        found = [c for c in self.solved if any(leaf.op == "multiplier" for leaf in leaves(*_laws(c)))]
        yield self.entry("forces that depend on reactions", found, "none")
        inputs = self.scene.inputs
        yield Entry("inputs", bool(inputs), few(list(inputs)) or "none", next((x.span for x in inputs.values()), None))
        yield from self.flexibility()

    def entry(
        self, effect: str, found: list[Component], nothing: str, kernels: tuple[str, ...] = (), unknowns: int = 0
    ) -> Entry:
        if not found:
            return Entry(effect, False, nothing)
        return Entry(effect, True, few([c.name for c in found], 4), found[0].span, unknowns, kernels)

    def kernels(self, *effects: str) -> tuple[str, ...]:
        """Functions in the emitted code of all parts that belong to ``effects``."""
        return tuple(dict.fromkeys(name for effect, name in self.functions if effect in effects))

    def without(self, effect: str, why: str) -> str:
        """Why there is no component with an effect."""
        return "left out on request" if effect in self.scene.without else why

    def redundant(self) -> Iterator[Entry]:
        """The constraints of an over-constrained mechanism in space that are left out, and the true mobility."""
        names, system = self.motion.redundant, self.motion.system
        if not names or not system.scene.spatial:
            return
        joint = system.scene.components[names[0].rpartition(".")[0]]
        mobility = system.n - system.m - system.p + len(names)
        shared = list(dict.fromkeys(name.rpartition(".")[0] for name in self.motion.not_unique))
        why = f"{few(names, 4)} left out; true mobility {mobility}; reactions of {few(shared, 6)} are not unique"
        yield Entry("redundant rows", True, why, joint.span)

    def drivers(self) -> Iterator[Entry]:
        driven = [c for c in self.solved if c.moves_in_time]
        moved = [name for note in self.motion.reduction.notes if note.action == "moved" for name in note.by]
        nothing = "none is left: their bodies are functions of time" if moved else "none"
        yield self.entry("drivers", driven, nothing, self.kernels("drivers", "expressions"))
        if any(p.system.tables.layout[L.N_MOVING] for p in self.motion.parts):
            # a component that is solved for is attached to one
            carried = [self.scene.components[name] for name in moved]
            yield self.entry("moving frames", carried, "", self.kernels("moving frames", "expressions"))

    def forces(self) -> Iterator[Entry]:
        """An entry for every kind of linear force."""
        present: dict[str, list[Component]] = {}
        for c in self.solved:
            if isinstance(c.kind, ForceKind) and not by_law(c):
                present.setdefault(c.kind.name, []).append(c)
        for name, found in present.items():
            own = (k for k in self.kernels("springs") if k.split(".")[0] in ("loops", _module(found[0])))
            yield self.entry(name, found, "", tuple(own))
        springs = [name for name, kind in kinds().items() if isinstance(kind, ForceKind) and kind.springs is not None]
        if absent := [name for name in springs if name not in present]:
            yield Entry("other linear forces", False, f"no {few(absent)}")

    def friction(self) -> Entry:
        found = [c for c in self.solved if c.friction is not None or _rubs(c)]
        idle = [c.name for c in self.scene.components.values() if c.friction is not None]
        why = f"of {few(idle, 4)}: it changes no motion" if idle else "no mu"
        return self.entry("friction", found, self.without("friction", why), self.kernels("laws", "expressions"))

    def flexibility(self) -> Iterator[Entry]:
        """Flexible bodies, bodies that turn in space, and their effect on the mass matrix."""
        special = [c for c in self.solved if c.name in self.deforming(1)]
        turning, found = [c for c in special if c.kind.spatial], [c for c in special if not c.kind.spatial]
        kernels, nothing = self.kernels("flexibility"), self.without("flexibility", "all bodies are rigid")
        of = sum(len(c.coordinates) - 3 for c in found)
        yield self.entry("flexibility", found, nothing, () if turning else kernels, of)
        if self.scene.spatial:
            yield self.entry("gyroscopic torques", turning, "no body turns in space", kernels)
        varies = [c for c in found if c.name in self.deforming(2)]
        mass = self.entry("mass matrix", varies or special, "diagonal and constant: coordinates of centres of mass")
        if special:
            constant = "constant in the axes of the bodies" if turning else "constant, but not diagonal"
            mass.why = f"of {mass.why}: {'it depends on coordinates' if varies else constant}"
            mass.kernels = self.kernels("mass matrix")
        yield mass

    def deforming(self, least: int) -> set[str]:
        """Bodies whose mass matrix is not constant and diagonal (1), or depends on coordinates (2)."""
        blocks = [b for p in self.motion.parts for b in p.system.tables.blocks if b.role == "body"]
        return {c.name for b in blocks if least <= b.module.MASS for c in b.components}


def _damps(c: Component) -> bool:
    kind = c.kind
    if not isinstance(kind, ForceKind):
        return len(c.coordinates) > len(kind.coordinates) and bool(kind.effects["damping"](c.values))
    if by_law(c):
        laws = [c.values[name] for name in kind.laws if isinstance(c.values[name], Expr)]
        return any(is_velocity_level(law) for law in laws)
    return kind.springs is not None and any(damping for _, damping, _ in kind.springs(c.values))


def _rubs(c: Component) -> bool:
    """Whether it is a contact with friction."""
    return "contact" in c.kind.effects and bool(c.values.get("mu_s"))


def _laws(c: Component) -> list[Expr]:
    return [x for x in (c.friction, *c.values.values()) if isinstance(x, Expr)]


def _hoisted(motion: MechanismRun) -> list[str]:
    kinds_ = {int(p.system.tables.layout[L.MASS_KIND]) for p in motion.parts}
    found = ["the mass matrix, constant and diagonal: one vector"] if 0 in kinds_ else []
    if 1 in kinds_:
        found.append("the mass matrix of elements: constant, factorised once where its inverse is needed")
    if 2 in kinds_:
        found.append("of the mass matrix: integrals over shapes; elastic entries, factorised once")
    if any(
        p.system.tables.numbers[p.system.tables.layout[L.CONSTANT_FORCE] :][: p.system.n].any() for p in motion.parts
    ):
        found.append("gravity, constant in these coordinates: the initial vector of the forces")
    orders = [p for p in motion.parts if p.system.unknowns]
    if orders:
        found.append("order and pattern of the factorisation: from the graph, once")
    return found


def _takes(motion: MechanismRun, names: SignalNames, name: str) -> str:
    """The computation that a signal requires."""
    scene = motion.system.scene
    key = name.rsplit(".", 1)[-1]
    if key in (*ACCELERATIONS, *ACCELERATIONS_IN_SPACE, "a") and name not in names.expressions:
        return "accelerations: a linear solve at every output point"
    if "Phi[" in key or "Gam[" in key:
        return "residuals of constraints: an evaluation at every output point"
    if name.startswith("energy."):
        return "a formula of coordinates and velocities"
    root = names.expressions[name][0] if name in names.expressions else scene.signal(name)
    reads = [leaf.value for leaf in leaves(root) if leaf.op == "multiplier"]
    rows = [motion.system.tables.multipliers[key] - motion.system.n for key in reads]  # type: ignore[index]
    if not rows:
        return "a formula of coordinates and velocities"
    if motion.own_reactions and motion.whole.known[rows].all():
        return "a formula of the method's multipliers"
    return "reactions that are not unknowns: a linear solve at every output point"


# -- costs ----------------------------------------------------------------------------------------------


def _share(motion: MechanismRun, receipt: Receipt) -> None:
    """Fill in the shares of a step's time."""
    from mbdsl.explanation.statement_costs import measure

    total, spent = measure(motion)
    of: dict[str, float] = {}
    for (effect, function), seconds in spent.items():
        own = effect == "springs" and not function.startswith("loops.")
        key = function.split(".")[0] if own else effect
        of[key] = of.get(key, 0.0) + seconds
    rows = _rows(motion)
    laws = rows["forces by expression"] + rows["friction"]
    on_tape = sum(rows.values()) - rows["springs"]
    for e in receipt.entries:
        if not e.present:
            continue
        found = of.get(e.effect)
        if e.effect in rows:
            own = of.get("laws", 0.0) * rows[e.effect] / laws if laws and found is None else found or 0.0
            found = own + of.get("expressions", 0.0) * rows[e.effect] / on_tape
        elif isinstance(kinds().get(e.effect), ForceKind):
            members = [c for c in _solved(motion) if c.kind.name == e.effect and not by_law(c)]
            part = sum(c.kind.rows for c in members) / rows["springs"]
            found = of.get(_module(members[0]), 0.0) + of.get("springs", 0.0) * part
        e.share = found / total if found is not None else None
    receipt.step = total
    shares = sum(e.share for e in receipt.entries if e.share is not None)
    receipt.remainder = 1.0 - shares if shares <= 1.0 else None
    if shares > 1.0:  # statements took longer alone than within a step: the machine was slowed down by other work
        for e in receipt.entries:
            e.share = e.share / shares if e.share is not None else None


def _rows(motion: MechanismRun) -> dict[str, int]:
    """Numbers of users of the loops and the tape: expressions by effect, and rows of linear forces."""
    found = dict.fromkeys(("forces by expression", "friction", "nonholonomic rows", "drivers", "moving frames"), 0)
    found["springs"] = 0
    for c in _solved(motion):
        if isinstance(c.kind, ForceKind):
            found["forces by expression" if by_law(c) else "springs"] += c.kind.rows
        elif isinstance(c.kind, JointKind):
            found["friction"] += c.friction is not None
            found["nonholonomic rows"] += len(c.velocity_constraints)
            found["drivers"] += c.kind.driver is not None and c.kind.rows > 0
    # a pose and its rates
    found["moving frames"] = sum(6 * int(p.system.tables.layout[L.N_MOVING]) for p in motion.parts)
    return found
