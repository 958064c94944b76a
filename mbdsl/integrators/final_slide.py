"""The end of sliding in several directions, where the direction turns ever faster as the speed becomes zero.

An implicit step across such an end has no solution, and one that ends shortly before it has, but Newton's iteration
does not find it. The motion from the last step to the end is integrated by the explicit method of order 4 of Nystroem
type, with steps that are a part of the time that is left.
"""

from __future__ import annotations

from typing import NamedTuple

from mbdsl.integrators.friction_set import At, FrictionSet
from mbdsl.integrators.start_values import onto_constraints
from mbdsl.kernels.arrays import Array

#: length of a step, relative to the time that is left; most of them
PART, MOST = 0.25, 200
#: the end is near if it is expected within this number of steps of the run
WITHIN = 2.0


class End(NamedTuple):
    """The time [s] from the last step to the end, and q and v (n,) there."""

    s: float
    q: Array
    v: Array


def final_slide(friction: FrictionSet, at: At, h: float) -> End | None:
    """The end of sliding of a joint that is expected within a few steps of length ``h`` [s]; None if there is none."""
    left = friction.time_left(at)
    if not left < WITHIN * h:
        return None
    s = 0.0
    for _ in range(MOST):
        step = PART * left
        q, v = _stepped(friction, at, step)
        s, at = s + step, at._replace(t=at.t + step, q=q, v=v)
        left = friction.time_left(at)
        if friction.stopped(at) or not s + left < 2.0 * WITHIN * h:
            break
    return End(s, at.q, at.v)


def _stepped(friction: FrictionSet, at: At, h: float) -> tuple[Array, Array]:
    """q and v after a step of length h [s]."""
    moved, v = friction.system.moved, at.v

    def rate(s: float, shift: Array, change: Array) -> Array:
        return friction.motion(at._replace(t=at.t + s, q=moved(at.q, shift), v=v + change), at.left_out)[0]

    a = rate(0.0, 0.0 * v, 0.0 * v)
    b = rate(h / 2, h / 2 * v + h * h / 8 * a, h / 2 * a)
    c = rate(h / 2, h / 2 * v + h * h / 8 * a, h / 2 * b)
    d = rate(h, h * v + h * h / 2 * c, h * c)
    q = moved(at.q, h * v + h * h / 6 * (a + b + c))
    return onto_constraints(friction.system, at.t + h, q, v + h / 6 * (a + 2 * b + 2 * c + d), at.left_out)
