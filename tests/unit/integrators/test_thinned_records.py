"""Records of the ends of steps: those that are dropped follow from the others, and none beside a blow is dropped."""

from types import SimpleNamespace

import numpy as np
import pytest

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.thinned_records import BENT, LEAST, MOST, thin
from mbdsl.kernels import buffer_layout as L
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.hermite import between

N = 400  #: steps


def kept(q, v, lam, t, rotations=()):
    """The rows that are left of states q, v (N, n) and lam (N, m) at times t."""
    rows = np.column_stack([t, q, v, lam])
    n, width = q.shape[1], rows.shape[1]
    layout = np.zeros(200, np.int64)
    layout[[L.N_Q, L.N_ALL, L.N_ROTATIONS, L.ROTATIONS]] = n, n + lam.shape[1], len(rotations), 150
    layout[150 : 150 + 2 * len(rotations) : 2] = rotations
    run = SimpleNamespace(
        reals=np.zeros(S.REALS + rows.size + n + lam.shape[1]),
        integers=np.zeros(S.INTEGERS, np.int64),
        vectors=np.ones((L.SCALE + 1, n)),
        layout=layout,
    )
    run.integers[[S.THIN, S.NOTES]] = LEAST, len(rows)
    for step, row in enumerate(rows):
        at = S.REALS + run.integers[S.NOTED] * width
        run.reals[at : at + width] = row
        run.integers[S.NOTED] += 1
        run.integers[S.STEP] = step
        if step % run.integers[S.THIN] == 0:
            thin(run)
            assert LEAST <= run.integers[S.THIN] <= MOST
    return run.reals[S.REALS : S.REALS + rows.size].reshape(-1, width)[: run.integers[S.NOTED]]


def test_dropped_states_follow_from_the_others():
    t = np.linspace(0.0, 1.0, N + 1)
    q, v = np.column_stack([np.sin(3 * t), t]), np.column_stack([3 * np.cos(3 * t), np.ones(N + 1)])
    lam = np.cos(3 * t)[:, None]
    left = kept(q, v, lam, t)
    assert len(left) < 0.5 * N  # where a coordinate turns, the way is short
    found = between(t, left[:, 0], left[:, 1:3], left[:, 3:5], left[:, 5:])
    for x, y, near in zip(found, (q, v, lam), (1e-7, 1e-5, 2 * BENT), strict=True):
        assert x == pytest.approx(y, abs=near)


@pytest.mark.parametrize("k", range(200, 200 + MOST + 1))
def test_a_blow_in_one_step_remains(k):
    """A force acts between the ends k and k + 1: both are left, and the multiplier there."""
    t = np.linspace(0.0, 1.0, N + 1)
    lam = np.where(np.arange(N + 1) == k + 1, 0.01 * N, 0.0)
    v = 1.0 + np.where(np.arange(N + 1) > k, 0.01, 0.0)
    q = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    left = kept(q[:, None], v[:, None], lam[:, None], t)
    assert {t[k], t[k + 1]} <= set(left[:, 0])
    assert left[:, 3].max() == 0.01 * N
    assert len(left) < 0.1 * N


def test_turns_in_space():
    """A body turns about a fixed axis by one radian; rotation vectors are multiples of it."""
    t, axis = np.linspace(0.0, 1.0, N + 1), np.array([2.0, -1.0, 2.0]) / 3.0
    angle, rate = np.sin(t), np.cos(t)
    left = kept(angle[:, None] * axis, rate[:, None] * axis, np.zeros((N + 1, 0)), t, (0,))
    assert len(left) < 0.2 * N
    q, v, _ = between(t, left[:, 0], left[:, 1:4], left[:, 4:7], np.zeros((len(left), 0)), np.array([0]))
    exact = rotation_arrays.matrices(angle[:, None] * axis)
    assert rotation_arrays.matrices(q) == pytest.approx(exact, abs=1e-7)
    assert v == pytest.approx(rate[:, None] * axis, abs=1e-5)
