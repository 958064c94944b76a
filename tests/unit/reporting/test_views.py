"""Checks, graphs, plots, reports and animations as functions: the same as the commands of these names."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import cli
from mbdsl.errors import InitialisationError, IntegrationError, UsageError

MODEL = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
RUN = {"stop": 0.02, "step": 1e-3}
WORDS = ("--stop", "0.02", "--step", "1e-3")


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def builder():
    b = mbdsl.Builder("Pendulum", "A pendulum")
    b.Ground("ground")
    b.Body("bar", m="1 kg", length="1 m")
    b.Revolute("pin", "ground.c", "bar.a")
    b.initial("pin.phi", "20 deg")
    b.experiment(stop="0.02 s", step="1 ms")
    return b


GIVEN = {
    "path": lambda: MODEL,
    "text": lambda: mbdsl.parse(MODEL.read_text()),
    "scene": lambda: mbdsl.load(MODEL),
    "builder": builder,
}


@pytest.mark.parametrize("given", GIVEN)
def test_what_simulate_takes(given):
    """A pendulum and a slider crank have one degree of freedom; only the crank has a loop."""
    found = mbdsl.check(GIVEN[given]())
    assert found.graph.mobility == 1 and found.warnings == ()
    assert bool(found.assembly) == (given != "builder")  # a tree is not assembled
    assert len(mbdsl.graph(GIVEN[given](), "g.svg").loops) == (given != "builder")
    body = "bar" if given == "builder" else "crank"
    (panel,) = mbdsl.plot(GIVEN[given](), f"{body}.phi", out="p.svg", **RUN).panels
    expected = mbdsl.simulate(GIVEN[given](), **RUN)[f"{body}.phi"]
    np.testing.assert_array_equal(panel.series[0].y, expected)
    assert mbdsl.report(GIVEN[given](), f"{body}.w", out="r.html", **RUN).trajectory.t[-1] == 0.02
    assert mbdsl.animate(GIVEN[given](), "a.html", traces=body, **RUN).motion.t[-1] == 0.02
    assert all(Path(name).stat().st_size > 1000 for name in ("g.svg", "p.svg", "r.html", "a.html"))


def test_the_commands_write_the_same(capsys):
    model = str(MODEL)
    assert cli.main(["check", model]) == 0
    assert capsys.readouterr().out == f"{mbdsl.check(model)}\n"
    assert cli.main(["graph", model]) == 0
    assert capsys.readouterr().out == f"{mbdsl.graph(model)}\n"
    run = mbdsl.simulate(model, **RUN)
    run.save("a.npz", ["O.fx", *run.default_names])
    run.save("a.csv")
    for words, call in (
        (["graph", model], lambda out: mbdsl.graph(model, out)),
        (["plot", "a.npz", "--signals", "rod.*,O.fx"], lambda out: mbdsl.plot("a.npz", ["rod.*", "O.fx"], out=out)),
        (["animate", "a.npz", "--trace", "A"], lambda out: mbdsl.animate("a.npz", out, traces="A")),
        (["animate", model, "--result", "a.csv", "--ghost", "a.npz"],
         lambda out: mbdsl.animate(model, out, result="a.csv", ghost="a.npz")),
        (["animate", model, *WORDS], lambda out: mbdsl.animate(model, out, **RUN)),
    ):  # fmt: skip
        suffix = "html" if words[0] == "animate" else "svg"
        assert cli.main([*words, "--out", f"command.{suffix}"]) == 0
        call(f"function.{suffix}")
        assert Path(f"command.{suffix}").read_bytes() == Path(f"function.{suffix}").read_bytes()


def test_trajectories_and_several_results():
    one, other = mbdsl.simulate(MODEL, **RUN), mbdsl.simulate(MODEL, parameters={"m1": 9.0}, **RUN)
    found = mbdsl.plot([one, other], "crank.phi", difference=True)
    np.testing.assert_allclose(found.panels[0].series[0].y, other["crank.phi"] - one["crank.phi"], atol=1e-15)
    both = mbdsl.plot([one, MODEL], "crank.phi", parameters={"m1": 9.0}, **RUN)
    np.testing.assert_array_equal(both.panels[0].series[1].y, other["crank.phi"])
    assert mbdsl.report(one).trajectory is one
    assert mbdsl.animate(one).motion.t[-1] == 0.02


def test_what_is_shown_in_notebooks():
    assert "mobility 1 =" in mbdsl.check(MODEL)._repr_html_() and "mobility 1" in repr(mbdsl.check(MODEL))
    assert mbdsl.graph(MODEL)._repr_svg_().startswith("<svg")
    assert repr(mbdsl.graph(MODEL)) == "<Structure of SliderCrank: 2 bodies, 3 joints, 1 force, 1 independent loop>"


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: mbdsl.plot(MODEL, "crank.ph"), "no signal named `crank.ph`"),
        (lambda: mbdsl.plot(MODEL, out="plot.xyz"), "unknown suffix"),
        (lambda: mbdsl.plot("a.txt"), "neither a result file nor a model"),
        (lambda: mbdsl.plot([]), "needs a result or a model"),
        (lambda: mbdsl.report(MODEL, "O.fq"), "no signal `O.fq`"),
        (lambda: mbdsl.report(MODEL, out="report.pdf"), "a report is a page"),
        (lambda: mbdsl.animate(MODEL, traces=["C"]), "no frame or joint `C`"),
        (lambda: mbdsl.animate(MODEL, ghost="pendulum.mbd"), "is not a result"),
        (lambda: mbdsl.animate(MODEL, out=MODEL), "unknown suffix"),
        (lambda: mbdsl.animate("a.npz", result="a.csv"), "are both results"),
        (lambda: mbdsl.graph(MODEL, "none/graph.svg"), "folder"),
        (lambda: mbdsl.check(3), "a path, a Scene or a Builder"),
    ],
)
def test_what_is_wrong_is_said_before_a_run(call, says, monkeypatch):
    monkeypatch.setattr("mbdsl.api.simulated", lambda *given, **named: pytest.fail("a run begins"))
    with pytest.raises(UsageError, match=says):
        call()


def test_arguments_of_a_run_do_not_belong_to_a_result():
    run = mbdsl.simulate(MODEL, **RUN)
    for call in (mbdsl.plot, mbdsl.report, mbdsl.animate):
        with pytest.raises(UsageError, match="`stop` belongs to a simulation"):
            call(run, stop=1.0)


def test_errors_of_the_model():
    """Circles of 1 m about points that are 3 m apart do not meet."""
    loose = mbdsl.parse("""model Apart Ground ground(frames(far = {3, 0} m)); PointMass mass(m = 1 kg);
        Distance left(ground, mass, length = 1 m); Distance right(ground.far, mass, length = 1 m); end Apart;""")
    with pytest.raises(InitialisationError):
        mbdsl.check(loose)
    assert mbdsl.check(loose, quick=True).graph.mobility == 0


def test_a_failed_run_is_shown_until_its_end():
    """1/(0.01 s - time): the force is infinite at 10 ms."""
    b = builder()
    b.Torque("push", "ground.c", "bar.c", tau="1 N.m.s/(0.01 s - time)")
    for name, call in (("p.svg", mbdsl.plot), ("r.html", mbdsl.report), ("a.html", mbdsl.animate)):
        with pytest.raises(IntegrationError) as caught:
            call(b, out=name, tol=1e-4)
        assert 0.0 < caught.value.trajectory.t[-1] <= 0.0101
        assert Path(name).stat().st_size > 1000
