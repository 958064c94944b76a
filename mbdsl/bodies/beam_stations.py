"""The position of a frame along the axis of a beam."""

from __future__ import annotations


def on_axis(pose: tuple[float, float, float], length: float) -> float:
    """The distance [m] along the axis from frame a to a frame at ``pose`` (relative to the middle of the beam).

    Raises
    ------
    ValueError
        If the frame is not on the axis of the beam.
    """
    x, slack = pose[0] + length / 2, 1e-9 * length
    if abs(pose[1]) > slack or not -slack <= x <= length + slack:
        raise ValueError(
            "a frame of a flexible beam lies on its axis: {x, 0, phi} with x, from the middle, between "
            f"-{length / 2:g} and {length / 2:g} m, not {{{pose[0]:g}, {pose[1]:g}, ...}}"
        )
    return min(max(x, 0.0), length)
