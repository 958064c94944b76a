"""Records of the ends of steps without those that follow from their neighbours by interpolation.

Steps are often much shorter than interpolation needs. As long as the last state but one follows from the one before it
and the last, by the cubic Hermite polynomials of :mod:`mbdsl.numerics.hermite`, it is dropped. The intervals on both
sides of it have to be alike in length: a longer one is made of two only if the motion within both is smooth.
"""

from __future__ import annotations

from mbdsl.integrators.loop import loop_state as S
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import untangled

#: largest errors of a coordinate, and of the interval times its velocity, and largest cubic term, relative to the way
#: at the larger of both speeds; smallest way that counts, relative to the mechanism
OF_Q, OF_V, CUBIC, TINY = 2e-7, 3e-6, 1e-3, 1e-12
#: largest deviation of a multiplier from the straight line, relative to its value; to the largest multiplier
BENT, SMALL = 1e-3, 1e-9
#: largest way within an interval, in radians and relative to the mechanism: turns are counted from end to end
LONGEST = 0.5
LEAST, MOST = 4, 8  #: numbers of steps that are examined together


@rare
def thin(run):
    """Drop records before the last that follow from their neighbours.

    Called after every THIN steps. Of their records, the middle one represents the others, as a force that acts in one
    step only leaves other velocities. If it follows, more steps are examined next time, else fewer.
    """
    integers, layout = run.integers, run.layout
    width, half, together = 1 + layout[L.N_Q] + layout[L.N_ALL], integers[S.THIN] // 2, LEAST
    last = S.REALS + (integers[S.NOTED] - 1) * width
    while half > 0:
        way = half * width
        if integers[S.NOTED] > 2 * half and follows(last - 2 * way, last - way, last, run):
            if half > 1:
                grows = 2 * half == integers[S.THIN] and integers[S.STEP] & (4 * half - 1) == 0
                together = 4 * half if grows else 2 * half
            last, half = drop(2 * half - 1, last, width, run), 1
        else:
            half = half // 2
    integers[S.THIN] = min(MOST, together)


@kernel
def drop(count, last, width, run):
    """Drop so many records before the last one; the new place of this."""
    reals = run.reals
    there = last - count * width
    for i in range(width):
        reals[there + i] = reals[last + i]
    run.integers[S.NOTED] -= count
    return there


@kernel
def follows(a, b, c, run):
    """Whether the record at b of ``reals`` follows from those at a and c."""
    reals, layout, scale = run.reals, run.layout, run.vectors[L.SCALE]
    n, size, h, x = layout[L.N_Q], layout[L.N_ALL], reals[c] - reals[a], reals[b] - reals[a]
    if not (0.33 * h < x < 0.67 * h):
        return False
    x /= h
    q0, q, q1 = reals[a + 1 :], reals[b + 1 :], reals[c + 1 :]
    v0, v, v1 = reals[a + 1 + n :], reals[b + 1 + n :], reals[c + 1 + n :]
    i = r = 0
    while i < n:
        if r < layout[L.N_ROTATIONS] and i == layout[layout[L.ROTATIONS] + 2 * r]:
            x0, y0, z0 = untangled(q0[i:], v0[i], v0[i + 1], v0[i + 2])
            xb, yb, zb = untangled(q[i:], v[i], v[i + 1], v[i + 2])
            x1, y1, z1 = untangled(q1[i:], v1[i], v1[i + 1], v1[i + 2])
            if (
                cubic(x, h, q0[i], q[i], q1[i], x0, xb, x1, scale[i]) > 0.0
                or cubic(x, h, q0[i + 1], q[i + 1], q1[i + 1], y0, yb, y1, scale[i + 1]) > 0.0
                or cubic(x, h, q0[i + 2], q[i + 2], q1[i + 2], z0, zb, z1, scale[i + 2]) > 0.0
            ):
                return False
            i, r = i + 3, r + 1
        else:
            if cubic(x, h, q0[i], q[i], q1[i], v0[i], v[i], v1[i], scale[i]) > 0.0:
                return False
            i += 1
    largest = 0.0
    for i in range(n, size):
        largest = max(largest, abs(v0[i]))
    for i in range(n, size):
        bent = abs(v0[i] + x * (v1[i] - v0[i]) - v[i])
        if not bent <= BENT * max(abs(v0[i]), abs(v1[i])) + SMALL * largest:
            return False
    return True


@kernel
def cubic(x, h, q0, q, q1, v0, v, v1, scale):
    """0 if q and v at the part x of a short way h are those of the cubic polynomial through its ends, else 1.

    The error of the polynomial may vanish there; its cubic term bounds the interval in that case.
    """
    w0, w1, d = h * v0, h * v1, q1 - q0
    c2, c3, way = 3.0 * d - 2.0 * w0 - w1, w0 + w1 - 2.0 * d, max(abs(w0), abs(w1))
    if not scale * way <= LONGEST:
        return 1.0
    of_q = scale * (abs(q0 + x * (w0 + x * (c2 + x * c3)) - q) - OF_Q * way)
    of_v = scale * (abs(w0 + x * (2.0 * c2 + x * 3.0 * c3) - h * v) - OF_V * way)
    return 0.0 if max(of_q, of_v, scale * (abs(c3) - CUBIC * way)) <= TINY else 1.0
