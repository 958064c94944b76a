"""Signals of a ``Simulation`` that are chosen once and read together."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.simulation.present_signals import PresentSignals


class Reader:
    """Present values of chosen signals, from ``Simulation.reader``; call it.

    Parameters
    ----------
    names : sequence of str
        Names of the signals.
    reading : callable
        The functions of signals for the present buffers.

    Attributes
    ----------
    names : tuple of str
        Names of the signals.
    """

    def __init__(self, names: Sequence[str], reading: Callable[[], PresentSignals]) -> None:
        self.names = tuple(names)
        self._reading = reading
        self._known = reading()
        self._function = self._known.function(self.names)  # turns of angles in space are counted from now on

    def __call__(self, out: Array | None = None) -> Array:
        """Return the present values.

        Parameters
        ----------
        out : (k,) array, optional
            An array to write the values to. Default: a new array.

        Returns
        -------
        (k,) array
            Values in SI units.
        """
        known = self._reading()
        if known is not self._known:  # the buffers of the run were replaced
            self._function, self._known = known.function(self.names), known
        if out is None:
            return np.array(self._function())
        out[:] = self._function()
        return out

    @property
    def units(self) -> tuple[str, ...]:
        """SI units of the signals; "" for pure numbers."""
        known = self._reading().known
        return tuple(known.unit(name) for name in self.names)
