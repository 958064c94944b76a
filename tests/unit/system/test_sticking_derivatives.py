"""The matrices of joints whose friction sticks against central differences, while they slide and are held."""

import numpy as np
import pytest

import mbdsl
from mbdsl.mechanism.sticking import EDGE, SLIDING, number
from mbdsl.system import build

JOINTS = {
    "Prismatic": "n = {1, 2, 2}",
    "PointOnLine": "n = {1, 2, 2}",
    "Revolute": "radius = 0.2 m",
    "Cylindrical": "n = {1, 2, 2}, radius = 0.2 m",
    "Screw": "n = {1, 2, 2}, radius = 0.2 m, pitch = 0.3 m",
    "Planar": "n = {1, 2, 2}",
    "PointOnPlane": "n = {1, 2, 2}",
    "PointOnCurve": "f1 = joint.x^2 + 2*joint.y^2 - 1, f2 = 1 m*joint.z - joint.x*joint.y",
    "PointOnSurface": "f = joint.x^2 + 2*joint.y^2 + 3*joint.z^2 - 1",
    "Spherical": "radius = 0.2 m",
}


def system_of(kind: str):
    text = f"""
spatial model M
  Ground ground;
  Body first(m = 1 kg, I = {{1, 2, 2.5}} kg.m2, frames(p = {{0.3, -0.2, 0.1}} m));
  Body second(m = 2 kg, I = {{2, 2, 1}} kg.m2, frames(p = {{-0.1, 0.4, 0.2}} m));
  FreeMotion carrier(ground, first.c);
  {kind} joint(first.p, second.p, {JOINTS[kind]}, mu = 0.7, mu_s = 0.9, sticks = true);
end M;
"""
    return build(mbdsl.parse(text))


def difference(f, x, step=1e-5):
    return np.stack([(f(x + step * e) - f(x - step * e)) / (2 * step) for e in np.eye(len(x))], axis=1)


@pytest.mark.parametrize("kind", JOINTS)
def test_matrices_while_it_slides_and_while_it_is_held(kind):
    system = system_of(kind)
    (joint,) = system.scene.sticking
    rng = np.random.default_rng(7)
    numbers = joint.starts | {name: float(x) for name, x in zip(joint.kept, rng.normal(size=9), strict=False)}
    numbers |= {number("joint", SLIDING): 1.0, number("joint", EDGE): 0.1}  # the edge counts beside v
    for name, x in numbers.items():
        system.set_input(name, x)
    system.activate(())
    n, t = system.n, 0.0
    q, v, lam = 0.3 * rng.normal(size=n), rng.normal(size=n), rng.normal(size=system.m)

    def force(q, v, lam):
        return system.evaluate(t, q, v, lam)[0].copy()

    with_rows = [system.tables.rows[row] for row in joint.rows]
    assert -difference(lambda x: force(q, x, lam), v) == pytest.approx(system.damping(t, q, v, lam), abs=1e-7)
    U = system.tangent(t, q, v, lam, cL=1.0, cP=1.0, cV=1.0)[:n, n:]
    assert -difference(lambda x: force(q, v, x), lam) == pytest.approx(U, abs=1e-7)
    J = system.velocity_jacobian(t, q, v)[with_rows]
    found = difference(lambda d: system.Phi(t, system.moved(q, d))[with_rows], np.zeros(n))
    assert found == pytest.approx(J, abs=1e-7)
    assert np.linalg.matrix_rank(J) == len(with_rows)
    assert np.abs(U - system.velocity_jacobian(t, q, v).T).max() > 0.01  # friction reads reactions
