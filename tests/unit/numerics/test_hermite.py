"""Interpolation between the steps of a motion: exact for the polynomials of its degree, of order 4 for others."""

import numpy as np
import pytest

from mbdsl.numerics.hermite import between


def states(t, position, rate):
    return position(t)[:, None], rate(t)[:, None], (2.0 + 3.0 * t)[:, None]


def test_cubic_motions_are_exact():
    known, t = np.array([-1.0, 0.5, 0.75, 2.0]), np.linspace(-1.0, 2.0, 61)
    position, rate = np.poly1d([0.7, -1.3, 0.2, 5.0]), np.poly1d([2.1, -2.6, 0.2])
    q, v, lam = between(t, known, *states(known, position, rate))
    expected = states(t, position, rate)
    for found, want in zip((q, v, lam), expected, strict=True):
        np.testing.assert_allclose(found, want, rtol=0.0, atol=1e-13 * np.abs(want).max())


@pytest.mark.parametrize("steps", [8, 16, 32])
def test_order_four_with_the_constant_of_the_theory(steps):
    """The error is h^4/384 times the fourth derivative, here the sine, in the middle of an interval."""
    h = 1.0 / steps
    known = np.linspace(0.0, 1.0, steps + 1)
    middle = known[:-1] + h / 2
    q, _, _ = between(middle, known, *states(known, np.sin, np.cos))
    error = np.sin(middle) - q[:, 0]
    assert error == pytest.approx(h**4 / 384 * np.sin(middle), rel=h**2)  # the next term is h^2/40 of it


def test_known_states_are_returned_to_the_bit():
    known = np.array([0.0, 0.1, 0.3])
    given = states(known, np.sin, np.cos)
    for found, want in zip(between(known, known, *given), given, strict=True):
        assert np.array_equal(found, want)


def test_a_single_state():
    q, v, lam = between(np.array([0.0, 1.0]), np.array([0.0]), np.ones((1, 2)), np.zeros((1, 2)), np.ones((1, 1)))
    assert q.tolist() == [[1.0, 1.0]] * 2 and v.tolist() == [[0.0, 0.0]] * 2 and lam.tolist() == [[1.0]] * 2


@pytest.mark.parametrize("q0", [0.375, 1000.0])
def test_velocities_within_the_width_of_an_event(q0):
    """Both sides of an event have the same q, or one that differs by rounding; v changes by nothing between them."""
    t = np.array([0.0, 0.5, 0.5 + 2e-14, 1.0])
    q, v = np.array([[0.0], [q0], [q0], [q0 + 1.0]]), np.array([[0.0], [1.5], [1.5 - 1e-13], [1.0]])
    found = between(np.array([0.5 + 1e-14]), t, q, v, np.zeros((4, 0)))
    assert found[0][0, 0] == pytest.approx(q0, rel=1e-12)
    assert found[1][0, 0] == pytest.approx(1.5, rel=1e-9)
