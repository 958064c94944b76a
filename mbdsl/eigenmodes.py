"""Eigenmodes: small motions about a state of a mechanism.

The equations of motion and their constraints, linearised about (t, q, v) with accelerations a and multipliers lam,

    M da + D dv + (K + (M a)_q) dq + U dlam = 0,   Phi_q dq = 0,   Gam_v dv + Gam_q dq = 0,

in coordinates y of what the holonomic constraints leave free, and speeds u of what all leave:

    dq = Z y,   dv = Z y' + Z' y,   y' = T u + S y,       L^T U = 0 with L of as many columns as u

    L^T M Z T u' + L^T (M Z (T' + S T) + (2 M Z' + D Z) T) u
                 + L^T (M Z (S' + S S) + (2 M Z' + D Z) S + M Z'' + D Z' + (K + (M a)_q) Z) y = 0.

At rest Z, T and S do not change, S = 0, and everything is exact. Where the mechanism moves, y are variations of the
joints' own coordinates, of elastic ones in axes that turn with the beam, and of bodies', where joints have none, so
that what turns as a whole is seen by those who turn with it, and Z', Z'', T', S' are differences along the motion.
Eigenvalues of a motion that is not steady hold for the moment only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.equilibrium import prepare, settle
from mbdsl.errors import UsageError
from mbdsl.lang.expressions import Expr, coordinate, is_velocity_level, leaves
from mbdsl.saddle import RANK, Array, Matrix, Saddle, dense, largest, null_space, row_size, scaled
from mbdsl.scene import Scene
from mbdsl.simulation import simulate
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.bodies import POSITIONS, Pose, Rigid
from mbdsl.system.initial import initial_position, initial_state
from mbdsl.system.signals import gradients
from mbdsl.wording import few

if TYPE_CHECKING:
    from mbdsl.builder import Builder

Complex = NDArray[np.complex128]

COUNT = 10  #: modes that are told unless somebody says more
CENTRE: Pose = (0.0, 0.0, 0.0)  #: of a beam: its frame c
LARGEST_MOVING = 3000  #: unknowns up to which a state that moves is linearised: with dense matrices


@dataclass(frozen=True)
class Mode:
    """One eigenvalue, or a pair of complex ones, and how the mechanism moves with it.

    Attributes
    ----------
    eigenvalue : complex [1/s]
        With an imaginary part of zero or more. Zero: what moves so neither returns nor runs away faster than evenly.
    shape : (n,) complex [m, rad]
        Displacements of the coordinates, in the order of ``system.names()``. The largest, with lengths measured in the
        mechanism's size, is 1. Times the eigenvalue, they are velocities.
    bodies : dict
        Body -> its part of the kinetic energy, the largest first.
    """

    eigenvalue: complex
    shape: Complex
    bodies: Mapping[str, float]

    @property
    def omega(self) -> float:
        """Undamped angular frequency [rad/s]: the absolute value of the eigenvalue."""
        return abs(self.eigenvalue)

    @property
    def frequency(self) -> float:
        """Undamped frequency [Hz]."""
        return self.omega / (2.0 * np.pi)

    @property
    def damped_frequency(self) -> float:
        """Frequency of what is seen [Hz]; 0 of what does not oscillate."""
        return self.eigenvalue.imag / (2.0 * np.pi)

    @property
    def damping(self) -> float:
        """Damping ratio: -Re/abs of the eigenvalue; 1 of what decays without oscillation, below zero if unstable."""
        return -self.eigenvalue.real / self.omega + 0.0 if self.omega else 0.0

    @property
    def unstable(self) -> bool:
        return self.eigenvalue.real > 1e-9 * self.omega


@dataclass
class Modes(Sequence[Mode]):
    """The modes of a mechanism about a state, from low to high frequency.

    Attributes
    ----------
    system : System
    at : str
        What was linearised about: "static", "start" or "t = 1.5 s".
    t, q, v : float [s], (n,), (n,)
    modes : list of Mode
    notes : list of str
    total : int or None
        Number of modes that there are; None where not all were looked for.

    Examples
    --------
    ``[mode.frequency for mode in modes]``; ``modes.displacement(0, "rod.b.y")`` is how far a signal goes in the first.
    """

    system: System
    at: str
    t: float
    q: Array
    v: Array
    modes: list[Mode]
    notes: list[str]
    total: int | None = field(default=None)

    def __len__(self) -> int:
        return len(self.modes)

    def __getitem__(self, k):
        return self.modes[k]

    @property
    def scene(self) -> Scene:
        return self.system.scene

    @property
    def unstable(self) -> list[Mode]:
        return [mode for mode in self.modes if mode.unstable]

    def displacement(self, k: int, signal: str) -> complex:
        """The variation of a signal of positions (of a frame: ``rod.b.y``, of a joint: ``pin.phi``) in mode ``k``.

        Raises
        ------
        ModelError, UsageError
            There is no such signal, or it depends on more than positions.
        """
        expression = self.scene.signal(signal)
        if not _of_positions(expression):
            raise UsageError(f"`{signal}` depends on more than positions")
        return complex((gradients(self.system, [expression], self.t, self.q, self.v)[1] @ self.modes[k].shape)[0])

    def to_dict(self) -> dict[str, Array]:
        """Columns over modes: number, frequencies, damping, eigenvalues, and shapes as amplitude and phase [rad]."""

        def column(of: Callable[[Mode], float]) -> Array:
            return np.array([of(mode) for mode in self.modes], float)

        found = {
            "mode": np.arange(1.0, len(self.modes) + 1),
            "frequency": column(lambda m: m.frequency),
            "damped_frequency": column(lambda m: m.damped_frequency),
            "damping": column(lambda m: m.damping),
            "eigenvalue.re": column(lambda m: m.eigenvalue.real),
            "eigenvalue.im": column(lambda m: m.eigenvalue.imag),
        }
        for j, name in enumerate(self.system.names()):
            values = np.array([m.shape[j] for m in self.modes], complex)
            found[f"{name}.amplitude"], found[f"{name}.phase"] = np.abs(values), np.angle(values)
        return found

    def __str__(self) -> str:
        shown = f"{len(self)} of {self.total}" if self.total and self.total > len(self) else f"{len(self)}"
        if not self.modes:
            shown = "no"
        head = f"{self.scene.name}: {shown} mode{'s' * (len(self) != 1)} about "
        head += "its static equilibrium" if self.at == "static" else f"its state at t = {self.t:g} s"
        lines = [head, "    #      f [Hz]  damped [Hz]     damping  what moves"] if self.modes else [head]
        for k, mode in enumerate(self.modes, 1):
            parts = [f"{name} {part:.0%}" for name, part in mode.bodies.items() if part >= 0.05]
            mark = "  unstable" if mode.unstable else "  moves freely" if mode.omega == 0.0 else ""
            damping = mode.damping if abs(mode.damping) > 1e-9 else 0.0
            row = f"{k:5} {mode.frequency:11.6g}  {mode.damped_frequency:11.6g} {damping:11.4g}"
            lines.append(f"{row}  {few(parts, 4)}{mark}")
        return "\n".join([*lines, *(f"note: {text}" for text in self.notes)])


def eigen(
    model: Scene | Builder | str | PathLike,
    at: str | float = "static",
    count: int | None = COUNT,
    *,
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Modes:
    """Eigenmodes of ``model`` about a state.

    Parameters
    ----------
    model : Scene, Builder or path
    at : str or float, optional
        "static", about the equilibrium that :func:`mbdsl.static` finds; "start", about the initial state with its
        velocities; or a time [s] up to which the model is simulated, as it says itself.
    count : int, optional
        So many modes of the lowest frequencies; None for all.
    without, parameters, announce : optional
        As for :func:`mbdsl.simulate`.

    Raises
    ------
    ModelError, UsageError
        If model or arguments make no sense.
    EquilibriumError, InitialisationError, IntegrationError
        If there is no such state.
    """
    if count is not None and (not isinstance(count, (int, np.integer)) or count < 1):
        raise UsageError(f"count = {count!r}: the number of modes is 1 or more")
    if not isinstance(at, str) and not np.isfinite(at):
        raise UsageError(f"at = {at} is not a finite number")
    if isinstance(at, str) and at not in ("static", "start"):
        raise UsageError(f"at = {at!r}: modes are about `static`, `start` or a time")
    system, mechanism = prepare(model, parameters, without, announce)
    start, notes = float(system.scene.experiment.start), list[str]()
    if at == "static":
        found = settle(system, start, initial_position(system, mechanism, start))
        notes += found.notes
        state = found.t, found.q, np.zeros(system.n), np.zeros(system.n), found.lam
    elif at == "start" or at == start:
        first = initial_state(system, mechanism, start)
        state = start, first.q, first.v, first.a, first.lam
    else:
        assert not isinstance(at, str)
        run = simulate(system.scene, stop=float(at), interval=abs(float(at) - start), announce=announce)
        t, q, v = float(run.t[-1]), run.q[-1], run.v[-1]
        state = t, q, v, *accelerations(system, t, q, v, run.left_out)
    name = at if isinstance(at, str) else f"t = {float(at):g} s"
    t, q, v, a, lam = state
    scale = system.tables.scale
    speed, rate = (float(np.abs(x * scale).max(initial=0.0)) for x in (v, a))
    if rate > 1e-9 * (1.0 + speed**2):
        if speed == 0.0:
            notes.append("no equilibrium: it begins to move, and eigenvalues hold for that moment only")
        else:
            notes.append("it moves: eigenvalues are those of a motion whose equations stay as they are at this moment")
    moving = bool(speed > 0.0 or rate > 1e-9)
    values, shapes, total = _solve(system, t, q, v, a, lam, moving, count)
    modes = [Mode(complex(s), x, _shares(system, t, q, x)) for s, x in zip(values, shapes, strict=True)]
    return Modes(system, name, t, q, v, modes, notes, total)


def _of_positions(expression: Expr) -> bool:
    found = leaves(expression)
    return all(x.op in ("coordinate", "time") for x in found) and not is_velocity_level(expression)


def _shares(system: System, t: float, q: Array, shape: Complex) -> dict[str, float]:
    """Each body's part of the kinetic energy of a shape; of its displacements, where nothing that moves has mass."""
    energy = (shape.conj() * (system.M(t, q) @ shape)).real
    if not energy.sum() > 0.0:
        energy = np.abs(shape * system.tables.scale) ** 2
    parts: dict[str, float] = {}
    for name, part in zip(system.names(), energy, strict=True):
        body = name.rsplit(".", 1)[0]
        parts[body] = parts.get(body, 0.0) + float(part)
    whole = sum(parts.values()) or 1.0
    return {name: part / whole for name, part in sorted(parts.items(), key=lambda item: -item[1])}


