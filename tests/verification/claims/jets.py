"""Numbers with their first and second derivative along one parameter: velocities and accelerations of poses.

Written for the references of this folder alone; nothing of it is shared with mbdsl.
"""

from __future__ import annotations

import numpy as np


class Jet:
    """f, f', f'' along one parameter; floats or arrays."""

    __slots__ = ("d", "e", "f")

    def __init__(self, f, d=0.0, e=0.0):
        self.f, self.d, self.e = f, d, e

    def __add__(self, o):
        o = jet(o)
        return Jet(self.f + o.f, self.d + o.d, self.e + o.e)

    def __neg__(self):
        return Jet(-self.f, -self.d, -self.e)

    def __sub__(self, o):
        return self + (-jet(o))

    def __rsub__(self, o):
        return jet(o) + (-self)

    def __mul__(self, o):
        o = jet(o)
        return Jet(self.f * o.f, self.d * o.f + self.f * o.d, self.e * o.f + 2 * self.d * o.d + self.f * o.e)

    def __truediv__(self, o):
        return self * chain(jet(o), lambda x: (1 / x, -1 / x**2, 2 / x**3))

    def __rtruediv__(self, o):
        return jet(o) / self

    __radd__, __rmul__ = __add__, __mul__


def jet(x) -> Jet:
    return x if isinstance(x, Jet) else Jet(x, 0.0 * x, 0.0 * x)


def chain(x: Jet, derivatives) -> Jet:
    """f(x), where ``derivatives(x)`` gives f, f' and f''."""
    f, d, e = derivatives(x.f)
    return Jet(f, d * x.d, e * x.d**2 + d * x.e)


def sin(x):
    return chain(jet(x), lambda x: (np.sin(x), np.cos(x), -np.sin(x)))


def cos(x):
    return chain(jet(x), lambda x: (np.cos(x), -np.sin(x), -np.cos(x)))


def sqrt(x):
    return chain(jet(x), lambda x: (np.sqrt(x), 0.5 / np.sqrt(x), -0.25 / np.sqrt(x) ** 3))


def asin(x):
    return chain(jet(x), lambda x: (np.arcsin(x), (1 - x * x) ** -0.5, x * (1 - x * x) ** -1.5))


def acos(x):
    return np.pi / 2 - asin(x)


def atan2(y, x):
    """The angle of (x, y); its derivatives follow from x' y'' and the like."""
    y, x = jet(y), jet(x)
    r = x.f**2 + y.f**2
    d = (x.f * y.d - y.f * x.d) / r
    e = (x.f * y.e - y.f * x.e) / r - 2 * d * (x.f * x.d + y.f * y.d) / r
    return Jet(np.arctan2(y.f, x.f), d, e)
