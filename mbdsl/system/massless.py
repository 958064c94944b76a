"""Motions without mass: coordinates, and rotations in space about axes that may lie between those of the body."""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.system.tables import Tables


def bodies_without_inertia(tables: Tables) -> list[str]:
    """Names of the bodies with such motions."""
    moved = np.abs(massless(tables)).sum(axis=1) > 0.0
    return [name for name, d in tables.coordinates.items() if moved[d : d + tables.models[name].n].any()]


def massless(tables: Tables) -> Array:
    """Orthonormal directions (n, k), in the axes of the bodies, on which the mass matrix is zero."""
    n = sum(model.n for model in tables.models.values())
    found = [np.zeros((n, 0))]
    for name, d in tables.coordinates.items():
        model = tables.models[name]
        # an optional member: kinds with a mass matrix that is singular, but not on a coordinate
        own = model.massless() if hasattr(model, "massless") else np.eye(model.n)[:, ~(model.mass() > 0.0)]
        if own.shape[1]:
            columns = np.zeros((n, own.shape[1]))
            columns[d : d + model.n] = own
            found.append(columns)
    return np.hstack(found)
