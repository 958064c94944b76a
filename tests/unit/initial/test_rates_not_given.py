"""Rates that no initial value gives: joints on driven bodies start at rest relative to them, and check lists others."""

import numpy as np
import pytest

import mbdsl
from mbdsl.initial.start_check import check_start
from mbdsl.mechanism.graph import build

ROTOR = """spatial model Rotor "Two blades with flap and lag hinges at offset e"
  parameter AngularVelocity Omega = 30 rad/s;
  Ground ground(g = 0, n = {0, 0, -1});
  Body hub(m = 50 kg, I = {2, 2, 3} kg.m2, frames(h1(r = {0.3, 0, 0} m), h2(r = {-0.3, 0, 0} m, phi = 180 deg)));
  Body cuff1(m = 0, I = 0, frames(a = {0, 0, 0}));
  Body cuff2(m = 0, I = 0, frames(a = {0, 0, 0}));
  Rod blade1(m = 40 kg, length = 5 m);
  Rod blade2(m = 40 kg, length = 5 m);
  Revolute shaft(ground, hub.c, n = {0, 0, 1});
  RotationalDriver rpm(shaft, phi = Omega*time);
  Revolute flap1(hub.h1, cuff1.a, n = {0, -1, 0});
  Revolute flap2(hub.h2, cuff2.a, n = {0, -1, 0});
  Revolute lag1(cuff1.a, blade1.a, n = {0, 0, 1});
  Revolute lag2(cuff2.a, blade2.a, n = {0, 0, 1});
initial equation
  flap1.phi = 0 rad; flap2.phi = 0 rad; lag1.phi = 0 rad; lag2.phi = 0 rad;
end Rotor;"""


def start(text, general=False):
    return mbdsl.simulate(mbdsl.parse(text), stop=0.0, general=general)


@pytest.mark.parametrize("given", ["", "flap1.w = 0.5 rad/s; "])
@pytest.mark.parametrize("driver", ["RotationalDriver rpm(shaft, phi = Omega*time)",
                                    "RotationalVelocityDriver rpm(shaft, w = Omega)"])  # fmt: skip
def test_hinges_of_a_driven_rotor(given, driver):
    text = ROTOR.replace("RotationalDriver rpm(shaft, phi = Omega*time)", driver)
    run = start(text.replace("flap1.phi =", f"{given}flap1.phi ="))
    rates = [run[f"{name}.w"][0] for name in ("flap1", "flap2", "lag1", "lag2")]
    assert rates == pytest.approx([0.5 if given else 0.0, 0.0, 0.0, 0.0], abs=1e-12)
    assert run["hub.wz"][0] == pytest.approx(30.0)


def test_frequencies_of_a_rotor():
    """Rods of length l on hinges at e: flap (1 + 3/2 e/l) W^2, lag 3/2 e/l W^2, about the middle of the hinges."""
    modes = mbdsl.eigen(mbdsl.parse(ROTOR), "start")
    flap, lag = 30.0 * np.sqrt(1.0 + 1.5 * 0.3 / 5.0), 30.0 * np.sqrt(1.5 * 0.3 / 5.0)
    assert [mode.eigenvalue for mode in modes] == pytest.approx([1j * lag] * 2 + [1j * flap] * 2, rel=1e-9)


CRANE = """model Crane
  Ground ground;
  Body trolley(m = 1 kg, I = 1 kg.m2, frames(e = {0.2 m, 0}));
  Rod upper(m = 2 kg, length = 1 m);
  Rod lower(m = 2 kg, length = 1 m);
  PointMass bead(m = 1 kg);
  Prismatic rail(ground, trolley.c);
  TranslationalDriver pull(rail, s = 2 m/s*time);
  Revolute pin(trolley.e, upper.a);
  Revolute link(upper.b, lower.a);
  PointOnLine string(lower.c, bead);
initial equation
  pin.phi = -70 deg; link.phi = 20 deg; string.s = 0.3 m;
end Crane;"""


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("general", [False, True])
def test_what_hangs_on_a_driven_trolley(spatial, general):
    """Everything moves with it; a body that is not joined to it stays at rest."""
    text = CRANE.replace("Prismatic", "Body other(m = 1 kg, I = 1 kg.m2); Revolute o(ground, other.c); Prismatic", 1)
    run = start(spatial + text, general)
    assert [run[f"{body}.vx"][0] for body in ("upper", "lower", "bead")] == pytest.approx([2.0] * 3, rel=1e-12)
    found = [run[name][0] for name in ("pin.w", "link.w", "string.v", "lower.vy", "bead.vy", "o.w")]
    assert found == pytest.approx([0.0] * 6, abs=1e-12)


def test_long_chain_on_a_driven_base():
    """Sparse equations, more than 400 unknowns."""
    text = """model Chain Ground ground;
      Body base(m = 1 kg, I = 1 kg.m2); Rod link[100](each m = 0.1 kg, each length = 0.1 m);
      Prismatic rail(ground, base.c, phi0 = 0); TranslationalDriver pull(rail, s = 2 m/s*time);
      Revolute first(base.c, link[1].a); for i in 2:100 loop Revolute J[i](link[i-1].b, link[i].a); end for;
    initial equation first.phi = -90 deg; end Chain;"""
    run = start(text)
    assert [run[f"link[{k}].vx"][0] for k in (1, 50, 100)] == pytest.approx([2.0] * 3, rel=1e-12)
    assert [run[f"link[{k}].w"][0] for k in (1, 50, 100)] == pytest.approx([0.0] * 3, abs=1e-12)


ARM = """model Arm Ground ground; Rod a(m = 1 kg, length = 1 m); Rod b(m = 2 kg, length = 0.7 m);
  Revolute A(ground, a.a); Revolute B(a.b, b.a);
initial equation A.phi = 0.3 rad; B.phi = -0.8 rad; A.w = 1.3 rad/s;{}
end Arm;"""


@pytest.mark.parametrize("spatial", ["", "spatial "])
def test_check_lists_rates(spatial):
    """The second rod keeps the least velocity, and its hinge has a rate that is not given."""
    text = spatial + ARM.format("")
    rate = start(text)["B.w"][0]
    assert rate < -1.0
    lines = check_start(build(mbdsl.parse(text)))
    assert lines[1:-1] == [f"initial rates that are not given and not zero: B.w = {rate:.6g} rad/s"]
    for given in (" B.w = -1 rad/s;", " guess B.w = -1 rad/s;", " b.w = 0 rad/s;" if not spatial else " b.wz = 0;"):
        assert len(check_start(build(mbdsl.parse(spatial + ARM.format(given))))) == 2
    assert len(check_start(build(mbdsl.parse(ROTOR)))) == 2
