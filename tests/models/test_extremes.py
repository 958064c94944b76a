"""Extremes and means over all steps, against closed forms and against the quadrature of ten thousand short steps."""

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson

import mbdsl
from mbdsl import cli, results
from mbdsl.simulation import simulate as simulation
from mbdsl.simulation.extremes import Extreme, lines

MODELS = Path(__file__).parents[2] / "models"
STEPS = 10_000
#: model, its stop time [s] and signals: coordinates, velocities, accelerations, reactions, forces, expressions
CASES = {
    "pendulum": (2.0, "mass.x", "mass.vy", "mass.ax", "mass.a", "rod.f"),
    "slider_crank": (2.0, "B.s", "rod.w", "rod.alpha", "A.f", "hypot(O.fx, O.fy)*crank.w"),
    "four_bar": (0.6, "R[1].phi", "R[2].w", "C[1].ax", "C[2].v", "D[1].f"),
    "gallery/triple_pendulum": (1.0, "A[1].phi", "rod[3].w", "A[2].f"),
    "space/heavy_top": (0.5, "top.x", "top.vz", "top.wx", "top.a", "ball.f"),
}
METHODS = {"hht-si2": 3e-6, "radau5": 1e-6, "dop853": 1e-6}  #: and their tolerances


@pytest.fixture(scope="module")
def short_steps():
    """Runs of ten thousand steps with every step in the rows."""
    known = {}

    def run(model):
        if model not in known:
            stop = CASES[model][0]
            found = mbdsl.simulate(MODELS / f"{model}.mbd", stop=stop, method="radau5", step=stop / STEPS, interval=0)
            assert len(found.t) == STEPS + 1
            known[model] = found
        return known[model]

    return run


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("model", CASES)
def test_against_ten_thousand_steps(model, method, short_steps):
    """Rows are 20 times farther apart than needed; steps of the methods are up to a quarter of a period long."""
    stop, *names = CASES[model]
    fine = short_steps(model)
    run = mbdsl.simulate(MODELS / f"{model}.mbd", stop=stop, interval=stop / 20, method=method, tol=METHODS[method])
    # the tolerance is that of positions; a step of dop853 turns the top by one radian
    near = 3e-4 if (model, method) == ("space/heavy_top", "dop853") else 3e-5
    for name, e in run.extremes(names).items():
        x = fine[name]
        size = float(np.ptp(x))
        assert e.of == "steps" and e.unit == fine.unit(name)
        assert (e.least, e.largest) == pytest.approx((x.min(), x.max()), abs=near * size)
        mean, rms = simpson(x, fine.t) / stop, math.sqrt(simpson(x**2, fine.t) / stop)
        assert (e.mean, e.rms) == pytest.approx((mean, rms), abs=near * size)
        for time, value in ((e.time_of_least, x.min()), (e.time_of_largest, x.max())):
            assert np.interp(time, fine.t, x) == pytest.approx(value, abs=near * size)
        assert run[name].min() >= e.least and run[name].max() <= e.largest


OSCILLATOR = """model O Ground g; Body b(m = 1 kg, I = 1 kg.m2); Prismatic p(g, b.c);
  TranslationalSpringDamper s(p, k = 39.47841760435743 N/m); initial equation p.s = 1 m; p.v = 0 m/s; end O;"""
TURN = 2.0 * math.pi
#: signal -> its amplitude; all are sines of the period 1 s
AMPLITUDES = {"b.x": 1.0, "p.v": TURN, "b.ax": TURN**2, "s.force": TURN**2, "3 m*p.v": 3.0 * TURN}


@pytest.mark.parametrize("how", [{"method": "dop853", "tol": 1e-7}, {"step": 1e-3}], ids=str)
def test_an_oscillator(how):
    """Of whole periods, the mean is 0 and the rms is A/sqrt(2); rows are half a period and more apart."""
    run = mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=10.0, interval=0.7, **how)
    near = 1e-6 if "tol" in how else 1e-5  # with steps of 1 ms, the frequency has the error (omega h)^2/12 = 3e-6
    for name, e in run.extremes(AMPLITUDES).items():
        found = np.array([-e.least, e.largest, math.sqrt(2.0) * e.rms]) / AMPLITUDES[name]
        assert found == pytest.approx(1.0, abs=near)
        assert e.mean == pytest.approx(0.0, abs=near * AMPLITUDES[name])
    part = run[2.1:4.9].extremes("b.x")["b.x"]  # cos(2 pi t)
    assert (part.least, part.largest, part.of) == (pytest.approx(-1.0, abs=near), pytest.approx(1.0, abs=near), "steps")
    assert part.mean == pytest.approx((math.sin(4.9 * TURN) - math.sin(2.1 * TURN)) / (2.8 * TURN), abs=10 * near)


