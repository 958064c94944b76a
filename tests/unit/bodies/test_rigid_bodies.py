"""Frames on many rigid bodies at once: their motion, and its derivatives by differences."""

import numpy as np
import pytest

from mbdsl.bodies.rigid_body import Rigid

COUNT, STEP = 7, 1e-6
RNG = np.random.default_rng(4)
POSES = RNG.uniform(-1, 1, (COUNT, 3))
Q, V = RNG.uniform(-2, 2, (2, COUNT, 3))


def place(q):
    """Poses (COUNT, 3) by complex numbers: r + e^(i phi) s."""
    r = q[:, 0] + 1j * q[:, 1] + np.exp(1j * q[:, 2]) * (POSES[:, 0] + 1j * POSES[:, 1])
    return np.stack([r.real, r.imag, q[:, 2] + POSES[:, 2]], axis=1)


def test_poses_and_rates():
    z, rates, _, _ = Rigid.gradients(POSES, Q, V)
    assert z == pytest.approx(place(Q), abs=1e-14)
    # central differences: the error is STEP^2 of third derivatives, and rounding / STEP
    assert rates == pytest.approx((place(Q + STEP * V) - place(Q - STEP * V)) / (2 * STEP), abs=1e-8)


@pytest.mark.parametrize("j", range(3))
def test_derivatives(j):
    _, _, B, of_rates = Rigid.gradients(POSES, Q, V)
    e = STEP * np.eye(3)[j]
    assert B[:, :, j] == pytest.approx((place(Q + e) - place(Q - e)) / (2 * STEP), abs=1e-8)
    after, before = (Rigid.gradients(POSES, q, V)[1] for q in (Q + e, Q - e))
    assert of_rates[:, :, j] == pytest.approx((after - before) / (2 * STEP), abs=1e-8)
