"""Frequency responses about a state: amplitude and phase of signals while an input oscillates.

    x' = A x + B(s) u,   y = C x + D(s) u,   H(s) = C (s I - A)^{-1} B(s) + D(s),   s = j w

of the linear equations in :mod:`mbdsl.analysis.linear_equations`. B and D are polynomials in s where a driver
oscillates. The frequencies are close to each other where the response changes, and the frequencies of resonances are
computed by themselves, so that narrow peaks are not cut.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.analysis import excitations, frequency_ranges, operating_points, resonances
from mbdsl.analysis.eigenmodes import Mode, Modes, modes_about
from mbdsl.analysis.excitations import FORCE, Excitation
from mbdsl.analysis.linear_responses import Transfer
from mbdsl.analysis.linearisation import equations_of, outputs_of
from mbdsl.analysis.operating_points import At, OperatingPoint
from mbdsl.analysis.response_results import Peak, Response
from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array, Complex
from mbdsl.lang import units
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.display_units import in_units
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.lang.quantities import unit_text
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import few
from mbdsl.numerics.saddle_point import largest, scaled
from mbdsl.results.selection import split

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder


#: amplitude of an input over the angular frequency -> the power of w
AMPLITUDES = {"1": 0, "w": 1, "w^2": 2, "1/w": -1, "1/w^2": -2}
MOST = 500  #: largest number of pairs of an output and an input
NOTHING = 1e-11  #: response, relative to the terms that cancel in it, that is zero
STRETCHED = 1e-4  #: change of length of springs at a state, relative to the size of the mechanism, at least
TAKES_PART = 0.01  #: least part of a mode in a response, relative to the largest one, to give its name to a resonance
WIDER = 30.0  #: default range: from the slowest pole divided by this to the fastest one times this
_ROTATING = re.compile(r"rotating\s*\(([^(),]+),([^(),]+)\)")


@blame_model
def response(
    model: Scene | Builder | str | PathLike,
    input: str | Sequence[str] | None = None,
    output: str | Sequence[str] | None = None,
    range: str | Sequence[str | float] | None = None,
    *,
    at: At = "static",
    amplitude: str = "1",
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    units: str | Iterable[str] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Response:
    """Compute the frequency response of signals to inputs about a state: amplitudes, phases and resonances.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    input : str or sequence of str, optional
        What oscillates: an input of the model; a force element, or one of its components (``push.fx``), for a force in
        addition to its own; a driver (``base.s``), whose position or velocity oscillates about its value; or
        ``rotating(push.fx, push.fy)``, which is cos(w t) of the first and sin(w t) of the second. Default: all inputs
        of the model.
    output : str or sequence of str, optional
        Names, patterns and expressions of signals, also reactions and accelerations. Default: the coordinates.
    range : str or sequence, optional
        Frequencies: ``"0.1:100Hz"``, ``"1:600 rad/s"``, or two numbers [Hz]. Default: from far below the slowest to far
        above the fastest pole.
    at : str, float or mapping, optional
        The state, as for ``mbdsl.linearise``.
    amplitude : str, optional
        How the amplitude of the inputs depends on the angular frequency w: c times "1", "w", "w^2", "1/w" or "1/w^2".
        Responses are per unit of c. "w^2" is that of an unbalance, m e w^2; with "1/w^2" the acceleration of a driver
        has the same amplitude at all frequencies, as on a shaker.
    units : str or iterable of str, optional
        Units such as "deg, kN, mm" of printed tables and plots; arrays are in SI units.
    without, parameters, announce : optional
        As for ``mbdsl.simulate``.

    Returns
    -------
    Response

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    EquilibriumError, InitialisationError, IntegrationError
        If the state is not found.
    """
    if amplitude not in AMPLITUDES:
        raise UsageError(f"amplitude: found `{amplitude}`, expected one of {', '.join(AMPLITUDES)}")
    limits = None if range is None else frequency_ranges.read(range)
    scene = in_units(as_scene(model, parameters, without), units)
    chosen = _Inputs(scene, input, amplitude)
    if output is not None:
        _check_outputs(scene, output, chosen.sources)
    point = operating_points.find(scene, at, (), None, announce)
    return _Computation(point, chosen, output, amplitude).response(limits)


class _Inputs:
    """The inputs: names, units, and the excitations that they are combinations of."""

    def __init__(self, scene: Scene, given: str | Sequence[str] | None, amplitude: str) -> None:
        names = [*scene.inputs] if given is None else split(given) if isinstance(given, str) else list(given)
        if not names:
            known = excitations.all_of(scene)
            hint = f"{scene.name} has {few(known)}" if known else f"{excitations.NOTHING} or a driver"
            raise UsageError("a frequency response needs an input", hint=hint)
        self.sources: list[Excitation] = []
        self.names: list[str] = []
        self.units: list[str] = []
        combined: list[dict[int, complex]] = []
        for name in dict.fromkeys(names):
            match = _ROTATING.fullmatch(name.strip()) if isinstance(name, str) else None
            if match is None and isinstance(name, str) and name.strip().startswith("rotating("):
                force = name.strip()[len("rotating(") :].rstrip(") ").rpartition(".")[0] or "push"
                hint = f"write rotating({force}.fx, {force}.fy)"
                raise UsageError(f"found `{name}`, and `rotating` takes two forces", hint=hint)
            parts = excitations.read(scene, [part.strip() for part in match.groups()] if match else [name])
            if match and (len(parts) != 2 or parts[0].unit != parts[1].unit):
                raise UsageError(f"`{name}` does not rotate", hint="name two different inputs with one unit")
            self.sources += [part for part in parts if part not in self.sources]
            factors = (1.0, -1j)  # cos(w t) and sin(w t), of the real part of exp(j w t)
            combined.append({self.sources.index(e): x for e, x in zip(parts, factors, strict=False)})
            self.names.append(f"rotating({parts[0].name}, {parts[1].name})" if match else parts[0].name)
            self.units.append(_per_power(parts[0].unit, AMPLITUDES[amplitude]))
        self.matrix = np.zeros((len(self.sources), len(names)), complex)[:, : len(combined)]
        for k, factors_of in enumerate(combined):
            for j, x in factors_of.items():
                self.matrix[j, k] = x


def _per_power(unit: str, power: int) -> str:
    """The unit of c where the amplitude is c w^power."""
    if not power:
        return unit
    dimension = units.multiply(units.dimension(unit or "1"), units.power(units.dimension("s"), power))
    return "" if dimension == units.NUMBER else unit_text(dimension)


def _check_outputs(scene: Scene, output: str | Sequence[str], sources: Sequence[Excitation]) -> None:
    """Raise an error if an output is unknown, or is that of a force element to which the input adds."""
    for name in outputs_of(scene, AskedSignals(scene), _texts(output)):
        for e in sources:
            if e.sort == FORCE and re.search(rf"(?<![\w.]){re.escape(e.name)}(?![\w.])", name):
                raise UsageError(
                    f"`{name}` does not contain the input, which is a force in addition to `{e.name}`",
                    hint="declare an input in the model, and write it into the law of the force",
                )


def _texts(output: str | Sequence[str]) -> list[str]:
    return split(output) if isinstance(output, str) else list(output)


class _Computation:
    """A response about a state."""

    def __init__(
        self, point: OperatingPoint, inputs: _Inputs, output: str | Sequence[str] | None, amplitude: str
    ) -> None:
        self.point, self.inputs, self.amplitude, self.power = point, inputs, amplitude, AMPLITUDES[amplitude]
        scene, known = point.system.scene, AskedSignals(point.system.scene)
        equations = equations_of(point, inputs.sources)
        if output is None:
            coordinates = equations.coordinates
            self.outputs, self.units = [x.name for x in coordinates], [x.unit for x in coordinates]
            C, D = np.eye(len(coordinates), len(equations.A)), np.zeros((3, len(coordinates), len(inputs.sources)))
            self.y0 = np.full(len(coordinates), np.nan)
            if not coordinates:
                raise UsageError("nothing can move but what the inputs move", hint="name outputs, such as reactions")
        else:
            self.outputs = outputs_of(scene, known, _texts(output))
            self.units = [known.unit(name) for name in self.outputs]
            C, D, self.y0 = equations.outputs(known, self.outputs)
        if len(self.outputs) * len(inputs.names) > MOST:
            raise UsageError(
                f"{len(self.outputs)} outputs and {len(inputs.names)} inputs are too many: at most {MOST} pairs",
                hint="name the outputs",
            )
        self.transfer = Transfer(equations.A, equations.B @ inputs.matrix, C, D @ inputs.matrix)
        self.poles: list[complex] = list(np.linalg.eigvals(equations.A)) if len(equations.A) else []

    def response(self, limits: tuple[float, float] | None) -> Response:
        """The response within limits [Hz]."""
        point, power = self.point, self.power
        low, high = limits or self._limits()
        s = np.asarray(2j * np.pi * np.geomspace(low, high, 23), complex)  # where no pole is but by accident
        with np.errstate(all="ignore"):
            least = np.maximum(self.transfer.size(s).max(axis=0), self._of_the_state())
            reached = np.abs(self.transfer.at(s)).max(axis=0) > NOTHING * least

        def of(f: Array) -> Complex:
            w = 2.0 * np.pi * f
            with np.errstate(all="ignore"):
                return np.where(reached, self.transfer.at(np.asarray(1j * w, complex)) * w[:, None, None] ** power, 0.0)

        f = resonances.sampled(of, self.poles, low, high)
        modes = modes_about(point, None)
        notes = point.notes + point.warning("responses") + self._notes(reached, modes)
        H = of(f)
        peaks = [
            peak for j, k in np.ndindex(reached.shape) for peak in self._peaks(f, np.abs(H[:, j, k]), of, j, k, modes)
        ]
        inputs = self.inputs
        return Response(
            point.system,
            point.at,
            point.t,
            inputs.names,
            self.outputs,
            inputs.units,
            self.units,
            f,
            H,
            peaks,
            modes,
            self.amplitude,
            self.y0,
            notes,
            of,
        )

    def _of_the_state(self) -> Array:
        """Values of the outputs over those of the inputs (o, i) at the state, which is known but for rounding."""
        size, load = self.point.system.tables.size, self._load()
        known = {"m": size, "rad": 1.0, "": 1.0, "N": load, "N.m": load * size}
        inputs = np.array([known.get(e.unit, 0.0) for e in self.inputs.sources]) @ np.abs(self.inputs.matrix)
        values = np.abs(np.where(np.isfinite(self.y0), self.y0, 0.0))
        return np.divide(values[:, None], inputs, where=inputs > 0.0, out=np.zeros((len(values), len(inputs))))

    def _load(self) -> float:
        """The size of the forces at the state [N]. Those of springs may balance weights and leave rounding."""
        point, scale = self.point, self.point.system.tables.scale
        q, v, lam, n = point.q, point.v, point.lam, point.system.n
        K = point.system.tangent(point.t, q, v, lam, cK=1.0)[:n, :n]
        springs = STRETCHED * largest(scaled(K, 1.0 / scale, 1.0 / scale))
        applied = float(np.abs(point.system.Q(point.t, q, v) / scale).max(initial=0.0))
        return max(float(np.abs(lam).max(initial=0.0)), max(springs, applied) / point.system.tables.size)

    def _limits(self) -> tuple[float, float]:
        size = np.abs(self.poles) / (2.0 * np.pi)
        size = size[size > 1e-9 * size.max(initial=0.0)]
        return (float(size.min() / WIDER), float(size.max() * WIDER)) if len(size) else (0.01, 100.0)

    def _notes(self, reached: NDArray[np.bool_], modes: Modes) -> list[str]:
        notes = []
        if growing := [str(k) for k, mode in enumerate(modes, 1) if mode.unstable]:
            which = f"mode {growing[0]} grows" if len(growing) == 1 else f"modes {few(growing)} grow"
            notes.append(
                f"the state is unstable: {which}, so that no oscillation about it becomes steady; the response is that "
                "of the linear equations alone"
            )
        for k, name in enumerate(self.inputs.names):
            if silent := [output for j, output in enumerate(self.outputs) if not reached[j, k]]:
                notes.append(f"{few(silent)} {'does' if len(silent) == 1 else 'do'} not respond to {name}")
        if self.power:
            factor = dict.fromkeys(f"c [{unit or '1'}]" for unit in self.inputs.units)
            notes.append(
                f"inputs have the amplitude {_times(self.amplitude)}, w in rad/s; responses are per {few(factor)}"
            )
        return notes

    def _peaks(
        self, f: Array, size: Array, of: Callable[[Array], Complex], output: int, input: int, modes: Modes
    ) -> list[Peak]:
        """The resonances and antiresonances of one output and one input."""
        names, found = (self.outputs[output], self.inputs.names[input]), []

        def height(x: Array) -> Array:
            w = 2.0 * np.pi * x
            return np.abs(self.transfer.entry(np.asarray(1j * w, complex), output, input)) * w**self.power

        extremes = resonances.extremes(f, size, height, self.poles)
        values = of(np.array([extreme.f for extreme in extremes]))[:, output, input] if extremes else ()
        for extreme, value in zip(extremes, values, strict=True):
            mode = self._mode(2j * np.pi * extreme.f, output, input, modes) if extreme.highest else None
            damping = np.nan if mode is None else _damping(modes[mode])
            quality = np.inf if damping == 0.0 else 0.5 / damping
            phase = np.nan if extreme.infinite else float(np.angle(value))
            number = None if mode is None else mode + 1
            size_ = np.inf if extreme.infinite else float(abs(value))
            found.append(Peak(*names, extreme.highest, extreme.f, size_, phase, number, damping, quality))
        return found

    def _mode(self, s: complex, output: int, input: int, modes: Modes) -> int | None:
        """The index of the mode next to s, among those that take part in the response there."""
        poles, parts = self.transfer.shares(s, output, input)
        if not len(modes) or not len(poles):
            return None
        near = np.abs(s - poles) / np.maximum(np.abs(poles), 1e-300)
        pole = poles[int(np.argmin(np.where(parts >= TAKES_PART * parts.max(), near, np.inf)))]
        pole = complex(pole.real, abs(pole.imag))
        return int(np.argmin([abs(mode.eigenvalue - pole) for mode in modes]))


def _damping(mode: Mode) -> float:
    return 0.0 if resonances.undamped(mode.eigenvalue) else mode.damping


def _times(amplitude: str) -> str:
    return f"c {amplitude}" if amplitude[0] == "w" else f"c{amplitude[1:]}"