def test_short_steps_are_not_all_kept():
    """Of steps much shorter than the motion needs, few ends are kept, and give the same extremes and means."""
    run = mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=10.0, interval=0.7, step=1e-4)
    assert len(run.steps.ends.t) < 0.05 * run.stats["steps"]
    for name, e in run.extremes(AMPLITUDES).items():
        found = np.array([-e.least, e.largest, math.sqrt(2.0) * e.rms]) / AMPLITUDES[name]
        assert found == pytest.approx(1.0, abs=1e-6)  # the frequency has the error (omega h)^2/12 = 3e-8
        assert e.mean == pytest.approx(0.0, abs=1e-6 * AMPLITUDES[name])


def test_the_first_drop_of_a_long_run(monkeypatch):
    """Steps are folded when there are too many: the results remain, memory is bounded, and other signals say so."""
    scene = mbdsl.parse(OSCILLATOR)
    given = {"stop": 30.0, "step": 1e-2, "interval": 0.7}  # a step is long enough that all ends are kept
    whole = mbdsl.simulate(scene, **given)
    monkeypatch.setattr(simulation, "MOST_KEPT", 3000)
    monkeypatch.setattr(simulation, "SLICE", 100)
    run = mbdsl.simulate(scene, **given, signals=["p.v", "s.force"])
    assert len(run.steps.ends.t) < 0.9 * len(whole.steps.ends.t)
    for name in ("p.v", "s.force"):
        a, b = run.extremes(name)[name], whole.extremes(name)[name]
        assert a.of == b.of == "steps"
        assert (a.least, a.largest, a.mean, a.rms) == pytest.approx(
            (b.least, b.largest, b.mean, b.rms),
            rel=1e-8,
            abs=1e-8,  # each fold has two more ends of quadrature
        )
        times = (a.time_of_least, a.time_of_largest)  # where a top is flat up to rounding
        assert times == pytest.approx((b.time_of_least, b.time_of_largest), abs=1e-5)
    other = run.extremes("b.x")["b.x"]
    assert other.of.startswith("steps from ") and other.of.endswith(" s on, outputs before")
    assert other.largest == 1.0
    default = mbdsl.simulate(scene, **given)
    assert default.extremes()["b.x"].of == "steps"


def test_both_sides_of_a_jump():
    """A damper acts below the height 0: its force jumps from 0 to c v there, and is largest just behind the jump."""
    g, c, stop = 9.81, 50.0, 0.6
    text = """model D Ground ground; Frame up(ground.c, phi = 90 deg); Body ball(m = 1 kg, I = 1 kg.m2);
      Prismatic guide(up, ball.c, phi0 = -90 deg);
      Force f(ball.c, fy = if guide.s < 0 m then -50 N.s/m*guide.v else 0 N);
      initial equation guide.s = 1 m; guide.v = 0 m/s; end D;"""
    v0, vn, left = math.sqrt(2.0 * g), g / c, stop - math.sqrt(2.0 / g)
    e1, e2 = math.exp(-c * left), math.exp(-2.0 * c * left)
    mean = c * (vn * left + (v0 - vn) * (1.0 - e1) / c)
    square = c**2 * (vn**2 * left + 2.0 * vn * (v0 - vn) * (1.0 - e1) / c + (v0 - vn) ** 2 * (1.0 - e2) / (2.0 * c))
    for method, tol in METHODS.items():
        run = mbdsl.simulate(mbdsl.parse(text), stop=stop, interval=0.1, method=method, tol=tol)
        e = run.extremes("f.fy")["f.fy"]
        assert (e.least, e.largest) == (0.0, pytest.approx(c * v0, rel=1e-9))
        assert e.time_of_largest == pytest.approx(math.sqrt(2.0 / g), abs=1e-9)
        assert (e.mean, e.rms) == pytest.approx((mean / stop, math.sqrt(square / stop)), rel=2e-5)
        assert run.extremes("-f.fy")["-f.fy"].least == -e.largest


