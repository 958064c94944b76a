"""Signals that are computed from the states after a run: accelerations, multipliers, residuals and energies."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.expressions.spatial_coordinates import QUATERNION
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism import contacts, poses
from mbdsl.mechanism.energies import energies
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.numerics import rotation_arrays
from mbdsl.system.accelerations import accelerations
from mbdsl.system.batch_accelerations import sampled
from mbdsl.system.signals import values
from mbdsl.system.system import System
from mbdsl.system.tables import gravity

#: inputs and reference angles (N,) that the equations depend on, by their index in the table F
Numbers = Mapping[int, Array]


def motion(
    system: System,
    t: Array,
    q: Array,
    v: Array,
    left_out: tuple[int, ...],
    numbers: Numbers,
    least: int | None = None,
) -> tuple[Array, Array, list[float]]:
    """Accelerations and multipliers that satisfy the equations of motion at N states; at ``least`` so many together.

    Returns
    -------
    a : (N, n) [m/s2, rad/s2]
        Accelerations; nan at singular poses.
    lam : (N, m + p)
        Multipliers; nan at singular poses.
    undetermined : list of float [s]
        Times of the singular poses, at which there is no solution or more than one.
    """
    if system.scene.contacts or system.scene.sticking:
        return _by_modes(system, t, q, v, left_out, numbers, least)
    return _with_rows(system, t, q, v, left_out, numbers, least)


def _with_rows(
    system: System, t: Array, q: Array, v: Array, left_out: tuple[int, ...], numbers: Numbers, least: int | None
) -> tuple[Array, Array, list[float]]:
    """As ``motion``, with the same rows at all states."""
    N, undetermined = len(t), []
    known = sampled(system, t, q, v, left_out, numbers, least)
    if known is not None:
        a, lam, done = known
    else:
        a, lam, done = np.zeros((N, system.n)), np.zeros((N, system.m + system.p)), np.zeros(N, bool)
    for i in map(int, np.flatnonzero(~done)):
        _set(system, numbers, i)
        try:
            a[i], lam[i] = accelerations(system, t[i], q[i], v[i], left_out)
        except InitialisationError:
            a[i], lam[i] = np.nan, np.nan
            undetermined.append(float(t[i]))
    return a, lam, undetermined


def _by_modes(
    system: System, t: Array, q: Array, v: Array, left_out: tuple[int, ...], numbers: Numbers, least: int | None
) -> tuple[Array, Array, list[float]]:
    """As ``motion``, of a scene with rows that hold at times only: each set of rows that hold by itself."""
    tables, scene = system.tables, system.scene
    rows = [row for rows in tables.contact_rows for row in rows]
    rows += [tables.rows[row] for x in scene.sticking for row in x.rows]

    def known_number(name: str) -> Array:
        return numbers.get(tables.inputs[name], np.zeros(len(t)))

    modes = []
    for c in scene.contacts:
        modes.append(known_number(contacts.number(c.name, contacts.MODE)) == contacts.CLOSED)
        modes += [known_number(contacts.number(c.name, contacts.HELD)) != 0.0 for _ in c.slips]
    modes += [known_number(name) != 0.0 for x in scene.sticking for name in x.held]
    holds = np.stack(modes, axis=1)
    a, lam, undetermined = np.zeros((len(t), system.n)), np.zeros((len(t), system.m + system.p)), []
    for own in np.unique(holds, axis=0):
        at = np.flatnonzero((holds == own).all(axis=1))
        active = {row for row, is_held in zip(rows, own, strict=True) if is_held}
        without = tuple(sorted({*left_out, *rows} - active))
        system.activate(without)
        known = {k: x[at] for k, x in numbers.items()}
        a[at], lam[at], poor = _with_rows(system, t[at], q[at], v[at], without, known, least)
        undetermined += poor
    return a, lam, sorted(undetermined)


def residuals(system: System, t: Array, q: Array, v: Array, numbers: Numbers) -> tuple[Array, Array, Array]:
    """Phi (N, m), Phi_q v + Phi_t (N, m) and Gam (N, p) at N states."""
    N = len(t)
    Phi, dPhi, Gam = np.zeros((N, system.m)), np.zeros((N, system.m)), np.zeros((N, system.p))
    for i in range(N):
        _set(system, numbers, i)
        _, Phi[i], dPhi[i] = system.evaluate(t[i], q[i], v[i])
        if system.p:
            Gam[i] = system.Gam(t[i], q[i], v[i])
    return Phi, dPhi, Gam


def angles(system: System, t: Array, q: Array, v: Array, inputs: Mapping[str, Array] | None = None) -> Numbers:
    """Angles between frames in space at N states, whose turns are counted from the first state on."""
    found: dict[int, Array] = {}
    for node, places in system.tables.angles.items():
        (angle,) = values(system, [node], t, q, v, None, inputs)
        found |= dict.fromkeys(places, angle)
    return found


def _set(system: System, numbers: Numbers, i: int) -> None:
    for at, value in numbers.items():
        system.set_number(at, float(value[i]))


def turns(system: System, t: Array, q: Array, v: Array) -> dict[str, Array]:
    """Reference angles (N,) for counting turns, by body, for bodies whose coordinates do not contain the turns."""
    found = {}
    for name in system.tables.flexible:
        d, body = system.tables.coordinates[name], system.tables.models[name]
        if body.counter >= 0:
            found[name] = body.turned(body.turn, q[:, d : d + body.n], v[:, d : d + body.n], t)
    return found


def accelerations_in_space(system: System, name: str, q: Array, a: Callable[[], Array]) -> dict[str, Array]:
    """Accelerations (N,) of a body in space at N states, in world axes, as signals."""
    d, body = system.tables.coordinates[name], system.tables.models[name]
    own = a()[:, d : d + body.n]
    found = {f"{name}.a{i}": own[:, k] for k, i in enumerate("xyz")}
    if body.n > 3:
        R = rotation_arrays.matrices(q[:, d + 3 : d + 6])
        found |= {f"{name}.alpha{i}": (R[:, k] * own[:, 3:]).sum(axis=1) for k, i in enumerate("xyz")}
        found[f"{name}.alpha"] = found[f"{name}.alphaz"]
    return found


def quaternion(system: System, name: str, q: Array) -> dict[str, Array]:
    """The quaternion (N,) of a body or frame in space at N successive states, as signals."""
    frame = system.scene.frames.get(system.scene.aliases.get(name, name))
    of, axes = (name, SpatialFrame.axes) if frame is None else (frame.body, frame.pose[3:])
    p = np.tile(poses.quaternion_of(axes), (len(q), 1))
    body = system.tables.models.get(of)
    if body is not None and body.n > 3:
        d = system.tables.coordinates[of]
        own = rotation_arrays.quaternions(q[:, d + 3 : d + 6])
        p = own if axes == SpatialFrame.axes else rotation_arrays.times(own, p)
    turned = np.einsum("ik,ik->i", p[1:], p[:-1]) < 0.0  # p and -p are the same attitude
    p[1:] *= np.cumprod(np.where(turned, -1.0, 1.0))[:, None]
    return {f"{name}.{key}": p[:, k] for k, key in enumerate(QUATERNION)}


def flexible_energies(
    system: System, t: Array, q: Array, v: Array, inputs: Mapping[str, Array]
) -> tuple[Array, Array, Array]:
    """Kinetic, potential energy and their sum (N,) [J] of a model with bodies that deform."""
    tables = system.tables
    rigid = energies(system.scene, tables.flexible)
    kinetic, potential, _ = values(system, rigid, t, q, v, None, inputs)
    g = gravity(system.scene)
    for name in tables.flexible:
        d, body = tables.coordinates[name], tables.models[name]
        T, U = body.energies(q[:, d : d + body.n], v[:, d : d + body.n], g)
        kinetic, potential = kinetic + T, potential + U
    return kinetic, potential, kinetic + potential
