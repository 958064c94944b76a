"""Turns of ANCF beams, whose coordinates are slopes: they follow from the accepted states of a motion, and not from
trial states."""

import numpy as np
import pytest

import mbdsl

#: without gravity the motion is the same at any angle
DRIVEN = """model Driven parameter Angle start = 0 deg; Ground ground(g = 0);
FlexibleBeam strip(length = 1 m, mass = 0.5 kg, E = 1e8, S = 1e-4 m2, I = 1e-9, formulation = "ancf", elements = 2);
Revolute pin(ground, strip.a); RotationalDriver drive(pin, phi = start + 0.2*sin(9*time));
RotationalSpringDamper key(ground, strip.b, k = 1 N.m/rad, c = 1 N.m.s/rad, phi0 = start + 0.3);
end Driven;"""
#: its tip is turned by a spring alone: the axis is a circle, and the tip at (EI/L) theta = k (phi0 - theta)
ROLL = """model Roll parameter Real phi0 = 7; Ground ground(g = 0);
FlexibleBeam beam(length = 1 m, mass = 1 kg, E = 1e8, S = 1e-2 m2, I = 1e-8, formulation = "ancf", elements = 8{more});
Fixed clamp(ground, beam.a); RotationalSpringDamper key(ground, beam.b, k = 1 N.m/rad, phi0 = phi0);
end Roll;"""


def driven(degrees, **given):
    scene = mbdsl.parse(DRIVEN, overrides={"start": np.deg2rad(degrees)})
    run = mbdsl.simulate(scene, **{"stop": 0.1, "interval": 0.02, **given})
    return np.array([run["key.torque"], run["drive.tau"], run["strip.b.phi"] - np.deg2rad(degrees)])


@pytest.mark.parametrize(
    "given",
    [
        {"method": "hht-si2", "step": 1e-3},
        {"method": "newmark", "step": 1e-3},
        {"method": "radau5", "tol": 1e-6},
        {"method": "scipy-radau", "tol": 1e-6, "stop": 0.03, "interval": 0.005},  # its steps take long
    ],
    ids=lambda given: given["method"],
)
def test_a_motion_does_not_know_where_angles_are_zero(given):
    """From 190 degrees, where atan2 has jumped, and two turns further: the same motion as from 0. The difference is the
    rounding of angles of 13 rad, 2e-15, in a stiff beam's forces over (h omega)^2, or the error that the tolerance
    allows."""
    truth = driven(0.0, **given)
    for degrees in (190.0, -530.0, 910.0):
        assert np.abs(driven(degrees, **given) - truth).max() < 1e-5 * np.abs(truth[0]).max()


@pytest.mark.parametrize("phi0", [-7.0, 30.0])
def test_an_end_turned_by_more_than_half_a_turn_stays_where_it_is(phi0):
    """Along the axis an element turns by phi0/16; cubic ones err by about the fourth power of that, over 720."""
    text = ROLL.format(more=', shape = "static"')
    error = abs(phi0) / 2 * (phi0 / 16) ** 4 / 720 * 3
    found = mbdsl.static(mbdsl.parse(text, overrides={"phi0": phi0}))
    assert found["key.torque"] == pytest.approx(-phi0 / 2, abs=error + 1e-8)
    assert found["clamp.tau"] == pytest.approx(found["key.torque"], rel=1e-8)
    run = mbdsl.simulate(mbdsl.parse(text, overrides={"phi0": phi0}), stop=0.02, step=1e-3, interval=1e-2)
    assert np.abs(run["key.torque"] - found["key.torque"]).max() < 1e-6
