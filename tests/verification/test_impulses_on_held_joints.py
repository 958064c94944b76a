"""Impulses on joints that friction holds: friction of a finite force has no impulse, so that they slide behind it."""

import numpy as np
import pytest

import mbdsl

G = 9.81
STRUCK = """model Struck "A block strikes another that friction holds"
  Ground ground;
  Body a(m = 1 kg, I = 1e-3 kg.m2), b(m = 2 kg, I = 1e-3 kg.m2);
  Prismatic pa(ground, a.c, mu = 0.1, sticks = true), pb(ground, b.c, mu = 0.2, sticks = true);
  Contact hit(gap = pb.s - pa.s - 0.1 m, e = 0.8);
initial equation
  pa.s = 0 m; pa.v = 2 m/s; pb.s = 0.6 m; pb.v = 0 m/s;
end Struck;"""


@pytest.mark.parametrize("given", [{"method": "hht-si2", "step": 1e-3}, {"method": "radau5", "tol": 1e-6}], ids=str)
def test_a_held_block_that_is_struck_slides(given):
    """Newton's law with the momentum of both blocks, and the ways v^2/(2 mu g) on which friction stops them."""
    run = mbdsl.simulate(mbdsl.parse(STRUCK), stop=1.5, **given)
    v = np.sqrt(2.0**2 - 2.0 * 0.1 * G * 0.5)
    back, away = v * (1.0 - 0.8 * 2.0) / 3.0, v * 1.8 / 3.0
    assert run["pa.s"][-1] == pytest.approx(0.5 - back**2 / (2.0 * 0.1 * G), abs=1e-8)
    assert run["pb.s"][-1] == pytest.approx(0.6 + away**2 / (2.0 * 0.2 * G), abs=1e-8)


KICKED = """model Kicked
  Ground ground;
  Body b(m = 2 kg, I = 1e-3 kg.m2);
  PointMass low(m = 1 kg), high(m = 1 kg);
  Prismatic pb(ground, b.c, mu = 0.2, sticks = true);
  Contact floor(gap = low.y, e = 0.5), between(gap = high.y - low.y - 0.1 m, e = 0.5);
initial equation
  pb.s = 0 m; pb.v = 0 m/s;
  low.x = 0 m; low.vx = 0 m/s; low.y = 0 m; low.vy = 0 m/s;
  high.x = 0 m; high.vx = 0 m/s; high.y = 9.81 m; high.vy = 0 m/s;
equation
  when time > 0.5 s then reinit(pb.v, 1 m/s); reinit(low.vy, 2 m/s); end when;
end Kicked;"""


def test_reinit_moves_what_friction_holds_and_contacts_support():
    """Open contacts do not pass it on, a closed one opens."""
    run = mbdsl.simulate(mbdsl.parse(KICKED), method="hht-si2", step=1e-3, stop=0.75)
    t = 0.25
    assert run["pb.s"][-1] == pytest.approx(t - 0.1 * G * t**2, abs=1e-9)
    assert run["low.y"][-1] == pytest.approx(2.0 * t - 0.5 * G * t**2, abs=1e-9)
    assert run["high.y"][-1] == pytest.approx(G - 0.5 * G * 0.75**2, abs=1e-9)


PUSHED = """model Pushed "A force that grows, on the first of two blocks that touch"
  Ground ground;
  Body a(m = 1 kg, I = 1e-3 kg.m2), b(m = 2 kg, I = 1e-3 kg.m2);
  Prismatic pa(ground, a.c, mu = 0.1, sticks = true), pb(ground, b.c, mu = 0.2, sticks = true);
  Force f(a.c, fx = {sign}2 N/s*time);
  Contact hit(gap = pb.s - pa.s - 0.1 m, e = 0.5);
initial equation
  pa.s = 0 m; pa.v = 0 m/s; pb.s = 0.1 m; pb.v = 0 m/s;
end Pushed;"""


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3"])
def test_friction_does_not_hold_a_block_by_a_contact_that_would_pull(method):
    """It slides from 2 N/s t = mu m g on, with the acceleration 2 N/s (t - t1)/m."""
    run = mbdsl.simulate(mbdsl.parse(PUSHED.format(sign="-")), method=method, step=1e-2, stop=1.0)
    first = 0.1 * G / 2.0
    assert [event.t for event in run.events if event.kind == "slip"] == pytest.approx([first], abs=1e-6)
    assert run["pa.s"][-1] == pytest.approx(-((1.0 - first) ** 3) / 3.0, abs=1e-4)


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3"])
def test_a_contact_carries_what_friction_does_not(method):
    """Block a is held until 0.981 N, then pushes block b, which is held until 3.924 N; then both slide."""
    run = mbdsl.simulate(mbdsl.parse(PUSHED.format(sign="")), method=method, step=1e-2, stop=3.0, interval=0.5)
    held = run.t < 2.4
    np.testing.assert_allclose(run["hit.force"][held], np.maximum(2.0 * run.t[held] - 0.1 * G, 0.0), atol=1e-6)
    np.testing.assert_allclose(run["pb.friction"][held], run["hit.force"][held], atol=1e-6)
    begins = 0.5 * G / 2.0
    assert run["pb.s"][-1] == pytest.approx(0.1 + 2.0 * (3.0 - begins) ** 3 / 18.0, abs=1e-4)
