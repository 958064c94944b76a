"""Forces that are infinite at rest only, and laws that have no value: closed forms, and the words of the errors."""

import numpy as np
import pytest

import mbdsl

WINCH = """model Winch
  Ground ground;
  Body drum(m = 3 kg, I = {inertia} kg.m2);
  Revolute shaft(ground, drum.c);
  Torque motor(shaft, tau = {law});
initial equation
  shaft.w = {w} rad/s;
  annotation(experiment(StopTime = 1 s, Interval = 0.1 s));
end Winch;
"""
STEPPED = "(if time < 0.4 s then 60 W else 20 W)/shaft.w"


def text(spatial="", law="60 W/shaft.w", w=4.0):
    return spatial + WINCH.format(inertia="{1, 2, 0.5}" if spatial else 0.5, law=law, w=w)


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("law", ["60 W/shaft.w", STEPPED], ids=["constant", "stepped"])
@pytest.mark.parametrize(
    ("method", "given"),
    [("hht-si2", {"tol": 1e-7}), ("hht-i3", {"step": 1e-3}), ("radau5", {"tol": 1e-8}), ("dop853", {"tol": 1e-8})],
)
def test_constant_power(spatial, law, method, given):
    """I w^2/2 grows by P t."""
    run = mbdsl.simulate(mbdsl.parse(text(spatial, law)), method=method, **given)
    work = 60.0 * np.minimum(run.t, 0.4) + 20.0 * np.maximum(run.t - 0.4, 0.0) if law == STEPPED else 60.0 * run.t
    assert run["shaft.w"] == pytest.approx(np.sqrt(16.0 + 2.0 * work / 0.5), rel=2e-5)


def test_a_constraint_without_derivative_at_rest():
    """v_y = 0.75 |v_x| as sqrt(v_x^2): along this direction, a force of 5 N along x accelerates 2 kg by its part along
    the way, 5*0.8 N, in both components."""
    model = """model Slide
      Ground ground(g = 0);
      PointMass p(m = 2 kg);
      VelocityConstraint way(gamma = p.vy - 0.75*sqrt(p.vx^2));
      Force push(p.c, fx = 5 N);
    initial equation
      p.vx = 0.8 m/s; p.vy = 0.6 m/s;
      annotation(experiment(StopTime = 1 s, Interval = 0.1 s));
    end Slide;"""
    for given in ({"step": 1e-3}, {"tol": 1e-6}):
        run = mbdsl.simulate(mbdsl.parse(model), **given)
        assert run["p.vx"] == pytest.approx(0.8 + 0.8 * 2.0 * run.t, rel=1e-5)
        assert run["p.vy"] == pytest.approx(0.6 + 0.6 * 2.0 * run.t, rel=1e-5)


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize(
    ("law", "w", "words"),
    [
        (
            "60 W/shaft.w",
            0.0,
            "the forces at t = 0 s are not finite numbers: `motor.tau` is infinite at .*shaft.w = 0 rad/s",
        ),
        ("3*sqrt(shaft.w - 2)", 1.0, "the forces .* `motor.tau` has no value at .*shaft.w = 1 rad/s"),
        (
            "3*sqrt(2 - shaft.w)",
            1.0,
            "values that are not finite in the step .* `motor.tau` has no value at .*w = 2 rad",
        ),
        ("3*sqrt(shaft.phi)", 1.0, "the derivatives .* `motor.tau` has an infinite derivative at .*shaft.phi = 0 rad"),
    ],
)
def test_the_component_and_its_signals_are_named(spatial, law, w, words):
    with pytest.raises(mbdsl.MbdslError, match=words) as caught:
        mbdsl.simulate(mbdsl.parse(text(spatial, law, w)), tol=1e-5)
    assert "Torque motor" in str(caught.value)
