"""Bodies without mass that can move without moving a mass: the mass matrix is singular on the motions that the
constraints allow."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.initial.massless_points import remedy
from mbdsl.kernels.arrays import Array
from mbdsl.messages import few
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.massless import massless
from mbdsl.system.system import System

DEPENDENT = 1e-9  #: singular values below this part of the largest are zero
ROUNDING = 1e-13  #: entries below this part of those of other motions of the same body are sums that cancel
PART = 0.1  #: a body takes part in a motion in which one of its coordinates is this part of the largest
MOST = 400  #: largest number of massless coordinates that are examined


def singular_mass(system: System, t: float, q: Array, v: Array, lam: Array | None = None) -> InitialisationError | None:
    """The error of a singular mass matrix; None if it is regular on the motions that the constraints allow.

    Parameters
    ----------
    system : System
        The equations.
    t : float [s]
    q, v : (n,) [m, rad]
        A consistent state.
    lam : (m + p,), optional
        Its multipliers. If they are given, motions that stiffness or damping determine are not errors: a massless body
        between springs is at their equilibrium.

    Returns
    -------
    InitialisationError or None
        It names the bodies.
    """
    light = massless(system.tables)
    if not 0 < light.shape[1] <= MOST:
        return None
    light = light / system.tables.scale[:, None]
    owners = [body.name for body in system.scene.with_coordinates() for _ in body.coordinates]
    whole = _whole_bodies(light, system.tables.scale, owners)
    J = _significant(system.velocity_jacobian(t, q, v), light, whole)
    size = np.linalg.norm(J, axis=1, keepdims=True)
    free = light @ _null_space(J / np.where(size > 0.0, size, 1.0))
    if lam is not None and free.shape[1]:
        held = (system.stiffness(t, q, v, lam), system.damping(t, q, v, lam))
        whole = _whole_bodies(free, system.tables.scale, owners)
        free = free @ _null_space(np.vstack([_significant(X, free, whole, left=True) for X in held]))
    if not free.shape[1]:
        return None
    share = np.abs(free * system.tables.scale[:, None]).max(axis=1)
    moving = np.flatnonzero(share > PART * share.max())
    bodies = list(dict.fromkeys(owners[k] for k in moving))
    components = [system.scene.components[name] for name in bodies]
    notes = tuple((f"{c.kind.name} {c.name} has {_lacking(c.values)}", c.span) for c in components)
    hint = next(filter(None, (remedy(system.scene, name) for name in bodies)), None)
    hint = hint or "give it a mass and a moment of inertia, or hold it by further joints"
    if any(c.kind.spatial and c.kind.name == "Rod" for c in components):
        hint += "; a Cylinder has a moment of inertia about its axis"
    return InitialisationError(
        f"the mass matrix is singular: {few(bodies)} can move without moving a mass",
        components[0].span,
        notes=notes,
        hint=hint,
    )


def _lacking(values: Mapping) -> str:
    """The inertia that a body does not have."""
    zero = [f"{name} = 0" for name in ("m", "I") if values.get(name) == 0.0]
    I = values.get("I")
    if values.get("m") and isinstance(I, tuple) and not isinstance(I[0], tuple):
        axes = [axis for axis, x in zip("xyz", I, strict=True) if x == 0.0]
        return f"no moment of inertia about its {' and '.join(axes)} axis"
    return " and ".join(zero) or "no mass"


def _whole_bodies(motions: Array, scale: Array, owners: list[str]) -> Array:
    """Motions (n, k) in which every coordinate of a body moves as far as that which moves farthest."""
    _, body = np.unique(owners, return_inverse=True)
    farthest = np.zeros((body.max() + 1, motions.shape[1]))
    np.maximum.at(farthest, body, np.abs(motions * scale[:, None]))
    return farthest[body] / scale[:, None]


def _significant(X, motions: Array, whole: Array, left: bool = False) -> Array:
    """X @ motions, or motions.T @ X @ motions, where rounding errors are zeros: a thin rod turns about the axis through
    a ball without moving it, and without a torque."""
    found, bound = dense(X @ motions), dense(abs(X) @ whole)
    if left:
        found, bound = motions.T @ found, whole.T @ bound
    return np.where(np.abs(found) > ROUNDING * bound, found, 0.0)


def _null_space(J: Array) -> Array:
    """An orthonormal basis (n, k) of the x with J x = 0."""
    if not J.any():
        return np.eye(J.shape[1])
    _, sizes, Vt = np.linalg.svd(J, full_matrices=True)
    return Vt[int((sizes > DEPENDENT * sizes[0]).sum()) :].T
