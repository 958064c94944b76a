"""The matrices of models with states against central differences, in the plane and in space."""

import numpy as np
import pytest

import mbdsl
from mbdsl.system import build

TEXT = """
{} M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  Current i(start = 1 A);
  Real y(start = 0.5), z(start = 2);
  Torque motor(pin, tau = 1 N.m/A*i*(1 + y^2));
equation
  der(i) = (3 V*cos(pin.phi) - 2 Ohm*i - 0.5 V.s*pin.w*z)/(50 mH);
  der(y) = (rod.b.x/(1 m)*sin(y) - z*i/(1 A))/(0.2 s);
  der(z) = (pin.fy/(1 N)*y - z)/(0.3 s);
end M;
"""


def difference(f, x, step=1e-6):
    columns = [(f(x + step * e) - f(x - step * e)) / (2 * step) for e in np.eye(len(x))]
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("word", ["model", "spatial model"])
def test_matrices(word):
    system = build(mbdsl.parse(TEXT.format(word)))
    rng = np.random.default_rng(1)
    n, m = system.n, system.m
    q, v, lam = 0.3 * rng.normal(size=n), rng.normal(size=n), rng.normal(size=m)
    f = lambda q, v, lam: system.evaluate(0.7, q, v, lam)[0].copy()  # noqa: E731
    D = system.damping(0.7, q, v, lam)
    assert -difference(lambda v: f(q, v, lam), v) == pytest.approx(D, abs=1e-6)
    assert np.abs(D[n - 3 :]).max() > 1.0
    U = system.tangent(0.7, q, v, lam, cL=1.0, cP=1.0, cV=1.0)[:n, n:]
    assert -difference(lambda lam: f(q, v, lam), lam) == pytest.approx(U, abs=1e-6)
    assert np.abs(U[n - 3 :]).max() > 0.01  # the rate of z by the reaction
    K = system.stiffness(0.7, q, v, lam)
    if word == "model":
        assert -difference(lambda q: f(q, v, lam), q) == pytest.approx(K, abs=1e-5)
    else:  # by displacements and rotations in the axes of the body
        moved = lambda d: f(system.moved(q, d), v, lam)  # noqa: E731
        found = -difference(moved, np.zeros(n))
        assert found[n - 3 :, :3] == pytest.approx(K[n - 3 :, :3], abs=1e-5)
    assert not K[:, n - 3 :].any()  # nothing depends on the integrals of states
    assert not system.velocity_jacobian(0.7, q, v)[:, n - 3 :].any()
