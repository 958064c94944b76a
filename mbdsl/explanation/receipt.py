"""The receipt of a scene: the effects that it contains, the cost of each, and the reductions that avoid further costs.

``explain`` compares the reduced parts, which are solved, with the scene, and measures the run time of every statement
of the emitted code and of a whole run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING

from mbdsl.elements import kinds
from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.explanation.effects import Effects, Entry, module_of, solved
from mbdsl.expressions.symbolic import leaves
from mbdsl.integrators import backend, declared
from mbdsl.kernels import buffer_layout as L
from mbdsl.lang import given_values
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.reduction import Note
from mbdsl.mechanism.scene import Scene, is_rate
from mbdsl.mechanism.signal_names import ACCELERATIONS, ACCELERATIONS_IN_SPACE, SignalNames
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import DEFAULT_METHOD, DEFAULT_STEP, Plan, plan
from mbdsl.simulation.run_options import RunOptions
from mbdsl.simulation.steady_start import settled
from mbdsl.storage.compilation_notice import announce_compilation
from mbdsl.system.structure import by_law

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder


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
        from mbdsl.plotting.figures import TextTable
        from mbdsl.plotting.html_tables import fragment

        head, *rows = cells(self)
        code = [(e.effect, few_kernels(e.kernels)) for e in self.entries if e.kernels]
        tables = [
            TextTable("", head, rows, of_step(self)),
            TextTable("Code", ("effect", "functions"), code),
            TextTable("Before the first step", ("", ""), [split(line) for line in before(self)]),
            TextTable("Outputs, computed on access", ("signal", "computation"), self.outputs),
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
    entries = list(Effects(motion).entries())
    used = tuple(dict.fromkeys(p.method for p in motion.parts))
    notes = motion.reduction.notes
    found = Receipt(scene, motion.plan, entries, notes, sizes, len(motion.parts), used, _hoisted(motion))
    if signals is not None:
        names = SignalNames(scene)
        found.outputs = [(name, _takes(motion, names, name)) for name in names.select(signals) if name != "time"]
    if measured and motion.parts and all(backend(method) is None for method in used):
        _share(motion, found)
    return found


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
    rows = [motion.system.tables.multipliers[key] - motion.system.n for key in reads]
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
        own = effect == "springs" and not function.startswith(("loops.", "tangent_loops."))
        key = function.split(".")[0] if own else effect
        of[key] = of.get(key, 0.0) + seconds
    rows = _rows(motion)
    laws = rows["forces by expression"] + rows["friction"] + rows["states"]
    on_tape = sum(rows.values()) - rows["springs"]
    for e in receipt.entries:
        if not e.present:
            continue
        found = of.get(e.effect)
        if e.effect in rows:
            own = of.get("laws", 0.0) * rows[e.effect] / laws if laws and found is None else found or 0.0
            found = own + of.get("expressions", 0.0) * rows[e.effect] / on_tape
        elif isinstance(kinds().get(e.effect), ForceKind):
            members = [c for c in solved(motion) if c.kind.name == e.effect and not by_law(c)]
            part = sum(c.kind.rows for c in members) / rows["springs"]
            found = of.get(module_of(members[0]), 0.0) + of.get("springs", 0.0) * part
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
    found["springs"] = found["states"] = 0
    for c in solved(motion):
        if is_rate(c):
            found["states"] += 1
        elif isinstance(c.kind, ForceKind):
            found["forces by expression" if by_law(c) else "springs"] += c.kind.rows
        elif isinstance(c.kind, JointKind):
            found["friction"] += c.friction is not None
            found["nonholonomic rows"] += len(c.velocity_constraints)
            found["drivers"] += c.kind.driver is not None and c.kind.rows > 0
    # a pose and its rates
    found["moving frames"] = sum(6 * int(p.system.tables.layout[L.N_MOVING]) for p in motion.parts)
    return found
