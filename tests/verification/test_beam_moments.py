"""Moments on the ends of a beam in a floating frame: the cantilever of Euler and Bernoulli."""

import pytest

import mbdsl

TEXT = """model Cantilever
  Ground ground(g = 0);
  FlexibleBeam beam(length = 2 m, mass = 1 kg, E = 2e9 Pa, S = 1e-4 m2, I = 1e-9 m4, elements = 4,
    formulation = "floating");
  Fixed clamp(ground, beam.a);
  Torque moment(beam.b, tau = {tau} N.m);
  annotation(experiment(StopTime = 1 ms));
end Cantilever;"""


@pytest.mark.parametrize("tau", [0.02, -0.05])
def test_a_moment_at_the_tip(tau):
    """E I = 2 N.m2: the tip turns by M L/EI and moves by M L^2/(2 EI), where it is small."""
    found = mbdsl.static(mbdsl.parse(TEXT.format(tau=tau)))
    assert found["beam.b.phi"] == pytest.approx(tau * 2.0 / 2.0, rel=1e-3)
    assert found["beam.b.y"] == pytest.approx(tau * 4.0 / 4.0, rel=1e-3)
    assert found["clamp.tau"] == pytest.approx(-tau, rel=1e-6)  # on the beam


@pytest.mark.parametrize("method", ["hht-si2", "hht-add", "nstiff-si2"])
def test_a_clamped_beam_swings_alike_with_all_corrections(method):
    """Stabilised methods correct positions along B^T mu, which contains the moment of the clamp."""
    text = TEXT.format(tau="0.02*sin((20 rad/s)*time)").replace(" N.m);", "*1 N.m);")
    found, expected = (mbdsl.simulate(mbdsl.parse(text), method=x, step=1e-3, stop=0.05) for x in (method, "hht-i3"))
    size = abs(expected["beam.b.phi"]).max()
    assert found["beam.b.phi"] == pytest.approx(expected["beam.b.phi"], abs=0.02 * size)
    assert abs(found["clamp.Phi[3]"]).max() < 1e-6 * size and found.stats["iterations"] < 6 * found.stats["steps"]
