"""Runs with fixed steps that pass over a pulse or a window warn, with the law, its line, the time, and a sufficient
step.

A mass of 1 kg slides without friction. The truth is the momentum of the force, or its work: of 1 N.s or 1 J here, which
steps of 50 ms miss altogether.
"""

import re

import numpy as np
import pytest

from mbdsl import cli, resume, simulate
from mbdsl.integrators.missed_peaks import BATCH
from mbdsl.lang.load import parse_text
from mbdsl.simulation.checkpoint import Checkpoint

STEP = 0.05
TEXT = """model Unseen
  {tables}
  Ground ground(g = 0);
  Body b(m = 1.0, I = 1);
  Prismatic s(ground, b.c);
  TranslationalSpringDamper law(s,
    force = -({force}));
initial equation
  s.s = 0.0;
  s.v = {v};
  annotation(experiment(StopTime = 5));
end Unseen;
"""
PEAK = float(1.0 / np.sqrt(np.pi))
#: tables, force [N], largest force, speed at the start and at the end, time of the peak
CASES = {
    "pulse": ("", f"{PEAK / 0.005!r}*exp(-((time - 3.325)/0.005)^2)", PEAK / 0.005, 0.0, 1.0, 3.325),
    "window of time": ("", "if time > 3.312 and time < 3.332 then 50 else 0", 50.0, 0.0, 1.0, 3.322),
    "table": (
        "Table p(table = [0, 0; 3.315, 0; 3.325, 100; 3.335, 0; 5, 0]);",
        "p(time)",
        100.0,
        0.0,
        1.0,
        3.325,
    ),
    "window of position": (
        "",
        "if s.s > 1.012 and s.s < 1.032 then 50 else 0",
        50.0,
        1.0,
        np.sqrt(3.0),
        1.012 + (np.sqrt(3.0) - 1.0) / 50.0 / 2.0,
    ),
    "narrow spring": (
        "",
        f"{PEAK / 0.005!r}*exp(-((s.s - 1.025)/0.005)^2)",
        PEAK / 0.005,
        1.0,
        np.sqrt(3.0),
        1.025,
    ),
    "far behind": ("", f"{PEAK / 5e-6!r}*exp(-((time - 4.999525)/5e-6)^2)", PEAK / 5e-6, 0.0, 1.0, 4.999525),
}
SAYS = re.compile(
    r"unseen\.mbd:6:\d+: the law of TranslationalSpringDamper law has a peak near t = (\S+) s, within the step from "
    r"(\S+) to (\S+) s, that the ends of the step do not show: a short pulse is lost there, a corner changes little, "
    r"and fixed steps do not estimate which; try a tolerance instead, or a step of (\S+) s"
)


def peaks(run):
    return [text for text in run.stats["warnings"] if "peak" in text]


@pytest.mark.parametrize("method", ["hht-si2", "newmark", "radau5"])
@pytest.mark.parametrize("name", CASES)
def test_a_missed_peak_is_named_and_what_is_advised_sees_it(name, method, tmp_path):
    tables, force, largest, v0, v1, when = CASES[name]
    path = tmp_path / "unseen.mbd"
    path.write_text(TEXT.format(tables=tables, force=force, v=v0))
    h = 1e-4 if name == "far behind" else STEP
    run = simulate(path, method=method, step=h)
    if method == "radau5":  # whose stages may meet it
        assert abs(run["s.v"][-1] - v1) > 0.1
    else:
        assert abs(run["s.v"][-1] - v0) < 1e-6  # the whole pulse is missed
    (text,) = peaks(run)
    found = SAYS.search(text)
    assert found, text
    time, start, end, advised = (float(x) for x in found.groups())
    assert start < when < end and end - start == pytest.approx(h, rel=1e-3)
    # on the path, the motion without the force is used; times are printed with 6 digits
    assert abs(time - when) < 0.2 * h
    if name != "far behind":  # otherwise it takes a million steps
        run = simulate(path, method=method, step=advised)
        assert peaks(run) == []
        assert abs(run["s.v"][-1] - v1) < advised * largest


