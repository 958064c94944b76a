"""What graphs, checks and receipts say of states."""

from pathlib import Path

import mbdsl
from mbdsl.mechanism.graph import build

BOOM = Path(__file__).parents[2] / "data" / "machines" / "boom.mbd"


def test_graph():
    found = build(mbdsl.load(BOOM))
    assert (found.mobility, found.coordinates, found.states) == (1, 3, ["y", "pA", "pB"])
    assert found.summary().startswith("Boom: 1 body, 1 joint, 1 force, 0 independent loops, 3 states\nmobility 1 = 3")
    text = found.describe()
    assert "  pA  reads boom, pB, y" in text and "StateRate" not in text
    assert "pA  (state)" in str(mbdsl.graph(BOOM))


def test_receipt():
    found = {e.effect: e for e in mbdsl.explain(BOOM).entries}
    assert (found["bodies"].unknowns, found["states"].unknowns) == (3, 3)
    assert found["states"].why == "y, pA, pB"
    assert found["forces by expression"].why == "cylinder"


EVENTS = """model M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  discrete Real u(start = 0.5, unit = "N.m");
  Current i(start = 0 A);
  Real x(start = 0);
  Torque motor(pin, tau = u);
initial equation
  pin.phi = -80 deg; pin.w = 0 rad/s;
equation
  der(i) = (1 A - i)/(0.1 s);
  der(x) = (pin.phi - x)/(0.1 s);
  when sample(0, 10 ms) then u = 2; end when;
end M;"""


def test_states_alone_are_no_mechanism_and_their_equations_no_forces():
    model = mbdsl.parse(EVENTS)
    text = str(mbdsl.graph(model))
    assert "sub-mechanism" not in text and "StateRate" not in text and "der(" not in text
    assert "x  (state)  reads rod" in text and text.count("i  (state)") == 1
    assert "der(i).frame_a.fx" not in mbdsl.simulate(model, stop=0.1).select("*.frame_a.fx")


def test_events_on_the_receipt_and_in_statics():
    model = mbdsl.parse(EVENTS)
    (found,) = (e for e in mbdsl.explain(model).entries if e.effect == "events")
    assert found.present and found.why == "1 when-equation, clocks of 0.01 s" and found.span.line == 14
    rest = mbdsl.static(model)
    assert rest["motor.tau"] == 0.5  # as at the start
    assert any("values at the start" in note for note in rest.notes)
