"""Words of the language that users' reports found misleading."""

import numpy as np
import pytest

import mbdsl

WHEEL = """model Wheel
  Ground ground(g = 0);
  Body {name}(m = 1 kg, I = 2 kg.m2);
  Revolute A(ground, {name}.c);
  {force}
initial equation
  A.w = 3 rad/s;
  annotation(experiment(StopTime = 0.5 s, Interval = 0.1 s));
end Wheel;"""


def wheel(force, name="wheel"):
    return mbdsl.parse(WHEEL.format(force=force, name=name))


@pytest.mark.parametrize(
    "law", ["50 W/A.w", "100 N.m.rad/s/2/A.w", "50 W/(A.w)", "25 W/A.w + 25 W/A.w", "50 W/A.w*1", "0.05 kW/A.w"]
)
def test_a_number_with_a_unit_over_a_component_called_like_one(law):
    """A is the component, not the ampere: I w^2/2 = 9 J + 50 W t."""
    run = mbdsl.simulate(wheel(f"Torque t(A, tau = {law});"), tol=1e-8, method="dop853")
    assert run["A.w"] == pytest.approx(np.sqrt(9.0 + 50.0 * run.t), rel=1e-7)


@pytest.mark.parametrize("unit", ["N.m/rad", "W.s/rad", "N.m.s/s/rad"])
def test_units_with_quotients_remain_units(unit):
    spring = (
        f"RotationalSpringDamper s(A, k = 8 {unit});" if unit == "N.m/rad" else f"Torque s(A, tau = -8 {unit}*A.phi);"
    )
    run = mbdsl.simulate(wheel(spring), tol=1e-8, method="dop853")
    assert run["A.phi"] == pytest.approx(1.5 * np.sin(2.0 * run.t), abs=1e-7)


@pytest.mark.parametrize("law", ["sin(2*pi*time)", "sin(pi*2*time)", "sin(2*time*pi)", "sin(2*pi*(time + 1 s))"])
def test_time_in_seconds_is_an_angle_in_radians(law):
    run = mbdsl.simulate(wheel(f"Torque t(A, tau = 4 N.m*{law});"), tol=1e-8, method="dop853")
    assert run["A.w"] == pytest.approx(3.0 + (1.0 - np.cos(2.0 * np.pi * run.t)) / np.pi, abs=1e-7)


@pytest.mark.parametrize("law", ["sin(3 s)", "sin(A.phi*(1 s))", "exp(2 m)"])
def test_other_dimensions_are_refused(law):
    with pytest.raises(mbdsl.ModelError, match="takes a pure number or an angle"):
        wheel(f"Torque t(A, tau = 4 N.m*{law});")


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize(
    ("kind", "signal"), [("Revolute pin", "pin.phi"), ("RotationalSpringDamper pin", "pin.torque")]
)
def test_assertions_about_signals_of_joints_and_forces(spatial, kind, signal):
    text = f"""{spatial}model Limit
      Ground ground;
      Rod rod(m = 1 kg, length = 1 m);
      Revolute hinge(ground, rod.a);
      {kind}(ground, rod.a);
    equation
      assert({signal} < 3, "too far");
    end Limit;"""
    model = mbdsl.parse(text)
    (when,) = model.events.whens
    assert [action.what for action in when.branches[0].actions] == ["assert"]


@pytest.mark.parametrize("spatial", ["", "spatial "])
def test_a_torque_between_frames_of_one_body_is_refused(spatial):
    text = f"""{spatial}model Twist
      Ground ground;
      Rod rod(m = 1 kg, length = 1 m);
      Revolute hinge(ground, rod.a);
      Torque t(rod.a, rod.b, tau = 5 N.m);
    end Twist;"""
    with pytest.raises(
        mbdsl.ModelError, match=r"Torque `t` does nothing: rod.a and rod.b belong to the same body"
    ) as found:
        mbdsl.simulate(mbdsl.parse(text), stop=0.1)
    axes = ', axes = "frame_b"' if spatial else ""
    assert f"`Torque t(rod.b, tau = ...{axes})`" in str(found.value)


def test_a_frequency_of_rounding_is_zero():
    """A ball joint under gravity turns freely about the vertical."""
    text = """spatial model Hanging
      Ground ground;
      Body b(m = 2 kg, I = {0.3, 0.2, 0.1} kg.m2, frames(top = {0.1, 0.7, 0.05} m));
      Spherical ball(ground, b.top);
    end Hanging;"""
    modes = mbdsl.eigen(mbdsl.parse(text))
    assert len(modes) == 3 and modes[0].omega == 0.0 and not modes.unstable
