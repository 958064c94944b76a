"""The compiled functions of a scene, their buffers, and the numbers in these that change from state to state."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mbdsl.compilation import code_cache
from mbdsl.expressions.symbolic import Expr
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.kernels.columns import columns_of
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import few
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.rotation import BASE
from mbdsl.system import background_compilation, emit
from mbdsl.system.emit import Kernels
from mbdsl.system.peaks_in_time import Replayed, Zone
from mbdsl.system.tables import Tables
from mbdsl.system.time_derivatives import TimeTerms
from mbdsl.system.workspace import Workspace

if TYPE_CHECKING:
    import subprocess


Search = TypeVar("Search")


@dataclass
class CompiledScene:
    """The part of :class:`mbdsl.system.system.System` that evaluates its compiled functions at a state."""

    scene: Scene
    graph: MechanismGraph
    tables: Tables
    code: str = ""
    _kernels: dict[int, Kernels] = field(default_factory=dict)
    _kept: dict[Callable, Any] = field(default_factory=dict, init=False, repr=False, compare=False)
    _work: Workspace | None = None
    _A: Array | None = None
    _clock: TimeTerms | None = None
    _zones: dict[tuple[float, float, float], Replayed[Zone]] = field(default_factory=dict)
    _built: tuple[bool, float | None] = (False, None)  #: further arguments of ``build``
    #: times [s] at which the search for zones of functions of time was given up
    zones_end: list[float] = field(default_factory=list, init=False, repr=False, compare=False)

    @property
    def n(self) -> int:
        """Number of generalised coordinates."""
        return self.tables.n

    @property
    def m(self) -> int:
        """Number of holonomic constraints."""
        return self.tables.m

    @property
    def p(self) -> int:
        """Number of nonholonomic constraints."""
        return self.tables.p

    @property
    def unknowns(self) -> int:
        """Coordinates and multipliers together, n + m + p."""
        return self.n + self.m + self.p

    @property
    def size(self) -> int:
        """Number of entries of A that ``tangent`` fills if every requested entry has a slot of its own."""
        return len(self.tables.pattern[0])

    def kernels(self, sets: int = 1) -> Kernels:
        """The compiled functions of this structure, for ``sets`` sets of multipliers."""
        if sets not in self._kernels:
            self._kernels[sets] = emit.load(self.tables.blocks, self.tables.has_tape, sets)
        return self._kernels[sets]

    def module_name(self, sets: int = 1) -> str:
        """The name of the emitted module of this structure."""
        return emit.module_name(emit.emit(self.tables.blocks, self.tables.has_tape, sets))

    def uncompiled(self, sets: int = 1) -> list[str]:
        """A description of the kernels, if they have to be compiled; [] if not."""
        if code_cache.is_compiled(self.module_name(sets)):
            return []
        names = dict.fromkeys(b.name.removesuffix("_kernels").replace("_", " ") for b in self.tables.blocks)
        return [f"a new combination of elements ({few(names)})"]

    def compile_beside(self, sets: int = 1) -> subprocess.Popen | None:
        """Start compiling the kernels in another process; None if no process can be started."""
        return background_compilation.start(self.tables.blocks, self.tables.has_tape, sets)

    def workspace(self, slots: Integers | None = None, rows: int = L.ROWS) -> Workspace:
        """New buffers. ``slots`` gives the position in A of every requested entry (default: one position each)."""
        t = self.tables
        if slots is None:
            slots = np.arange(self.size)
        layout = np.concatenate([t.layout, slots.astype(np.int64)])
        layout[L.SLOTS], layout[L.SIZE] = len(t.layout), self.size
        vectors = np.zeros((rows, max(1, self.unknowns)))
        vectors[L.SCALE, : self.n] = t.scale
        C = np.zeros((max(1, t.pair_rows), columns_of(self.scene.spatial).GRADIENT_COLUMNS))
        return Workspace(vectors, t.frame_table.copy(), C, t.numbers.copy(), layout)

    def into_charts(self, q: Array, numbers: Array) -> Array:
        """Make the attitudes of q (n,) the origins of the charts in ``numbers``; q with zeros for rotation vectors."""
        if not len(self.tables.rotations):
            return q
        d, at = self.tables.rotations.T
        numbers[at[:, None] + BASE + np.arange(4)] = rotation_arrays.quaternions(q[d[:, None] + np.arange(3)])
        q = np.array(q, float)
        q[d[:, None] + np.arange(3)] = 0.0
        return q

    def out_of_charts(self, q: Array, numbers: Array) -> Array:
        """Coordinates (n,) with the rotation vectors of attitudes, of coordinates in the charts of ``numbers``."""
        if not len(self.tables.rotations):
            return q
        d, at = self.tables.rotations.T
        base = rotation_arrays.vectors(numbers[at[:, None] + BASE + np.arange(4)])
        q = np.array(q, float)
        q[d[:, None] + np.arange(3)] = rotation_arrays.turned(base, q[d[:, None] + np.arange(3)])
        return q

    def moved(self, q: Array, *changes: Array) -> Array:
        """q (n,) after the sum of ``changes`` (n,): q + change, but rotations of bodies in space are composed."""
        found = q
        for change in changes:
            found = found + change
        if len(self.tables.rotations):
            own = self.tables.rotations[:, :1] + np.arange(3)
            rotation = np.sum([change[..., own] for change in changes], axis=0)
            found[..., own] = rotation_arrays.turned(q[..., own], rotation)
        return found

    def difference(self, q: Array, q0: Array) -> Array:
        """The displacements from q0 to q, (n,) or (N, n): ``moved(q0, difference(q, q0))`` is q."""
        found = q - q0
        if len(self.tables.rotations):
            own = self.tables.rotations[:, :1] + np.arange(3)
            found[..., own] = rotation_arrays.turned(-q0[..., own], q[..., own])
        return found

    def _in_body_axes(self, A):
        """A matrix over unknowns, from the world axes of compiled code to the axes of bodies."""
        if not len(self.tables.rotations):
            return A
        assert self._work is not None
        for d, at in self.tables.rotations:
            R, own = self._work.numbers[at : at + 9].reshape(3, 3), slice(d, d + 3)
            A[own] = R.T @ A[own]
            A[:, own] = A[:, own] @ R
        return A

    @property
    def buffers(self) -> Workspace:
        """The buffers in which states are evaluated."""
        if self._work is None:
            self._work = self.workspace()
        return self._work

    def _at(self, t: float, q, v=None, lam=None, mu=None) -> Workspace:
        w = self.buffers
        n = self.n
        w.vectors[L.POSITION, :n] = self.into_charts(q, w.numbers)
        w.vectors[L.VELOCITY, :n] = 0.0 if v is None else v
        w.vectors[L.UNKNOWN, n : self.unknowns] = 0.0 if lam is None else lam
        w.vectors[L.UNKNOWN2, n : n + self.m] = 0.0 if mu is None else mu
        self._any_kernels(2 if mu is not None else 1).evaluate(
            float(t), w.vectors, w.frames, w.gradients, w.numbers, w.layout
        )
        return w

    def _any_kernels(self, sets: int) -> Kernels:
        """Kernels for at least ``sets`` sets of multipliers; loaded ones are preferred, because they cost nothing."""
        return self._kernels[max(self._kernels)] if max(self._kernels, default=0) >= sets else self.kernels(sets)

    def set_first_angle(self, node: Expr, value: float) -> None:
        """Set the value at the start of an angle that counts turns, or of an expression."""
        self.tables.first_angles[node] = value
        if node in self.tables.starts:
            for name in ("laws", "searched_laws", "searched_angles", "switches_at_rest"):
                vars(self).pop(name, None)
        places = [self.tables.starts[node]] if node in self.tables.starts else self.tables.angles.get(node, ())
        for at in places:
            self.tables.numbers[at] = value
            self.set_number(at, value)

    def set_input(self, name: str, value: float) -> None:
        """Set the value of an input u for all later evaluations."""
        if name in self.tables.inputs:
            self.set_number(self.tables.inputs[name], value)

    def set_number(self, at: int, value: float) -> None:
        """Set an entry of ``numbers`` for all later evaluations."""
        self.buffers.numbers[at] = value

    def activate(self, left_out: Collection[int]) -> None:
        """Let those rows that hold at times only act in all later evaluations that are not among ``left_out``."""
        if self.tables.switchable:
            self.mark_switchable(self.buffers.layout, left_out)

    def mark_switchable(self, layout: Integers, left_out: Collection[int]) -> None:
        """Mark in ``layout`` which of the rows that hold at times only are left out."""
        for row in self.tables.switchable:
            layout[layout[L.PAIRS] + L.PAIR * row + L.LEFT_OUT] = int(row in left_out)

    def set_turn(self, name: str, angle: float) -> None:
        """Set the reference ``angle`` for counting the revolutions of body ``name``, if q does not contain them."""
        body = self.tables.models[name]
        if body.counter >= 0:
            body.turn = self.tables.numbers[body.counter] = angle
            self.set_number(body.counter, angle)

    def count_turns(self, q: Array, start: bool = False) -> None:
        """Count revolutions up to the accepted state q (n,), the ``start`` of a motion or the end of a step."""
        for name, body in self.tables.models.items():
            if body.counter >= 0:
                d, last = self.tables.coordinates[name], float(self.buffers.numbers[body.counter])
                own = q[None, d : d + body.n]
                angle = float(body.turned(last, own, own)[0])
                if start:
                    self.set_turn(name, angle)
                else:
                    self.set_number(body.counter, angle)

    def count_angles(self) -> None:
        """Count the turns of angles between frames in space up to the last evaluated state, which becomes the start."""
        for node, places in self.tables.angles.items():
            assert self._work is not None
            self.set_first_angle(node, float(self._work.numbers[places[0] + 1]))

    def count_angles_from_start(self) -> None:
        """Count the turns of angles between frames in space from their values at the start of a motion on."""
        for node, places in self.tables.angles.items():
            for at in places:
                self.set_number(at, self.tables.first_angles.get(node, 0.0))

    @property
    def counts_angles(self) -> bool:
        """Whether signals may be angles whose turns states do not contain: in space, and of ropes in the plane."""
        return self.scene.spatial or bool(self.tables.angles)

    def count_angles_up_to(self, t: float, q: Array) -> None:
        """Count them up to the accepted state q (n,), the end of a step."""
        if self.tables.angles:
            numbers = self._at(t, q).numbers
            for places in self.tables.angles.values():
                for at in places:
                    numbers[at] = numbers[at + 1]

    def kept(self, make: Callable[[Any], Search]) -> Search:
        """``make(self)``, made once; searches for peaks, which read signals of a System, are kept in it that way."""
        if make not in self._kept:
            self._kept[make] = make(self)
        return self._kept[make]