# -- linearised ----------------------------------------------------------------------------------------------


def _solve(
    system: System, t: float, q: Array, v: Array, a: Array, lam: Array, moving: bool, count: int | None
) -> tuple[list[complex], list[Complex], int | None]:
    """Eigenvalues, one of each pair, shapes (n,), and how many there are."""
    n = system.n
    A = system.tangent(t, q, v, lam, cL=1.0, cP=1.0, cV=1.0)
    U, J, M = A[:n, n:], A[n:, :n], system.M(t, q)
    K, D = system.stiffness(t, q, v, lam, a), system.damping(t, q, v, lam)
    small = isinstance(K, np.ndarray)
    if moving and not small and system.unknowns > LARGEST_MOVING:
        raise UsageError(
            f"modes about a motion need dense matrices: {system.unknowns} unknowns are too many",
            hint=f"up to {LARGEST_MOVING}; about an equilibrium (static) there is no limit",
        )
    if not small and not moving and count is not None:
        return _few(system, M, D, K, U, J, count)
    M, D, K, U, J = (dense(x) for x in (M, D, K, U, J))
    if moving:
        basis = _Moving(system, t, q, v, a)
    else:
        basis = _Still(system, J)
    values, y = _reduced(system, M, D, K, U, J, basis)
    shapes = [_normalised(system, basis.Z @ x) for x in y]
    values, shapes = _one_of_each(values, shapes)
    total = len(values)
    return values[:count], shapes[:count], total


