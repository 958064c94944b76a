"""Turns of angles between axes in space, counted step by step in place of from all stored states."""

from __future__ import annotations

from math import atan2, tau


class TurnCounter:
    """The present value of an angle that is known up to whole turns.

    Between two counts, turns follow from the mean of both rates, as in
    :func:`mbdsl.expressions.array_operations.counted`.

    Parameters
    ----------
    angle : float [rad]
        The value, up to less than half a turn, at the time t.
    t : float [s]
    rate : float [rad/s]
    """

    __slots__ = ("angle", "rate", "t")

    def __init__(self, angle: float, t: float, rate: float = 0.0) -> None:
        self.angle, self.t, self.rate = angle, t, rate

    def __call__(self, y: float, x: float, rate: float, t: float) -> float:
        """The angle of the direction (x, y) at the time t, which becomes the last one."""
        angle = atan2(y, x)
        expected = self.angle + 0.5 * (rate + self.rate) * (t - self.t)
        self.angle = angle = angle + tau * round((expected - angle) / tau)
        self.t, self.rate = t, rate
        return angle

    @property
    def state(self) -> tuple[float, float, float]:
        """The arguments of an equal counter."""
        return self.angle, self.t, self.rate