def test_methods_without_steps_say_so():
    run = mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=1.0, method="scipy-dop853", interval=0.3)
    e = run.extremes("b.x")["b.x"]
    assert (e.of, e.least) == ("outputs", run["b.x"].min())
    assert "of the outputs, because the steps of the run are not known" in str(run.extremes("b.x"))
    every = mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=1.0, method="scipy-dop853", interval=0)
    assert every.extremes("b.x")["b.x"].of == "steps"
    copy = pickle.loads(pickle.dumps(run))
    assert copy.extremes("p.v")["p.v"].of == "outputs"


def test_a_result_file_contains_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("o.mbd").write_text(OSCILLATOR)
    words = ["--stop", "10s", "--interval", "0.7s", "--method", "dop853", "--tol", "1e-7"]
    assert cli.main(["simulate", "o.mbd", *words, "--signals", "p.v,2*s.force", "--output", "o.npz"]) == 0
    out = capsys.readouterr().out.splitlines()
    table = out[out.index("over all steps:") + 1 :]
    assert [line.split()[:3] for line in table] == [
        ["signal", "unit", "least"], ["p.v", "m/s", "-6.283"], ["2*s.force", "N", "-78.96"],
    ]  # fmt: skip
    rows = json.loads(results.read("o.npz")[1]["extremes"])
    assert [row[0] for row in rows] == ["p.v", "2*s.force"]
    assert rows[0][4] == pytest.approx(TURN, rel=1e-6)
    assert cli.main(["info", "o.npz"]) == 0
    assert capsys.readouterr().out.splitlines()[-3:] == table
    plot = mbdsl.plot("o.npz", "p.v")
    (marks,) = [series for series in plot.panels[0].series if series.name == "peak between outputs"]
    assert (min(marks.y), max(marks.y)) == pytest.approx((-TURN, TURN), rel=1e-6)
    assert cli.main(["convert", "o.npz", "--out", "part.npz", "--stop", "5s"]) == 0
    assert "extremes" not in results.read("part.npz")[1]
    assert cli.main(["convert", "o.npz", "--out", "o.csv"]) == 0
    capsys.readouterr()
    assert cli.main(["info", "o.csv"]) == 0
    assert "least and largest are of the outputs" in capsys.readouterr().out
    page = mbdsl.report(mbdsl.simulate("o.mbd", stop=10.0, interval=0.7, signals=["p.v"])).html
    assert page.index("Extremes over all steps") < page.index("Mechanism")


def test_a_damaged_text_is_no_text(tmp_path):
    from mbdsl.results.stored import open_result
    from mbdsl.simulation.stored_extremes import of_result

    for text in ("[", "3", "[[1, 2]]", '[["x", "m", 1, 2, 3, "a", 5, 6, "steps"]]', "[null]"):
        path = tmp_path / "a.npz"
        results.write(path, {"time": np.arange(3.0), "x": np.arange(3.0)}, {}, {"complete": True, "extremes": text})
        assert len(of_result(open_result(path))) == 0


def test_measures_of_sweeps_are_those_of_all_steps():
    text = OSCILLATOR.replace("m = 1 kg", "m = m").replace("model O ", "model O parameter Mass m = 1 kg; ")
    found = mbdsl.sweep(
        mbdsl.parse(text),
        {"m": ["1 kg", "4 kg"]},
        ["max(p.v)", "rms(s.force)", "time_of_min(b.x)", "at_max(b.x, p.v)", "amplitude(b.ax)", "min(p.v)"],
        stop=10.0, interval=0.7, method="dop853", tol=1e-7,
    )  # fmt: skip
    for k, w in enumerate((TURN, TURN / 2.0)):
        expected = (w, TURN**2 / math.sqrt(2.0), math.pi / w, 0.0, w * w, -w)
        values = [found[name][k] for name in ("max(p.v)", "rms(s.force)")]
        values += [found["time_of_min(b.x)"][k] % (TURN / w)]
        values += [found[name][k] for name in ("at_max(b.x, p.v)", "amplitude(b.ax)", "min(p.v)")]
        assert values == pytest.approx(expected, rel=1e-5, abs=1e-4)


