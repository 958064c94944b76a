"""Events that never end: each run stops at once, and names the lines."""

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import IntegrationError, MbdslError
from mbdsl.integrators import compiled

METHODS = sorted(set(compiled()) - {"kinematic", "moreau-jean"})
MODEL = """model H
  Ground ground;
  Frame up(ground, phi = 90 deg);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(up, b.c);
  {declared}
initial equation
  rail.s = {s} m; rail.v = {v} m/s;
equation
  {events}
end H;"""
#: declarations, events, start, and text of the message
CASES = {
    "fires itself": (
        "Integer x(start = 0), y(start = 0); Real n = pre(x) + pre(y);",
        """when rail.s < 0.5 m then x = 1; elsewhen mod(n, 2) > 0.5 then x = pre(x) + 1; end when;
           when mod(n, 2) > 0.5 then y = pre(y) + 2; elsewhen mod(n, 2) < 0.5 then y = pre(y) + 1; end when;""",
        (1.0, 0.0),
        "the when-equations act without end",
    ),
    "two that fight": (
        "Boolean on(start = false); Force f(b.c, fy = if on then 5 N else 15 N);",
        "when rail.v > 1 m/s then on = true; elsewhen rail.v < 1 m/s then on = false; end when;",
        (0.0, 0.0),
        "the when-equation acts again and again",
    ),
    "bounces without end": (
        "",
        "when rail.s <= 0 m then reinit(rail.v, -0.5*rail.v); end when;",
        (1.0, 0.0),
        "the when-equation acts again and again",
    ),
    "impact without a solution": (
        "TranslationalDriver d(rail, s = 1 m - 1 m/s*time); Contact floor(gap = rail.s, e = 0.5);",
        "",
        (1.0, -1.0),
        "no impulses satisfy the laws of the contacts `floor`",
    ),
    "sample of a picosecond": (
        "Integer n(start = 0);",
        "when sample(0, 1e-12 s) then n = pre(n) + 1; end when;",
        (1.0, 0.0),
        "ticks 3.6e+15 times",
    ),
}


def model(name):
    declared, events, (s, v), expected = CASES[name]
    start = {"impact without a solution": "initial equation\n  rail.s = 1.0 m; rail.v = -1.0 m/s;\n"}.get(name, "")
    return MODEL.format(declared=declared, events=events, s=s, v=v).replace(start or "\0", ""), expected


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("given", [{"tol": 1e-4}, {"step": 7e-3}], ids=str)
@pytest.mark.parametrize("name", CASES)
def test_runs_end_and_name_the_line(name, given, method):
    text, expected = model(name)
    with pytest.raises(MbdslError, match=expected.replace("+", r"\+")) as found:
        mbdsl.simulate(mbdsl.parse(text), method=method, stop=3600.0 if "sample" in name else 3.0, **given)
    assert found.value.span is not None
    assert found.value.hint


def test_a_bouncing_body_does_not_fall_through_the_floor():
    """Bounces become shorter than a fixed step: the run ends at the limit of their times, t1 (1 + e)/(1 - e)."""
    text, _ = model("bounces without end")
    with pytest.raises(IntegrationError) as found:
        mbdsl.simulate(mbdsl.parse(text), method="hht-si2", step=7e-3, stop=3.0)
    run = found.value.trajectory
    assert run["rail.s"].min() > -1e-9
    assert run.t[-1] == pytest.approx(3.0 * np.sqrt(2.0 / 9.81), abs=7e-3)


def test_the_shell_ends_with_code_4_and_the_line(tmp_path, capsys):
    path = tmp_path / "h.mbd"
    path.write_text(model("two that fight")[0])
    assert main(["simulate", str(path), "--stop", "3", "--output", str(tmp_path / "h.csv")]) == 4
    error = capsys.readouterr().err
    assert "h.mbd:10:8" in error and "hysteresis" in error


RELAY = """
  Boolean on(start = true);
  Force f(b.c, fy = 9.81 N + (if on then 1 N else -1 N));
initial equation
  rail.s = 0 m; rail.v = 0 m/s;
equation
  when rail.v > {half} m/s then on = false; elsewhen rail.v < -{half} m/s then on = true; end when;
  when time > {end} s then terminate("a part of the run"); end when;
end H;"""


@pytest.mark.parametrize("half", [0.25e-3, 1e-6])
@pytest.mark.parametrize("given", [{"tol": 1e-3}, {"step": 1e-3}], ids=str)
def test_a_relay_is_no_chatter_in_a_long_run(half, given):
    """With 1 m/s2 it switches every 2 half seconds, at 1 kHz and 250 kHz, of a run of an hour."""
    text = MODEL.partition("  {declared}")[0] + RELAY.format(half=half, end=100 * half)
    run = mbdsl.simulate(mbdsl.parse(text), stop=3600.0, **given)
    assert run.t[-1] == pytest.approx(100 * half, rel=1e-6)
    switched = [e.t for e in run.events if e.kind == "when"]
    np.testing.assert_allclose(switched, half * (1 + 2 * np.arange(50)), rtol=1e-6)
    assert np.abs(run["rail.v"]).max() <= half * (1 + 1e-6)
