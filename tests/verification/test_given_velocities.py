"""Start values of velocities that are not fixed: kept if they agree, changed as by an impulse if they do not."""

import numpy as np
import pytest

import mbdsl

CHAIN = """model Chain
  World world(g = 0 m/s2);
  Rod a[{n}](each m = {m} kg, each length = 0.7 m);
  Revolute pin(world, a[1].a, phi(start = 0.4), w(start = {w}));
  Revolute j[{n} - 1](a[1:{n} - 1].b, a[2:{n}].a, each phi(start = -0.2), each w(start = {r}));
  annotation(experiment(StopTime = 1 ms));
end Chain;"""


@pytest.mark.parametrize(("n", "m"), [(2, 1.0), (30, 0.01), (120, 5.0)])
@pytest.mark.parametrize(("w", "r"), [(1.0, 0.0), (-3.0, 0.25)])
def test_rates_of_a_chain_are_kept(n, m, w, r):
    start = mbdsl.Simulation(mbdsl.parse(CHAIN.format(n=n, m=m, w=w, r=r)), step=1e-3)
    assert start["pin.w"] == pytest.approx(w, rel=1e-12)
    assert [start[f"j[{k}].w"] for k in range(1, n)] == pytest.approx([r] * (n - 1), abs=1e-12)


@pytest.mark.parametrize("spatial", ["", "spatial "])
def test_a_free_body_keeps_its_velocity(spatial):
    inertia, w = ("{1, 2, 3}", "wz") if spatial else ("1", "w")
    text = f"""{spatial}model Free
      Ground g;
      Body b(m = 1 kg, I = {inertia} kg.m2, vx(start = 7), {w}(start = -2));
      FreeMotion fly(g, b.c);
      annotation(experiment(StopTime = 1 ms));
    end Free;"""
    start = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    assert (start["b.vx"], start["b.vy"], start[f"b.{w}"]) == (7.0, 0.0, -2.0)


@pytest.mark.parametrize("spatial", ["", "spatial "])
def test_velocities_that_do_not_fit_change_as_by_an_impulse(spatial):
    """A massless rod between 1 and 3 kg: 1 m/s and 0 along it become 1/4 m/s; across it, nothing changes."""
    text = f"""{spatial}model Impulse
      Ground g(g = 0);
      PointMass a(m = 1 kg, x(start = 0), y(start = 0), vx(start = 1), vy(start = 0.3));
      PointMass b(m = 3 kg, x(start = 1), y(start = 0), vx(start = 0), vy(start = 0));
      FreeMotion fly(g, a);
      Distance rod(a, b, length = 1 m);
      annotation(experiment(StopTime = 1 ms));
    end Impulse;"""
    start = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    assert [start["a.vx"], start["b.vx"]] == pytest.approx([0.25, 0.25], rel=1e-9)
    assert [start["a.vy"], start["b.vy"]] == pytest.approx([0.3, 0.0], abs=1e-9)
    momentum = np.array([start["a.vx"], start["b.vx"]]) @ [1.0, 3.0]
    assert momentum == pytest.approx(1.0, rel=1e-9)