SPINS = """spatial model Spins
  Ground ground(g = 0);
  Body b(m = 1 kg, I = {0.1, 0.2, 0.3} kg.m2);
  Revolute P(ground, b.c, n = {0.6, 0, 0.8});
  RotationalSpringDamper s(P, k = 0.001 N.m/rad, c = 0);
initial equation
  P.w = 5 rad/s;
  annotation(experiment(StopTime = 8 s));
end Spins;"""


@pytest.mark.parametrize("given", [{"method": "hht-si2", "step": 2e-3}, {"method": "radau5"}], ids=["fixed", "radau5"])
@pytest.mark.parametrize("part", [(0.0, 8.0), (3.0, 5.0)])
def test_turns_are_counted_between_kept_ends(part, given):
    """phi = 5/w sin(w t), about 38 rad after 8 s, and the spring's torque is proportional to it."""
    run = mbdsl.simulate(mbdsl.parse(SPINS), **given)
    t = run.t[(run.t >= part[0]) & (run.t <= part[1])]
    w = np.sqrt(0.001 / (0.36 * 0.1 + 0.64 * 0.3))
    phi = 5.0 / w * np.sin(w * t)
    found = run[part[0] : part[1]].extremes(["P.phi", "s.torque", "P.phi^2"])
    for name, x in (("P.phi", phi), ("s.torque", 0.001 * phi), ("P.phi^2", phi**2)):
        assert found[name].least == pytest.approx(x.min(), rel=1e-3, abs=1e-5)
        assert found[name].largest == pytest.approx(x.max(), rel=1e-3)
        assert found[name].mean == pytest.approx(np.trapezoid(x, t) / (t[-1] - t[0]), rel=1e-3)


APART = """model Apart
  Ground ground(g = 0);
  Frame f(ground, r = {1 m, 0});
  Body b(m = 1 kg, I = 1 kg.m2);
  Body c(m = 1 kg, I = 1 kg.m2);
  Revolute P(ground, b.c);
  Revolute Q(f, c.c);
  RotationalSpringDamper s(P, k = 4 N.m/rad, c = 0);
  RotationalSpringDamper fast(Q, k = 70 N.m/rad, c = 0);
initial equation
  P.phi = 1 rad; Q.phi = 0.3 rad;
  annotation(experiment(StopTime = 10 s));
end Apart;"""


@pytest.mark.parametrize(("method", "tol"), [("dop853", 1e-6), ("radau9", 1e-9)])
def test_parts_with_long_steps_of_their_own(method, tol):
    """Two oscillators that are solved apart: each has its own ends of steps, which the other passes over."""
    found = mbdsl.simulate(mbdsl.parse(APART), method=method, tol=tol).extremes(["P.w", "b.alpha"])
    assert found["P.w"].largest == pytest.approx(2.0, abs=2e-6) and found["P.w"].least == pytest.approx(-2.0, abs=2e-6)
    assert found["P.w"].rms == pytest.approx(np.sqrt(4.0 * (0.5 - np.sin(40.0) / 80.0)), abs=2e-6)
    assert found["b.alpha"].largest == pytest.approx(4.0, abs=1e-5)


def test_tables_fit_eighty_columns():
    """Numbers remain aligned; names that leave no room for them, and only those, are in lines of their own."""
    long = "front_suspension.left.lower_wishbone.bushing_of_the_rear"
    wide = Extreme(f"{long}.fx", "N", -1.234e-05, 1.234e-05, 1.234e05, 1.234e-05, -1.234e-05, 1.234e-05)
    short = Extreme("p.v", "m/s", -1.0, 0.25, 1.0, 0.75, 0.0, 0.7071)
    found = lines([short, wide, wide._replace(signal=2 * long)])
    assert max(map(len, found)) <= 80
    head, one, name, numbers, longest, _ = found
    assert (name, longest) == (wide.signal, f"{(2 * long)[:40]}…{(2 * long)[-39:]}")
    assert len(head) == len(one) == len(numbers)
    assert one.split() == ["p.v", "m/s", "-1", "0.25", "1", "0.75", "0", "0.7071"]
    assert [line.split()[:3] for line in lines([short, short._replace(signal="left.lower_wishbone.x")])] == [
        ["signal", "unit", "least"], ["p.v", "m/s", "-1"], ["left.lower_wishbone.x", "m/s", "-1"],
    ]  # fmt: skip
