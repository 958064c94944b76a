"""Poles and responses of linear models x' = A x + B u, y = C x + D u."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array, Complex

POINTS = 501  #: of a response without given times or frequencies
DEPENDENT = 1e10  #: condition number of eigenvectors that do not tell the parts of modes apart
SETTLED = 7.0  #: duration of a step response in time constants of the slowest pole


class Linear(Protocol):
    """A linear model: :class:`mbdsl.analysis.linearisation.Linearisation`."""

    A: Array
    B: Array
    C: Array
    D: Array
    states: list[str]
    inputs: list[str]
    outputs: list[str]


class StepResponse(NamedTuple):
    """The response to a unit step of each input at t = 0, as deviations from the state."""

    t: Array  #: (N,) [s]
    y: Array  #: (N, o, i): output o for a step of input i


class FrequencyResponse(NamedTuple):
    """The response to harmonic inputs, C (j w I - A)^{-1} B + D."""

    f: Array  #: (N,) [Hz]
    amplitude: Array  #: (N, o, i): amplitude of output o for a unit amplitude of input i
    phase: Array  #: (N, o, i) [rad]: without jumps along f


def poles(linear: Linear) -> Complex:
    """The eigenvalues (r,) of A [1/s], the slowest first."""
    found = np.linalg.eigvals(linear.A) if len(linear.A) else np.zeros(0)
    return np.asarray(found[np.lexsort((found.imag, np.abs(found)))], complex)


def step_response(linear: Linear, t: ArrayLike | None = None) -> StepResponse:
    """See :meth:`Linearisation.step_response`."""
    from scipy.linalg import expm

    if t is None:
        slow = np.abs(poles(linear).real)
        slowest = slow[slow > 1e-9 * np.abs(poles(linear)).max(initial=0.0)].min(initial=np.inf)
        t = np.linspace(0.0, SETTLED / slowest if np.isfinite(slowest) else 10.0, POINTS)
    times, (r, i) = np.array(t, float), linear.B.shape
    if times.ndim != 1 or not len(times) or times[0] < 0.0 or (np.diff(times) <= 0.0).any():
        raise UsageError("times of a step response ascend from 0 s on", hint="e.g. numpy.linspace(0, 5, 501)")
    # d/dt [x; u] = [[A, B], [0, 0]] [x; u]: exact at any times
    whole, state = np.zeros((r + i, r + i)), np.zeros((r + i, i))
    whole[:r, :r], whole[:r, r:], state[r:] = linear.A, linear.B, np.eye(i)
    found, last, before = np.zeros((len(times), len(linear.outputs), i)), 0.0, (-1.0, np.eye(r + i))
    for k, now in enumerate(times):
        step = now - last
        if step > 0.0:
            if abs(step - before[0]) > 1e-12 * step:
                before = step, expm(step * whole)
            state = before[1] @ state
        found[k], last = linear.C @ state[:r] + linear.D, now
    return StepResponse(times, found)


def bode(linear: Linear, f: ArrayLike | None = None) -> FrequencyResponse:
    """See :meth:`Linearisation.bode`."""
    if f is None:
        size = np.abs(poles(linear)) / (2.0 * np.pi)
        size = size[size > 1e-9 * size.max(initial=0.0)]
        low, high = (size.min() / 30.0, size.max() * 30.0) if len(size) else (0.01, 100.0)
        f = np.geomspace(low, high, POINTS)
    frequencies, r = np.array(f, float), len(linear.A)
    if frequencies.ndim != 1 or not len(frequencies) or not (frequencies >= 0.0).all():
        raise UsageError("frequencies [Hz] are not negative", hint="e.g. numpy.geomspace(0.1, 100, 501)")
    s = 2j * np.pi * frequencies
    values = poles(linear)
    near = 1e-13 * np.abs(values).max(initial=0.0)
    if r and (np.abs(s[:, None] - values) <= near).any():
        raise UsageError("a frequency is that of an undamped pole, where the response is infinite")
    H = Transfer(linear.A, linear.B[None], linear.C, linear.D[None]).at(s)
    return FrequencyResponse(frequencies, np.abs(H), np.unwrap(np.angle(H), axis=0))


class Transfer:
    """C (s I - A)^{-1} B(s) + D(s) with B(s) = B0 + s B1 + s^2 B2 and D(s) alike, by the Schur form of A.

    Parameters
    ----------
    A, B, C, D : (r, r), (k, r, i), (o, r), (k, o, i)
        B and D contain the coefficients of the powers of s.
    """

    def __init__(self, A: Array, B: Array, C: Array, D: Array) -> None:
        from scipy.linalg import schur

        self.T, Q = schur(A, output="complex") if len(A) else (np.zeros((0, 0), complex), np.zeros((0, 0)))
        self.B, self.C, self.D = Q.conj().T @ B, C @ Q, D

    def _states(self, s: Complex) -> Complex:
        """(s I - T)^{-1} B(s) (N, r, i), by back substitution for all s at once."""
        x = np.tensordot(s[:, None] ** np.arange(len(self.B)), self.B, 1)
        for k in reversed(range(len(self.T))):
            x[:, k] += np.tensordot(x[:, k + 1 :], self.T[k, k + 1 :], (1, 0))
            x[:, k] /= (s - self.T[k, k])[:, None]
        return x

    def at(self, s: Complex) -> Complex:
        """The values (N, o, i) at the complex frequencies s (N,) [1/s]."""
        direct = np.tensordot(s[:, None] ** np.arange(len(self.D)), self.D, 1)
        return np.asarray(np.moveaxis(np.tensordot(self.C, self._states(s), (1, 1)), 0, 1) + direct)

    def size(self, s: Complex) -> Array:
        """The sums (N, o, i) of the absolute values of the terms of :meth:`at`, to which its rounding errors belong."""
        direct = np.tensordot(np.abs(s[:, None]) ** np.arange(len(self.D)), np.abs(self.D), 1)
        return np.asarray(np.moveaxis(np.tensordot(np.abs(self.C), np.abs(self._states(s)), (1, 1)), 0, 1) + direct)

    @cached_property
    def _modal(self) -> tuple[Complex, Complex, Complex] | None:
        """The poles (r,), C V (o, r) and V^{-1} B (k, r, i) with the eigenvectors V; None if they are dependent."""
        values, V = np.linalg.eig(self.T)
        if len(values) and np.linalg.cond(V) > DEPENDENT:
            return None
        return values, self.C @ V, np.linalg.solve(V, self.B) if len(values) else self.B

    def entry(self, s: Complex, output: int, input: int) -> Complex:
        """The values (N,) of one entry of :meth:`at`, faster and with larger rounding errors: as a sum over modes."""
        if self._modal is None:
            return self.at(s)[:, output, input]
        values, left, right = self._modal
        powers = s[:, None] ** np.arange(len(right))
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = left[output] * (powers @ right[:, :, input]) / (s[:, None] - values)
        return np.asarray(parts.sum(axis=1) + powers @ self.D[:, output, input])

    def shares(self, s: complex, output: int, input: int) -> tuple[Complex, Array]:
        """The poles (r,), and the absolute value of the part of each in one entry of :meth:`at`; 1 if not known."""
        if self._modal is None:
            return np.diag(self.T), np.ones(len(self.T))
        values, left, right = self._modal
        b = np.tensordot(s ** np.arange(len(right)), right[:, :, input], 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = np.abs(left[output] * b / (s - values))
        return values, np.where(np.isfinite(parts), parts, np.inf)


def to_control(linear: Linear, name: str) -> Any:
    """See :meth:`Linearisation.to_control`."""
    try:
        import control  # type: ignore[import-untyped]
    except ImportError:
        raise UsageError("python-control is not installed", hint="pip install control") from None
    names = {key: _plain(getattr(linear, key)) for key in ("states", "inputs", "outputs")}
    return control.ss(linear.A, linear.B, linear.C, linear.D, name=name, **names)


def _plain(names: list[str]) -> list[str]:
    """Names without dots and brackets, each different from the others."""
    found: list[str] = []
    for name in names:
        plain = name.replace(".", "_").replace("[", "_").replace("]", "").replace(",", "_")
        while plain in found:
            plain += "_"
        found.append(plain)
    return found
