"""Models with events in simulations step by step: closed forms, saved states, and changes from outside."""

import pickle

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError, UsageError

SLIDE = """model M
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c);
  {declared}
initial equation
  rail.s = {s} m; rail.v = {v} m/s;
equation
  {events}
end M;"""
BOUNCE = (
    "Integer hits(start = 0); Force weight(b.c, fx = -9 N);",
    """when rail.s <= 0 m then
         reinit(rail.v, -0.8*rail.v);
         hits = pre(hits) + 1;
       end when;
       when hits >= 5 then terminate("five hits"); end when;""",
)
#: time to the first hit from 1 m, and the time of the fifth
FIRST = np.sqrt(2 / 9)
FIFTH = FIRST * (1 + 2 * sum(0.8**k for k in range(1, 5)))


def slide(declared, events, s=0.0, v=0.0):
    return mbdsl.parse(SLIDE.format(declared=declared, events=events, s=s, v=v))


@pytest.fixture(scope="module")
def bounce():
    return slide(*BOUNCE, s=1.0)


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "nstiff", "generalized-alpha", "radau5"])
def test_bouncing_ball_up_to_its_end(bounce, method):
    sim = mbdsl.Simulation(bounce, method=method, step=7e-3)
    while not sim.terminated:
        sim.step(3)
        assert sim.terminated or sim.time == pytest.approx(7e-3 * round(sim.time / 7e-3), abs=1e-12)
    assert sim.terminated == "five hits"
    assert sim.time == pytest.approx(FIFTH, abs=1e-9)
    assert sim["rail.v"] == pytest.approx(9 * FIRST * 0.8**5, abs=1e-9)
    run = sim.trajectory()
    assert (sim["hits"], run["hits"][-1], run.t[-1]) == (5, 5, sim.time)
    assert run.stats["kinds of events"] == {"reinit": 5, "terminate": 1}
    hits = [x.t for x in run.events if x.kind == "reinit"]
    assert np.diff(hits) == pytest.approx(2 * FIRST * 0.8 ** np.arange(1, 5), abs=1e-9)
    assert run["hits"][np.searchsorted(run.t, FIRST) - 1] == 0 and run["hits"][np.searchsorted(run.t, FIRST)] == 1
    with pytest.raises(UsageError, match=r"has ended at t = 2\.69.*: five hits"):
        sim.step()
    sim.reset()
    assert (sim.time, sim["hits"], sim.terminated) == (0.0, 0, "")
    sim.step(3)


def test_states_copies_and_pickles_continue_bit_for_bit(bounce):
    sim = mbdsl.Simulation(bounce, step=1e-2)
    sim.step(30)
    state, copies = sim.state, [sim.copy(), pickle.loads(pickle.dumps(sim))]
    sim.step(100)
    there = [sim["rail.s"], sim["rail.v"], sim["hits"]]
    for other in copies:
        other.step(100)
        assert [other["rail.s"], other["rail.v"], other["hits"]] == there and there[2] == 2
    sim.state = state
    assert sim["hits"] == 0
    for _ in range(100):
        sim.step()
    assert [sim["rail.s"], sim["rail.v"], sim["hits"]] == there


def test_an_event_just_before_the_end_of_a_step():
    """x = t reaches 1 - 1e-7 in the step to 1; the force of 1 N acts from then on."""
    model = slide(
        "Boolean on(start = false); Force f(b.c, fx = if on then 1 N else 0 N);",
        "when rail.s > 1 m - 1e-7 m then on = true; end when;", v=1.0,
    )  # fmt: skip
    for method in ("hht-i3", "hht-si2", "nstiff", "radau5"):
        sim = mbdsl.Simulation(model, method=method, step=1e-2)
        sim.step(100)
        assert sim["on"] == 1 and sim.time == pytest.approx(1.0, abs=1e-14)
        assert sim["rail.s"] == pytest.approx(1.0, abs=1e-12)
        assert sim["rail.fx"] == pytest.approx(0.0, abs=1e-6) and sim["rail.fy"] == pytest.approx(9.81, rel=1e-4)
        sim.step(100)
        assert [sim["rail.s"], sim["rail.v"]] == pytest.approx([2.5 + 1e-7, 2.0 + 1e-7], abs=1e-9)


def test_a_controller_outside_sets_what_a_sampled_one_sets():
    """x'' = u with u held between samples of 10 ms: the exact discrete motion, by `when` and by hand."""
    declared = 'discrete Real u(unit = "N"); Force f(b.c, fx = u);'
    inside = slide(declared, "when sample(0, 10 ms) then u = -4 N/m*rail.s - 2 N.s/m*rail.v; end when;", s=1.0)
    by_hand = slide(declared, "when rail.s > 99 m then u = 0; end when;", s=1.0)
    x, v, T = 1.0, 0.0, 0.01
    for _ in range(100):
        u = -4 * x - 2 * v
        x, v = x + T * v + T * T / 2 * u, v + T * u
    for model in (inside, by_hand):
        sim = mbdsl.Simulation(model, step=2e-3)
        for _ in range(100):
            if model is by_hand:
                sim["u"] = -4 * sim["rail.s"] - 2 * sim["rail.v"]
            sim.step(5)
        assert [sim["rail.s"], sim["rail.v"]] == pytest.approx([x, v], abs=1e-6)
        assert sim.trajectory()["u"][-2] == pytest.approx(u, abs=1e-5)
        assert sim.trajectory()["u"][0] == pytest.approx(-4.0)


