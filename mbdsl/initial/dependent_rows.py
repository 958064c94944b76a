"""Constraint rows that depend on others in all poses: the rank at the assembled pose and at poses near it.

A row that is redundant in every pose is a combination of others, as of a planar loop whose hinges hold its bodies in
their plane as well. In a singular pose more rows are dependent, but only there. Poses near the assembled one, displaced
along the mobility, tell the two apart: they are found by Gauss-Newton steps of the assembled pose's rank, in which the
smaller singular values do not count. Rows and coordinates are without units and of the mechanism's size.
"""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import Matrix, dense, least_squares, row_size, scaled
from mbdsl.system.system import System

ZERO = 1e-7  #: singular values and remainders of rows of length one that count as zero: poses hold to 1e-9
CLOSED = 1e-9  #: misfit of the constraints in a pose, in the mechanism's size, up to which they hold
ARRIVED = 1e-15  #: misfit that further steps do not reduce
DISPLACED = 1e-2  #: displacement of the poses near the assembled one, in the mechanism's size and in radians
#: a row joins the independent ones if this part of it is new; the next bounds are for rows that no other replaces
NEW = (1e-2, 1e-5, ZERO)
#: most rows of sparse systems in space that are analysed; 1500 rows take a second
MOST_ROWS = 1500
#: poses along the motion in which the rows kept are compared, in each direction, their distance in the mechanism's size
#: and in radians, and most rows of a mechanism for this
WALK, STRIDE, MOST_EXCHANGED = 16, 0.4, 40
#: smallest singular value, of rows of length about one, below which rows are exchanged; most exchanges, least gain
POOR, EXCHANGES, BETTER = 0.02, 6, 1.2


def without_units(J: Matrix, r: Array, scale: Array) -> tuple[Matrix, Array]:
    """Rows over scaled coordinates, each divided by its largest entry, and their residuals."""
    J = scaled(J, np.ones(J.shape[0]), 1.0 / scale)
    size = row_size(J)
    return scaled(J, 1.0 / size, np.ones(len(scale))), r / size


def redundant_rows(system: System, t: float, q: Array, v: Array) -> tuple[int, ...]:
    """Rows of [Phi_q; Gam_v] that depend on others here and in nearby poses, for systems of moderate size.

    Rows that depend on others only in this (singular) pose are kept. Rows that hold at times only are left out as well.
    """
    return tuple(sorted({*_redundant_rows(system, t, q, v), *system.tables.switchable}))


def _redundant_rows(system: System, t: float, q: Array, v: Array) -> tuple[int, ...]:
    scale = system.tables.scale

    def rows(J: Matrix) -> Array:
        return dense(without_units(J, np.zeros(J.shape[0]), scale)[0])

    J = system.velocity_jacobian(t, q, v)
    if not isinstance(J, np.ndarray) and not _worth_it(system, J):
        return ()
    if not J.shape[0] or not dependent(rows(J)):
        return ()
    if not system.m:
        return dependent(rows(J))
    near = pose_nearby(system, t, q)
    if near is None:
        return ()  # no nearby pose: the result is unknown
    left_out = dependent(rows(system.velocity_jacobian(t, near, v)))
    if not left_out or not system.scene.spatial or J.shape[0] > MOST_EXCHANGED or system.p:
        return left_out
    found = [rows(system.velocity_jacobian(t, pose, v)) for pose in poses_along(system, t, q)]
    return exchanged(left_out, np.array(found))


def _worth_it(system: System, J: Matrix) -> bool:
    """Whether rows of a large system are analysed: in space, where every planar loop has redundant ones."""
    return system.scene.spatial and J.shape[0] <= MOST_ROWS and _has_loops(system)


def _has_loops(system: System) -> bool:
    """Whether joints connect bodies that others connect already; the constraints of a tree are independent."""
    scene = system.scene
    group = {"": "", **{name: name for name in system.tables.coordinates}}  # "": the ground

    def root(name: str) -> str:
        while group[name] != name:
            group[name] = name = group[group[name]]
        return name

    for name in system.tables.rows.keys() - system.tables.holding.keys():
        ends = [scene.frames[frame].body for frame in system.tables.joint(name).ports.values()]
        ends += [""] * (len(ends) < 2)
        roots = {root(body if body in group else "") for body in ends}
        if len(roots) < len(ends):
            return True
        first, *others = roots
        for other in others:
            group[other] = first
    return False


def rank(J: Array) -> int:
    """The rank of rows without units."""
    sizes = np.linalg.svd(J, compute_uv=False) if J.size else np.zeros(0)
    return int((sizes > ZERO * sizes.max(initial=0.0)).sum())


