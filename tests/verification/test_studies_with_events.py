"""What is claimed of accuracy by studies of models with events, against closed forms: oscillators of 1 rad/s whose
motion between events is an arc of a circle."""

import math

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError, UsageError

MODEL = """model M
  parameter Real e = 0.7;
  Ground ground(g = 10 m/s2);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c{joint});
  TranslationalSpringDamper k(rail, k = 1 N/m);
  {declared}
initial equation
  rail.s = 1 m; rail.v = 0 m/s;
equation
  {events}
end M;"""
#: the parts of a model: what is declared, its events, and what the joint has
PARTS = {
    "reinit": ("", "when rail.s < -0.4 m then reinit(rail.v, -e*rail.v); end when;", ""),
    "sample": (
        'discrete Real F(unit = "N", start = 0); Force f(b.c, fx = F);',
        "when sample(0, 0.25 s) then F = -e*(1 N/m)*rail.s; end when;",
        "",
    ),
    "contact": ("Contact stop(gap = rail.s + 0.4 m, e = e);", "", ""),
    "sticks": ("", "", ", mu = 0.03*e, mu_s = 0.05, sticks = true"),
    "state": ("Real z(start = 1); Force f(b.c, fx = 1 N*z);", "der(z) = -e*z/(1 s);", ""),
}
HIT = math.acos(-0.4)  #: the first impact [s]


def model(name):
    declared, events, joint = PARTS[name]
    return mbdsl.parse(MODEL.format(declared=declared, events=events, joint=joint))


def turned(s, v, t, f=0.0):
    """x'' = f - x from (s, v), after t."""
    c, d = np.cos(t), np.sin(t)
    return f + (s - f) * c + v * d, v * c - (s - f) * d


def of_wall(t, e):
    s, v = turned(1.0, 0.0, HIT)
    since = t - HIT
    while since > 0.0:
        v *= -e
        again = 2.0 * (math.pi - math.atan2(v, 0.4))  # until it falls to -0.4 m
        if since < again:
            return turned(s, v, since)
        since, v = since - again, -v
    return turned(1.0, 0.0, t)


def of_sample(t, e):
    s, v, held = 1.0, 0.0, -e
    for _ in range(int(t / 0.25)):
        s, v = turned(s, v, 0.25, held)
        held = -e * s
    return turned(s, v, t - 0.25 * int(t / 0.25), held)


def of_sticks(t, e):
    """Half a turn about 0.3 e or -0.3 e each time, until the spring pulls with less than 0.5 N."""
    s, f = 1.0, 0.3 * e
    while t > math.pi and abs(s) > 0.5:
        s, t, f = 2.0 * f - s, t - math.pi, -f
    return turned(s, 0.0, t, f) if abs(s) > 0.5 else (s, 0.0)


def of_state(t, e):
    """x = A cos t + B sin t + exp(-e t)/(1 + e^2)."""
    p = 1.0 / (1.0 + e * e)
    s, v = turned(1.0 - p, e * p, t)
    return s + p * math.exp(-e * t), v - e * p * math.exp(-e * t)


EXACT = {"reinit": of_wall, "contact": of_wall, "sample": of_sample, "sticks": of_sticks, "state": of_state}


def errors(name, run, e=0.7):
    """The errors (N,) of positions, relative to the size of the mechanism, 1 m, and of velocities, relative to the
    largest, without outputs at an event."""
    s, v = np.array([EXACT[name](t, e) for t in run.t]).T
    error = np.maximum(np.abs(run["rail.s"] - s), np.abs(run["rail.v"] - v) / np.abs(v).max())
    jumps = np.abs(run["rail.v"] - v) > 0.5 if name in ("reinit", "contact") else np.zeros(len(s), bool)
    assert jumps.sum() <= 1 and (np.abs(run.t[jumps] - HIT) < 2e-5).all()
    return np.where(jumps, 0.0, error)


@pytest.mark.parametrize("name", PARTS)
def test_an_accuracy_is_reached_and_the_error_is_true(name):
    """Outputs lie just behind the first impact, where one run is behind it and another one before it."""
    run = mbdsl.simulate(model(name), accuracy=1e-4, stop=3 * (HIT + 5e-7), interval=HIT + 5e-7)
    fine = mbdsl.simulate(model(name), accuracy=1e-4, stop=6.0, interval=0.05)
    for found in (run, fine):
        error, said = errors(name, found).max(), found.stats["accuracy"]
        assert error <= 1e-4 and error <= 3 * said["estimated"] + 1e-12
        assert said["not checked"] is None


@pytest.mark.parametrize("name", PARTS)
def test_verify_counts_times_of_events_and_not_jumps(name):
    run = mbdsl.simulate(model(name), method="hht-si2", tol=1e-4, stop=3 * (HIT + 1e-5), interval=HIT + 1e-5)
    found = mbdsl.study.verify(run, ["rail.s", "rail.v"])
    true = errors(name, run).max()
    assert not found.problem
    for x in found.agreements:
        assert 3.5 < x.digits < 2.0 - math.log10(true)


