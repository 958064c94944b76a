"""Potential energies of springs that are given by a law: the integral of the law, and energy that is conserved."""

import numpy as np
import pytest

import mbdsl
from mbdsl.expressions.array_operations import integral
from mbdsl.expressions.primitive import VARIABLE
from mbdsl.expressions.symbolic import call

LAWS = {
    "k*(s - s0)": "same",
    "k*(s - s0) + 400 N/m3*(s - s0)^3": None,
    "20 N*tanh((s - s0)/(0.05 m))": None,
    "max(0 N, k*(s - s0))": None,
    "if s > 0.9 m then 300 N/m*(s - 0.9 m) else 0 N": None,
    "curve(s)": None,
}
TEXT = """{spatial}model Laws
  Table curve(table = [0 m, -10 N; 0.5 m, 0 N; 0.8 m, 50 N; 2 m, 90 N], extrapolation = "linear");
  Ground ground(g = 2);
  PointMass a(m = 1 kg);
  parameter TranslationalSpringConstant k = 100 N/m;
  FreeMotion free(ground, a);
  SpringDamper spring(ground, a, s0 = 0.5 m, force = {law});
initial equation
  a.x = 1 m; a.y = 0 m; a.vy = 1 m/s; a.vx = -0.5 m/s;
  annotation(experiment(StopTime = 2 s, Interval = 10 ms));
end Laws;"""


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("law", LAWS)
def test_energy_is_conserved(law, spatial):
    run = mbdsl.simulate(mbdsl.parse(TEXT.format(law=law, spatial=spatial)), method="dop853", tol=1e-9)
    energy = run["energy.total"]
    assert np.ptp(run["energy.potential"]) > 0.1
    assert np.ptp(energy) < 1e-7 * max(1.0, np.abs(run["energy.potential"]).max())
    if LAWS[law] == "same":
        linear = TEXT.format(law=law, spatial=spatial).replace("force = k*(s - s0)", "k = k")
        expected = mbdsl.simulate(mbdsl.parse(linear), method="dop853", tol=1e-9)
        assert energy == pytest.approx(expected["energy.total"], abs=1e-7)


@pytest.mark.parametrize(("spatial", "inertia"), [("", "0.2"), ("spatial ", "{0.2, 0.2, 0.2}")])
def test_a_torsion_spring_loses_what_its_damping_takes(spatial, inertia):
    """The damping of a law has no potential: the energy falls by the integral of c w^2."""
    text = f"""{spatial}model Torsion
      Ground ground(g = 0);
      Body b(m = 1 kg, I = {inertia} kg.m2);
      Revolute pin(ground, b.c);
      RotationalSpringDamper s(pin, phi0 = 10 deg, torque = 5 N.m*sin(phi - phi0) + 0.1 N.m.s/rad*w);
    initial equation
      pin.phi = 70 deg; pin.w = 1 rad/s;
      annotation(experiment(StopTime = 2 s, Interval = 1 ms));
    end Torsion;"""
    run = mbdsl.simulate(mbdsl.parse(text), method="dop853", tol=1e-9)
    assert run["energy.potential"][0] == pytest.approx(5.0 * (1.0 - np.cos(np.pi / 3.0)), rel=1e-10)
    taken = np.trapezoid(0.1 * run["pin.w"] ** 2, run.t)
    assert run["energy.total"][0] - run["energy.total"][-1] == pytest.approx(taken, rel=1e-5)


def test_a_law_of_time_has_no_potential():
    run = mbdsl.simulate(
        mbdsl.parse(TEXT.format(law="k*(s - s0)*(1 + time/1 s)", spatial="").replace("g = 2", "g = 0"))
    )
    assert not run["energy.potential"].any()


@pytest.mark.parametrize(
    ("law", "exact"),
    [
        (call("cos", VARIABLE), np.sin),
        (VARIABLE * VARIABLE, lambda x: x**3 / 3.0),
        (call("abs", VARIABLE - 0.3), lambda x: 0.5 * ((x - 0.3) * np.abs(x - 0.3) + 0.09)),
        (call("sqrt", call("max", VARIABLE, 0.0 * VARIABLE)), lambda x: np.maximum(x, 0.0) ** 1.5 / 1.5),
    ],
)
def test_quadrature(law, exact):
    x = np.array([3.0, -2.0, 0.1, 0.1, 40.0, np.nan])
    found = integral((law, 0.0), x)
    assert found[:-1] == pytest.approx(exact(x[:-1]) - exact(np.zeros(1)), rel=1e-9, abs=1e-9) and np.isnan(found[-1])
    assert integral((law, 0.0), 3.0) == pytest.approx(exact(np.array([3.0]))[0] - exact(np.zeros(1))[0], rel=1e-9)
