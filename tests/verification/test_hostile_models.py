"""Models that cannot be simulated as they are written: each ends at once, with its line, the reason and a remedy.

Expected values: a body falls by g t^2/2; impacts at a gap s - 0.51 m.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError, MbdslError, ModelError
from mbdsl.integrators.loop import loop_state as S
from mbdsl.lang.source import Source

MODEL = """model H
  Ground ground;
  Frame up(ground, phi = 90 deg);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(up, b.c);
  {declared}
initial equation
  rail.s = 1 m; rail.v = 0 m/s;
equation
  {events}
end H;"""
CLOCK = "when sample(0, 1 ms) then {} end when;"
#: declarations, events, line of the error, and its text
CASES = {
    "a gap that loses its value": (
        "Contact floor(gap = sqrt(rail.s/(1 m) - 0.5)*1 m + 0.1*rail.s, e = 0.5);",
        "",
        6,
        "the gap of `floor` has no value at t = 0.319",
    ),
    "a variable that overflows": (
        "Real x(start = 1);",
        CLOCK.format("x = pre(x)*1e10;"),
        10,
        "`x` at t = 0.03 s: the value is inf",
    ),
    "a force that is not a number": (
        "Real x(start = 1); Force f(b.c, fx = x*1 N);",
        "when sample(0, 0.5 s) then x = sqrt(0.2 - time/(1 s)); end when;",
        10,
        "`x` at t = 0.5 s: the value is nan",
    ),
    "a count that is rounded": (
        "Integer n(start = 1);",
        CLOCK.format("n = pre(n)*1000000;"),
        10,
        "the whole number 1e\\+18 is too large",
    ),
    "a condition on a fast sine": (
        "Integer n(start = 0);",
        "when sin(1e9*time/(1 s)) > 0 then n = pre(n) + 1; end when;",
        10,
        "the when-equation acts again and again",
    ),
    "a condition of a tiny period": (
        "Integer n(start = 0);",
        "when mod(time, 1e-9 s) > 0.5e-9 s then n = pre(n) + 1; end when;",
        10,
        "the when-equation acts again and again",
    ),
    "a law of a tiny period": (
        "Force f(b.c, fy = if mod(time, 1e-9 s) > 0.5e-9 s then 1 N else 2 N);",
        "",
        6,
        "a condition on time changes so often that the run would not end",
    ),
    "bounces with a tight tolerance": (
        "",
        "when rail.s <= 0 m then reinit(rail.v, -0.5*rail.v); end when;",
        10,
        "the when-equation acts again and again",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_runs_end_with_the_line(name):
    declared, events, line, expected = CASES[name]
    model = mbdsl.parse(MODEL.format(declared=declared, events=events))
    stop = 3600.0 if "tiny" in name or "fast" in name else 3.0
    with pytest.raises(MbdslError, match=expected) as found:
        mbdsl.simulate(model, method="hht-si2", tol=1e-7, stop=stop)
    assert found.value.span is not None and found.value.span.line == line
    assert found.value.hint


@pytest.mark.parametrize("gap", ["abs(rail.s)", "sqrt(rail.s*1 m)", "rail.s^2/(1 m)", "hypot(b.x, b.y) + 1 mm"])
def test_a_gap_that_is_never_negative_is_an_error(gap):
    with pytest.raises(ModelError, match="not negative at any position"):
        mbdsl.parse(MODEL.format(declared=f"Contact floor(gap = {gap}, e = 0.5);", events=""))


def test_gaps_that_may_be_negative_are_possible():
    for gap in ("abs(rail.s) - 1 mm", "hypot(b.x, b.y) - 1 mm", "rail.s^3/(1 m2)", "max(rail.s, b.x)"):
        mbdsl.parse(MODEL.format(declared=f"Contact floor(gap = {gap}, e = 0.5);", events=""))


def test_a_gap_without_a_value_behind_its_zero_closes():
    """The step across the impact ends where the gap has no value."""
    model = MODEL.format(declared="Contact floor(gap = sqrt(rail.s/(1 m) - 0.5)*1 m - 0.1 m, e = 0.5);", events="")
    run = mbdsl.simulate(mbdsl.parse(model), method="hht-si2", step=0.02, stop=1.0)
    assert run["floor.impacts"][-1] > 1
    assert run["rail.s"].min() > 0.51 - 1e-6


DRIVEN = """
  Body c(m = 1 kg, I = 1 kg.m2);
  Prismatic other(up, c.c);
  TranslationalDriver d(other, s = 1.5 m - 2 m/s*time);
  Contact hit(gap = c.y - b.y, e = 0);
  Contact floor(gap = b.y - 0.9 m, e = 0);"""


@pytest.mark.parametrize(
    ("declared", "names", "line"),
    [
        ("TranslationalDriver d(rail, s = 1 m - 1 m/s*time); Contact floor(gap = rail.s, e = 0.5);", "`floor`", 6),
        (DRIVEN, "`hit`, `floor`", 9),  # the driven body is a part of the ground
    ],
)
@pytest.mark.parametrize(
    "given", [{"method": "hht-si2", "tol": 1e-5}, {"method": "moreau-jean", "step": 1e-2}], ids=str
)
def test_a_driver_that_moves_bodies_into_a_contact_is_named(declared, names, line, given):
    text = MODEL.format(declared=declared, events="")
    if "(rail," in declared:
        text = text.replace("rail.s = 1 m; rail.v = 0 m/s;", "")
    with pytest.raises(IntegrationError, match=rf"contacts {names}.*: `d` prescribes a motion") as found:
        mbdsl.simulate(mbdsl.parse(text), stop=3.0, **given)
    assert [span.line for _, span in found.value.notes] == [line]


@pytest.mark.parametrize("gap", ["rail.s^3/(1 m2)", "1e-9*rail.s"])
def test_a_gap_whose_derivative_is_zero_where_it_closes(gap):
    """No impulse acts along it; the body stopped in silence, whatever its restitution."""
    text = MODEL.format(declared=f"Contact c(gap = {gap}, e = 0.5);", events="").replace("rail.v = 0", "rail.v = -1")
    with pytest.raises(mbdsl.MbdslError, match="the gap of `c` hardly changes with the positions where it closes"):
        mbdsl.simulate(mbdsl.parse(text), stop=3.0, step=0.01, method="hht-si2")


def test_a_gap_that_jumps_into_an_overlap_by_an_input():
    """The body was moved out of the overlap in silence."""
    declared = (
        'input Real h(unit = "m", start = 0); Force hold(b.c, fy = 9.81 N); Contact c(gap = rail.s - h, e = 0.5);'
    )
    simulation = mbdsl.Simulation(mbdsl.parse(MODEL.format(declared=declared, events="")), step=0.01)
    simulation.step(5)
    simulation.inputs["h"] = 1.2
    with pytest.raises(IntegrationError, match=r"the gap of `c` jumps from 1 to -0\.2 m at t = 0\.05 s"):
        simulation.step(5)


@pytest.mark.parametrize("given", [{"step": 0.01}, {"tol": 1e-4}, {"step": 0.01, "method": "radau5"}], ids=str)
def test_a_gap_that_jumps_into_an_overlap(given):
    """A step h of 0.3 m at each tick, below a body at 1 m; the bodies overlapped in silence, or "at the start"."""
    declared = (
        'discrete Real h(unit = "m", start = 0); Force hold(b.c, fy = 9.81 N); Contact c(gap = rail.s - h, e = 0);'
    )
    text = MODEL.format(declared=declared, events="when sample(0.1, 0.1) then h = pre(h) + 0.3; end when;")
    with pytest.raises(IntegrationError, match=r"the gap of `c` jumps from 0\.1 to -0\.2 m at t = 0\.4 s") as found:
        mbdsl.simulate(mbdsl.parse(text), **{"method": "hht-si2", "stop": 1.0, **given})
    assert found.value.span.line == 6
    model = mbdsl.parse(text.replace("0.3;", "0.05;"))  # it does not reach the body in 1 s
    assert mbdsl.simulate(model, **{"method": "hht-si2", "stop": 1.0, **given})["c.gap"][-1] == pytest.approx(0.5)


def test_what_is_terminal_acts_behind_terminate():
    events = 'when time > 0.5 s then terminate("end"); end when; when terminal() then n = 1; end when;'
    model = MODEL.format(declared="Integer n(start = 0);", events=events)
    assert mbdsl.simulate(mbdsl.parse(model), method="hht-si2", tol=1e-5, stop=1.0)["n"][-1] == 1


def test_places_in_one_line_share_its_text():
    """If each place kept its line, the memory for a line of many words would grow with the square of its length."""
    source = Source("m.mbd", "model M end M;" * 100)
    assert source.span(0, 5).text is source.span(700, 705).text


SHARED = """model Share
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2), c(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c), along(ground, c.c);
  Contact left(gap = b.x, e = 0), right(gap = 2*b.x, e = 0);
  Force push(b.c, fx = -10 N);
  Force f(c.c, fx = {law});
  Integer n(start = 0);
