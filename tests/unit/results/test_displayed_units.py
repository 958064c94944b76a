"""Units of what is printed, drawn and written: every form of output of one pendulum, with values known in closed form.

The pendulum hangs at rest, turned by a driver at 60 rpm from 0: phi = 2 pi t, so that at t = 0.25 s it is at 90 deg.
"""

import json

import numpy as np
import pytest

import mbdsl
from mbdsl import results
from mbdsl.errors import UsageError
from mbdsl.simulation import result_units

MODEL = """model M
  parameter Length a(displayUnit = "mm") = 0.5;
  Ground ground;
  Rod rod(m = 2 kg, length = a);
  Revolute pin(ground, rod.a, phi(displayUnit = "deg"));
  RotationalDriver drive(pin, phi = 2*3.141592653589793*time/(1 s));
  Real F(unit = "N", displayUnit = "kN") = 2000 N*(time/(1 s)) "in the actuator";
  annotation(experiment(StopTime = 0.25, Step = 0.001, Interval = 0.0625));
end M;
"""
LBF = 0.45359237 * 9.80665


@pytest.fixture
def model(say, tmp_path):
    (tmp_path / "m.mbd").write_text(MODEL, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def run():
    return mbdsl.simulate(mbdsl.parse(MODEL))


def cells(text, name):
    """The words of the line of a table that begins with a name."""
    return next(line.split() for line in text.splitlines() if line.startswith(name))


def test_extremes_in_the_terminal(model, say):
    code, out, _ = say("simulate", "m.mbd", "--signals", "pin.phi,rod.w,F,drive.power")
    assert code == 0
    assert cells(out, "pin.phi")[1:6] == ["deg", "0", "0", "90", "0.25"]
    assert cells(out, "rod.w")[1] == "rad/s" and cells(out, "F")[1:5] == ["kN", "0", "0", "0.5"]
    _, out, _ = say("simulate", "m.mbd", "--signals", "pin.phi,rod.w,F", "--units", "rev, rpm, lbf, ms")
    assert "at [ms]" in out
    assert cells(out, "pin.phi")[1:6] == ["rev", "0", "0", "0.25", "250"]
    assert cells(out, "rod.w")[1:3] == ["rpm", "60"]
    assert cells(out, "F")[1:5] == ["lbf", "0", "0", f"{500.0 / LBF:.4g}"]


def test_files_stay_in_si_and_say_so(model, say):
    for suffix in ("npz", "mat", "nc", "csv"):
        say("simulate", "m.mbd", "--signals", "pin.phi,F", "--output", f"r.{suffix}", "--quiet")
        columns, _ = results.read(f"r.{suffix}")
        assert columns["pin.phi"][-1] == pytest.approx(np.pi / 2, rel=1e-12)
        _, out, _ = say("info", f"r.{suffix}")
        shown = cells(out, "pin.phi")
        if suffix == "csv":
            assert "2, in SI units if mbdsl has written them; the file names none" in out
        else:
            assert "signals     2, in SI units\n" in out and shown[1:4] == ["deg", "0", "90"]
    _, out, _ = say("info", "r.npz", "--units", "rev,ms")
    assert cells(out, "pin.phi")[1:4] == ["rev", "0", "0.25"] and "0 ... 250 ms" in out
    say("simulate", "m.mbd", "--signals", "pin.phi", "--output", "r.npz", "--units", "rev", "--quiet")
    assert results.read("r.npz")[0]["pin.phi"][-1] == pytest.approx(np.pi / 2, rel=1e-12)


def test_a_csv_file_in_other_units_names_them_and_is_read_in_si(model, say):
    say("simulate", "m.mbd", "--signals", "pin.phi,rod.w,F", "--output", "r.csv", "--units", "deg,rpm,ms", "--quiet")
    lines = (model / "r.csv").read_text().splitlines()
    assert lines[:2] == ["time,pin.phi,rod.w,F", "ms,deg,rpm,N"]  # F: what is declared does not change files
    assert np.array(lines[-1].split(","), float) == pytest.approx([250.0, 90.0, 60.0, 500.0], rel=1e-12)
    _, out, _ = say("info", "r.csv", "--signals", "pin.phi,sin(pin.phi)")
    assert "in ms, deg, rpm, others in SI units" in out
    assert cells(out, "pin.phi")[3] == "90" and float(cells(out, "sin(pin.phi)")[2]) == pytest.approx(1.0)
    say("convert", "r.csv", "--out", "r.npz")
    assert results.read("r.npz")[0]["pin.phi"][-1] == pytest.approx(np.pi / 2, rel=1e-12)
    assert results.read("r.npz")[0]["time"][-1] == pytest.approx(0.25, rel=1e-12)
    say("convert", "r.npz", "--out", "s.csv", "--units", "rev")
    assert (model / "s.csv").read_text().splitlines()[1] == "s,rev,rad/s,N"


def test_inputs_and_references_in_other_units_are_converted(model, say):
    (model / "p.mbd").write_text(PUSHED, encoding="utf-8")
    (model / "push.csv").write_text("time,u\nms,kN\n0,2\n1000,2\n", encoding="utf-8")
    say("simulate", "p.mbd", "--input", "u=push.csv", "--signals", "ball.x", "--output", "r.csv", "--quiet")
    assert results.read("r.csv")[0]["ball.x"][-1] == pytest.approx(0.5 * 2000.0 / 4.0 * 0.1**2, rel=1e-6)  # F t^2/(2 m)
    columns, meta = result_units.read("push.csv")
    assert columns["time"].tolist() == [0.0, 1.0] and columns["u"].tolist() == [2000.0, 2000.0] and meta["complete"]


PUSHED = """model P
  input Force u;
  Ground ground;
  PointMass ball(m = 4 kg);
  FreeMotion free(ground, ball);
  Force push(ball, fx = u);
  annotation(experiment(StopTime = 0.1, Step = 0.001));
end P;
"""


def test_the_flag_without_a_list_stands_before_a_model(model, say):
    assert say("simulate", "--units", "m.mbd", "--signals", "pin.phi", "--output", "r.csv", "--quiet")[0] == 0
    assert (model / "r.csv").read_text().splitlines()[1] == "s,rad"


def test_plots(model, say, run):
    figure = run.plot(["pin.phi", "rod.phi", "F"]).panels
    assert [panel.y_label for panel in figure] == ["pin.phi [deg]", "rod.phi [rad]", "F [kN]"]  # axes never mix units
    figure = run.plot(["pin.phi", "rod.phi"], units="rev, ms").panels[0]
    assert (figure.x_label, figure.y_label) == ("time [ms]", "phi [rev]")
    assert figure.series[0].y[-1] == pytest.approx(0.25, rel=1e-9) and figure.series[0].x[-1] == 250.0
    figure = run.plot("rod.x", against="rod.y", units="mm").panels[0]
    assert figure.equal and (figure.x_label, figure.y_label) == ("rod.y [mm]", "rod.x [mm]")
    assert max(figure.series[0].x) == pytest.approx(250.0, rel=1e-9)
    waves = mbdsl.simulate(run.scene, interval=0.01).plot("rod.x", spectrum=True, units="ms, mm").panels[0]
    assert (waves.x_label, waves.y_label) == ("frequency [Hz]", "rod.x [mm]")
    assert mbdsl.plot(run, "F", units="lbf").panels[0].series[0].y[-1] == pytest.approx(500.0 / LBF, rel=1e-12)
    _, out, _ = say("plot", "m.mbd", "--signals", "F", "--units", "N", "--out", "f.svg")
    assert out.startswith("f.svg: F [N]")


def test_profiles(run):
    shown = run.along("rod.x", at=0.0, units="mm")
    assert "rod.x [mm]" in str(shown) and "distance from rod.a [mm]" in str(shown)
    assert str(shown).splitlines()[-1].split()[0] == "500" and shown.lines["rod.x"].x[-1] == 0.5
    assert "deg" in str(run.along("rod.phi", units="deg"))


def test_tables_of_a_notebook(run):
    assert ">deg<" in run[["pin.phi"]]._repr_html_() and ">500<" in run.scene._repr_html_()
    assert ">rev<" in run.extremes("pin.phi", units="rev")._repr_html_()
    assert run.extremes("pin.phi", units="rev")["pin.phi"].largest == pytest.approx(np.pi / 2)


def test_descriptions_of_variables(model, say, run):
    assert "F: in the actuator." in str(run.plot(["F", "pin.phi"])) and "actuator" not in str(run.plot("pin.phi"))
    assert "F: in the actuator" in str(run.extremes(["F", "pin.phi"])).splitlines()
    assert "F: in the actuator" in mbdsl.report(run, "F").html
    assert json.dumps("in the actuator") in run.animate(signals="F").html
    _, out, _ = say("sweep", "m.mbd", "--vary", "a=0.25,0.5", "--measure", "max(F),final(F)")
    assert out.count("F: in the actuator.") == 1


def test_pages(model, say, run):
    html = mbdsl.report(run, "pin.phi", units="rev, kJ, ms").html
    assert "pin.phi [rev]" in html and "energy [kJ]" in html and "at [ms]" in html and ">mm<" in html
    page = run.animate(signals="pin.phi", units="rev").html
    assert json.dumps("rev") in page and json.dumps("deg") not in page
    assert say("animate", "m.mbd", "--signals", "pin.phi", "--units", "rev", "--out", "a.html", "--quiet")[0] == 0
    assert json.dumps("rev") in (model / "a.html").read_text()
    assert say("report", "m.mbd", "--units", "lbf.ft", "--out", "r.html", "--quiet")[0] == 0
    assert "--units=lbf.ft" in (model / "r.html").read_text()


HANGING = """model H
  Ground ground;
  Rod rod(m = 2 kg, length = 0.5 m);
  Revolute pin(ground, rod.a, phi(start = -1, displayUnit = "deg"));
  Force push(rod.b, fx = 0 N);
  annotation(experiment(StopTime = 0.01, Step = 0.001));
end H;
"""


def test_statics_modes_and_responses(say, tmp_path):
    (tmp_path / "h.mbd").write_text(HANGING, encoding="utf-8")
    asked = ["--units", "in, lbf, deg", "--signals", "rod.y,rod.phi,pin.fy"]
    _, out, _ = say("static", "h.mbd", *asked, "--output", "e.csv")
    assert cells(out, "  rod.y")[1:] == [f"{-0.25 / 0.0254:.6g}", "in"]
    assert cells(out, "  rod.phi")[1:] == ["-90", "deg"]
    assert cells(out, "  pin.fy")[1:] == [f"{2.0 * 9.81 / LBF:.6g}", "lbf"]
    assert (tmp_path / "e.csv").read_text().splitlines()[1] == "s,in,deg,lbf"
    f = np.sqrt(1.5 * 9.81 / 0.5) / (2.0 * np.pi)  # of a rod about its end [Hz]
    _, out, _ = say("eigen", "h.mbd", "--units", "1/min")
    assert "f [1/min]" in out and float(cells(out, "    1")[1]) == pytest.approx(60.0 * f, rel=1e-5)
    scene = mbdsl.parse(HANGING)
    known = {"input": "push.fx", "output": "pin.phi", "range": "0.001:0.01Hz"}
    plain, shown = mbdsl.response(scene, **known), mbdsl.response(scene, **known, units="lbf, rev")
    assert "pin.phi / push.fx [deg/N]" in str(plain) and "pin.phi / push.fx [rev/lbf]" in str(shown)
    slope = 0.5 / (2.0 * 9.81 * 0.25)  # of the angle over a small horizontal force on the end [rad/N]
    assert float(cells(str(shown), "     0.001")[1]) == pytest.approx(slope * LBF / (2.0 * np.pi), rel=1e-3)
    assert plain.amplitude[0, 0, 0] == shown.amplitude[0, 0, 0] == pytest.approx(slope, rel=1e-3)
    assert shown.plot().panels[0].y_label == "pin.phi / push.fx [rev/lbf]"


def test_sweeps_and_solutions(model, say):
    vary = ["--vary", "a=0.25,0.5"]
    _, out, _ = say("sweep", "m.mbd", *vary, "--measure", "final(pin.phi),final(F)", "--output", "si.csv")
    assert "a [m]" in out and "final(pin.phi) [deg]" in out and out.split("\n")[3].split() == ["0.25", "90", "0.5"]
    assert (model / "si.csv").read_text().splitlines()[0] == "a [m],final(pin.phi) [rad],final(F) [N],outcome"
    more = ["--units", "in,rev,lbf", "--output", "s.csv"]
    _, out, _ = say("sweep", "m.mbd", *vary, "--measure", "final(pin.phi),final(F)", *more)
    assert out.split("\n")[2].split()[::2] == ["a", "final(pin.phi)", "final(F)"]
    assert out.split("\n")[3].split() == [f"{0.25 / 0.0254:.6g}", "0.25", f"{500.0 / LBF:.6g}"]
    first = (model / "s.csv").read_text().splitlines()
    assert first[0] == "a [in],final(pin.phi) [rev],final(F) [lbf],outcome"
    assert float(first[1].split(",")[0]) == pytest.approx(0.25 / 0.0254, rel=1e-14)
    _, out, _ = say("solve", "m.mbd", "--vary", "a=0.2:1 m", "--for", "final(rod.y) = 0.3 m", "--units", "in")
    assert "a = 23.6" in out and f"final(rod.y) = {0.3 / 0.0254:.6g} in" in out


def test_units_belong_to_csv_files(run, tmp_path):
    run.save(tmp_path / "r.csv", ["pin.phi"], units="deg")
    assert (tmp_path / "r.csv").read_text().splitlines()[1] == "s,deg"
    with pytest.raises(UsageError, match=r"\.npz files are in SI units"):
        run.save(tmp_path / "r.npz", units="deg")


@pytest.mark.parametrize("command", ["simulate", "plot", "report", "animate", "eigen", "static", "info"])
def test_a_wrong_unit_is_an_error_of_each_command(model, say, command):
    code, _, err = say(command, "m.mbd", "--units", "deg,rev")
    assert code == 2 and "deg and rev are both units of angles" in err
