"""Linearly dependent constraints: redundant joints, and joints whose constraints lose rank in a singular pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.elements.kind import is_point
from mbdsl.initial.shared_loads import undetermined
from mbdsl.kernels.arrays import Array
from mbdsl.messages import few
from mbdsl.system.system import System

NEAR = 1e-2  #: a pose is close to a singular one if the smallest singular value is below this part of the largest
FITS = 1e-12  #: misfit of a redundant joint, relative to the mechanism's size, that counts as rounding
PART = 1e-2  #: coefficients below this part of the largest are taken as zero


def _rows(system: System, t: float, q: Array, v: Array) -> Array | None:
    """The rows of [Phi_q; Gam_v], dimensionless and of length 1; None if there are too many to analyse."""
    J = system.velocity_jacobian(t, q, v)
    if not isinstance(J, np.ndarray) or not len(J) or not np.isfinite(J).all():
        return None
    J = J / system.tables.scale
    size = np.linalg.norm(J, axis=1, keepdims=True)
    return J / np.where(size > 0.0, size, 1.0)


def _joints(system: System, rows: Sequence[int]) -> list[str]:
    names = system.constraint_names()
    return list(dict.fromkeys(names[k].rsplit(".", 1)[0] for k in rows))


def repeated(system: System, t: float, q: Array, v: Array, redundant: Sequence[int]) -> list[str]:
    """A line for each joint with redundant constraints: its place, the joints that imply it, and its misfit."""
    at_times = system.tables.switchable  # such rows hold at times only
    redundant = [k for k in redundant if k not in at_times]
    J = _rows(system, t, q, v) if redundant else None
    if J is None:
        return []
    rest = [k for k in range(len(J)) if k not in redundant and k not in at_times]
    violation = np.concatenate([system.Phi(t, q), system.Gam(t, q, v)])
    lines = []
    for joint in _joints(system, redundant):
        own = [k for k in redundant if joint in _joints(system, [k])]
        parts = np.abs(np.linalg.lstsq(J[rest].T, J[own].T, rcond=1e-9)[0]).max(axis=1)
        others = _joints(system, [rest[k] for k in np.flatnonzero(parts > PART * parts.max())])
        names = ", ".join(where(system, other) for other in others if other != joint)
        off = float(np.abs(violation[own]).max())
        misfit = f"; its misfit is {off:.2g}" if off > FITS * system.tables.size else ""
        why = f"follows from {names}" if names else _alone(system, joint)
        lines.append(f"{where(system, joint)} {why}{misfit}")
    return lines


def _alone(system: System, joint: str) -> str:
    """Why a row of a joint is redundant without other joints."""
    scene = system.scene
    ends = [scene.components[scene.frames[x].body] for x in scene.components[joint].ports.values()]
    points = [c.name for c in ends if is_point(c.kind)]
    if points:
        return f"constrains the attitude of {points[-1]}, a point mass, which has none"
    return "has rows that depend on each other"


def of_attitudes(system: System, t: float, q: Array, v: Array, redundant: Sequence[int]) -> list[str]:
    """Names of the redundant rows that are always satisfied: they constrain the attitude of a point mass."""
    J = system.velocity_jacobian(t, q, v) if redundant else None
    names = system.constraint_names()
    return [names[k] for k in redundant if isinstance(J, np.ndarray) and not J[k].any()]


def not_unique(system: System, t: float, q: Array, redundant: Sequence[int]) -> list[str]:
    """A line that names the reactions that the equations of motion do not determine; [] if all are determined."""
    found: dict[str, list[str]] = {}
    for name in undetermined(system, t, q, tuple(redundant)):
        joint, _, key = name.rpartition(".")
        found.setdefault(joint, []).append(key)
    if not found:
        return []
    texts = [f"{name} ({', '.join(keys)})" for name, keys in found.items()]
    return [f"reactions that are not unique: {few(texts, 12)}"]


def where(system: System, joint: str) -> str:
    """ "Revolute A3 (model.mbd:14)"."""
    component = system.scene.components[joint]
    place = f" ({component.span.file.rsplit('/', 1)[-1]}:{component.span.line})" if component.span else ""
    return f"{component.kind.name} {joint}{place}"


def singular(system: System, t: float, q: Array, v: Array, left_out: Sequence[int] = ()) -> str:
    """A message if the constraints, without those left out, are linearly dependent in a pose, or nearly so; else an
    empty text."""
    J = _rows(system, t, q, v) if np.isfinite([q, v]).all() else None
    if J is None:
        return ""
    kept = np.delete(np.arange(len(J)), left_out)
    J = J[kept]
    left, sizes, _ = np.linalg.svd(J)
    smallest = float(sizes[-1] / sizes[0]) if len(J) <= J.shape[1] else 0.0
    if smallest > NEAR:
        return ""
    share = np.abs(left[:, -1])
    joints = _joints(system, [int(kept[k]) for k in np.argsort(-share) if share[k] > 0.1 * share.max()])
    if len(joints) < 2:
        return ""
    return f"the pose is singular, or close to it (to {smallest:.1g}): {few(joints)} depend on each other there"
