"""A Builder declares everything of docs/events.md: its scenes have the same events and contacts as those of texts."""

import pytest

import mbdsl
from mbdsl import parse
from mbdsl.errors import ModelError

TEXT = """model M
  Ground ground;
  PointMass ball(m = 2 kg);
  FreeMotion free(ground, ball);
  Real x(start = 1);
  discrete Real u(unit = "N", start = 1), w[2](start = {1, 2});
  Integer n(start = 0);
  Boolean on(start = true), near(start = false);
  Contact floor(gap = ball.y, slip = ball.vx, mu = 0.2, e = 0.8);
  Force push(ball, fx = u + noEvent(abs(w[1]))*(1 N), fy = smooth(1, abs(ball.x))*(1 N/m));
equation
  der(x) = -x/(1 s);
  when {sample(0, 10 ms), initial()} then
    u = -2*pre(u); n = pre(n) + 1;
  elsewhen edge(on) then
    n = 0;
  end when;
  when ball.y < 1 m then
    reinit(ball.vy, 2 m/s); reinit(x, 0); w[2] = 3; near = true; on = change(n);
    assert(u > 0, "u", AssertionLevel.warning);
  end when;
  when terminal() then assert(near, "not near"); end when;
  when n > 20 then terminate("done"); end when;
  assert(ball.x < 5 m, "far");
  assert(ball.x < 4 m, "rather far", AssertionLevel.warning);
end M;"""


def built():
    b = mbdsl.Builder("M")
    ground, ball = b.Ground("ground"), b.PointMass("ball", m="2 kg")
    b.FreeMotion("free", ground, ball)
    x = b.state("x", 1)
    u, _ = b.discrete("u", 1, unit="N"), b.discrete("w", [1, 2])
    n, on = b.discrete("n", 0, type="Integer"), b.discrete("on", True, type="Boolean")
    near = b.discrete("near", False, type="Boolean")
    b.Contact("floor", gap="ball.y", slip="ball.vx", mu=0.2, e=0.8)
    b.Force("push", ball, fx="u + noEvent(abs(w[1]))*(1 N)", fy="smooth(1, abs(ball.x))*(1 N/m)")
    b.rate(x, "-x/(1 s)")
    b.when(["sample(0, 10 ms)", "initial()"], {u: "-2*pre(u)"}, "n = pre(n) + 1", elsewhen=[("edge(on)", {n: 0})])
    b.when(
        "ball.y < 1 m",
        "reinit(ball.vy, 2 m/s)",
        "reinit(x, 0)",
        {"w[2]": 3, near: True, on: "change(n)"},
        'assert(u > 0, "u", AssertionLevel.warning)',
    )
    b.when("terminal()", 'assert(near, "not near")')
    b.when("n > 20", 'terminate("done")')
    b.assertion("ball.x < 5 m", "far")
    b.assertion("ball.x < 4 m", "rather far", level="warning")
    return b


def test_a_builder_makes_the_events_of_the_text():
    scene, text = built().scene(), parse(TEXT)
    assert scene.events == text.events and len(scene.events.branches) == 7
    assert scene == text


def test_a_warning_lets_the_run_go_on():
    """1 m falls below 0.5 m at sqrt(1/g) = 0.3193 s."""
    b = mbdsl.Builder("Falls")
    ball = b.PointMass("ball", m=1)
    b.FreeMotion("free", b.Ground("ground"), ball)
    for name, value in {ball.x: 0, ball.vx: 0, ball.y: "1 m", ball.vy: 0}.items():
        b.initial(name, value)
    b.assertion("ball.y > 0.5 m", "low", level="warning")
    run = mbdsl.simulate(b, stop=0.4, step=0.01, method="hht-si2")
    assert run.t[-1] == 0.4 and run.status == "done"
    assert [x.t for x in run.events if x.kind == "warning"] == pytest.approx([(1 / 9.81) ** 0.5], abs=1e-9)
    (said,) = (text for text in run.stats["warnings"] if "low" in text)
    assert "ball.y > 0.5 m" in said


def test_an_unknown_level_is_refused():
    b = mbdsl.Builder("M")
    b.FreeMotion("free", b.Ground("ground"), b.PointMass("ball", m=1))
    b.assertion("ball.y > 0.5 m", "low", level="loud")
    with pytest.raises(ModelError, match="loud"):
        b.scene()
