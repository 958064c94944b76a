"""The contract of a body kind: a module of kernels, and beside it a model with arrays.

The kernels (:mod:`mbdsl.bodies.rigid_body_kernels`, ...) are what emitted code calls. They move the body's frames,
collect the forces on them and fill its part of the iteration matrix. ``kernels`` lists them with their parameters; the
first is always the offset in ``layout`` of the block's header. The module also has

``MASS``    0: the mass matrix is diagonal and constant; 1: constant; 2: it depends on q
``MODEL``   the name of the module whose ``MODEL`` is the class of the model

The model computes the same for single states, and fills the tables that the kernels read; :class:`Body` says what it
has. An element of the language names the kernels of its bodies as ``motion`` (see ``mbdsl/elements/body.py``).

``model_class`` checks all of this where a kind of body is met first.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import ModuleType
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


def kernels(mass: int) -> dict[str, str]:
    """Kernel -> its parameters, of bodies whose ``MASS`` is ``mass``.

    All read ``layout`` and write nothing but what is named here; wrenches are in columns of ``frames``, coordinates in
    rows of ``vectors``.
    """
    numbers = "numbers, " if mass else ""
    found = {
        # frames: pose and rate of every frame; its wrenches are set to zero
        "move": "block, vectors, frames, numbers, layout",
        "collect": f"block, vectors, frames, {numbers}layout",  # row FORCE += B^T F of every frame's wrench F
        "collect_with_mu": f"block, vectors, frames, {numbers}layout",  # the same, and FORCE2 from the wrenches of mu
        # PAST_FORCE += B^T F from the wrenches of psi, at the pose of the step's start
        "collect_past": f"block, vectors, frames, {numbers}layout",
        "jacobians": "block, vectors, frames, numbers, layout",  # numbers: B = dz/dq and (B v)_q of every frame
    }
    if mass > 0:
        # FORCE += elastic and damping forces, and those quadratic in velocities
        found["forces"] = "block, vectors, numbers, layout"
        # row ``target`` += (M - its diagonal) times ``row``, or M^{-1}
        found["inertia"] = "block, task, row, target, vectors, numbers, layout"
        # matrix: the derivatives of both
        found["tangents"] = "block, cM, cK, cD, cA, vectors, numbers, layout, matrix"
    if mass > 1:
        found["carry_over"] = "block, vectors, numbers, layout"  # what M of the start of the step adds
    return found


def optional_kernels(mass: int) -> dict[str, str]:
    """Those that a body may have: without ``stiffness``, B is constant; without ``keep``, there is nothing to keep."""
    numbers = "numbers, " if mass else ""
    return {
        "stiffness": f"block, cK, frames, {numbers}layout, matrix",  # matrix += cK (-d(B^T F)/dq) at the wrenches F
        "keep": "block, numbers, layout",  # numbers: what ``collect_past`` reads of the start of the step
    }


class Body(Protocol):
    """What a model of a body has; n is the number of its generalised coordinates.

    ``turned`` is for bodies with a ``counter`` only; all else is required.
    """

    n: int
    #: whether it changes its shape: its coordinates are more than a pose, and results have them as ``q[k]``, ``dq[k]``
    deforms: bool
    #: if q does not contain turns: the reference angle for counting them, and its offset in numbers; else -1
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
        one closest to ``turn``."""

    def rigid(self, q: Array) -> Array:
        """Directions (n, 3) of its motions as a rigid body in the shape that it has at q (n,)."""

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        """Kinetic and potential energy (N,) of states q, v (N, n) in the field g."""

    def bend(self, q: Array) -> Array:
        """The largest rotation (N,) [rad] that its theory takes for small; zeros where it takes none so."""


@cache
def model_class(module: ModuleType) -> type:
    """The class of the models that belong to a module of kernels.

    Parameters
    ----------
    module : module
        Kernels of a body kind.

    Raises
    ------
    TypeError
        If kernels or model are not as the contract says; the message lists all that is wrong.
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
