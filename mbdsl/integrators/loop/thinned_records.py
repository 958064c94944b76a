"""Records of the ends of steps without those that follow from their neighbours by interpolation.

Steps are often much shorter than interpolation needs. A state is dropped if it follows from one before and one behind
it by the cubic Hermite polynomials of :mod:`mbdsl.numerics.hermite`. The intervals on both sides of it have to be alike
in length: a longer one is made of two only if the motion within both is smooth.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import composed, half, logarithm, untangled

#: largest errors of a coordinate, and of the interval times its velocity, and largest cubic term, relative to the way
#: at the larger of both speeds; smallest way that counts, relative to the mechanism
OF_Q, OF_V, CUBIC, TINY = 1e-6, 2e-5, 1e-3, 1e-12
#: largest deviation of a multiplier from the straight line, relative to its value; to the largest multiplier
BENT, SMALL = 1e-3, 1e-9
#: part of the recent largest speed or multiplier below which errors are relative to that; its decrease in each call
SHARE, FADE = 0.3, 0.998
#: largest way within an interval, in radians and relative to the mechanism: turns are counted from end to end
LONGEST = 0.5
LEAST, MOST = 4, 16  #: numbers of steps that are examined together


@rare
def thin(run):
    """Drop records before the last that follow from their neighbours.

    Called after every THIN steps. Of their records, the middle one represents the others, as a force that acts in one
    step only leaves other velocities. If it does not follow, the same is asked of halves, quarters, ... of them.
    """
    integers, layout = run.integers, run.layout
    width = 1 + layout[L.N_Q] + layout[L.N_ALL]
    count = min(integers[S.THIN], integers[S.NOTED] - 1)
    first = S.REALS + (integers[S.NOTED] - 1 - count) * width
    there, i, longest = first, 0, 1
    note_sizes(first + count * width, width, run)
    while i < count:
        some, a = integers[S.THIN], first + i * width
        while some > 1 and (
            some > count - i or i & (some - 1) != 0 or not follows(a, a + some // 2 * width, a + some * width, run)
        ):
            some = some // 2
        there = move(a + some * width, there + width, width, run)
        i, longest = i + some, max(longest, some)
    integers[S.NOTED] -= count - (there - first) // width
    if longest < integers[S.THIN]:
        integers[S.THIN] = max(LEAST, 2 * longest)
        return
    while integers[S.NOTED] > 2 and follows(there - 2 * width, there - width, there, run):
        there = move(there, there - width, width, run)
        integers[S.NOTED] -= 1
    if 2 * longest <= MOST and integers[S.STEP] & (2 * longest - 1) == 0:
        integers[S.THIN] = 2 * longest


@kernel
def note_sizes(last, width, run):
    """Update the recent largest speeds and multipliers, which are behind the records, by the record at ``last``."""
    reals, n = run.reals, run.layout[L.N_Q]
    seen, now = reals[S.REALS + run.integers[S.NOTES] * width :], reals[last + 1 + n :]
    for i in range(run.layout[L.N_ALL]):
        seen[i] = max(FADE * seen[i], abs(now[i]))


@kernel
def move(a, b, width, run):
    """Move the record at a of ``reals`` to b, which is returned."""
    reals = run.reals
    if a != b:
        for i in range(width):
            reals[b + i] = reals[a + i]
    return b


@kernel
def follows(a, b, c, run):
    """Whether the record at b of ``reals`` follows from those at a and c."""
    reals, integers, layout, scale = run.reals, run.integers, run.layout, run.vectors[L.SCALE]
    n, size, h, x = layout[L.N_Q], layout[L.N_ALL], reals[c] - reals[a], reals[b] - reals[a]
    if not (0.33 * h < x < 0.67 * h):
        return False
    seen = reals[S.REALS + integers[S.NOTES] * (1 + n + size) :]
    share = SHARE * h
    x /= h
    q0, q, q1 = reals[a + 1 :], reals[b + 1 :], reals[c + 1 :]
    v0, v, v1 = reals[a + 1 + n :], reals[b + 1 + n :], reals[c + 1 + n :]
    i = r = 0
    while i < n:
        if r < layout[L.N_ROTATIONS] and i == layout[layout[L.ROTATIONS] + 2 * r]:
            if turns((x, h), (q0[i:], q[i:], q1[i:]), (v0[i:], v[i:], v1[i:]), share, seen[i:], scale[i]) > 0.0:
                return False
            i, r = i + 3, r + 1
        else:
            if cubic((x, h), (q0[i], q[i], q1[i]), (v0[i], v[i], v1[i]), share * seen[i], scale[i]) > 0.0:
                return False
            i += 1
    largest = 0.0
    for i in range(n, size):
        largest = max(largest, seen[i])
    for i in range(n, size):
        bent = abs(v0[i] + x * (v1[i] - v0[i]) - v[i])
        if not bent <= BENT * max(abs(v0[i]), abs(v1[i]), SHARE * seen[i]) + SMALL * largest:
            return False
    return True


@kernel
def turns(way, qs, vs, share, seen, scale):
    """As ``cubic``, for a rotation: the coordinates are the rotation vector from the attitude at the earlier end."""
    (q0, q, q1), (v0, v, v1) = qs, vs
    c, s = half(q0[0], q0[1], q0[2])
    base = (c, -s * q0[0], -s * q0[1], -s * q0[2])
    p0, p1, p2, p3 = composed(base, q[0], q[1], q[2])
    a, b, c = logarithm(p0, p1, p2, p3)
    u, w, z = untangled((a, b, c), v[0], v[1], v[2])
    p0, p1, p2, p3 = composed(base, q1[0], q1[1], q1[2])
    a1, b1, c1 = logarithm(p0, p1, p2, p3)
    u1, w1, z1 = untangled((a1, b1, c1), v1[0], v1[1], v1[2])
    return (
        cubic(way, (0.0, a, a1), (v0[0], u, u1), share * seen[0], scale)
        + cubic(way, (0.0, b, b1), (v0[1], w, w1), share * seen[1], scale)
        + cubic(way, (0.0, c, c1), (v0[2], z, z1), share * seen[2], scale)
    )


@kernel
def cubic(way, qs, vs, least, scale):
    """0 if q and v at a part x of a short time h are those of the cubic polynomial through its ends, else 1.

    ``way`` is (x, h); ``qs`` and ``vs`` are q and v at the earlier end, there, and at the later end. The error of the
    polynomial may vanish there; its cubic term bounds the interval in that case.
    """
    (x, h), (q0, q, q1), (v0, v, v1) = way, qs, vs
    w0, w1, d = h * v0, h * v1, q1 - q0
    c2, c3, size = 3.0 * d - 2.0 * w0 - w1, w0 + w1 - 2.0 * d, max(abs(w0), abs(w1))
    if not scale * size <= LONGEST:
        return 1.0
    size = max(size, least)
    of_q = scale * (abs(q0 + x * (w0 + x * (c2 + x * c3)) - q) - OF_Q * size)
    of_v = scale * (abs(w0 + x * (2.0 * c2 + x * 3.0 * c3) - h * v) - OF_V * size)
    return 0.0 if max(of_q, of_v, scale * (abs(c3) - CUBIC * size)) <= TINY else 1.0