@pytest.mark.parametrize("name", PARTS)
def test_errors_of_studies_are_true(name, tmp_path):
    """The errors of a convergence study are those of the same runs against the closed form, of order 2."""
    interval = HIT + 1e-5
    steps = [interval / n for n in (80, 160, 320)]
    given = {"steps": steps, "stop": 2 * interval, "store": tmp_path / "store", "workers": 1}
    rows = mbdsl.study.convergence(model(name), methods=["hht-si2"], **given).survey.rows
    said = [max(row.errors["q"].scaled, row.errors["v"].scaled) for row in rows]
    true = [errors(name, row.trajectory).max() for row in rows]
    assert len(said) == 3 and said == pytest.approx(true, rel=1e-4)
    assert np.log2(np.array(said[:-1]) / said[1:]) == pytest.approx(2.0, abs=0.1)
    assert max(row.errors["Phi"].scaled for row in rows) < 1e-9


@pytest.mark.parametrize("name", PARTS)
def test_sweeps_know_events(name, tmp_path):
    given = {"stop": 6.0, "tol": 1e-6, "store": tmp_path / "store", "workers": 1}
    swept = mbdsl.sweep(model(name), {"e": [0.4, 0.7]}, "final(rail.s)", **given)
    assert swept["final(rail.s)"] == pytest.approx([EXACT[name](6.0, e)[0] for e in (0.4, 0.7)], abs=1e-5)


@pytest.mark.parametrize("method", ["scipy-radau", "ida"])
@pytest.mark.parametrize("name", PARTS)
def test_backends_work_or_say_why(name, method):
    if name == "state":
        run = mbdsl.simulate(model(name), method=method, tol=1e-6, stop=6.0, interval=0.5)
        assert errors(name, run).max() <= 1e-5
        return
    what = {"contact": "the rigid contact `stop`", "sticks": "friction that sticks, of `rail`"}.get(name, "the `when`")
    with pytest.raises(UsageError, match=f"does not know {what}") as problem:
        mbdsl.simulate(model(name), method=method, tol=1e-6, stop=6.0)
    assert problem.value.span.line in (5, 7, 11)


def test_linear_models_know_open_contacts_and_discrete_variables():
    contact = model("contact")
    for at in ("start", "1 s"):
        assert [x.frequency for x in mbdsl.eigen(contact, at=at).modes] == pytest.approx([1.0 / (2.0 * math.pi)])
    with pytest.raises(InitialisationError, match="a rigid contact that is closed, as `stop` is") as problem:
        mbdsl.eigen(contact, at={"rail.s": "-0.4 m"})
    assert problem.value.span.line == 7
    assert mbdsl.static(contact, without=["contact"])["rail.s"] == pytest.approx(0.0, abs=1e-9)
    switched = MODEL.format(
        declared='discrete Real more(unit = "N/m", start = 0); Force f(b.c, fx = -more*rail.s);',
        events="when sample(0.5 s, 1 s) then more = 3 N/m; end when;",
        joint="",
    )
    found = [mbdsl.eigen(mbdsl.parse(switched), at=at).modes[0].frequency for at in ("start", "0.4 s", "1 s")]
    assert 2.0 * math.pi * np.array(found) == pytest.approx([1.0, 1.0, 2.0])


def test_studies_know_discrete_variables_and_forces_of_contacts(tmp_path):
    """F holds -0.7 of the position at the last sample; a growing force presses a body against a stop."""
    given = {"methods": ["hht-si2", "radau5"], "stop": 3.0, "store": tmp_path / "store", "workers": 1}
    sampled = mbdsl.study.convergence(model("sample"), steps=[0.05], tols=[1e-6], signals=["F", "b.ax"], **given).survey
    for row in sampled.rows:
        F = [-0.7 * of_sample(0.25 * int((t + 1e-9) / 0.25), 0.7)[0] if t >= 0.0 else 0.0 for t in row.trajectory.t]
        error = np.abs(row.trajectory["F"] - F).max() / np.ptp(F)
        assert row.errors["F"].scaled == pytest.approx(error, rel=1e-4)
        assert error < (1e-3 if row.case.step else 1e-5)
    pressed = mbdsl.parse(
        "model P Ground o; Body b(m = 1 kg, I = 1 kg.m2); Prismatic s(o, b.c); Force f(b.c, fx = 1 N + 1 N/s*time); "
        "Contact stop(gap = 1 m - s.s, e = 0); initial equation s.s = 0 m; s.v = 0 m/s; end P;"
    )
    found = mbdsl.study.convergence(pressed, steps=[0.05], signals=["stop.force"], **given).survey
    for row in found.rows:
        closed = row.trajectory.t > 1.3  # t^2/2 + t^3/6 = 1 at 1.1958 s
        assert row.trajectory["stop.force"][closed] == pytest.approx(1.0 + row.trajectory.t[closed], rel=1e-6)
        assert row.errors["stop.force"].scaled < 1e-2


def test_verify_compares_runs_that_terminate_at_slightly_different_times():
    """cos t = 0.3 at t = 1.2661 s; the period of the method is longer, so that the second run, with h/2, ends first."""
    model = mbdsl.parse("""model M Ground g; Body b(m = 1 kg, I = 1 kg.m2); Prismatic rail(g, b.c);
      TranslationalSpringDamper spring(rail, k = 1 N/m);
    initial equation rail.s = 1 m; rail.v = 0 m/s;
    equation when rail.s < 0.3 m then terminate("there"); end when; end M;""")
    run = mbdsl.simulate(model, stop=2.0, step=0.02, interval=0.02, method="hht-si2")
    assert run.t[-1] == pytest.approx(math.acos(0.3), abs=1e-3) and run.t[-1] > math.acos(0.3)
    found = mbdsl.study.verify(run, ["b.x", "b.vx"])
    assert not found.problem and run.t[-2] < found.until < run.t[-1]
    assert all(3.0 < a.digits < 16.0 for a in found.agreements)
