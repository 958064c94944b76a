"""Tables of a scene: indices of its coordinates, constraints and frames, and the flat buffers that kernels read.

The result is data only; :mod:`mbdsl.system.emit` generates code from its *structure* (kinds and features). Scenes of
the same structure share their code, whatever their sizes and numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mbdsl.bodies.contract import Body
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.kernels.columns import PLANE as C
from mbdsl.mechanism import energies
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.system import switches
from mbdsl.system.structure import Block, expressions

Result = TypeVar("Result")


@dataclass
class Tables:
    """The buffers of a scene, and the offsets of their content."""

    scene: Scene
    blocks: list[Block]
    n: int
    m: int
    p: int
    coordinates: dict[str, int]  #: body name -> first coordinate
    rows: dict[str, int]  #: joint name -> first holonomic constraint
    velocity_rows: dict[str, int]  #: joint name -> first nonholonomic constraint, counted after the holonomic ones
    frames: dict[str, int]  #: frame name -> row of the frame table
    models: dict[str, Body]  #: body name -> its model
    numbers: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    layout: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    frame_table: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, C.COLUMNS)))
    size: float = 1.0  #: of the mechanism [m]
    #: displacement in a run, relative to the size, from which on the displacement becomes the size
    outgrown_from: float = np.inf
    scale: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    lengths: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, bool))  #: which coordinates are lengths
    pattern: tuple[NDArray[np.int64], NDArray[np.int64]] = (np.empty(0, np.int64), np.empty(0, np.int64))
    multipliers: dict[tuple[str, int], int] = field(default_factory=dict)  #: (joint, k) -> entry in a row of vectors
    inputs: dict[str, int] = field(default_factory=dict)  #: name -> offset in numbers, of inputs that are used
    rotations: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 2), np.int64))  #: see Buffers
    #: angle in space that counts turns -> offsets in numbers of its values at the last accepted step
    angles: dict[Expr, list[int]] = field(default_factory=dict)
    starts: dict[Expr, int] = field(default_factory=dict)  #: value at the start -> offset in numbers
    #: such an angle -> its value at the start, up to less than half a turn; and values at the start
    first_angles: dict[Expr, float] = field(default_factory=dict)
    switches: list[switches.Switch] = field(default_factory=list)
    quantities: list[tuple[Any, ...]] = field(default_factory=list)  #: that decide them
    #: offsets in numbers of the truth of the scene's conditions
    conditions: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    values: list[Expr] = field(default_factory=list)  #: expressions of laws, drivers and nonholonomic constraints
    #: what is searched for peaks instead of some of them: of constraints by expression, the sum of the user's laws in
    #: them; of components along a path, ``searched`` of their values
    row_laws: dict[Expr, Expr | None] = field(default_factory=dict)

    def resize(self, size: float) -> None:
        """Set the size [m] of the mechanism: translations are scaled by it, angles are in radians."""
        own = of_models(self.models, lambda body: body.scale(size).tolist())
        other = of_models(self.models, lambda body: body.scale(2.0 * size).tolist())
        self.size, self.scale = size, np.array([x for found in own for x in found], float)
        self.lengths = self.scale != np.array([x for found in other for x in found], float)

    @cached_property
    def of_multipliers(self) -> bool:
        """Whether some force depends on multipliers."""
        blocks = [b for b in self.blocks if b.role in ("law", "gamma")]
        found = (x for b in blocks for c in b.components for x in leaves(*expressions(b, c)))
        return any(leaf.op == "multiplier" for leaf in found)

    @cached_property
    def switches_of_multipliers(self) -> bool:
        """Whether some switch depends on multipliers."""
        return any(leaf.op == "multiplier" for switch in self.switches for leaf in leaves(switch.node))

    @cached_property
    def flexible(self) -> tuple[str, ...]:
        """Names of the bodies that deform."""
        return tuple(name for name, body in self.models.items() if body.deforms)

    @cached_property
    def states(self) -> int:
        """The number of states, whose coordinates are the last ones."""
        return len(self.scene.states())

    @cached_property
    def holding(self) -> dict[str, Component]:
        """The rows that hold joints while their friction sticks; no components of the scene."""
        joints = (c for b in self.blocks if b.role == "joint" for c in b.components)
        return {c.name: c for c in joints if c.name not in self.scene.components}

    @cached_property
    def counters(self) -> tuple[int, ...]:
        """Offsets in ``numbers`` of the angles whose turns are counted, and of values at the start."""
        counted = [at for places in self.angles.values() for at in places]
        return (*(b.counter for b in self.models.values() if b.counter >= 0), *counted, *self.starts.values())

    @cached_property
    def switchable(self) -> tuple[int, ...]:
        """Rows of constraints that hold at times only; left out unless a run activates them."""
        return tuple(sorted(self.rows[name] for name in self.holding))

    @cached_property
    def contact_rows(self) -> tuple[tuple[int, ...], ...]:
        """The rows of each rigid contact: that of its gap, and those of its slips, which follow all holonomic ones."""
        found = []
        for c in self.scene.contacts:
            first = self.velocity_rows.get(c.name, 0)
            found.append((self.rows[c.name], *range(first, first + len(c.slips))))
        return tuple(found)

    def joint(self, name: str) -> Component:
        """A joint that has rows."""
        return self.holding[name] if name in self.holding else self.scene.components[name]

    @property
    def pair_rows(self) -> int:
        """Rows of the gradient table."""
        return sum(len(b.components) * b.rows for b in self.blocks if b.role in ("joint", "spring", "law"))

    @property
    def has_tape(self) -> bool:
        own = any(b.role in ("law", "gamma", "moving") or b.driven or b.coupled or b.related for b in self.blocks)
        return own or self.scene.has_events


class Buffers:
    """Growing float and integer buffers; ``floats`` and ``ints`` return the offset of the appended values."""

    def __init__(self, header: int) -> None:
        self.numbers: list[float] = []
        self.layout: list[int] = [0] * header
        self.rows: list[int] = []  #: of the requested entries of the iteration matrix
        self.columns: list[int] = []  #: the same
        self.rotations: list[tuple[int, int]] = []  #: (first coordinate, offset in numbers), of bodies in space

    def floats(self, values) -> int:
        offset = len(self.numbers)
        self.numbers.extend(values)
        return offset

    def ints(self, values) -> int:
        offset = len(self.layout)
        self.layout.extend(values)
        return offset

    @property
    def requested(self) -> int:
        """Number of requested entries of the iteration matrix."""
        return len(self.rows)

    def slots(self, rows: Sequence[int], columns: Sequence[int]) -> int:
        """Request entries (r, c) of the iteration matrix; returns the relative offset of their slots."""
        offset, count = len(self.rows), len(columns)
        self.columns.extend([*columns] * len(rows))
        self.rows.extend(rows if count == 1 else [r for r in rows for _ in range(count)])
        return offset

    def rotation_slots(self, rows: Sequence[int], columns: Sequence[int], spare: int) -> None:
        """As :meth:`slots`, for entries that are zero unless both coordinates are rotations of bodies in space, whose
        first three coordinates are displacements; the zeros are added to the entry (spare, spare)."""
        for i, r in enumerate(rows):
            for j, c in enumerate(columns):
                turns = i >= 3 and j >= 3
                self.rows.append(r if turns else spare)
                self.columns.append(c if turns else spare)


def of_models(models: Mapping[str, Body], value: Callable[[Body], Result]) -> list[Result]:
    """The value of the model of each body; computed once for a model that bodies share."""
    each = {id(body): body for body in models.values()}
    found = {key: value(body) for key, body in each.items()}
    return [found[id(body)] for body in models.values()]


def gravity(scene: Scene) -> NDArray[np.float64]:
    """The gravity field (2,) [m/s2]."""
    return np.array(energies.gravity(scene))