initial equation
  rail.s = 0 m; rail.v = 0 m/s; along.s = 0 m; along.v = 0 m/s;
equation
  when {condition} then n = 1; end when;
end Share;"""


def test_laws_that_read_shared_reactions_have_a_warning():
    """The equations only determine left + 2 right = 10 N."""
    together = "(left.force + 2*right.force)"
    cases = {
        ("left.force", f"{together} > 20 N"): ["Force `f`"],
        (f"0.1*{together}", "right.force > 20 N"): ["the `when`"],
        (f"0.1*{together}", f"{together} > 20 N"): [],
    }
    for (law, condition), names in cases.items():
        model = mbdsl.parse(SHARED.format(law=law, condition=condition))
        run = mbdsl.simulate(model, method="hht-si2", tol=1e-4, stop=0.01)
        found = [x for x in run.stats["warnings"] if "not unique" in x]
        assert len(found) == len(names)
        assert all(x in y and "`left`, `right`" in y for x, y in zip(names, found, strict=True))
    assert np.allclose(run["along.v"], 1.0 * run.t, rtol=1e-6)  # 0.1*10 N on 1 kg


def test_shared_reactions_are_read_with_the_present_inputs():
    text = SHARED.replace("  Ground", "  input Real k(start = 0);\n  Ground", 1)
    model = mbdsl.parse(text.format(law="k*left.force", condition="time > 0.5 s"))
    run = mbdsl.Simulation(model, step=0.1, method="hht-si2")
    read = run._single.set.contacts.read
    run.step(2)
    assert not read.found
    run.inputs["k"] = 1.0
    run.step(4)
    assert [x.reader.name for x in read.found] == ["the law of Force `f`"]


def test_a_condition_on_a_reaction_that_makes_no_progress_names_its_contact(monkeypatch):
    """Also where it is not known which condition changes."""
    monkeypatch.setattr("mbdsl.integrators.events.SwitchEvents.come", lambda self: (S.SLIDING, None))
    monkeypatch.setattr("mbdsl.integrators.events.SwitchEvents.changing", property(lambda self: []))
    text = MODEL.format(declared="Contact floor(gap = rail.s, e = 0.5);", events="")
    text = text.replace("rail.v = 0", "rail.v = -1")
    with pytest.raises(IntegrationError, match=r"a condition on a reaction .* changes in the gap of Contact floor"):
        mbdsl.simulate(mbdsl.parse(text), method="hht-si2", tol=1e-4, stop=3.0)
