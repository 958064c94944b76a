"""Poles, step and frequency responses of linear models against closed forms, and python-control."""

import numpy as np
import pytest

import mbdsl

TEXT = """model Carriage
  input Force u(start = 0 N);
  Ground ground(g = 0);
  Body cart(m = 2 kg, I = 1 kg.m2);
  Prismatic rail(ground, cart.c);
  TranslationalSpringDamper s(rail, k = 50 N/m, c = 4 N.s/m);
  Force push(cart.c, fx = u);
end Carriage;"""
W, D = 5.0, 0.2  # natural frequency [rad/s] and damping ratio


@pytest.fixture(scope="module")
def linear():
    return mbdsl.linearise(mbdsl.parse(TEXT), signals=["rail.s", "cart.ax"])


def test_poles(linear):
    expected = W * (-D + np.array([-1j, 1j]) * np.sqrt(1.0 - D**2))
    assert linear.poles() == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("t", [None, np.linspace(0.0, 3.0, 61), [0.3, 0.35, 1.0, 2.2]])
def test_step_response(linear, t):
    """x = F/k (1 - e^{-d w t} (cos w_d t + d/sqrt(1 - d^2) sin w_d t))."""
    found = linear.step_response(t)
    wd, d = W * np.sqrt(1.0 - D**2), D / np.sqrt(1.0 - D**2)
    x = (1.0 - np.exp(-D * W * found.t) * (np.cos(wd * found.t) + d * np.sin(wd * found.t))) / 50.0
    assert found.y[:, 0, 0] == pytest.approx(x, abs=1e-12)
    assert found.y.shape == (len(found.t), 2, 1)
    if t is None:
        assert found.t[0] == 0.0 and found.y[-1, 0, 0] == pytest.approx(1.0 / 50.0, rel=2e-3)


def test_frequency_response(linear):
    f = np.array([0.0, 0.3, W / (2.0 * np.pi), 4.0, 50.0])
    found, w = linear.bode(f), 2.0 * np.pi * f
    H = 1.0 / (50.0 - 2.0 * w**2 + 4j * w)
    assert found.amplitude[:, 0, 0] == pytest.approx(np.abs(H), rel=1e-12)
    assert found.phase[:, 0, 0] == pytest.approx(np.unwrap(np.angle(H)), abs=1e-12)
    assert found.amplitude[1:, 1, 0] == pytest.approx((w**2 * np.abs(H))[1:], rel=1e-9)
    assert len(linear.bode().f) == 501 and linear.bode().phase[-1, 0, 0] == pytest.approx(-np.pi, abs=0.05)


def test_python_control_takes_the_names(linear):
    control = pytest.importorskip("control")
    model = linear.to_control()
    assert model.state_labels == ["rail_s", "rail_v"] and model.output_labels == ["rail_s", "cart_ax"]
    assert np.sort_complex(control.poles(model)) == pytest.approx(np.sort_complex(linear.poles()))


def test_at_given_values():
    """A pendulum held at an angle: the stiffness m g l cos(phi) of the equations frozen there."""
    text = """model Pendulum
      Ground ground;
      PointMass ball(m = 2 kg);
      Rod rod(m = 0 kg, length = 1 m);
      Revolute pin(ground, rod.a);
      Fixed weld(rod.b, ball);
    end Pendulum;"""
    scene = mbdsl.parse(text)
    for degrees in (-90.0, 10.0):
        found = mbdsl.linearise(scene, {"pin.phi": f"{degrees} deg"})
        assert found.x0[0] == pytest.approx(np.radians(degrees))
        assert found.A[1, 0] == pytest.approx(9.81 * np.sin(np.radians(degrees)), abs=1e-9)


def test_what_makes_no_sense(linear):
    with pytest.raises(mbdsl.UsageError, match="ascend"):
        linear.step_response([1.0, 0.5])
    with pytest.raises(mbdsl.UsageError, match="not negative"):
        linear.bode([-1.0])
    with pytest.raises(mbdsl.UsageError, match=r"has no signal|no signal"):
        mbdsl.linearise(mbdsl.parse(TEXT), {"rail.phi": 1.0})


def test_the_times_of_a_run_have_a_name():
    run = mbdsl.simulate(mbdsl.parse(TEXT), stop=0.01, step=1e-3)
    assert run.time is run.t
