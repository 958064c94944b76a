"""Names that a model may not use because mbdsl defines them, and names that it may use."""

import numpy as np
import pytest

from mbdsl import parse, simulate
from mbdsl.errors import ModelError

MODEL = """\
model A
  Ground ground;
  {}
  annotation(experiment(StopTime = 0.01 s, Step = 1 ms));
end A;
model S
  Frame tip;
  Rod q(m = 1 kg, length = 1 m);
  Revolute j(tip, q.a);
  {}
end S;
"""


def test_a_body_and_a_joint_may_be_called_energy():
    """Each signal is that of the same model with another name."""
    body = "Rod {0}(m = 1 kg, length = 1 m); Revolute {1}(ground, {0}.a);"
    plain = simulate(parse(MODEL.format(body.format("rod", "pin"), ""), model="A"))
    for renamed in ({"rod": "energy", "pin": "pin"}, {"rod": "rod", "pin": "energy"}):
        named = simulate(parse(MODEL.format(body.format(*renamed.values()), ""), model="A"))
        for signal in plain.names:
            owner, dot, key = signal.partition(".")
            np.testing.assert_array_equal(plain[signal], named[renamed.get(owner, owner) + dot + key])


@pytest.mark.parametrize("name", ["kinetic", "potential", "total"])
def test_a_variable_cannot_replace_the_energy_of_the_model(name):
    with pytest.raises(ModelError, match=f"every model has a signal `energy.{name}`") as caught:
        parse(MODEL.format("S energy(ground);", f"Real {name} = 5;"), "a.mbd", model="A")
    assert (caught.value.span.line, caught.value.span.column) == (10, 8)
    other = parse(MODEL.format("S energies(ground);", f"Real {name} = 5;"), model="A")
    assert simulate(other)[f"energies.{name}"][-1] == 5.0
