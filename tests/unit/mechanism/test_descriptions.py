"""Variables keep their declared unit and description."""

import pytest

import mbdsl
from mbdsl.mechanism.signal_meanings import meaning
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.results.stored import open_result

VARIABLES = """
  input Torque u(start = 1 N.m) "motor torque";
  input Real v(unit = "deg") "set point";
  Force F = 2 N + 1 N/rad*pin.phi "in the actuator";
  Real P(unit = "kW") = u*der(pin.phi) "drive";
  Power P2 = u*der(pin.phi);
  Real x = 5 m/s*time;
  Length s[2] = {1 m/s*time, 2 m} "two lengths";
  Angle h = 2*pin.phi;
  Real c = sin(pin.phi) "no unit";
"""
PLANE = f"model M Ground g; Rod a(m = 2 kg, length = 1 m); Revolute pin(g, a.a); {VARIABLES} end M;"
SPACE = f"spatial model M Ground g; Rod a(m = 2 kg, length = 1 m); Revolute pin(g, a.a); {VARIABLES} end M;"
EXPECTED = {
    "u": ("N.m", "motor torque"),
    "v": ("rad", "set point"),
    "F": ("N", "in the actuator"),
    "P": ("W", "drive"),
    "P2": ("W", "variable of the model"),
    "x": ("m", "variable of the model"),
    "s[1]": ("m", "two lengths"),
    "s[2]": ("m", "two lengths"),
    "h": ("rad", "variable of the model"),
    "c": ("", "no unit"),
}


@pytest.mark.parametrize("text", [PLANE, SPACE], ids=["plane", "space"])
def test_units_and_descriptions_of_signals(text):
    scene = mbdsl.parse(text)
    known = SignalNames(scene)
    assert {name: (known.unit(name), meaning(scene, name)) for name in scene.variables} == EXPECTED
    assert "in the actuator" in scene._repr_html_()


def test_of_sub_models_and_of_a_builder():
    arm = 'model Arm Frame root; Rod r(m = 1, length = 1); Revolute p(root, r.a); Force f = 3 N "grip"; end Arm; '
    scene = mbdsl.parse(f"{arm} model M Ground g; Arm arm[2](each root = g); end M;")
    assert SignalNames(scene).unit("arm[2].f") == "N" and meaning(scene, "arm[2].f") == "grip"
    m = mbdsl.Builder("M")
    m.variable("F", "3 N", "pull")
    m.Ground("g")
    m.Rod("a", m="1 kg", length="1 m")
    scene = m.scene()
    assert SignalNames(scene).unit("F") == "N" and meaning(scene, "F") == "pull"


def test_in_results(tmp_path):
    found = mbdsl.simulate(mbdsl.parse(PLANE), stop=0.01, step=0.01)
    assert found.unit("F") == "N" and found.signals["F"].doc == "in the actuator"
    found.save(tmp_path / "run.npz", ["F", "h"])
    assert [open_result(tmp_path / "run.npz").unit(name) for name in ("F", "h")] == ["N", "rad"]


@pytest.mark.parametrize("text", [PLANE, SPACE], ids=["plane", "space"])
def test_inputs_over_time_keep_them(text):
    found = mbdsl.simulate(mbdsl.parse(text), stop=0.01, step=0.01, inputs={"u": ([0.0, 1.0], [0.0, 2.0])})
    assert found.unit("u") == "N.m" and found.signals["u"].doc == "motor torque"
