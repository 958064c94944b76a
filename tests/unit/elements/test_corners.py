"""Corner cases of elements that no shipped scene reaches: zero lengths, small couplings, multipliers of velocities."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.bodies.beam_elements import without_dust
from mbdsl.elements import modules
from mbdsl.kernels.columns import PLANE as C
from mbdsl.system import build, row_kernels

MODELS = Path(__file__).parents[3] / "models"
#: a row that is quadratic in velocities, and an angle in it
GEAR = """model Curved Ground ground(g = 0); Body a(m = 1 kg, I = 1 kg.m2); Body b(m = 2 kg, I = 3 kg.m2);
VelocityConstraint row(gamma = a.vx*a.vx*cos(b.phi) + 0.3 m*a.w*b.vy + a.x/(10 m)*b.vx*b.vx); end Curved;"""


def test_a_distance_of_zero_pulls_nowhere():
    """A distance of zero has no direction: any unit vector would be as wrong as NaN."""
    Z, G = np.zeros((2, C.COLUMNS)), np.full((1, C.GRADIENT_COLUMNS), 7.0)
    Z[:, :2] = 0.3, -0.2
    spring = row_kernels.module(modules()["SpringDamper"]).gradient
    with np.errstate(all="raise"):
        getattr(spring, "py_func", spring)(Z, 0, 1, (), G)
    assert list(G[0, [C.VALUE, 0, 1, 3, 4]]) == [0.0] * 5


def test_only_rounding_is_dust():
    """A sum over some hundred points has a rounding error of 1e-14 of its largest possible value; a coupling of a
    millionth, as of a mass that is off the middle by a millionth, is real."""
    kept = np.array([1.0, -1e-6, 1e-9, 1e-12])
    assert list(without_dust(3.0 * kept, 3.0)) == list(3.0 * kept)
    assert list(without_dust(np.array([2e-15, -5e-15]), 1.0)) == [0.0, 0.0]


@pytest.mark.parametrize("name", ["sleigh", "row"])
def test_tangents_of_velocity_constraints(name):
    """K and D of Gam_v^T nu against central differences: errors of d^2 f'''/6 + eps f/d, 1e-9 of them."""
    scene = mbdsl.load(MODELS / "chaplygin_sleigh.mbd") if name == "sleigh" else mbdsl.parse(GEAR)
    S = build(scene)
    random = np.random.default_rng(3)
    q, v, lam = random.normal(size=S.n), random.normal(size=S.n), 5.0 * random.normal(size=S.m + S.p)
    d = 1e-5

    def differences(f, x):
        return np.array([(f(x + d * e) - f(x - d * e)) / (2 * d) for e in np.eye(S.n)]).T

    of_q = -differences(lambda x: S.evaluate(0.0, x, v, lam)[0], q)
    of_v = -differences(lambda x: S.evaluate(0.0, q, x, lam)[0], v)
    assert np.abs(of_q).max() > 0.1
    assert np.abs(S.stiffness(0.0, q, v, lam) - of_q).max() < 1e-8 * np.abs(of_q).max()
    assert np.abs(S.damping(0.0, q, v, lam) - of_v).max() < 1e-8 * np.abs(of_q).max()
