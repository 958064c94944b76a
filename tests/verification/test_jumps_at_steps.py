"""Forces that jump exactly at the end of a fixed step, against a closed form: methods keep their order."""

import numpy as np
import pytest

import mbdsl
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import declared
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

M, K = 2.0, 50.0
#: pushed along a guide by a step, which begins and ends, and by a sawtooth; across it by the same step
MODEL = """model Jumps Ground ground(g = 0);
Table saw(table = [0, -3; 0.2, 5]);
Body lump(m = 2 kg, I = 1 kg.m2); Prismatic guide(ground, lump.c);
TranslationalSpringDamper spring(guide, k = 50 N/m);
Force push(lump.c, fx = (if time >= 0.3 and time < 0.7 then 4 else 0) + saw(mod(time, 0.2)),
  fy = if time < 0.3 then 1 else 6);
initial equation guide.s = 0.1; guide.v = 0.2;
end Jumps;"""


def motion(stop):
    """s and its rate: between jumps M s'' + K s = c + d t, so s = (c + d t)/K and a harmonic part."""
    w, s, v = np.sqrt(K / M), 0.1, 0.2
    for t, end in zip(np.arange(0, stop, 0.1), np.arange(0.1, stop + 0.05, 0.1), strict=True):
        middle = 0.5 * (t + end)
        d = 8 / 0.2
        c = -3 - d * 0.2 * np.floor(middle / 0.2) + 4 * (0.3 < middle < 0.7)
        a, b = s - (c + d * t) / K, (v - d / K) / w
        x = w * (end - t)
        s, v = (c + d * end) / K + a * np.cos(x) + b * np.sin(x), d / K + w * (b * np.cos(x) - a * np.sin(x))
    return np.array([s, v])


def test_order_is_kept(any_method):
    """Jumps are at ends of steps, where 3 times 0.1 is not quite 0.3, and 120 times 2.5e-3 something else again."""
    errors = []
    for h in (5e-3, 2.5e-3):
        run = mbdsl.simulate(mbdsl.parse(MODEL), method=any_method, stop=1.0, step=h, interval=0.1)
        errors.append(np.abs(np.array([run["guide.s"], run["guide.v"]])[:, -1] - motion(1.0)).max())
    order = declared(any_method).order
    assert errors[1] < 1e-12 or np.log2(errors[0] / errors[1]) > order - 0.15
    # across the guide nothing moves: the reaction balances the force, on either side of the jump
    assert np.abs(run["guide.fy"][[2, 4]]) == pytest.approx([1.0, 6.0], abs=1e-6)


def test_a_run_taken_up_again_finds_the_jumps_still_to_come():
    """As from a checkpoint, which stores the next jump as a number: the result is the same to the last bit."""
    scene, found = mbdsl.parse(MODEL), []
    for stops in ([], [100, 121]):
        mechanism = graph.build(scene)
        system = build(scene, mechanism)
        first = initial_state(system, mechanism, 0.0)
        run = MethodRun(system, "hht-si2", 2.5e-3, 0.0, 1.0, np.array([1.0]))
        run.begin(first.q, first.v, first.a, first.lam)
        for steps in stops:
            assert run.advance(steps) == S.RUNNING
            due = run.reals[S.NEXT_EVENT]
            run.jumps.rejoin(due)
            assert run.jumps.next[0] == due < 1.0
        assert run.advance() == S.DONE
        found.append(run.out.copy())
    assert np.array_equal(*found)


def test_two_jumps_at_the_end_of_one_step():
    """At times that differ by 2e-13 s, more than rounding: they are treated as equal."""
    found = []
    for shift in (0.0, 2e-13):
        law = f"40*time + (if time >= 0.3 then 4 else 0) + (if time >= 0.3 + {shift!r} then 4 else 0)"
        text = f"""model Two Ground ground(g = 0); PointMass lump(m = 2 kg); Force push(lump, fx = {law});
          initial equation lump.x = 0; lump.y = 0; lump.vx = 0; lump.vy = 0; end Two;"""
        run = mbdsl.simulate(mbdsl.parse(text), method="hht-si2", stop=1.0, step=2.5e-3)
        found.append([run.q[-1, 0], run.v[-1, 0]])
    assert found[1] == pytest.approx(found[0], rel=1e-9)
