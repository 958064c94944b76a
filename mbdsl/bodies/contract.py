"""The contract of a body kind: a module of kernels, and a model, a class that evaluates the same quantities in NumPy.

Emitted code calls the kernels (:mod:`mbdsl.bodies.rigid_body_kernels`, ...). They compute the motion of the body's
frames, collect the forces on them and assemble the body's part of the iteration matrix. ``kernels`` lists them with
their parameters; the first is always the offset in ``layout`` of the block's header. The module also defines

``MASS``    0: the mass matrix is diagonal and constant; 1: constant; 2: it depends on q
``MODEL``   the name of the module that contains the model, under the name ``MODEL``

The model computes the same quantities for single states, and fills the tables that the kernels read; :class:`Body`
lists its members. The module of an element of the language names the kernels of its bodies as ``motion`` (see
``mbdsl/elements/body.py``).

``model_class`` checks all of this when a kind of body is first used.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from mbdsl.kernels.arrays import Array

Pose = Any  #: a tuple of floats: (x, y, phi), or in space origin and axes (12 numbers)
#: largest rotation of a section [rad] in theories of small deformation; their relative error is about its square
LARGEST_BEND = 0.5
POSITIONS, VELOCITIES = ("x", "y", "phi"), ("vx", "vy", "w")
#: coordinates of a frame in space, in the order of the frame table: origin, axes x, y, z; velocity, angular velocity
SPATIAL_POSITIONS = ("x", "y", "z", "xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")
SPATIAL_VELOCITIES = ("vx", "vy", "vz", "wx", "wy", "wz")


class Described(Protocol):
    """The component of a scene from which a model is built: its kind, and the kind's parameters in SI units."""

    @property
    def kind(self) -> Any: ...

    @property
    def values(self) -> Mapping[str, Any]: ...


def kernels(mass: int) -> dict[str, str]:
    """The required kernels and their parameters, for bodies whose ``MASS`` is ``mass``.

    All kernels read ``layout``. They write only the buffers that are named here. Wrenches are columns of ``frames``;
    coordinates and forces are rows of ``vectors``.
    """
    numbers = "numbers, " if mass else ""
    found = {
        # frames: pose and rate of every frame, and zero wrenches
        "move": "block, vectors, frames, numbers, layout",
        # ``row`` += B^T F with the wrench F and the lever of every frame, in the columns of frames from ``wrench`` and
        # ``lever`` on; with PAST_FORCE at the pose of the step's start
        "gather": f"block, wrench, lever, row, vectors, frames, {numbers}layout",
        "jacobians": "block, vectors, frames, numbers, layout",  # numbers: B = dz/dq and (B v)_q of every frame
    }
    if mass > 0:
        # row FORCE += elastic and damping forces, and inertia forces quadratic in the velocities
        found["forces"] = "block, vectors, numbers, layout"
        # row ``target`` += (M - its constant diagonal) times ``row``, or = M^{-1} times ``row``
        found["inertia"] = "block, task, row, target, vectors, numbers, layout"
        # matrix += cM (M - its constant part) + cA (M a)_q - cK Q_q - cD Q_v with Q of ``forces``
        found["tangents"] = "block, factors, vectors, numbers, layout, matrix"
    if mass > 1:
        # row PAST_FORCE = M M_n^{-1} PAST_FORCE with M_n at the start of the step
        found["carry_over"] = "block, vectors, numbers, layout"
    return found


def optional_kernels(mass: int) -> dict[str, str]:
    """Optional kernels: without ``stiffness``, B is constant; without ``keep``, ``gather`` needs no storage.

    A body whose coordinates are charts of its rotation in a step (:mod:`mbdsl.integrators.loop.rotation_chart`) has all
    three kernels ``step_jacobians``, ``step_tangents`` and ``past_jacobians``.
    """
    numbers = "numbers, " if mass else ""
    return {
        # ``gather`` of the wrenches to FORCE and of those of mu to FORCE2, where one loop is faster
        "collect_with_mu": f"block, vectors, frames, {numbers}layout",
        "stiffness": f"block, cK, frames, {numbers}layout, matrix",  # matrix += cK (-d(B^T F)/dq) at the wrenches F
        # numbers: (B v)_q += the change of B v by that of the velocities due to the chart
        "step_jacobians": "block, cK, cD, vectors, frames, numbers, layout",
        # matrix += cU d(B^T F)/dq at the wrenches of mu, and with cU, the effect of the chart on cM M + cE I
        "step_tangents": "block, factors, vectors, frames, numbers, layout, matrix",
        # numbers: with cG, B is replaced by that of the start of the step, in the present axes of the rotation
        "past_jacobians": "block, cG, frames, numbers, layout",
        "keep": "block, numbers, layout",  # numbers: stores the data of the start of the step for ``gather``
    }


