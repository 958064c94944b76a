"""Amplitude spectra of signals.

Hann window, mean removed, amplitudes divided by the mean of the window: a sine of amplitude A shows A. See Heinzel,
Ruediger, Schilling, "Spectrum and spectral density estimation by the Discrete Fourier transform" (2002), on scaling.
Zero padding to eight times the length limits the error of a peak between two frequencies to 0.3 %, instead of 15 %.
Signals longer than ``LONGEST`` are divided into segments that overlap by half, whose squares are averaged (Welch, IEEE
Trans. Audio Electroacoust. 15 (1967) 70); these are padded to four times their length (1 %).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.messages import count
from mbdsl.plotting.differences import Window, rate_of
from mbdsl.results.stored import ROWS, Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LONGEST = 2**18  #: number of samples of a segment
PADDING, OF_SEGMENTS = 8, 4  #: length of the transform over that of the signal, or over that of a segment
UNEVEN = 1e-6  #: largest deviation of a time from a uniform grid, relative to its spacing
ROUNDINGS = 200.0  #: the same, in roundings of the largest time: the spacing is that of the first part
LEAST = 8  #: number of samples below which there is no spectrum


@dataclass(frozen=True)
class Spectrum:
    """Amplitudes (K,) at frequencies (K,) [Hz]; ``resampled`` is "" (not), "cubically" or "linearly"."""

    frequency: Array
    amplitude: Array
    segments: int
    resampled: str


def spectrum(result: Result, name: str) -> Spectrum:
    """The amplitude spectrum of a signal of a result, from two passes in bounded memory.

    Raises
    ------
    UsageError
        If the signal has gaps, too few samples, or times that do not ascend.
    """
    grid = _grid(result)
    known = set(result.names)
    rate = rate_of(name, known)
    if grid.uniform:
        samples: Iterator[Array] = (columns[name] for _, columns in result.chunks([name]))
    else:
        samples = _resampled(result, name, grid)
    amplitude, segments = amplitudes(_finite(samples, name, result.label))
    frequency = np.arange(len(amplitude)) / (2.0 * (len(amplitude) - 1) * grid.step)
    return Spectrum(frequency, amplitude, segments, "" if grid.uniform else "cubically" if rate else "linearly")


@dataclass(frozen=True)
class _Grid:
    """Uniform times: ``count`` from ``first`` to ``last``; ``uniform`` if those of the result are the same."""

    count: int
    first: float
    last: float
    uniform: bool

    @property
    def step(self) -> float:
        return (self.last - self.first) / (self.count - 1)

    def parts(self) -> Iterator[Array]:
        for k in range(0, self.count, ROWS):
            times = self.first + self.step * np.arange(k, min(k + ROWS, self.count))
            yield np.minimum(times, self.last)


def _grid(result: Result) -> _Grid:
    count_, first, last, step, deviation = 0, 0.0, -np.inf, 0.0, 0.0
    for t, _ in result.chunks([]):
        if not len(t):
            continue
        if t[0] < last or (np.diff(t) < 0.0).any():
            raise UsageError(f"the times of {result.label} do not ascend: it has no spectrum")
        if count_ == 0:
            first, step = float(t[0]), float(t[-1] - t[0]) / max(len(t) - 1, 1)
        expected = first + step * np.arange(count_, count_ + len(t))
        deviation = max(deviation, float(np.abs(t - expected).max()))
        count_, last = count_ + len(t), float(t[-1])
    if count_ < LEAST or not last > first:
        raise UsageError(
            f"{result.label} has {count(count_, 'row')}: a spectrum needs at least {LEAST} at several times"
        )
    rounding = float(np.spacing(max(abs(first), abs(last))))
    return _Grid(count_, first, last, deviation <= UNEVEN * step + ROUNDINGS * rounding)


def _resampled(result: Result, name: str, grid: _Grid) -> Iterator[Array]:
    window = Window(result, [name], ROWS)
    for t in grid.parts():
        window.move(t)
        yield window.at(t, name)


def _finite(samples: Iterable[Array], name: str, label: str) -> Iterator[Array]:
    for part in samples:
        if not np.isfinite(part).all():
            raise UsageError(f"`{name}` has values in {label} that are not finite: it has no spectrum")
        yield part


def amplitudes(samples: Iterable[Array], longest: int = LONGEST) -> tuple[Array, int]:
    """Amplitudes (K,) of uniform samples, given in parts, from 0 to half the sampling frequency.

    Parameters
    ----------
    samples : iterable of (k,)
        Parts of the signal.
    longest : int, optional
        Number of samples of a segment; shorter signals are one segment.

    Returns
    -------
    amplitudes : (K,)
    segments : int
        Number of segments.
    """
    parts = iter(samples)
    known = np.empty(0)
    while len(known) <= longest and (part := next(parts, None)) is not None:
        known = np.concatenate((known, part))
    if len(known) <= longest:
        return _scaled(_power(known, PADDING), len(known)), 1
    total, segments = np.zeros(OF_SEGMENTS * longest // 2 + 1), 0
    for part in chain([np.empty(0)], parts):
        known = np.concatenate((known, part))
        while len(known) >= longest:
            total += _power(known[:longest], OF_SEGMENTS)
            segments += 1
            known = known[longest // 2 :]
    return _scaled(total / segments, longest), segments


def _power(y: Array, padding: int) -> Array:
    """Squares of the transform of samples without their mean, with the window and zero padding."""
    from scipy import fft

    found = fft.rfft((y - y.mean()) * _window(len(y)), padding * len(y))
    return found.real**2 + found.imag**2


def _scaled(power: Array, size: int) -> Array:
    found = 2.0 * np.sqrt(power) / _window(size).sum()
    found[[0, -1]] *= 0.5
    return found


def _window(size: int) -> Array:
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(size) / size)
