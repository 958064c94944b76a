"""The range of small deformation, against the slope at the tip of a beam in its first mode."""

import numpy as np
import pytest

import mbdsl
from mbdsl.bodies.contract import LARGEST_BEND
from mbdsl.system import build
from mbdsl.system.bending import first_bend

MODEL = """
model Two
  Ground ground;
  FlexibleBeam a(length = 1 m, mass = 1 kg, E = 2e11 Pa, S = 1e-4 m2, I = 1e-9 m4,
                 reference = "clamped-free", modes = 1);
  FlexibleBeam b(length = 1 m, mass = 1 kg, E = 2e11 Pa, S = 1e-4 m2, I = 1e-9 m4,
                 reference = "clamped-free", modes = 1);
  Revolute pin_a(ground, a.a);
  Revolute pin_b(ground, b.a);
initial equation
  a.phi = 0;
  b.phi = 0;
end Two;
"""


@pytest.fixture(scope="module")
def system():
    return build(mbdsl.parse(MODEL))


def bent(system, name, angle):
    """A state (n,) at which the tip of a beam has this slope: that of b relative to its start."""
    q = np.zeros(system.n)
    body, d = system.tables.models[name], system.tables.coordinates[name]
    q[d + 3] = 1.0
    tip = float(body.frame((0.5, 0.0, 0.0), "phi", q[None, d : d + body.n], np.zeros((1, body.n)), None)[0])
    q[d + 3] = angle / tip
    return q


def test_slopes_of_the_tip_count(system):
    below, beyond = (np.array([bent(system, "b", f * LARGEST_BEND)]) for f in (0.98, 1.02))
    assert first_bend(system, below) is None
    row, name, angle = first_bend(system, beyond)
    assert (row, name) == (0, "b")
    assert angle == pytest.approx(1.02 * LARGEST_BEND, rel=1e-6)


def test_the_first_state_counts_and_then_the_first_body(system):
    straight, a, b = np.zeros(system.n), bent(system, "a", -1.0), bent(system, "b", 0.8)
    assert first_bend(system, np.array([straight, b, a]))[:2] == (1, "b")
    assert first_bend(system, np.array([straight, a + b]))[:2] == (1, "a")
    assert first_bend(system, straight[None]) is None
