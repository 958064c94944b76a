"""Events as a user of Modelica writes them: types, arrays, sub-models, assertions, and relations without events."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError

MODEL = """{before}model M
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c);
  {declared}
initial equation
  rail.s = 0 m; rail.v = 1 m/s;
equation
  {events}
end M;"""
PUSH = "Force f(b.c, fx = 0 N);"


def run(declared, events, before="", stop=3.0):
    """x = t, unless something acts."""
    model = mbdsl.parse(MODEL.format(declared=PUSH + declared, events=events, before=before))
    return mbdsl.simulate(model, stop=stop, method="hht-si2", step=1e-2, interval=0.5)


@pytest.mark.parametrize("condition", ["rail.s > 1 m", "time >= 1 s", "on", "{rail.s > 9 m, rail.s > 1 m}"])
def test_conditions_of_a_when(condition):
    found = run("Boolean on = rail.s > 1 m; Integer n(start = 5);", f"when {condition} then n = pre(n) - 2; end when;")
    assert found["n"].tolist() == [5, 5, 3, 3, 3, 3, 3]


def test_booleans_edges_and_changes():
    """edge(a) is a and not pre(a); change(a) is a <> pre(a)."""
    found = run(
        "Boolean a(start = false), c(start = true); Integer n(start = 0), m(start = 0), k(start = 0);"
        "Integer sum = n + 10*m + 100*k;",
        """when time >= 1 s then a = true; elsewhen time >= 2 s then a = false; end when;
           when edge(a) then n = pre(n) + 1; c = not pre(c); end when;
           when a and not pre(a) then m = pre(m) + 1; end when;
           when change(a) then k = pre(k) + 1; end when;""",
    )
    assert found["sum"].tolist() == [0, 0, 111, 111, 211, 211, 211]
    assert found["c"].tolist() == [1, 1, 0, 0, 0, 0, 0]


def test_arrays_have_values_before_the_event():
    found = run("Real x[3](start = {1, 2, 3});", """when rail.s > 1 m then x = {4, 5, 6};
                elsewhen rail.s > 2 m then x = 2*pre(x) + fill(1, 3); end when;""")  # fmt: skip
    assert [found[f"x[{k}]"].tolist()[::2] for k in (1, 3)] == [[1, 4, 9, 9], [3, 6, 13, 13]]


def test_loops_of_whens_and_arrays_of_sub_models():
    before = """model Counter
      parameter Length L = 1 m; Length s; Integer n(start = 0);
    equation
      when s > L then n = pre(n) + 1; end when;
    end Counter;
    """
    found = run(
        "Counter t[2](each s = rail.s, L = {1 m, 2 m}); Integer total = t[1].n + t[2].n, m[2](each start = 0);",
        "for i in 1:2 loop when rail.s > i*(1 m) then m[i] = pre(m[i]) + i; end when; end for;",
        before,
    )
    assert found["total"].tolist() == [0, 0, 1, 1, 2, 2, 2]
    assert found["m[1]"][-1] == 1 and found["m[2]"].tolist() == [0, 0, 0, 0, 2, 2, 2]


@pytest.mark.parametrize(
    "text",
    [
        "when {rail.s > 1 m, rail.s > 1.5 m} then reinit(rail.v, 2*rail.v); end when;",
        "when rail.s > 1 m then reinit(rail.v, 2*rail.v);"
        "elsewhen rail.s > 1.5 m then reinit(rail.v, 2*rail.v); end when;",
        "when rail.s > 1 m then reinit(rail.v, 2*rail.v); end when;"
        "when rail.s > 1.5 m then reinit(rail.v, 2*rail.v); end when;",
    ],
)
def test_reinit_does_not_depend_on_how_when_is_written(text):
    """OpenModelica issue 12350: x = t, then 1 + 2 (t - 1) up to 1.5 m at 1.25 s, then four times as fast."""
    found = run("", text, stop=2.0)
    assert found["rail.s"][[1, 2, 3, 4]] == pytest.approx([0.5, 1.0, 1.5 + 4 * 0.25, 1.5 + 4 * 0.75], abs=1e-9)


def test_two_jumps_of_one_velocity_at_once_are_an_error_with_both_lines():
    with pytest.raises(IntegrationError, match=r"reinit of rail.v acts twice at t = 1 s") as problem:
        run("", """when rail.s > 1 m then reinit(rail.v, 2 m/s); end when;
                   when rail.s > 1 m then reinit(rail.v, 3 m/s); end when;""")  # fmt: skip
    assert problem.value.notes and problem.value.trajectory.t[-1] == pytest.approx(1.0, abs=1e-5)


def test_a_jump_against_constraints_is_said():
    with pytest.raises(IntegrationError, match=r"reinit of b.vy at t = 1 s: the constraints do not allow"):
        run("", "when rail.s > 1 m then reinit(b.vy, 2 m/s); end when;")


@pytest.mark.parametrize(("limit", "at"), [(2, 2.0), (-1, 0.0)])
def test_assertions_about_the_motion_hold_all_the_time(limit, at):
    """As of Modelica: at the start and during the run; one that holds is no event."""
    with pytest.raises(IntegrationError, match=rf"is false at t = {at:g} s .*too far"):
        run("", f'assert(rail.s < {limit} m, "too far");')
    assert run("", 'assert(rail.s < 9 m, "too far");').events == []


def test_a_run_may_end_at_its_start():
    found = run("", 'when initial() then terminate("at once"); end when;')
    assert found.t[-1] == 0.0 and found.stats["terminated"] == "at once"


#: a force with a corner at 0.5 m
CORNER = "if rail.s < 0.5 m then 0 N else -100 N/m*(rail.s - 0.5 m)"


@pytest.mark.parametrize(
    ("force", "events"),
    [
        (CORNER.replace("-100 N/m*(rail.s - 0.5 m)", "-9 N"), 1),
        (f"noEvent({CORNER.replace('-100 N/m*(rail.s - 0.5 m)', '-9 N')})", 0),
        (f"smooth(2, {CORNER})", 0),
    ],
)
def test_relations_without_events_are_not_located(force, events):
    text = MODEL.format(declared=f"Force f(b.c, fx = {force});", events="", before="")
    text = text.replace("rail.v = 1 m/s", "rail.v = 1.01 m/s")
    found = mbdsl.simulate(mbdsl.parse(text), stop=0.6, tol=1e-4, method="radau5")
    assert found.stats["events"] == events
    x = 0.5 / 1.01
    if "9 N" in force:
        # with an event exact, without one within the tolerance, which counts relative to the speed
        assert found["rail.v"][-1] == pytest.approx(1.01 - 9 * (0.6 - x), abs=2e-4 if events == 0 else 1e-9)


def test_expressions_without_events_differ_from_those_with():
    from mbdsl.expressions.derivatives import diff
    from mbdsl.expressions.symbolic import QUIET, call, input_signal, walk, without_events

    x = input_signal("x")
    located = call("select", call("lt", x, 0.0), x * x, call("abs", x))
    quiet = without_events(located)
    assert quiet is not located and {n.value for n in walk(quiet) if n.op in ("lt", "abs")} == {QUIET}
    assert without_events(quiet) is quiet
    assert np.all([diff(quiet, x)[0].op == "select"])


def controlled():
    b = mbdsl.Builder("M")
    ground, body = b.Ground("ground"), b.Body("b", m=1, I=1)
    rail = b.Prismatic("rail", ground, body.c)
    u, n = b.discrete("u", 0.0, unit="N"), b.discrete("n", 0, type="Integer")
    on, _ = b.discrete("on", False, type="Boolean"), b.discrete("x", [1.0, 2.0])
    b.Force("f", body.c, fx=u)
    b.initial(rail.s, 1.0)
    b.initial(rail.v, 0.0)
    return b, rail, u, n, on


def test_a_builder_makes_the_scene_of_the_text():
    b, _, u, _, on = controlled()
    b.when("sample(0, 10 ms)", {u: "-4 N/m*rail.s - 2 N.s/m*rail.v"}, "n = pre(n) + 1")
    b.when("rail.s < 0.5 m", {on: True, "x[2]": 7},
           elsewhen=[("rail.s < 0.3 m", "x[1] = pre(x[1])*2;", "reinit(rail.v, 0 m/s)")])  # fmt: skip
    b.when(["rail.s < 0.1 m", "n > 150"], 'terminate("done")')
    b.assertion("rail.s < 2 m", "far")
    text = mbdsl.parse("""model M
      Ground ground; Body b(m = 1, I = 1); Prismatic rail(ground, b.c);
      discrete Real u(start = 0, unit = "N"); discrete Integer n(start = 0);
      discrete Boolean on(start = false); discrete Real x[2](start = {1, 2});
      Force f(b.c, fx = u);
    initial equation
      rail.s = 1; rail.v = 0;
    equation
      when sample(0, 10 ms) then u = -4 N/m*rail.s - 2 N.s/m*rail.v; n = pre(n) + 1; end when;
      when rail.s < 0.5 m then on = true; x[2] = 7;
      elsewhen rail.s < 0.3 m then x[1] = pre(x[1])*2; reinit(rail.v, 0 m/s); end when;
      when {rail.s < 0.1 m, n > 150} then terminate("done"); end when;
      assert(rail.s < 2 m, "far");
    end M;""")
    assert b.scene() == text and text.events == b.scene().events
    run = mbdsl.simulate(b, stop=2, method="hht-si2", step=2e-3)
    assert run.stats["terminated"] == "done" and run["n"][-1] == 151
    assert "`rail.s < 0.5 m`" in run.stats["acted"]


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ((), "there is nothing to do"),
        (("u == 2",), "found `u == 2` in a `when`"),
        (('terminte("x")',), "did you mean `terminate`"),
        ((5,), "found 5"),
        (({"w": 1},), "`w`"),
        (("u = rail.q",), "no `q`"),
        (("rail.s = 1",), "no discrete variable"),
        (("n = 0.5",), "whole number"),
        (("u = 2 kg",), "found a mass"),
    ],
)
def test_a_builder_refuses_what_a_text_refuses(actions, message):
    from mbdsl.errors import MbdslError

    b, *_ = controlled()

    def declare():
        b.when("rail.s > 1 m", *actions)
        b.scene()

    with pytest.raises(MbdslError) as problem:
        declare()
    assert message in str(problem.value)


def test_whens_go_with_what_they_name():
    from mbdsl.errors import UsageError

    b, _, u, _, on = controlled()
    b.when("rail.s < 0.5 m", {on: True})
    b.when("time > 1 s", {u: 1.0})
    with pytest.raises(UsageError, match=r"`u` cannot be removed: f, when time > 1 s refer to it"):
        b.remove(u)
    assert b.remove(u, dependents=True) == ("u", "f")
    assert len(b.scene().events.whens) == 1


def test_outputs_are_variables():
    declared = "output Real y = 3*rail.s/(1 m); output Integer n(start = 0);"
    found = run(declared, "when rail.s > 0.1 m then n = 2; end when;")
    np.testing.assert_allclose(found["y"], 3 * found["rail.s"], rtol=1e-14)
    assert found["n"][-1] == 2
