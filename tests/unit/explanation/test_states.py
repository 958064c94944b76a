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