@pytest.mark.parametrize("base", [-300.0, 300.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_peak_is_missed_whatever_the_force_around_it(sign, base):
    force = f"if time > 3.312 and time < 3.332 then {base + 50.0 * sign} else {base}"
    run = simulate(parse_text(TEXT.format(tables="", force=force, v=0.0)), method="newmark", step=STEP, interval=STEP)
    (text,) = peaks(run)
    assert "has a peak near t = 3.3" in text


@pytest.mark.parametrize(
    "force",
    [
        "1*sin(6*time)*exp(-time/1 s)",
        "-10*tanh(s.v/0.01) - 10*s.s",
        "if time > 3.3333 then 1 else 0",
        "100*exp(-((time - 3.325)/0.2)^2)",
        "if s.s > 1.0123 then -100*(s.s - 1.0123) else 0",
        "5*(cos(2*time/10) - 1 + (2*time/10)^2/2)",  # rounding, at the start
    ],
)
def test_what_steps_resolve_is_none_of_it(force):
    run = simulate(parse_text(TEXT.format(tables="", force=force, v=1.0)), step=STEP, interval=STEP)
    assert peaks(run) == []


def test_the_command_names_a_driver(tmp_path, monkeypatch, capsys):
    """The rod turns by 1 rad and back within a step, and pulls a mass by a spring."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cam.mbd").write_text(
        """model Cam
  Ground g0; Rod rod(m = 1 kg, length = 1 m); Revolute pin(g0, rod.a); PointMass p(m = 1 kg);
  RotationalDriver drive(pin, phi = 0.1*time/1 s + exp(-((time - 1.025 s)/3 ms)^2));
  SpringDamper spring(rod.b, p.c, k = 10 N/m);
initial equation p.x = 2 m; p.y = 0 m; p.vx = 0 m/s; p.vy = 0 m/s;
  annotation(experiment(StopTime = 2 s)); end Cam;"""
    )
    assert cli.main("simulate cam.mbd --step 50ms --quiet".split()) == 0
    err = capsys.readouterr().err
    assert "warning: cam.mbd:3:" in err and "the law of RotationalDriver drive has a peak near t = 1.02" in err


def test_what_was_found_before_a_checkpoint_is_said_after_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 1000)
    tables, force, _, v0, _, _ = CASES["window of position"]
    (tmp_path / "unseen.mbd").write_text(
        TEXT.format(tables=tables, force=force.replace("1.012", "0.4121").replace("1.032", "0.4122"), v=v0)
    )
    slices = []

    def stop(progress):
        slices.append(progress.steps)
        if progress.steps > BATCH:
            raise KeyboardInterrupt

    given = {"method": "hht-si2", "step": 4e-4}
    whole = simulate(tmp_path / "unseen.mbd", **given)
    with pytest.raises(KeyboardInterrupt):
        simulate(tmp_path / "unseen.mbd", **given, progress=stop, checkpoint=Checkpoint("run.cp"))
    assert slices[-1] > BATCH
    (text,) = whole.stats["warnings"]
    assert "near t = 0.412" in text
    assert resume("run.cp").stats["warnings"] == [text]


def test_without_such_laws_no_step_is_searched():
    from mbdsl.integrators.loop import loop_state as S
    from mbdsl.simulation.mechanism_run import MechanismRun
    from mbdsl.simulation.plan import plan
    from mbdsl.simulation.run_options import RunOptions

    for force, records in (("100*s.s + 3*sin(6*time)", False), ("-3*tanh(s.v/0.01)", True)):
        scene = parse_text(TEXT.format(tables="", force=force, v=1.0))
        motion = MechanismRun(scene, plan(scene, RunOptions(step=STEP)))
        motion.prepare()
        motion.watch()
        assert (motion.parts[0].integration.integers[S.THIN] == 0) == records


@pytest.mark.parametrize("welded", ["", "Body hat(m = 0.5, I = 1); Fixed weld(b.c, hat.c);"])
def test_the_corner_of_a_friction_is_named_and_not_called_lost(welded, tmp_path):
    """The normal force 10 t N - 10.05 N passes zero within a step: m dv/dt = -mu |N|."""
    (tmp_path / "slide.mbd").write_text(
        f"""model Slide
  Ground ground(g = 0); Body b(m = 1, I = 1); {welded}
  Prismatic s(ground, b.c,
    mu = 0.1, v_s = 1 mm/s);
  Force push(b.c, fy = 10 N/s*(time - 1.005 s));
initial equation s.s = 0; s.v = 10; annotation(experiment(StopTime = 2)); end Slide;"""
    )
    run = simulate(tmp_path / "slide.mbd", method="newmark", step=0.01)
    (text,) = peaks(run)
    assert "slide.mbd:3:13: the friction of Prismatic s has a peak near t = 1.0" in text
    assert "lost or wrong" not in text and "a corner changes little" in text
    m = 1.5 if welded else 1.0
    assert run["s.v"][-1] == pytest.approx(10.0 - 0.1 * 5.0 * (1.005**2 + 0.995**2) / m, abs=1e-4)