class Body(Protocol):
    """The members of a body model; n is the number of its generalised coordinates.

    ``turned`` is required only of bodies with a ``counter``, all else of every body.
    """

    n: int
    #: whether the body deforms: it has more coordinates than a pose, and results list them as ``q[k]``, ``dq[k]``
    deforms: bool
    #: if q lacks the number of revolutions: the reference angle for counting them, and its offset in numbers; else -1
    turn: float
    counter: int

    def mass(self) -> Array:
        """The constant part of the diagonal of the mass matrix (n,)."""

    def couplings(self) -> list[tuple[int, int, float]]:
        """Constant entries (i, j, value) of the mass matrix with i < j."""

    def M(self, q: Array) -> Array:
        """The mass matrix (n, n) at coordinates q (n,)."""

    def weight(self, g: Array) -> Array:
        """The constant part (n,) of the generalised force of gravity g (2,) [m/s2]."""

    def scale(self, size: float) -> Array:
        """Factors (n,) that make coordinates dimensionless and comparable; ``size`` [m] is that of the mechanism."""

    def eliminate(self) -> Sequence[int]:
        """The order in which the coordinates are eliminated."""

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        """Indices of the coordinates that a frame at ``pose`` depends on."""

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """Fill the tables of a body with first coordinate d and first frame ``first``; return its record."""

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        """Coordinate ``key`` of a frame for states q, v (N, n) at times t (N,); shape (N,)."""

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array]:
        """B = dz/dq and (B v)_q, both (3, n), of a frame's z = (x, y, phi) at one state."""

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        """q (n,) of the undeformed body with its reference point at ``pose``, and dq/dpose (n, 3)."""

    def turned(self, turn: float, q: Array, v: Array, t: Array | None = None) -> Array:
        """The reference angle (N,) for counting revolutions, in states q, v (N, n) at times t (N,); in the first state,
        the value closest to ``turn``."""

    def rigid(self, q: Array) -> Array:
        """Directions (n, 3) of the rigid-body motions, in the shape at q (n,)."""

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        """Kinetic and potential energy (N,) of states q, v (N, n) in the field g."""

    def bend(self, q: Array) -> Array:
        """The largest rotation (N,) [rad] that the theory assumes to be small; zeros if it assumes none to be."""


class UndeformedModel:
    """The members that a model has by default, of a body that does not deform and has no couplings."""

    n: int
    deforms = False
    turn, counter = 0.0, -1

    def couplings(self) -> list[tuple[int, int, float]]:
        return []

    def eliminate(self) -> Sequence[int]:
        return range(self.n)

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        return tuple(range(self.n))

    def bend(self, q: Array) -> Array:
        return np.zeros(len(q))


@cache
def model_class(module: ModuleType) -> type:
    """The model class that belongs to a module of kernels.

    Parameters
    ----------
    module : module
        Kernels of a body kind.

    Raises
    ------
    TypeError
        If the kernels or the model violate the contract; the message lists all violations.
    """
    wrong = list(_wrong_kernels(module))
    found: Any = None
    if isinstance(name := getattr(module, "MODEL", None), str):
        found = getattr(importlib.import_module(name), "MODEL", None)
        wrong += _wrong_model(found) if isinstance(found, type) else [f"{name} has no class MODEL"]
    else:
        wrong.append("MODEL is missing: the name of the module of its model")
    if wrong:
        raise TypeError(f"{module.__name__} breaks the contract in {__name__}: {'; '.join(wrong)}")
    return found


def _wrong_kernels(module: ModuleType) -> Iterator[str]:
    mass = getattr(module, "MASS", None)
    if mass not in (0, 1, 2):
        yield f"MASS is {mass}, expected 0, 1 or 2"
        return
    for name, parameters in (kernels(mass) | optional_kernels(mass)).items():
        kernel = getattr(module, name, None)
        if kernel is None:
            if name not in optional_kernels(mass):
                yield f"the kernel {name}({parameters}) is missing"
        elif not hasattr(kernel, "__mbdsl_kernel__"):
            yield f"{name} is not marked as a kernel"
        elif (has := ", ".join(inspect.signature(kernel).parameters)) != parameters:
            yield f"the kernel {name} takes ({has}), expected ({parameters})"


def _wrong_model(model: type) -> Iterator[str]:
    if not isinstance(getattr(model, "deforms", None), bool):
        yield f"{model.__name__}.deforms is missing: True or False"
    for name, wanted in vars(Body).items():
        if name.startswith("_") or not inspect.isfunction(wanted):
            continue
        method = getattr(model, name, None)
        parameters = ", ".join(inspect.signature(wanted).parameters)
        if method is None:
            if name != "turned":
                yield f"{model.__name__} has no method {name}({parameters})"
        elif (has := ", ".join(inspect.signature(method).parameters)) != parameters:
            yield f"{model.__name__}.{name} takes ({has}), expected ({parameters})"
