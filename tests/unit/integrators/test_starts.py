"""Initial values of methods and their transfer from step to step, compared with Taylor expansions of known motions:
polynomials of the degree up to which a formula is exact, and a cosine for the order."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError
from mbdsl.integrators import start_values
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.method import Start
from mbdsl.integrators.methods import generalized_alpha_i3, hht_i3, nstiff
from mbdsl.kernels import buffer_layout as L
from mbdsl.system.system import build

T0 = 0.4


def plain(kernel):
    return kernel


def start(h, *derivatives):
    """The motion at T0, from q and its first three derivatives as functions."""
    q, v, a, jerk = (np.array([f(T0)]) for f in derivatives)
    return Start(h, q, v, a, np.zeros(0), a, jerk, jerk, False)


def of_polynomial(*coefficients):
    p = np.polynomial.Polynomial(coefficients)
    return [p.deriv(k) if k else p for k in range(4)]


WAVE = (np.sin, np.cos, lambda t: -np.sin(t), lambda t: -np.cos(t))


@pytest.mark.parametrize("alpha", [-0.05, -0.3])
def test_hht_i3_begins_with_the_acceleration_at_its_node(alpha):
    """It equals q''(t_0 + alpha h), except for the square of alpha h times q''''/2."""
    for h in (0.1, 0.01):
        c = hht_i3.coefficients({"alpha": alpha})
        (a,) = hht_i3.begin(np.array(c), start(h, *WAVE))[L.UNKNOWN0]
        assert abs(a + np.sin(T0 + alpha * h)) <= 0.5 * (alpha * h) ** 2


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_generalized_alpha_i3_carries_the_acceleration_at_its_node(rho):
    """A_n belongs to t_n + (alpha_m - alpha_f) h, with alpha_m - alpha_f = (rho - 1)/(rho + 1); with another h as well:
    exactly so where accelerations are linear in time. Chung, Hulbert (1993), eq. (25)."""
    a = of_polynomial(0.3, -1.0, 0.7, 1.9)[2]
    c, node = np.array(generalized_alpha_i3.coefficients({"rho": rho})), (rho - 1) / (rho + 1)
    h, other, before = 0.1, 0.17, 0.08
    rows = generalized_alpha_i3.begin(c, start(h, *of_polynomial(0.3, -1.0, 0.7, 1.9)))
    (carried,) = rows[generalized_alpha_i3.CARRIED]
    assert carried == pytest.approx(a(T0 + node * h), rel=1e-14)
    reals, Y, layout = np.zeros(S.REALS), np.zeros((L.ROWS, 1)), np.zeros(L.N_Q + 1, int)
    layout[L.N_Q], reals[S.STEP_SIZE], reals[S.NODES], reals[S.NODES + 1] = (
        1,
        h,
        T0,
        T0 - before,
    )
    Y[L.UNKNOWN0, 0], Y[L.UNKNOWN0 + 1, 0], Y[generalized_alpha_i3.CARRIED, 0] = a(T0), a(T0 - before), carried
    run = SimpleNamespace(coefficients=c, reals=reals, vectors=Y, layout=layout)
    plain(generalized_alpha_i3.shift)(other, run)
    assert Y[generalized_alpha_i3.CARRIED, 0] == pytest.approx(a(T0 + node * other), rel=1e-13)


def test_nstiff_begins_with_the_step_before():
    """q of degree 3, and v of degree 2, exactly."""
    h, motion = 0.13, of_polynomial(0.3, -1.0, 0.7, 1.9)
    rows = nstiff.before(start(h, *motion))
    assert rows[L.KEPT] == pytest.approx(motion[0](T0 - h), rel=1e-14)
    assert rows[L.KEPT2] == pytest.approx(motion[1](T0 - h), rel=1e-14)


def test_rates_at_the_start_are_of_order_two():
    """A one-sided difference of three points is exact for a parabola; of a sine it errs by e^2/3 and some e^3."""
    p = np.polynomial.Polynomial([0.3, -1.0, 0.7])
    found = start_values.rate(lambda s: np.array([p(s)]), np.array([p(0.0)]), 0.05)
    assert found == pytest.approx(p.deriv()(0.0), rel=1e-13)
    for e in (0.1, 0.01):
        (found,) = start_values.rate(lambda s: np.array([np.sin(T0 + s)]), np.array([np.sin(T0)]), e)
        assert abs(found - np.cos(T0)) < 0.5 * e**2


class Stiff:
    """A coordinate with a spring."""

    n = 1

    def __init__(self, w):
        self.w = w

    def stiffness(self, *at):
        return np.array([[2.0 * self.w**2]])

    def M(self, *at):
        return np.array([[2.0]])

    def names(self):
        return ["lump.x"]


@pytest.mark.parametrize("h", [1e-2, 1e-5])
def test_what_is_stiff_beyond_300_is_refused(h):
    """docs/methods.md promises h omega = 300: M^-1 Q is 1e5 times the motion, and has five digits less."""
    at = (0.0, h, np.zeros(1), np.zeros(1), np.zeros(0))
    start_values.check_stiffness(Stiff(299.0 / h), "hht-add", *at)
    with pytest.raises(InitialisationError, match=r"lump.x has .* 301 times 1/h"):
        start_values.check_stiffness(Stiff(301.0 / h), "hht-add", *at)


@pytest.mark.parametrize("v", [0.0, 1.5, -1.5])
def test_one_newton_step_onto_the_constraints(v):
    """A pendulum off its circle by d: what one step leaves is of the size of d^2, in position and in velocity."""
    text = """model Pendulum
      Ground ground;
      PointMass ball(m = 2 kg);
      Distance rod(ground, ball, length = 1 m);
    initial equation
      ball.x = 1 m; ball.y = 0 m;
    end Pendulum;"""
    system, left = build(mbdsl.parse(text)), []
    for d in (1e-2, 1e-3):
        q, w = start_values.onto_constraints(system, 0.0, np.array([1.0 + d, 0.2 * d]), np.array([d, v]), ())
        left.append(np.abs([np.hypot(*q) - 1.0, q @ w]))
    assert np.all(left[0] < 1e-3) and np.all(left[1] <= 0.011 * left[0] + 1e-15)


@pytest.mark.parametrize("rounding", [0.0, 1e-60, 1e-20])
def test_an_acceleration_that_is_rounding_is_no_scale_for_the_first_step(rounding):
    """A mass of W = 2 rad/s passes its rest position with 1 m/s: the jerk is -4 m/s3, the acceleration zero. The step
    of hht-i3 errs by some h^3 W^3, here 1e-6, so that 5 ms would do; where no rate is known, one of 1/e is assumed,
    and the step grows soon."""
    a, jerk, one = np.array([rounding]), np.array([-4.0]), np.ones(1)
    c = np.array(hht_i3.coefficients({"alpha": -0.3}))
    error = partial(hht_i3.local_error, 0.1, 0.1, c)
    h = start_values.first_step(0.1, error, 1e-6, 1 / 3, (one, 1.0, 10.0), a, jerk, 1e-5)
    assert 1e-4 < h < 1.5e-2