def test_what_is_set_from_outside_makes_conditions_true():
    model = slide(
        "input Real u(start = 0); discrete Boolean go(start = false); Integer n(start = 0), m(start = 0); "
        "Force f(b.c, fx = 0 N);",
        """when go then reinit(rail.v, 2 m/s); end when;
           when edge(go) then n = pre(n) + 1; end when;
           when u > 3 then m = pre(m) + 1; end when;""",
    )
    sim = mbdsl.Simulation(model, step=1e-2)
    sim.step(5)
    sim["go"] = True
    assert sim["rail.v"] == pytest.approx(2.0) and sim["n"] == 1
    sim.step(10)
    assert sim["rail.s"] == pytest.approx(0.2) and sim["n"] == 1
    for value in (4.0, 5.0, 0.0, 6.0):
        sim.inputs["u"] = value
        sim.step()
    assert sim["m"] == 2
    run = sim.trajectory()
    assert run["m"].tolist() == [0] * 15 + [1, 1, 1, 2, 2]
    with pytest.raises(UsageError, match="expected an integer"):
        sim["n"] = 0.5
    with pytest.raises(UsageError, match="expected true or false"):
        sim["go"] = 2
    with pytest.raises(UsageError, match="cannot be set") as problem:
        sim["o"] = 1
    assert "`go`" in problem.value.hint


def test_assertions_and_endless_events_end_the_simulation():
    model = slide("Force f(b.c, fx = 1 N);", 'when rail.s > 0.5 m then assert(rail.v < 0.5 m/s, "fast"); end when;')
    sim = mbdsl.Simulation(model, step=1e-2)
    with pytest.raises(IntegrationError, match=r"is false at t = 1 s") as problem:
        sim.step(200)
    assert 1.0 - 1e-2 - 1e-9 < problem.value.trajectory.t[-1] < 1.0 + 1e-9  # the last step that was completed


def test_contacts_rest_and_are_restored():
    model = mbdsl.parse("""model Bounce
      Ground ground;
      PointMass ball(m = 2 kg);
      Contact floor(gap = ball.y, e = 0.8);
    initial equation
      ball.x = 0 m; ball.vx = 0 m/s; ball.y = 1 m; ball.vy = 0 m/s;
    end Bounce;""")
    sim = mbdsl.Simulation(model, step=1e-2)
    sim.step(406)  # the last impact is at 4.0637 s
    state = sim.state
    sim.step(10)
    assert sim["floor.force"] == pytest.approx(19.62) and sim["ball.y"] == pytest.approx(0.0, abs=1e-12)
    rest, other = sim.state, sim.copy()
    sim.state = state
    assert sim["floor.force"] == 0.0
    sim.state = rest
    for one in (sim, other):
        one.step(10)
        assert one["floor.force"] == pytest.approx(19.62)


def test_a_joint_that_sticks_is_pushed_by_an_input():
    """Held at mu_s = 0.5 on a slope of 20 deg; a push of 5 N along x: a = (m g + ...) by hand."""
    model = mbdsl.parse("""model Incline
      input Force push(start = 0);
      Ground ground;
      Frame slope(ground, phi = -20 deg);
      Body block(m = 1 kg, I = 1e-3 kg.m2);
      Force f(block.c, fx = push);
      Prismatic slide(slope, block.c, mu = 0.4, mu_s = 0.5, sticks = true);
    initial equation
      slide.s = 0 m; slide.v = 0 m/s;
    end Incline;""")
    sim = mbdsl.Simulation(model, step=1e-2)
    sim.step(100)
    assert sim["slide.s"] == pytest.approx(0.0, abs=1e-12)
    held, (s, c) = sim.state, (np.sin(np.radians(20)), np.cos(np.radians(20)))
    a = 9.81 * s + 5 * c - 0.4 * (9.81 * c - 5 * s)
    sim.inputs["push"] = 5.0
    sim.step(10)
    assert [sim["slide.s"], sim["slide.v"]] == pytest.approx([0.005 * a, 0.1 * a], rel=1e-9)
    sim.inputs["push"] = 0.0
    sim.step(100)  # a = g (s - mu c) < 0 until it stops
    assert sim["slide.v"] == pytest.approx(0.1 * a + 9.81 * (s - 0.4 * c), rel=1e-9)
    sim.state = held
    sim.step(10)
    assert sim["slide.s"] == pytest.approx(0.0, abs=1e-12)


def test_nothing_is_stored_on_request():
    model = slide(
        'discrete Real u(unit = "N"); Force f(b.c, fx = u);',
        "when sample(0, 5 ms) then u = -4 N/m*rail.s - 2 N.s/m*rail.v; end when;", s=1.0,
    )  # fmt: skip
    sim, other = (mbdsl.Simulation(model, step=1e-2, record=record) for record in (False, True))
    for _ in range(50):
        sim.step(2)
        other.step(2)
        assert (sim["u"], sim["rail.s"]) == (other["u"], other["rail.s"])
    assert len(sim.trajectory()) == 1 and sim.trajectory()["u"][0] == sim["u"]
    assert sum(map(len, sim._single.set.history)) == 1
