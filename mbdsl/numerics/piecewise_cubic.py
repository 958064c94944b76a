"""Piecewise cubics of a model's tables, for compiled code and for arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: order of the first derivative with corners, and of the first that is zero everywhere
SMOOTHNESS = {"linear": (0, 2), "monotone": (1, 4), "cubic": (2, 4)}


def piecewise(table) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Breaks (k,) and coefficients (k, 4), ascending powers of (u - break); the last row is for the end point."""
    u, y = np.array(table.u, float), np.array(table.y, float)
    if table.smoothness == "linear" or len(u) == 2:
        c = np.zeros((len(u) - 1, 4))
        c[:, 0], c[:, 1] = y[:-1], np.diff(y) / np.diff(u)
    else:
        from scipy.interpolate import CubicSpline, PchipInterpolator

        # not-a-knot requires four points, else a natural spline; periodic ends must meet exactly
        if table.smoothness == "monotone":
            spline = PchipInterpolator(u, y)
        elif table.extrapolation == "periodic" and y[0] == y[-1]:
            spline = CubicSpline(u, y, bc_type="periodic")
        else:
            spline = CubicSpline(u, y, bc_type="not-a-knot" if len(u) > 3 else "natural")
        c = spline.c[::-1].T.copy()
    return u, np.vstack([c, np.zeros((1, 4))])
