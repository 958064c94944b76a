"""Screws, and drivers on the free coordinates of joints in space, against closed forms."""

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import modules

METHODS = [name for name, module in modules().items() if module.METHOD.chosen and not hasattr(module, "take")]
G = 9.81
M, J, PITCH = 2.0, np.array([0.01, 0.02, 0.03]), 0.05
OFF = np.array([0.1, 0.05])  #: of the centre of mass from the axis


def nut(pitch=PITCH, start="thread.s = 0.12 m; thread.v = 0 m/s;", eye="c", more=""):
    """A nut on a vertical spindle through its centre of mass, or through its frame "eye"."""
    return f"""spatial model Nut
      Ground ground;
      Body nut(m = {M}, I = {{{J[0]}, {J[1]}, {J[2]}}}, frames(eye = {{{OFF[0]}, 0, {OFF[1]}}} m));
      Screw thread(ground, nut.{eye}, n = {{0, 1, 0}}, pitch = {pitch} m);
      {more}
    initial equation
      {start}
    end Nut;"""


def acceleration(pitch, off=0.0 * OFF):
    """-g m/(m + J/h^2), with J about the axis and h = pitch/(2 pi)."""
    return -G / (1 + (J[1] + M * off @ off) / M * (2 * np.pi / pitch) ** 2)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pitch", [PITCH, -0.4])
def test_a_nut_falls_along_its_spindle(pitch, method):
    """s = s0 + a t^2/2, and the angle is s/h. Methods of order 2 are exact for constant accelerations, up to their
    starts, with errors of a h^2; newmark, whose gamma is 0.6, has s by a h t/20 off."""
    t = mbdsl.simulate(mbdsl.parse(nut(pitch)), method=method, step=1e-3, stop=0.8, interval=0.1)
    a = acceleration(pitch)
    bound = 1e-4 * abs(a) if method == "newmark" else 2e-6 * abs(a) + 1e-12
    np.testing.assert_allclose(t["thread.s"], 0.12 + a * t.t**2 / 2, rtol=0, atol=bound)
    np.testing.assert_allclose(t["thread.phi"], 2 * np.pi * t["thread.s"] / pitch, rtol=1e-13)
    np.testing.assert_allclose(t["nut.wy"], t["thread.w"], rtol=0, atol=1e-6 * abs(t["thread.w"]).max())


def test_the_thread_carries_thrust_and_torque():
    """F = m (g + a) along the axis, and the torque J a/h about it, which has the moment of the centripetal force."""
    t = mbdsl.simulate(mbdsl.parse(nut(eye="eye")), step=1e-3, stop=0.8, interval=0.1)
    a, h = acceleration(PITCH, OFF), PITCH / (2 * np.pi)
    np.testing.assert_allclose(t["thread.fy"], M * (G + a), rtol=1e-7)
    np.testing.assert_allclose(t["thread.ty"], (J[1] + M * OFF @ OFF) * a / h, rtol=1e-6)
    radial = np.hypot(t["thread.fx"], t["thread.fz"])
    expected = M * np.hypot(*OFF) * np.hypot(t["thread.w"] ** 2, a / h)
    np.testing.assert_allclose(radial, expected, rtol=1e-5)


def test_turns_of_a_thread_follow_from_its_position():
    """A quarter of a turn in each step, from the eleventh turn on: s = s0 + v t without gravity."""
    start = f"thread.phi = {2 * np.pi * 10.3:.17g} rad; thread.v = 0.5 m/s;"
    text = nut(start=start).replace("Ground ground", "Ground ground(g = 0)")
    t = mbdsl.simulate(mbdsl.parse(text), step=0.025, stop=2.0, interval=0.5)
    np.testing.assert_allclose(t["thread.s"], 10.3 * PITCH + 0.5 * t.t, rtol=0, atol=1e-9)
    np.testing.assert_allclose(t["thread.phi"], 2 * np.pi * (10.3 + 0.5 * t.t / PITCH), rtol=1e-8)


def test_a_thread_without_pitch_is_refused():
    with pytest.raises(mbdsl.ModelError, match="the joint is a Revolute"):
        mbdsl.parse(nut(pitch=0.0))
