"""Stops and contacts without stiffness `k`, which are rigid, against closed forms."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import ModelError

G = 9.81
SLIDER = """
{of}model Slider
  Ground ground(g = 0);
  Body b(m = 2 kg, I = {I});
  Prismatic s(ground, b.c);
  TranslationalStop stop(ground, b.c, s_min = 0 m, s_max = 1 m, {given});
initial equation
  s.s = 0.5 m; s.v = 1 m/s;
  annotation(experiment(StopTime = 5 s));
end Slider;
"""
PENDULUM = """
{of}model Pendulum
  Ground ground;
  Body b(m = 2 kg, I = {I}, frames(pin = {{-0.5 m, 0{zero}}}));
  Revolute p(ground, b.pin);
  RotationalStop stop(ground, b.pin, phi_min = 0, e = 0.6);
initial equation
  p.phi = 60 deg; p.w = 0 rad/s;
  annotation(experiment(StopTime = 20 s));
end Pendulum;
"""
SPACES = pytest.mark.parametrize("spatial", [False, True], ids=["plane", "space"])


def made(text, spatial, **given):
    """The model in the plane or in space; its motion is the same."""
    words = {"of": "spatial " * spatial, "I": "{0.1, 0.1, 0.1} kg.m2" if spatial else "0.1 kg.m2"}
    return mbdsl.parse(text.format(zero=", 0" * spatial, **words, **given))


@SPACES
def test_a_slider_between_two_stops(spatial):
    """It meets them at 0.5 s, 0.5 + 1/e s and 0.5 + 1/e + 1/e^2 s, and each time keeps e of its speed."""
    found = mbdsl.simulate(made(SLIDER, spatial, given="e = 0.8"), step=0.01, interval=0.01)
    times = np.array([0.5, 0.5 + 1 / 0.8, 0.5 + 1 / 0.8 + 1 / 0.64])
    count = (found.t[:, None] > times).sum(axis=1)
    away = np.abs(found.t[:, None] - times).min(axis=1) > 1e-6
    np.testing.assert_allclose(found["s.v"][away], (-0.8) ** count[away], rtol=1e-9)
    np.testing.assert_array_equal(found["stop.impacts"][away], count[away])
    assert found["stop.impulse_max"][-1] == pytest.approx(2 * 0.64 * 1.8)
    assert found["stop.impulse_min"][-1] == pytest.approx(2 * 0.8 * 1.8)
    starts = np.array([-0.5 / 1.0 + 0.5, *times])
    inside = np.where(count % 2 == 0, 0.0, 1.0) + (-0.8) ** count * (found.t - starts[count]) + 0.5 * (count == 0)
    np.testing.assert_allclose(found["stop.s"], inside, atol=1e-9)


def returns(w, e, start, phi):
    """Time of the n-th impact of a pendulum with phi'' = -k cos(phi), k = ``w``**2, from rest at ``phi``."""
    from scipy.integrate import quad

    def fall(top):  # time from the angle top to 0: phi' = sqrt(2 k (sin top - sin phi)), with sin phi = sin top (1-u^2)
        s = np.sin(top)
        return quad(lambda u: 2 * s * u / np.sqrt(1 - (s * (1 - u * u)) ** 2) / np.sqrt(2 * s * u * u), 0, 1)[0] / w

    t = start + fall(phi)
    while True:
        yield t, phi
        phi = np.arcsin(e * e * np.sin(phi))
        t += 2 * fall(phi)


@SPACES
def test_a_pendulum_on_a_stop_comes_to_rest(spatial):
    """phi'' = -(m g l/J) cos(phi); each impact leaves e^2 of the energy; at rest the torque of the stop is m g l."""
    found = mbdsl.simulate(made(PENDULUM, spatial), step=5e-3, stop=4.0, interval=1e-3)
    w = np.sqrt(2 * G * 0.5 / (0.1 + 2 * 0.25))
    impacts = found["stop.impacts"]
    expected = returns(w, 0.6, 0.0, np.pi / 3)
    for n in range(4):
        t, _ = next(expected)
        k = int(np.flatnonzero(impacts > n)[0])
        assert found.t[k - 1] - 1e-5 <= t <= found.t[k] + 1e-5
    assert found["stop.active"][-1] == 1.0
    assert found["stop.torque"][-1] == pytest.approx(-2 * G * 0.5)
    assert found["stop.frame_b.tau"][-1] == pytest.approx(2 * G * 0.5)
    np.testing.assert_allclose(found["p.phi"][-1], 0.0, atol=1e-9)


def test_a_stop_without_stiffness_or_restitution():
    with pytest.raises(ModelError, match=r"without `k` it is rigid, and needs `e`"):
        made(SLIDER, False, given="v_0 = 1 m/s")
    with pytest.raises(ModelError, match=r"`v_0` and `exponent` have no meaning"):
        made(SLIDER, False, given="e = 0.5, v_0 = 1 m/s")
    with pytest.raises(ModelError, match=r"e is 1.2, the coefficient of restitution must be between 0 and 1"):
        made(SLIDER, False, given="e = 1.2")
