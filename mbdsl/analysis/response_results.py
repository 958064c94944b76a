"""Frequency responses and their resonances, as :func:`mbdsl.response` returns them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mbdsl.analysis.eigenmodes import Modes
from mbdsl.analysis.operating_points import about
from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array, Complex
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import DisplayUnit, few
from mbdsl.system import System

if TYPE_CHECKING:
    from mbdsl.plotting.figures import TextTable
    from mbdsl.plotting.signal_plots import Plot


class Peak(NamedTuple):
    """A resonance or an antiresonance of one output and one input.

    Attributes
    ----------
    output, input : str
        Their names.
    highest : bool
        True: a resonance, a maximum of the amplitude. False: an antiresonance, a minimum.
    frequency : float [Hz]
    amplitude : float
        Infinite at a resonance without damping.
    phase : float [rad]
    mode : int or None
        Number of the mode next to it that takes part in the response, from 1 as ``mbdsl.eigen`` counts; None at an
        antiresonance.
    damping, Q : float
        Damping ratio d of this mode, and its quality factor 1/(2 d); nan at an antiresonance.
    """

    output: str
    input: str
    highest: bool
    frequency: float
    amplitude: float
    phase: float
    mode: int | None
    damping: float
    Q: float


def _ratio(y: str, u: str) -> str:
    """The unit of a quotient; "" for a pure number."""
    if y == u or not u:
        return "" if y == u else y
    return f"{f'({y})' if '/' in y else y or '1'}/{f'({u})' if set(u) & set('./') else u}"


@dataclass(eq=False)
class Response:
    """A frequency response; ``print(response)`` shows resonances and a table.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    at : str
        State about which the model oscillates: "static", "start" or "t = 1.5 s".
    t : float [s]
        Time of the state.
    inputs, outputs : list of str
        Names.
    input_units, output_units : list of str
        Their units; "" for pure numbers. With another ``amplitude`` than "1", those of its factor.
    f : (N,) [Hz]
        Frequencies.
    H : (N, o, i) complex
        Output o for a unit of input i.
    peaks : list of Peak
        Resonances and antiresonances within the range.
    modes : Modes
        All modes about the state.
    amplitude_of_input : str
        The amplitude of an input over w: "1", "w", "w^2", "1/w" or "1/w^2".
    y0 : (o,)
        Values of the outputs at the state, of which the oscillations are deviations; nan for coordinates of beams.
    notes : list of str
        Remarks, such as that the state is unstable.
    """

    system: System
    at: str
    t: float
    inputs: list[str]
    outputs: list[str]
    input_units: list[str]
    output_units: list[str]
    f: Array
    H: Complex
    peaks: list[Peak]
    modes: Modes
    amplitude_of_input: str
    y0: Array
    notes: list[str]
    _of: Callable[[Array], Complex] = field(repr=False)

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.system.scene

    @property
    def amplitude(self) -> Array:
        """Amplitudes (N, o, i)."""
        return np.abs(self.H)

    @property
    def phase(self) -> Array:
        """Phases (N, o, i) [rad], without jumps along f; negative where the output lags."""
        return np.unwrap(np.angle(self.H), axis=0)

    def at_frequency(self, f: ArrayLike) -> Complex:
        """Return the exact response at given frequencies.

        Parameters
        ----------
        f : (N,) array [Hz]
            Frequencies above zero.

        Returns
        -------
        (N, o, i) array of complex
            ``abs`` is the amplitude and ``numpy.angle`` the phase.

        Raises
        ------
        UsageError
            If a frequency is not above zero.
        """
        given = np.atleast_1d(np.array(f, float))
        if given.ndim != 1 or not (np.isfinite(given) & (given > 0.0)).all():
            raise UsageError("frequencies [Hz] are above zero", hint="e.g. [0.5, 1.0, 2.0]")
        return self._of(given)

    def unit(self, output: int, input: int) -> str:
        """The unit of output / input; "" for a pure number.

        Parameters
        ----------
        output, input : int
            Indices, from 0.

        Returns
        -------
        str
        """
        return _ratio(self.output_units[output], self.input_units[input])

    def shown(self, output: int, input: int) -> DisplayUnit:
        """The unit in which output / input is displayed.

        Parameters
        ----------
        output, input : int
            Indices, from 0.

        Returns
        -------
        DisplayUnit
            With its size in the unit of ``unit``.
        """
        y = self.scene.display.of(self.output_units[output], self.outputs[output])
        u = self.scene.display.of(self.input_units[input], self.inputs[input])
        return DisplayUnit(_ratio(y.symbol, u.symbol), y.factor / u.factor)

    def to_dict(self) -> dict[str, Array]:
        """Return the response as columns.

        Returns
        -------
        dict of (N,)
            ``frequency`` [Hz], and of each output and input the amplitude and the phase [rad].
        """
        found, size, phase = {"frequency": self.f}, self.amplitude, self.phase
        for j, output in enumerate(self.outputs):
            for k, name in enumerate(self.inputs):
                found[f"{output} / {name} amplitude"] = size[:, j, k]
                found[f"{output} / {name} phase"] = phase[:, j, k]
        return found

    def table(self) -> TextTable:
        """Return the resonances and antiresonances.

        Returns
        -------
        Table
            One row for each.
        """
        from mbdsl.analysis.response_tables import peaks

        return peaks(self)

    def plot(self) -> Plot:
        """Return amplitude and phase over the frequency (a Bode plot).

        Returns
        -------
        Plot
            ``print(plot)`` shows it in characters; ``plot.save(path)`` writes it.
        """
        from mbdsl.analysis.response_tables import plot

        return plot(self)

    def save(self, path: str | PathLike) -> None:
        """Write the response to a file.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the content: .csv (all digits), .json (with resonances, modes and notes), .md
            or .tex (tables), .svg, .png, .pdf (the plot; the last two require matplotlib), .html (a page with both).

        Raises
        ------
        UsageError
            If the suffix is unknown or the file cannot be written.
        """
        from mbdsl.analysis.response_files import save

        save(self, path)

    def _head(self) -> str:
        where = about(self.at, self.t)
        return f"{self.scene.name}: frequency response about its {where}, {self.f[0]:g} to {self.f[-1]:g} Hz"

    def __repr__(self) -> str:
        return f"<Response of {self.scene.name}: {few(self.outputs)} to {few(self.inputs)}>"

    def __str__(self) -> str:
        from mbdsl.analysis.response_tables import text

        return text(self)

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        return fragment(self._head(), (), [self.table()], [f"note: {note}" for note in self.notes])