class _Still:
    """Bases at rest: Z spans what all constraints leave, whether on positions or velocities, and does not change."""

    def __init__(self, system: System, J: Array) -> None:
        scale = system.tables.scale
        J = scaled(J, np.ones(len(J)), 1.0 / scale)
        self.Z = null_space(J / row_size(J)[:, None]) / scale[:, None]
        r = self.Z.shape[1]
        self.Z1 = self.Z2 = np.zeros_like(self.Z)
        self.T, self.S = np.eye(r), np.zeros((r, r))
        self.T1, self.S1 = np.zeros((r, r)), np.zeros((r, r))
        self.rate = 0.0


class _Moving:
    """Bases along the motion q(t + s) = q + s v + s^2 a/2, with their derivatives."""

    #: weights of differences at s = -3e ... 3e of first and second derivatives, both to order e^6
    FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
    SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0

    def __init__(self, system: System, t: float, q: Array, v: Array, a: Array) -> None:
        self.system, self.scale = system, system.tables.scale
        self.path = lambda s: (t + s, q + s * v + s * s / 2.0 * a, v + s * a)
        self.bends = [name for name, body in system.tables.models.items() if not isinstance(body, Rigid)]
        self.targets, self.turned = self._coordinates(t, q, v)
        speed = float(np.abs(v * self.scale).max(initial=0.0))
        #: how fast bases change [1/s]
        self.rate = max(speed, float(np.sqrt(np.abs(a * self.scale).max(initial=0.0))), 1e-6)
        self.e = e = 1e-2 / self.rate
        self.H: Array | None = None
        Z, T, S = zip(*(self._at(k * e) for k in (0, -3, -2, -1, 1, 2, 3)), strict=True)

        def derivative(x: Sequence[Array], weights: Array, order: int) -> Array:
            line = [*x[1:4], x[0], *x[4:]]
            return np.asarray(sum(w * (y - x[0]) for w, y in zip(weights, line, strict=True)) / e**order)

        self.Z, self.T, self.S = Z[0], T[0], S[0]
        self.Z1, self.Z2 = derivative(Z, self.FIRST, 1), derivative(Z, self.SECOND, 2)
        self.T1, self.S1 = derivative(T, self.FIRST, 1), derivative(S, self.FIRST, 1)

    def _coordinates(self, t: float, q: Array, v: Array) -> tuple[list[Expr], list[int]]:
        """Targets whose variations are independent and determine all others: signals, and rows of :meth:`_of_beams`.

        Signals of joints first, then what beams do in their own axes, then coordinates of bodies.
        """
        scene, system = self.system.scene, self.system
        J = dense(system.Phi_q(t, q)) / self.scale
        free = null_space(J / row_size(J)[:, None])
        joints = [c for c in scene.components.values() if isinstance(c.kind, JointKind)]
        # places in fixed axes are not seen by those who turn with a beam: its own axes take their part
        own = [
            e
            for c in joints
            for key, e in c.signals.items()
            if e is not None and _of_positions(e)
            if not (c.kind.name == "FreeMotion" and key.rsplit(".", 1)[-1] in ("x", "y") and self._of_a_beam(e))
        ]
        bodies = [coordinate(f"{b.name}.c", key) for b in scene.bodies() for key in b.kind.coordinates]
        bodies = [e for e in bodies if not self._of_a_beam(e)]
        chosen: list[Expr] = []
        turned: list[int] = []
        for candidates in (own, bodies):
            if candidates and free.shape[1]:
                rows = dense(gradients(system, candidates, t, q, v)[1]) / self.scale
                which, free = self._independent(rows / row_size(rows)[:, None], free)
                chosen += [candidates[k] for k in which]
            if candidates is own and self.bends and free.shape[1]:
                elastic, pose = self._of_beams(q, v)
                for rows, first in ((elastic, 0), (pose, len(elastic))):
                    which, free = self._independent(rows, free)
                    turned += [first + k for k in which]
        if free.shape[1]:
            raise UsageError(
                f"what moves has {free.shape[1]} more freedoms than joints and bodies have coordinates to tell of",
                hint="another state",
            )
        return chosen, turned

    @staticmethod
    def _independent(rows: Array, free: Array) -> tuple[list[int], Array]:
        """Rows (m, n), of size one, that tell directions ``free`` (n, k) apart, and the directions that they leave."""
        found: list[int] = []
        while free.shape[1] and len(rows):  # the most independent one first
            size = np.linalg.norm(rows @ free, axis=1)
            k = int(np.argmax(np.round(size, 9)))
            if size[k] < 1e-3:
                break
            found.append(k)
            free = free @ null_space((rows[k] @ free)[None])
        return found, free

    def _of_a_beam(self, expression: Expr) -> bool:
        frames = self.system.scene.frames
        names = (x.value[0] for x in leaves(expression) if x.op == "coordinate")  # type: ignore[index]
        return any(frames[name].body in self.bends for name in names)

    def _of_beams(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Gradients, by scaled coordinates, of what beams do in axes that turn with their frames c: elastic coordinates
        or where nodes and slopes are (m, n), and of the places and angles of these frames (k, n)."""
        system, scale = self.system, self.scale
        elastic, pose = [np.zeros((0, system.n))], [np.zeros((0, system.n))]
        for name in self.bends:
            body, d = system.tables.models[name], system.tables.coordinates[name]
            own = slice(d, d + body.n)
            B = body.gradient(CENTRE, q[own], v[own])[0]
            phi = float(body.frame(CENTRE, "phi", q[own][None], v[own][None])[0])
            A = np.array([[np.cos(phi), np.sin(phi)], [-np.sin(phi), np.cos(phi)]])
            rigid = body.rigid(q[own])
            if not rigid[3:].any():  # q holds where its floating frame is, and what it does in that frame
                rows = np.eye(body.n)[3:] * scale[own]
            else:  # q holds pairs in fixed axes, which change by what the body does but for moving as c does
                x, y = (float(body.frame(CENTRE, key, q[own][None], v[own][None])[0]) for key in POSITIONS[:2])
                rigid = rigid @ np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])  # about c
                rows = np.kron(np.eye(body.n // 2), A) @ (np.eye(body.n) - rigid @ B) * scale[own][:, None]
            place = np.vstack([A @ B[:2] * scale[d], B[2:]])
            for found, part in ((elastic, rows), (pose, place)):
                whole = np.zeros((len(part), system.n))
                whole[:, own] = part
                found.append(whole / scale)
        return np.vstack(elastic), np.vstack(pose)

    def _gradient(self, t: float, q: Array, v: Array) -> Array:
        """The targets' gradient (r, n), by scaled coordinates."""
        G = dense(gradients(self.system, self.targets, t, q, v)[1]) / self.scale
        return np.vstack([G, np.vstack(self._of_beams(q, v))[self.turned]]) if self.turned else G

    def _at(self, s: float) -> tuple[Array, Array, Array]:
        """Z (n, r), T (r, d) and S (r, r) at the time ``s`` from now."""
        system, (t, q, v) = self.system, self.path(s)
        J = dense(system.Phi_q(t, q)) / self.scale
        size = row_size(J)
        G = self._gradient(t, q, v)
        r = len(G)
        right = np.vstack([np.zeros((len(J), r)), np.eye(r)])
        Z = np.linalg.lstsq(np.vstack([J / size[:, None], G]), right, rcond=RANK)[0] / self.scale[:, None]
        if not system.p:
            return Z, np.eye(r), np.zeros((r, r))
        # S belongs to y' = T u + S y: of Gam_v (Z y' + Z' y) + Gam_q Z y = 0, with Z' from the rate of J Z = 0
        rate = np.vstack([dense(system.Phi_v_q(t, q, v)) / self.scale / size[:, None], self._gradient_rate(s)])
        solved = np.linalg.lstsq(np.vstack([J / size[:, None], G]), -rate @ (Z * self.scale[:, None]), rcond=RANK)[0]
        Z1 = solved / self.scale[:, None]
        B, C = dense(system.Gam_v(t, q, v)), dense(system.Gam_q(t, q, v))
        C = B @ Z1 + C @ Z
        B = B @ Z
        size = row_size(B)
        B, C = B / size[:, None], C / size[:, None]
        if self.H is None:
            self.H = null_space(B).T
        whole = np.vstack([B, self.H])
        T = np.linalg.lstsq(whole, np.vstack([np.zeros((len(B), len(self.H))), np.eye(len(self.H))]), rcond=RANK)[0]
        S = np.linalg.lstsq(whole, np.vstack([-C, np.zeros((len(self.H), r))]), rcond=RANK)[0]
        return Z, T, S

    def _gradient_rate(self, s: float) -> Array:
        """The rate of the targets' gradient (r, n), scaled."""
        e = self.e
        return sum(w * self._gradient(*self.path(s + k * e)) for w, k in zip(self.FIRST, range(-3, 4), strict=True)) / e  # type: ignore[return-value]


# -- eigenvalues -----------------------------------------------------------------------------------------------


def _reduced(
    system: System, M: Array, D: Array, K: Array, U: Array, J: Array, basis: _Still | _Moving
) -> tuple[list[complex], list[Complex]]:
    """All eigenvalues, of one of each pair where that is known, and vectors y (r,)."""
    Z, Z1, Z2, T, T1, S, S1 = (getattr(basis, name) for name in ("Z", "Z1", "Z2", "T", "T1", "S", "S1"))
    L = Z @ T
    if not np.array_equal(U, J.T):  # forces that depend on multipliers act where constraints do not
        U = (U / system.tables.scale[:, None]).T
        L = null_space(U / row_size(U)[:, None]) / system.tables.scale[:, None]
        if L.shape[1] != T.shape[1]:
            raise UsageError(
                "forces that depend on reactions take all from a constraint that is solved for", hint="another state"
            )
    if not T.shape[1]:
        return [], []
    DZ = 2.0 * M @ Z1 + D @ Z
    Mr = L.T @ M @ Z @ T
    Dr = L.T @ (M @ Z @ (T1 + S @ T) + DZ @ T)
    Kr = L.T @ (M @ Z @ (S1 + S @ S) + DZ @ S + M @ Z2 + D @ Z1 + K @ Z)
    # what differences along the motion leave of terms that cancel
    size = 1e-9 * basis.rate * largest(np.abs(L).T @ np.abs(M) @ np.abs(Z))
    Dr = np.where(np.abs(Dr) > size, Dr, 0.0)
    Kr = np.where(np.abs(Kr) > size * basis.rate, Kr, 0.0)
    if not Dr.any() and not S.any() and _symmetric(Mr) and _symmetric(Kr):
        found = _undamped(Mr, Kr)
        if found is not None:
            return found
    return _first_order(Mr, Dr, Kr, T, S)


def _symmetric(A: Array) -> bool:
    return A.shape[0] == A.shape[1] and largest(A - A.T) <= 1e-12 * largest(A)


def _undamped(M: Array, K: Array) -> tuple[list[complex], list[Complex]] | None:
    """Eigenvalues of M y'' + K y = 0, symmetric; None where something that moves has no mass."""
    d = 1.0 / np.sqrt(np.where(np.diag(M) > 0.0, np.diag(M), 1.0))
    M, K = d[:, None] * (M + M.T) / 2.0 * d, d[:, None] * (K + K.T) / 2.0 * d
    try:
        C = np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        return None
    if np.diag(C).min() < 1e-6:
        return None
    _, x = np.linalg.eigh(np.linalg.solve(C, np.linalg.solve(C, K).T))
    x = np.linalg.solve(C.T, x)
    # as quotients, low frequencies do not feel the rounding of high ones
    work, size = (x * (K @ x)).sum(axis=0), (np.abs(x) * (np.abs(K) @ np.abs(x))).sum(axis=0)
    return _of_squares(np.where(np.abs(work) > 1e-13 * size, work, 0.0) / (x * (M @ x)).sum(axis=0), d[:, None] * x)


def _of_squares(square: Array, y: Array, zero: float = 0.0) -> tuple[list[complex], list[Complex]]:
    """Eigenvalues from squares of frequencies: two where those are negative."""
    values: list[complex] = []
    shapes: list[Complex] = []
    for w2, x in zip(square, y.T, strict=True):
        w = 0.0 if abs(w2) <= zero else float(np.sqrt(abs(w2)))
        for s in [complex(w), complex(-w)] if w2 < 0.0 and w else [complex(0.0, w)]:
            values.append(s)
            shapes.append(x.astype(complex))
    return values, shapes


def _first_order(M: Array, D: Array, K: Array, T: Array, S: Array) -> tuple[list[complex], list[Complex]]:
    """Eigenvalues of y' = T u + S y, M u' + D u + K y = 0. What has neither mass nor damping has none."""
    r, d = T.shape
    # a time in which masses and stiffnesses are of one size
    tau = float(np.sqrt(largest(M) / (largest(K) or largest(D) ** 2 / (largest(M) or 1.0) or 1.0))) or 1.0
    size = largest(M) or 1.0
    A = np.block([[tau * S, T], [-(tau**2) * K / size, -tau * D / size]])
    B = np.block([[np.eye(r), np.zeros((r, d))], [np.zeros((d, r)), M / size]])
    if np.linalg.cond(M) < 1e12:
        values, x = np.linalg.eig(np.linalg.solve(B, A))
    else:
        from scipy.linalg import eig

        pairs, x = eig(A, B, homogeneous_eigvals=True)
        alpha, beta = pairs
        finite = np.abs(beta) > 1e-12 * np.abs(alpha)
        values, x = alpha[finite] / beta[finite], x[:, finite]
    order = np.argsort(np.abs(values), kind="stable")
    values, x = values[order], x[:, order]
    largest_ = float(np.abs(values).max(initial=0.0))
    # zeros may be double, and come out of rounding as pairs of the square root of it: they are found as null vectors
    null = null_space_of(A)
    zeros = null.shape[1]
    if zeros:
        near = int((np.abs(values[: 2 * zeros]) <= 1e-7 * largest_).sum())
        values, x = values[max(zeros, near) :], x[:, max(zeros, near) :]
        values, x = np.concatenate([np.zeros(zeros), values]), np.hstack([null, x])
    rounding = 64.0 * np.finfo(float).eps * largest_
    oscillates = np.abs(values.imag) > rounding
    values = np.where(oscillates & (np.abs(values.real) <= rounding), 1j * values.imag, values)
    values = np.where(oscillates, values, values.real) / tau
    return [complex(s) for s in values], list(x[:r].T.astype(complex))


def null_space_of(A: Array) -> Array:
    """Null space of a square matrix whose rows are of one size, to rounding (singular values of 1e-13)."""
    _, s, Vt = np.linalg.svd(A)
    return Vt[int((s > 1e-13 * s.max(initial=0.0)).sum()) :].T


def _normalised(system: System, x: Complex) -> Complex:
    size = x * system.tables.scale
    most = size[int(np.argmax(np.round(np.abs(size) / (np.abs(size).max(initial=0.0) or 1.0), 9)))] if len(x) else 1.0
    return x / most if most else x


def _one_of_each(values: Sequence[complex], shapes: Sequence[Complex]) -> tuple[list[complex], list[Complex]]:
    """From low to high, without the conjugates; of real ones, those that grow before those that decay."""
    kept = [(s, x) for s, x in zip(values, shapes, strict=True) if s.imag >= 0.0]
    kept.sort(key=lambda item: (round(abs(item[0]), 12), -item[0].real))
    return [s for s, _ in kept], [x for _, x in kept]


def _few(
    system: System, M: Matrix, D: Matrix, K: Matrix, U: Matrix, J: Matrix, count: int
) -> tuple[list[complex], list[Complex], int | None]:
    """The modes of the lowest frequencies at rest, by Arnoldi's method for the inverse within the constraints."""
    from scipy.sparse.linalg import LinearOperator, eigs, eigsh

    n, scale = system.n, system.tables.scale
    stiff = largest(scaled(K, 1.0 / scale, 1.0 / scale))
    fast = stiff / (largest(scaled(M, 1.0 / scale, 1.0 / scale)) or 1.0) or 1.0  #: square of the highest frequency
    v0 = np.random.default_rng(0).normal(size=2 * n)
    symmetric = all(largest(A - A.T) <= 1e-12 * largest(A) for A in (M, K)) and largest(U - J.T) == 0.0
    if symmetric and largest(D) == 0.0:
        sigma, k = -1e-9 * fast, min(count, n - 2)
        inverse = Saddle(K - sigma * M, U, J, scale)
        OP = LinearOperator((n, n), lambda b: inverse.solve(b)[0], dtype=float)
        square, x = eigsh(K, k, M=M, sigma=sigma, OPinv=OP, v0=v0[:n])
        real = np.abs(square) < 1e6 * fast  # what constraints forbid is infinitely stiff
        values, shapes = _of_squares(square[real], x[:, real], 1e-7 * abs(sigma))
    else:
        shift, k = float(np.sqrt(1e-9 * fast)), min(2 * count + 2, 2 * n - 2)
        inverse = Saddle(K + shift * D + shift**2 * M, U, J, scale)

        def apply(x: Array) -> Array:
            q, v = x[:n], x[n:]
            found = inverse.solve(-(M @ v + D @ q + shift * (M @ q)))[0]
            return np.concatenate([found, shift * found + q])

        v0 = apply(np.concatenate([inverse.solve(v0[:n])[0], inverse.solve(v0[n:])[0]]))
        nu, x = eigs(LinearOperator((2 * n, 2 * n), apply, dtype=float), k, v0=v0)
        finite = np.abs(nu) > 1e-9 / np.sqrt(fast)
        found = shift + 1.0 / nu[finite]
        found = np.where(np.abs(found) <= 1e-5 * shift, 0.0, found)
        found = np.where(np.abs(found.imag) <= 1e-9 * np.abs(found), found.real, found)
        values, shapes = [complex(s) for s in found], list(x[:n, finite].T)
    values, shapes = _one_of_each(values, [_normalised(system, s) for s in shapes])
    return values[:count], shapes[:count], None
