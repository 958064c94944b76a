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