def pose_nearby(system: System, t: float, q: Array) -> Array | None:
    """A pose (n,) in which the constraints hold, displaced from ``q`` along the mobility; None if none was found."""
    scale = system.tables.scale
    J = dense(without_units(system.Phi_q(t, q), np.zeros(system.m), scale)[0])
    here = rank(J)
    null = np.linalg.svd(J, full_matrices=True)[2][here:]
    direction = null.T @ np.random.default_rng(1).normal(size=len(null))
    size = np.abs(direction).max(initial=0.0)
    displaced = system.moved(q, (DISPLACED / size if size else 0.0) * direction / scale)
    most = min(J.shape)
    # of a singular pose the rank nearby is larger; the steps of that rank find a pose, others do not
    for kept in dict.fromkeys([*range(here, min(here + 3, most)), most]):
        near = displaced
        for _ in range(20):
            found, r = without_units(system.Phi_q(t, near), system.Phi(t, near), scale)
            if np.abs(r).max(initial=0.0) <= ARRIVED:
                return near
            near = system.moved(near, -_step(dense(found), r, kept) / scale)
        r = without_units(system.Phi_q(t, near), system.Phi(t, near), scale)[1]
        if np.abs(r).max() <= CLOSED:
            return near
    return None


def poses_along(system: System, t: float, q: Array) -> list[Array]:
    """The pose ``q`` and poses along the mobility, forwards and backwards, in which the constraints hold."""
    scale, found = system.tables.scale, [q]
    J = dense(without_units(system.Phi_q(t, q), np.zeros(system.m), scale)[0])
    here = rank(J)
    null = np.linalg.svd(J, full_matrices=True)[2][here:]
    start = null.T @ np.random.default_rng(1).normal(size=len(null))
    for direction in (start, -start) if start.any() else ():
        pose = q
        for _ in range(WALK):
            ahead = system.moved(pose, STRIDE / np.abs(direction).max() * direction / scale)
            for _ in range(8):
                J, r = without_units(system.Phi_q(t, ahead), system.Phi(t, ahead), scale)
                if np.abs(r).max() <= CLOSED:
                    break
                ahead = system.moved(ahead, -_step(dense(J), r, here) / scale)
            else:
                break
            null = np.linalg.svd(dense(J), full_matrices=True)[2][here:]
            pose, direction = ahead, null.T @ (null @ direction)
            found.append(pose)
    return found


def exchanged(left_out: tuple[int, ...], J: Array) -> tuple[int, ...]:
    """Rows to leave out so that the others are well conditioned in all poses of J (poses, rows, coordinates).

    Rows that are independent in one pose may depend on each other in another one, where the iteration would fail
    although the mechanism passes it. Exchanges of one row with another improve a poor choice.
    """

    regular = np.linalg.svd(J, compute_uv=False)[:, J.shape[1] - len(left_out) - 1] > POOR  # no choice serves others
    J = J[regular]

    def worst(rows: tuple[int, ...]) -> float:
        """The smallest singular value of the rows kept, over all poses."""
        return float(np.linalg.svd(np.delete(J, rows, axis=1), compute_uv=False)[:, -1].min(initial=np.inf))

    best = worst(left_out)
    for _ in range(EXCHANGES if best < POOR else 0):
        kept = [k for k in range(J.shape[1]) if k not in left_out]
        others = [tuple(sorted({*left_out} - {i} | {k})) for i in left_out for k in kept]
        values = [worst(rows) for rows in others]
        k = int(np.argmax(np.array(values) > 0.99 * max(values)))  # of equal ones the first
        if values[k] <= BETTER * best:
            break
        best, left_out = values[k], others[k]
    return left_out


def _step(J: Array, r: Array, kept: int) -> Array:
    """The smallest solution of J d = r in the directions of the ``kept`` largest singular values."""
    if kept == min(J.shape):
        return least_squares(J, r, ZERO)
    U, sizes, Vt = np.linalg.svd(J, full_matrices=False)
    return Vt[:kept].T @ (U[:, :kept].T @ r / sizes[:kept])


def dependent(J: Array) -> tuple[int, ...]:
    """Rows of J that are combinations of the others, of which the first are kept (Gram-Schmidt).

    Rows that are nearly combinations of rows before them wait until the others had their turn, so that the rows kept
    are well conditioned, and rounding does not decide between rows.
    """
    waiting, found, count = list(range(len(J))), np.zeros((min(J.shape), J.shape[1])), 0
    for new in NEW:
        later = []
        for i in waiting:
            row, basis = J[i], found[:count]
            rest = row - basis.T @ (basis @ row)
            rest -= basis.T @ (basis @ rest)  # two passes suffice
            size = np.linalg.norm(rest)
            if count < len(found) and size > new * np.linalg.norm(row):
                found[count] = rest / size
                count += 1
            else:
                later.append(i)
        waiting = later
    return tuple(waiting)
