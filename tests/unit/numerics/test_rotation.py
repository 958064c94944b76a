"""Rotations: kernels against arrays, and both against SciPy's rotations and differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbdsl.numerics import rotation, rotation_arrays

#: rotation vectors of angles from rounding to nearly half a turn
ANGLES = [0.0, 1e-170, 1e-9, 5e-3, 9.99e-3, 1.001e-2, 0.3, 2.0, 3.1]


def vectors(angles=ANGLES):
    n = np.random.default_rng(0).normal(size=(len(angles), 3))
    return np.array(angles)[:, None] * n / np.linalg.norm(n, axis=1, keepdims=True)


def test_arrays_agree_with_scipy():
    psi = vectors()
    other = Rotation.from_rotvec(psi)
    np.testing.assert_allclose(rotation_arrays.matrices(psi), other.as_matrix(), atol=1e-15)
    np.testing.assert_allclose(rotation_arrays.vectors(rotation_arrays.quaternions(psi)), psi, atol=1e-15)
    np.testing.assert_allclose(rotation_arrays.vectors(-rotation_arrays.quaternions(psi)), psi, atol=1e-15)
    for R, p in zip(other.as_matrix(), psi, strict=True):
        np.testing.assert_allclose(rotation_arrays.of_matrix(R), p, atol=1e-7 if np.linalg.norm(p) > 3 else 1e-14)
    more = vectors(ANGLES[::-1])
    np.testing.assert_allclose(
        Rotation.from_rotvec(rotation_arrays.turned(psi, more)).as_matrix(),
        (other * Rotation.from_rotvec(more)).as_matrix(),
        atol=1e-15,
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_kernels_agree_with_arrays(plain, sign):
    """Quaternions of both signs, which are the same rotation."""
    attitude, logarithm, composed = plain(rotation.attitude), plain(rotation.logarithm), plain(rotation.composed)
    base = sign * rotation_arrays.quaternions(np.array([0.7, -1.9, 0.4]))
    R = np.zeros(9)
    for psi in vectors():
        attitude(psi, base, R)
        expected = rotation_arrays.matrices(np.array([0.7, -1.9, 0.4])) @ rotation_arrays.matrices(psi)
        np.testing.assert_allclose(R.reshape(3, 3), expected, atol=2e-15)
        found = logarithm(*composed(base, *psi))
        np.testing.assert_allclose(rotation_arrays.matrices(np.array(found)), expected, atol=2e-15)
        assert np.linalg.norm(found) <= np.pi + 1e-15


def test_tangent_of_the_exponential(plain):
    """T relates rates of psi to angular velocities: central differences of attitudes, with an error of h^2."""
    psi, rate, h = vectors(), vectors(ANGLES[::-1]), 1e-5
    before, after = rotation_arrays.matrices(psi - h * rate), rotation_arrays.matrices(psi + h * rate)
    W = np.swapaxes(rotation_arrays.matrices(psi), 1, 2) @ (after - before) / (2 * h)
    spin = np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], axis=1)
    np.testing.assert_allclose(rotation_arrays.to_spin(psi, rate), spin, atol=1e-8)
    np.testing.assert_allclose(rotation_arrays.from_spin(psi, rotation_arrays.to_spin(psi, rate)), rate, atol=1e-14)
    T = np.zeros(9)
    for p, w, r in zip(psi, rotation_arrays.to_spin(psi, rate), rate, strict=True):
        plain(rotation.inverse_tangent)(p, T)
        np.testing.assert_allclose(T.reshape(3, 3) @ w, r, atol=1e-14)
        np.testing.assert_allclose(plain(rotation.untangled)(p, *w), r, atol=1e-14)
