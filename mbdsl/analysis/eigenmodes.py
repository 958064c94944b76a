"""Eigenmodes: small motions about a state of a mechanism.

The equations of motion and their constraints, linearised about (t, q, v) with accelerations a and multipliers lam,

    M da + D dv + (K + (M a)_q) dq + U dlam = 0,   Phi_q dq = 0,   Gam_v dv + Gam_q dq = 0,

in coordinates y of the directions that the holonomic constraints allow, and speeds u of those that all allow:

    dq = Z y,   dv = Z y' + W y,   y' = T u + S y,       L^T U = 0, where L has as many columns as u

    L^T M Z T u' + L^T (M Z (T' + S T) + (M Z' + M W + D Z) T) u
                 + L^T (M Z (S' + S S) + (M Z' + M W + D Z) S + M W' + D W + (K + (M a)_q) Z) y = 0.

In the plane W is Z'. At rest Z, T and S are constant, S = 0, and the equations are exact. If the mechanism moves, y are
variations of joint coordinates, of elastic coordinates in axes that rotate with the beam, and, at joints without a
coordinate, of body coordinates: a mechanism that rotates as a whole is described in rotating axes. W', T', S' are then
differences along the motion. Eigenvalues of an unsteady motion hold at that instant only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from mbdsl.analysis import operating_points
from mbdsl.analysis.eigenvalues import lowest, normalised, one_of_each, reduced
from mbdsl.analysis.operating_points import about
from mbdsl.analysis.tangent_bases import Moving, Still, of_positions
from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Complex
from mbdsl.lang.display_units import in_units
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import few
from mbdsl.numerics.saddle_point import Array, dense
from mbdsl.system import System
from mbdsl.system.signals import gradients

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder
    from mbdsl.plotting.figures import TextTable
    from mbdsl.viewing.mode_animation import ModeAnimation


COUNT = 10  #: default number of modes
LARGEST_MOVING = 3000  #: largest number of unknowns for modes about a motion, which use dense matrices


@dataclass(frozen=True)
class Mode:
    """An eigenvalue, or a complex conjugate pair, and its mode shape.

    Attributes
    ----------
    eigenvalue : complex [1/s]
        The eigenvalue with an imaginary part >= 0; zero for a rigid-body mode.
    shape : (n,) complex [m, rad]
        Displacements of the coordinates, in the order of ``system.names()``. The largest is 1, with lengths relative
        to the size of the mechanism. Multiplied by the eigenvalue, they are velocities.
    bodies : dict
        Body -> its share of the kinetic energy, 0 to 1, the largest first.
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
        """Frequency of the damped oscillation [Hz]; 0 if the mode does not oscillate."""
        return self.eigenvalue.imag / (2.0 * np.pi)

    @property
    def damping(self) -> float:
        """Damping ratio, -Re/abs of the eigenvalue: 1 for decay without oscillation, negative for unstable modes."""
        return -self.eigenvalue.real / self.omega + 0.0 if self.omega else 0.0

    @property
    def unstable(self) -> bool:
        """Whether the mode grows."""
        return self.eigenvalue.real > 1e-9 * self.omega


