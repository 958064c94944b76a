"""What is assigned to an attribute has an effect, or is an error."""

import copy
import pickle

import pytest

import mbdsl
from mbdsl.errors import UsageError

MODEL = """model Motor
  input Torque u;
  input Force names;
  Ground ground;
  Body rotor(m = 1 kg, I = 2 kg.m2);
  Revolute shaft(ground, rotor.c);
  Torque motor(shaft, tau = u);
  Force push(rotor.c, fx = names);
end Motor;
"""
SPATIAL = MODEL.replace("model", "spatial model", 1).replace("2 kg.m2", "{1, 1, 2} kg.m2")


@pytest.mark.parametrize("text", [MODEL, SPATIAL], ids=["plane", "space"])
def test_an_input_is_set_by_its_attribute(text):
    """The speed after 0.1 s of a constant torque: tau t/I."""
    sim = mbdsl.Simulation(mbdsl.parse(text), step="10 ms")
    sim.inputs.u = 100.0
    assert sim.inputs.u == sim.inputs["u"] == 100.0
    sim.step(10)
    assert sim["shaft.w"] == pytest.approx(100.0 * 0.1 / 2.0, rel=1e-10)
    for other in (sim.copy(), copy.deepcopy(sim), pickle.loads(pickle.dumps(sim))):
        assert other.inputs.u == 100.0
        other.inputs = {"u": 0.0}
        other.step(10)
        assert other["shaft.w"] == pytest.approx(sim["shaft.w"], rel=1e-10)


def test_other_names_are_errors():
    sim = mbdsl.Simulation(mbdsl.parse(MODEL), step="10 ms")
    with pytest.raises(UsageError, match="no input `v`") as problem:
        sim.inputs.v = 1.0
    assert problem.value.hint == "its inputs: u, names"
    with pytest.raises(UsageError, match="not a number"):
        sim.inputs.u = "fast"
    with pytest.raises(AttributeError):
        _ = sim.inputs.v
    with pytest.raises(UsageError, match="no input") as problem:
        sim.inputs.names = 1.0  # the name of an input and of an attribute
    assert 'inputs["names"]' in problem.value.hint
    sim.inputs["names"] = 1.0
    assert sim.inputs["names"] == 1.0 and sim.inputs.names == ("u", "names")
    with pytest.raises(UsageError, match="mapping"):
        sim.inputs = 3


@pytest.mark.parametrize("name", ["u", "h", "time", "gravity", "parameters", "method"])
def test_a_simulation_has_no_other_attributes_to_set(name):
    sim = mbdsl.Simulation(mbdsl.parse(MODEL), step="10 ms")
    with pytest.raises(AttributeError):
        setattr(sim, name, 1.0)


@pytest.mark.parametrize("builder", [mbdsl.Builder, mbdsl.SpatialBuilder])
def test_a_handle_takes_no_values(builder):
    rod = builder("B").Rod("rod", m=1.0, length=1.0)
    for handle, name in ((rod, "m"), (rod, "phi"), (rod.b, "x")):
        with pytest.raises(UsageError, match="cannot be assigned"):
            setattr(handle, name, 3.0)
