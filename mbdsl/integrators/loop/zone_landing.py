"""Steps that end in zones around peaks of laws, and notes of where they ended: see
:mod:`mbdsl.integrators.peak_zones`."""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import N_ALL, N_Q, Q0, V0, XA
from mbdsl.compilation.marks import rare
from mbdsl.integrators.loop.loop_state import K_SIZE, NEXT_ZONE, NOTED, NOW, ZONE, ZONES, T


@rare
def until_zone(h, K, J):
    """The step h, or the part of it that ends in the middle of the next zone, if it would pass that; 0 where more zones
    have to be asked for."""
    while J[NEXT_ZONE] < J[ZONES] and K[NOW] >= K[ZONE + 2 * J[NEXT_ZONE]]:
        J[NEXT_ZONE] += 1
    if J[NEXT_ZONE] == J[ZONES]:
        return 0.0
    start, end = K[ZONE + 2 * J[NEXT_ZONE]], K[ZONE + 2 * J[NEXT_ZONE] + 1]
    return h if K[NOW] + h <= end else 0.5 * (start + end) - K[NOW]


@rare
def note(K, J, Y, I):
    """The state at the end of a step, to be looked at later."""
    n, size = I[N_Q], I[N_ALL]
    o = K_SIZE + J[NOTED] * (1 + n + size)
    K[o] = K[T]
    for i in range(n):
        K[o + 1 + i], K[o + 1 + n + i] = Y[Q0, i], Y[V0, i]
    for i in range(n, size):
        K[o + 1 + n + i] = Y[XA, i]
    J[NOTED] += 1
