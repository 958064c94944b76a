"""Tables of a scene: indices of its coordinates, constraints and frames, and the flat buffers that kernels read.

The result is data only; :mod:`mbdsl.system.emit` generates code from its *structure* (kinds and features). Scenes of
the same structure share their code, whatever their sizes and numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mbdsl.bodies.contract import Body
from mbdsl.compilation import buffer_layout
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.mechanism import energies
from mbdsl.mechanism.scene import Scene
from mbdsl.system import switches
from mbdsl.system.structure import Block, expressions


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
    frame_table: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, buffer_layout.COLUMNS)))
    size: float = 1.0  #: of the mechanism [m]
    from_start: bool = False  #: whether the size is that of initial positions, or 1 m if the model has no length
    scale: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    lengths: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, bool))  #: which coordinates are lengths
    pattern: tuple[NDArray[np.int64], NDArray[np.int64]] = (np.empty(0, np.int64), np.empty(0, np.int64))
    multipliers: dict[tuple[str, int], int] = field(default_factory=dict)  #: (joint, k) -> entry in a row of vectors
    inputs: dict[str, int] = field(default_factory=dict)  #: name -> offset in numbers, of inputs that are used
    switches: list[switches.Switch] = field(default_factory=list)
    values: list[Expr] = field(default_factory=list)  #: expressions of laws, drivers and nonholonomic constraints

    def resize(self, size: float) -> None:
        """Set the size [m] of the mechanism: translations are scaled by it, angles are in radians."""
        self.size, self.scale, self.lengths = size, np.ones(self.n), np.zeros(self.n, bool)
        for body, own_model in self.models.items():
            d, own = self.coordinates[body], own_model.scale(size)
            self.scale[d : d + len(own)] = own
            self.lengths[d : d + len(own)] = own != own_model.scale(2.0 * size)

    @cached_property
    def of_multipliers(self) -> bool:
        """Whether some force depends on multipliers."""
        found = (x for b in self.blocks for c in b.components for x in leaves(*expressions(b, c)))
        return any(leaf.op == "multiplier" for leaf in found)

    @cached_property
    def flexible(self) -> tuple[str, ...]:
        """Names of the bodies that deform."""
        return tuple(name for name, body in self.models.items() if body.deforms)

    @property
    def pair_rows(self) -> int:
        """Rows of the gradient table."""
        return sum(len(b.components) * b.rows for b in self.blocks if b.role in ("joint", "spring", "law"))

    @property
    def has_tape(self) -> bool:
        return any(b.role in ("law", "gamma", "moving") or b.driven or b.coupled for b in self.blocks)


class Buffers:
    """Growing float and integer buffers; ``floats`` and ``ints`` return the offset of the appended values."""

    def __init__(self, header: int) -> None:
        self.numbers: list[float] = []
        self.layout: list[int] = [0] * header
        self.requests: list[tuple[int, int]] = []

    def floats(self, values) -> int:
        offset = len(self.numbers)
        self.numbers.extend(values)
        return offset

    def ints(self, values) -> int:
        offset = len(self.layout)
        self.layout.extend(values)
        return offset

    def slots(self, rows, columns) -> int:
        """Request entries (r, c) of the iteration matrix; returns the relative offset of their slots."""
        offset = len(self.requests)
        self.requests.extend((r, c) for r in rows for c in columns)
        return offset


def gravity(scene: Scene) -> NDArray[np.float64]:
    """The gravity field (2,) [m/s2]."""
    return np.array(energies.gravity(scene))
