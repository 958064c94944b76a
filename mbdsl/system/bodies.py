"""Bodies as the rest of the system sees them: coordinates, masses, and frames that move with them.

A module that moves frames (:mod:`mbdsl.elements.rigid_frames`, ...) holds the compiled kernels; its model, of the class
that it names as ``MODEL``, says the same of single states with arrays, and fills the tables that these kernels read.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from types import ModuleType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements import modules
from mbdsl.elements.kind import BodyKind
from mbdsl.mechanism.scene import Component

Array = NDArray[np.float64]
Pose = tuple[float, float, float]
#: rotation of a section [rad] up to which theories of small deformation are followed; their error is about its square
LARGEST_BEND = 0.5
POSITIONS, VELOCITIES = ("x", "y", "phi"), ("vx", "vy", "w")


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


class Rigid:
    """A rigid body by x, y of its centre of mass and, unless it is a point mass, its angle."""

    turn, counter = 0.0, -1

    def __init__(self, component: Component) -> None:
        self._mass = np.array(component.kind.table(component.values), float)
        self.n = len(self._mass)

    def mass(self) -> Array:
        return self._mass

    def couplings(self) -> list[tuple[int, int, float]]:
        return []

    def M(self, q: Array) -> Array:
        return np.diag(self._mass)

    def weight(self, g: Array) -> Array:
        return np.concatenate([self._mass[:2] * g, np.zeros(self.n - 2)])

    def scale(self, size: float) -> Array:
        return np.array([1.0 / size, 1.0 / size, 1.0])[: self.n]

    def eliminate(self) -> Sequence[int]:
        return range(self.n)

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        return tuple(range(self.n))

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """First coordinate, first frame, number of frames, offset of their poses, slot of the last coordinate."""
        last = d + self.n - 1
        offset = buffers.floats(value for pose in poses for value in pose)
        return [d, first, len(poses), offset, buffers.slots((last,), (last,))]

    def _lever(self, pose: Pose, phi):
        c, s = np.cos(phi), np.sin(phi)
        return c * pose[0] - s * pose[1], s * pose[0] + c * pose[1]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        if self.n < 3:
            k = (POSITIONS if key in POSITIONS else VELOCITIES).index(key)
            constant = np.full(len(q), pose[2] if key == "phi" else 0.0)
            return constant if k == 2 else (q if key in POSITIONS else v)[:, k]
        if key in ("phi", "w"):
            return q[:, 2] + pose[2] if key == "phi" else v[:, 2]
        if pose[0] == 0.0 and pose[1] == 0.0:
            return {"x": q[:, 0], "y": q[:, 1], "vx": v[:, 0], "vy": v[:, 1]}[key]
        lx, ly = self._lever(pose, q[:, 2])
        w = v[:, 2]
        if key in ("x", "y"):
            return q[:, 0] + lx if key == "x" else q[:, 1] + ly
        return v[:, 0] - ly * w if key == "vx" else v[:, 1] + lx * w

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array]:
        B, rate = np.eye(3)[:, : self.n], np.zeros((3, self.n))
        if self.n == 3:
            lx, ly = self._lever(pose, q[2])
            B[:2, 2], rate[:2, 2] = (-ly, lx), (-lx * v[2], -ly * v[2])
        return B, rate

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        return np.array(pose)[: self.n], np.eye(self.n, 3)

    def turned(self, turn: float, q: Array, v: Array, t: Array | None = None) -> Array:
        raise NotImplementedError

    def rigid(self, q: Array) -> Array:
        return np.eye(self.n, 3)

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        return 0.5 * v**2 @ self._mass, -self._mass[0] * (q[:, :2] @ g)

    def bend(self, q: Array) -> Array:
        return np.zeros(len(q))


def motion_module(component: Component) -> ModuleType:
    """The module whose kernels move a body's frames; of kinds with several it depends on the values."""
    found = modules()[component.kind.name].motion
    return found(component.values) if callable(found) else found


def motion_modules(module: ModuleType) -> list[ModuleType]:
    """All that bodies of a kind may be moved by."""
    return list(getattr(module, "MOTIONS", [module.motion]))


def model(component: Component) -> Body:
    """The model of a body with coordinates."""
    where = getattr(motion_module(component), "MODEL", None)
    if where is None:
        return Rigid(component)
    return importlib.import_module(where).MODEL(component)


def body_pose(component: Component, frame) -> Pose:
    """A frame's (x, y, phi) from the centre of mass (of a beam: from its middle), in the body's axes."""
    cx, cy = component.kind.com(component.values) if isinstance(component.kind, BodyKind) else (0.0, 0.0)
    return frame.x - cx, frame.y - cy, frame.phi
