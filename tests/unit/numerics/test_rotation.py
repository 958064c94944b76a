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


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 0.999, 1.001, 2.0, 3.1])
def test_second_rates_of_charts(plain, angle):
    """psi(t) = psi + psi' t + psi'' t^2/2: Omega against central differences of SciPy's rotations, and psi'' from Omega
    and Omega'.

    Differences over 1e-5 s have errors of 1e-10 in Omega. Over 1e-2 s, those of order 4 have errors of
    1e-8 |Omega^(5)|/30 in Omega'."""
    rng = np.random.default_rng(4)
    n = rng.normal(size=3)
    psi, rate, second = angle * n / np.linalg.norm(n), rng.normal(size=3), rng.normal(size=3)

    def at(t):
        return psi + rate * t + second * t * t / 2

    def spin(t, h=1e-5):
        turn = Rotation.from_rotvec(at(t - h)).inv() * Rotation.from_rotvec(at(t + h))
        return turn.as_rotvec() / (2 * h)

    tangled = plain(rotation.tangled)
    np.testing.assert_allclose(tangled(psi, *rate), spin(0.0), atol=1e-9)
    h = 1e-2
    of = [np.array(tangled(at(k * h), *(rate + second * k * h))) for k in (-2, -1, 1, 2)]
    np.testing.assert_allclose(of, [spin(k * h) for k in (-2, -1, 1, 2)], atol=1e-9)
    turning = (of[0] - 8 * of[1] + 8 * of[2] - of[3]) / (12 * h)
    found = plain(rotation.chart_acceleration)(psi, np.array(tangled(psi, *rate)), *turning)
    np.testing.assert_allclose(found, second, atol=1e-6)
    np.testing.assert_allclose(plain(rotation.spin_acceleration)(psi, rate, *second), turning, atol=1e-6)


def test_forces_on_rotation_vectors(plain):
    """The power of a torque is that of T(psi)^T torque on psi'; the inverse returns the torque."""
    for psi, rate, torque in zip(vectors(), vectors(ANGLES[::-1]), vectors(ANGLES[3:] + ANGLES[:3]), strict=True):
        force = np.array(plain(rotation.tangled_back)(psi, *torque))
        assert force @ rate == pytest.approx(torque @ plain(rotation.tangled)(psi, *rate), abs=1e-14)
        np.testing.assert_allclose(plain(rotation.untangled_back)(psi, *force), torque, atol=1e-14)
