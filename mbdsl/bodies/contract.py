"""The contract of a body's model: coordinates, mass matrix, and frames that move with it, for single states.

A module of kernels (:mod:`mbdsl.bodies.rigid_body_kernels`, ...) moves the frames in compiled code. Its model, of the
class that it names as ``MODEL``, computes the same with arrays and fills the tables that these kernels read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pose = tuple[float, float, float]
#: rotation of a section [rad] up to which theories of small deformation are followed; their error is about its square
LARGEST_BEND = 0.5
POSITIONS, VELOCITIES = ("x", "y", "phi"), ("vx", "vy", "w")


class Described(Protocol):
    """The component of a scene that a model is made of: its kind, and the kind's parameters in SI units."""

    @property
    def kind(self) -> Any: ...

    @property
    def values(self) -> Mapping[str, Any]: ...


class Body(Protocol):
    """What a model of a body can tell; n is the number of its generalised coordinates."""

    n: int
    #: if q does not contain turns: the reference angle for counting them, and its offset in F for kernels; else -1
    turn: float
    counter: int

    def mass(self) -> Array:
        """The constant part of its mass matrix's diagonal (n,)."""

    def couplings(self) -> list[tuple[int, int, float]]:
        """Constant entries (i, j, value) of its mass matrix with i < j."""

    def M(self, q: Array) -> Array:
        """Its mass matrix (n, n) at coordinates q (n,)."""

    def weight(self, g: Array) -> Array:
        """The constant part (n,) of the generalised force of gravity g (2,) [m/s2]."""

    def scale(self, size: float) -> Array:
        """Factors (n,) that make coordinates comparable with one another, ``size`` [m] being that of the mechanism."""

    def eliminate(self) -> Sequence[int]:
        """The order in which its coordinates are eliminated."""

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        """Which of its coordinates a frame at ``pose`` moves with."""

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """Fill the tables: first coordinate and first frame of the body; the integers that stand in its block."""

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        """Coordinate ``key`` of a frame for states q, v (N, n) at times t (N,); shape (N,)."""

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array]:
        """B = dz/dq and (B v)_q, both (3, n), of a frame's z = (x, y, phi) at one state."""

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        """q (n,) of the undeformed body with its reference point at ``pose``, and dq/dpose (n, 3)."""

    def turned(self, turn: float, q: Array, v: Array, t: Array | None = None) -> Array:
        """The reference angle (N,) for counting turns, in states q, v (N, n) at times t (N,): in the first state the
        one closest to ``turn``. For bodies with a ``counter`` only."""

    def rigid(self, q: Array) -> Array:
        """Directions (n, 3) of its motions as a rigid body in the shape that it has at q (n,)."""

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        """Kinetic and potential energy (N,) of states q, v (N, n) in the field g."""

    def bend(self, q: Array) -> Array:
        """The largest rotation (N,) [rad] that its theory takes for small; zeros where it takes none so."""
