"""Telescopic legs without initial values: their parts point at each other, and a note says which branch was taken."""

import numpy as np
import pytest

import mbdsl

BOOM = """model Boom
  Ground ground;
  Frame foot(ground, r = {{{x} m, -0.1 m}});
  Rod boom(m = 5 kg, length = 1 m);
  Rod barrel(m = 1 kg, length = {length} m);
  Rod piston(m = 1 kg, length = {length} m);
  Revolute A(ground, boom.a);
  Revolute B(foot, barrel.a);
  {leg}
  Revolute C(piston.b, boom.b);
initial equation
  A.phi = {angle} deg; {more}
  annotation(experiment(StopTime = 10 ms));
end Boom;"""
LEG = "Prismatic leg(barrel.b, piston.a);"


def start(**given):
    values = {"x": 1.2, "length": 0.5, "angle": 50.0, "leg": LEG, "more": ""} | given
    return mbdsl.simulate(mbdsl.parse(BOOM.format(**values)), step=1e-3), values


@pytest.mark.parametrize("x", [1.2, -0.8, 0.3])
@pytest.mark.parametrize("angle", [50.0, 120.0, -70.0])
@pytest.mark.parametrize("length", [0.3, 0.5])
def test_the_leg_reaches_the_boom(x, angle, length):
    """2 length + s is the distance of its ends; the other branch has s = -2 length - distance."""
    run, _ = start(x=x, angle=angle, length=length)
    tip = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    distance = np.hypot(*(tip - [x, -0.1]))
    assert run["leg.s"][0] == pytest.approx(distance - 2.0 * length, abs=1e-9)


def test_the_branch_is_named():
    run, _ = start()
    assert any(
        "leg.s: assembled with 0.02981 m; with its parts turned round it would be -2.03 m" in x
        for x in run.stats["warnings"]
    )


@pytest.mark.parametrize("more", ["guess leg.s = -2 m;", "guess barrel.phi = 20 deg;"])
def test_what_the_model_gives_decides(more):
    assert start(more=more)[0]["leg.s"][0] < -2.0


def test_a_leg_in_space():
    text = """spatial model Strut
      Ground ground;
      Frame foot(ground, r = {1.2, -0.1, 0.2} m);
      Body arm(m = 5 kg, I = {1, 1, 1} kg.m2, frames(root = {-0.5, 0, 0} m, tip = {0.5, 0, 0} m));
      Cylinder barrel(m = 1 kg, length = 0.5 m, radius = 2 cm);
      Cylinder piston(m = 1 kg, length = 0.5 m, radius = 1 cm);
      Revolute A(ground, arm.root);
      Universal B(foot, barrel.a, n_a = {0, 0, 1}, n_b = {0, 1, 0});
      Prismatic leg(barrel.b, piston.a);
      Spherical C(piston.b, arm.tip);
    initial equation
      A.phi = 50 deg;
      annotation(experiment(StopTime = 10 ms));
    end Strut;"""
    run = mbdsl.simulate(mbdsl.parse(text), step=1e-3)
    distance = np.linalg.norm(np.array([np.cos(np.radians(50)), np.sin(np.radians(50)), 0.0]) - [1.2, -0.1, 0.2])
    assert run["leg.s"][0] == pytest.approx(distance - 1.0, abs=1e-9)