@dataclass
class Modes(Sequence[Mode]):
    """The modes of a mechanism about a state, by ascending frequency; a sequence of ``Mode``.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    at : str
        State of the linearisation: "static", "start" or "t = 1.5 s".
    t : float [s]
        Time of the state.
    q, v : (n,) [m, rad; m/s, rad/s]
        Coordinates and velocities of the state.
    modes : list of Mode
        The modes.
    notes : list of str
        Remarks, such as that the state is not an equilibrium.
    total : int or None
        Number of modes of the mechanism; None if only the lowest were computed.

    Examples
    --------
    ``[mode.frequency for mode in modes]`` are the undamped frequencies in Hz; ``modes.displacement(0, "rod.b.y")`` is
    the amplitude of a signal in the first mode.
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
        """The model."""
        return self.system.scene

    @property
    def unstable(self) -> list[Mode]:
        """The modes that grow."""
        return [mode for mode in self.modes if mode.unstable]

    def displacement(self, k: int, signal: str) -> complex:
        """Return the complex amplitude of a position signal in a mode.

        Parameters
        ----------
        k : int
            Index of the mode, from 0.
        signal : str
            Name of a signal of a frame (``rod.b.y``) or a joint (``pin.phi``) that depends on positions only.

        Returns
        -------
        complex [SI unit of the signal]

        Raises
        ------
        ModelError
            If there is no such signal.
        UsageError
            If the signal depends on more than positions.
        """
        expression = self.scene.signal(signal)
        if not of_positions(expression):
            raise UsageError(f"`{signal}` depends on more than positions")
        return complex((gradients(self.system, [expression], self.t, self.q, self.v)[1] @ self.modes[k].shape)[0])

    def animate(self, path: str | PathLike | None = None, mode: int | None = None) -> ModeAnimation:
        """Animate the mode shapes.

        Parameters
        ----------
        path : path, optional
            File that is written: a page with all modes for ``.html``, a film of one mode for ``.gif`` or ``.mp4``.
        mode : int, optional
            Index of the mode that the page shows first, from 0; a film shows no other. Default: the first that
            oscillates.

        Returns
        -------
        ModeAnimation
            The page; a notebook shows it below the cell, and its ``save`` writes it to a file.

        Raises
        ------
        UsageError
            If there are no modes, there is no such mode, or the file cannot be written.
        """
        from mbdsl.viewing.mode_animation import ModeAnimation, ModeRow

        rows = []
        for found in self.modes:
            moves = few([f"{name} {part:.0%}" for name, part in found.bodies.items() if part >= 0.05], 4)
            rows.append(ModeRow(found.frequency, found.damped_frequency, found.damping, moves, found.unstable))
        state = about(self.at, self.t)
        shapes = np.array([found.shape for found in self.modes], complex)
        animation = ModeAnimation(self.system, self.t, self.q, shapes, rows, state, mode)
        if path is not None:
            animation.save(path)
        return animation

    def to_dict(self) -> dict[str, Array]:
        """Return the modes as columns.

        Returns
        -------
        dict of (number of modes,)
            Number from 1, frequencies [Hz], damping ratio, eigenvalue [1/s], and for every coordinate the amplitude
            [m, rad] and the phase [rad] of its displacement.
        """

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

    def _head(self) -> str:
        shown = f"{len(self)} of {self.total}" if self.total and self.total > len(self) else f"{len(self)}"
        if not self.modes:
            shown = "no"
        return f"{self.scene.name}: {shown} mode{'s' * (len(self) != 1)} about its {about(self.at, self.t)}"

    def _rows(self) -> list[tuple[str, str, str, str, str]]:
        """Number, frequency, damped frequency, damping ratio, and the bodies that move, of each mode."""
        rows, hertz = [], self.scene.display.of("Hz")
        for k, mode in enumerate(self.modes, 1):
            parts = [f"{name} {part:.0%}" for name, part in mode.bodies.items() if part >= 0.05]
            mark = "  unstable" if mode.unstable else "  moves freely" if mode.omega == 0.0 else ""
            damping = mode.damping if abs(mode.damping) > 1e-9 else 0.0
            frequency, damped = mode.frequency / hertz.factor, mode.damped_frequency / hertz.factor
            numbers = f"{frequency:.6g}", f"{damped:.6g}", f"{damping:.4g}"
            rows.append((str(k), *numbers, few(parts, 4) + mark))
        return rows

    def table(self) -> TextTable:
        """Return frequencies, damping ratios and the bodies that move.

        Returns
        -------
        Table
            One row per mode.
        """
        from mbdsl.plotting.figures import TextTable

        unit = self.scene.display.of("Hz").symbol
        return TextTable("", ("#", f"f [{unit}]", f"damped [{unit}]", "damping", "moving bodies"), self._rows())

    def __str__(self) -> str:
        unit = self.scene.display.of("Hz").symbol
        heads = f"    # {f'f [{unit}]':>11}  {f'damped [{unit}]':>11}     damping  moving bodies"
        lines = [self._head(), *([heads] if self.modes else [])]
        lines += [f"{k:>5} {f:>11}  {damped:>11} {ratio:>11}  {what}" for k, f, damped, ratio, what in self._rows()]
        return "\n".join([*lines, *(f"note: {text}" for text in self.notes)])

    def __repr__(self) -> str:
        return f"<Modes of {self._head()}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        return fragment(self._head(), (), [self.table()], [f"note: {text}" for text in self.notes])


@blame_model
def eigen(
    model: Scene | Builder | str | PathLike,
    at: str | float | Mapping[str, Any] = "static",
    count: int | None = COUNT,
    *,
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    units: str | Iterable[str] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Modes:
    """Compute the eigenmodes of a model about a state.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    at : str, float or mapping, optional
        "static": the equilibrium that ``mbdsl.static`` finds. "start": the initial state with its velocities.
        A time [s]: the state at that time of a simulation with the model's settings. A mapping such as
        ``{"pin.phi": "80 deg"}``: the initial state with these values.
    count : int, optional
        Number of modes, from the lowest frequency; None computes all.
    units : str or iterable of str, optional
        A unit of frequencies for the printed table: "kHz", "1/min"; arrays are in SI units.
    without, parameters, announce : optional
        As for ``mbdsl.simulate``.

    Returns
    -------
    Modes

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    EquilibriumError, InitialisationError, IntegrationError
        If the state is not found.
    """
    if count is not None and (not isinstance(count, (int, np.integer)) or count < 1):
        raise UsageError(f"count = {count!r}: the number of modes is 1 or more")
    scene = in_units(as_scene(model, parameters, without), units) if units else None
    given = (model, at, without, parameters) if scene is None else (scene, at, (), None)
    return modes_about(operating_points.find(*given, announce), count)


def modes_about(point: operating_points.OperatingPoint, count: int | None) -> Modes:
    """The modes about a state; see :func:`eigen`."""
    system, t, q, v, a, lam, moving = point.system, point.t, point.q, point.v, point.a, point.lam, point.moving
    notes = point.notes + point.warning("eigenvalues")
    values, shapes, total = _solve(system, t, q, v, a, lam, moving, count)
    modes = [Mode(complex(s), x, _shares(system, t, q, x)) for s, x in zip(values, shapes, strict=True)]
    return Modes(system, point.at, t, q, v, modes, notes, total)


def _shares(system: System, t: float, q: Array, shape: Complex) -> dict[str, float]:
    """Share of each body in the kinetic energy of a shape; in the squared displacements if only massless parts move."""
    energy = (shape.conj() * (system.M(t, q) @ shape)).real
    energy[system.n - system.tables.states :] = 0.0
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
    """Eigenvalues (one of each pair), shapes (n,), and the total number of modes."""
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
        return lowest(system, M, D, K, U, J, count)
    M, D, K, U, J = (dense(x) for x in (M, D, K, U, J))
    if moving:
        basis = Moving(system, t, q, v, a)
    else:
        basis = Still(system, J)
    values, y = reduced(system, M, D, K, U, J, basis)
    shapes = [normalised(system, basis.Z @ x) for x in y]
    values, shapes = one_of_each(values, shapes)
    total = len(values)
    return values[:count], shapes[:count], total
