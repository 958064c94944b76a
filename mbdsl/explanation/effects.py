"""The effects of a mechanism: which components have each, and the compiled functions and unknowns due to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mbdsl.elements import declaring, kinds
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, is_velocity_level, leaves
from mbdsl.integrators import declared
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism.scene import Component, is_rate, is_state
from mbdsl.messages import count, few
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.system.emit import evaluate_lines, tangent_lines
from mbdsl.system.structure import by_law


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


def solved(motion: MechanismRun) -> list[Component]:
    """Components that remain in some part."""
    return [c for p in motion.parts for c in p.system.scene.components.values()]


def module_of(c: Component) -> str:
    """The module of a component's kind, whose functions the emitted code calls."""
    return declaring(c.kind).__name__.rsplit(".", 1)[-1]


class Effects:
    """The effects of a motion, each with the components that have it and the compiled functions due to it."""

    def __init__(self, motion: MechanismRun) -> None:
        self.motion, self.scene, self.solved = motion, motion.system.scene, solved(motion)
        self.functions: list[tuple[str, str]] = []
        for p in motion.parts:
            t, sets = p.system.tables, declared(p.method).sets
            for line in (*evaluate_lines(t.blocks, t.has_tape, sets), *tangent_lines(t.blocks, t.has_tape, sets)):
                self.functions.append((line.effect, line.text.split("(")[0]))

    def entries(self) -> Iterator[Entry]:
        """All effects, in the order of the receipt."""
        n, m, p = (sum(getattr(part.system, key) for part in self.motion.parts) for key in "nmp")
        joints = [c for c in self.solved if isinstance(c.kind, JointKind) and c.kind.rows]
        states = [c for c in self.solved if is_state(c)]
        bodies = [c for c in self.solved if isinstance(c.kind, BodyKind) and c.kind.coordinates and c not in states]
        laws = [c for c in self.solved if isinstance(c.kind, ForceKind) and by_law(c) and not is_rate(c)]
        rolling = [c for c in self.solved if c.velocity_constraints]
        nothing = "everything is fixed, or moved by drivers"
        yield self.entry("bodies", bodies, nothing, self.kernels("bodies"), n - len(states))
        if states:
            yield self.entry("states", states, "none", self.kernels("laws", "expressions"), len(states))
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
        found = [c for c in self.scene.components.values() if _damps(c) and not is_rate(c)]
        nothing = self.without("damping", "no force depends on velocities")
        yield self.entry("velocity-dependent forces", found, nothing, ("within those of the forces",))
        yield self.friction()
        found = [c for c in self.solved if "contact" in c.kind.effects and c.kind.effects["contact"](c.values)]
        nothing = self.without("contact", "no stop or contact")
        yield self.entry("contact", found, nothing, self.kernels("laws", "expressions"))
        found = [c for c in self.solved if any(leaf.op == "multiplier" for leaf in leaves(*_laws(c)))]
        yield self.entry("forces that depend on reactions", found, "none")
        inputs = self.scene.inputs
        yield Entry("inputs", bool(inputs), few(list(inputs)) or "none", next((x.span for x in inputs.values()), None))
        if self.scene.has_events:
            yield self.events()
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
            own = (
                k for k in self.kernels("springs") if k.split(".")[0] in ("loops", "tangent_loops", module_of(found[0]))
            )
            yield self.entry(name, found, "", tuple(own))
        springs = [name for name, kind in kinds().items() if isinstance(kind, ForceKind) and kind.springs is not None]
        if absent := [name for name in springs if name not in present]:
            yield Entry("other linear forces", False, f"no {few(absent)}")

    def friction(self) -> Entry:
        found = [c for c in self.solved if c.friction is not None or _rubs(c)]
        idle = [c.name for c in self.scene.components.values() if c.friction is not None]
        why = f"of {few(idle, 4)}: it changes no motion" if idle else "no mu"
        entry = self.entry("friction", found, self.without("friction", why), self.kernels("laws", "expressions"))
        if rows := sum(len(x.holds) for p in self.motion.parts for x in p.system.scene.sticking):
            entry.why += f"; held by {count(rows, 'row')} while it sticks"
        return entry

    def events(self) -> Entry:
        """What acts at events, which end steps."""
        scene = self.scene
        clocks = few([f"{float(clock.period):g} s" for clock in scene.events.clocks])
        found = [count(len(own), "when-equation")] if (own := scene.events.written) else []
        found += [f"clocks of {clocks}"] if clocks else []
        touching = [*(c.name for c in scene.contacts), *(x.name for x in scene.sticking)]
        found += [few(touching, 4)] if touching else []
        first = next(span for _, span in scene.kinds_of_events.values())
        return Entry("events", True, ", ".join(found), first)

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
