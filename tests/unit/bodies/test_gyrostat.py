"""A gyrostat: its mass matrix, energies and frames against those of its bodies, each on its own."""

from types import SimpleNamespace

import numpy as np
import pytest

from mbdsl.bodies.contract import SPATIAL_POSITIONS, SPATIAL_VELOCITIES
from mbdsl.bodies.gyrostat import Gyrostat
from mbdsl.elements import of_variant
from mbdsl.numerics.rotation_arrays import cross_matrix, matrices, turned

RNG = np.random.default_rng(5)
#: mass, inertia and centre of mass of the carrier; mass, moments about and across the axle, axle and place of rotors
CARRIER = 3.0, np.diag([0.8, 1.1, 0.9]), np.array([0.05, -0.02, 0.03])
ROTORS = [
    (0.7, 0.02, 0.013, np.array([0.6, 0.0, 0.8]), np.array([0.3, 0.1, -0.2])),
    (0.5, 0.01, 0.019, np.array([0.0, 1.0, 0.0]), np.array([-0.1, 0.2, 0.1])),
]
G = np.array([0.3, -9.0, 1.0])


def bodies():
    """Mass, inertia in the carrier's axes, and centre of mass, of all bodies."""
    return [CARRIER] + [(m, A * np.eye(3) + (C - A) * np.outer(n, n), c) for m, C, A, n, c in ROTORS]


def model():
    mass = sum(m for m, _, _ in bodies())
    centre = sum(m * c for m, _, c in bodies()) / mass
    J = sum(I - m * cross_matrix(c - centre) @ cross_matrix(c - centre) for m, I, c in bodies())
    rotors = tuple((tuple(n), C) for _, C, _, n, _ in ROTORS)
    values = {"m": mass, "com": tuple(centre), "J": tuple(J.ravel()), "rotors": rotors}
    return Gyrostat(SimpleNamespace(kind=of_variant("gyrostat", True).KIND, values=values)), centre


def test_energies_are_the_sums_of_those_of_the_bodies():
    """Of each body with the velocity of its centre of mass, and its angular velocity; gravity from the centre on."""
    own, centre = model()
    q, v = RNG.normal(size=(2, 1, own.n))
    R, w = matrices(q[:, 3:6])[0], v[0, 3:6]
    kinetic, potential = 0.0, 0.0
    for k, (m, I, c) in enumerate(bodies()):
        speed = v[0, :3] + R @ np.cross(w, c - centre)
        spin = w + (v[0, 5 + k] * ROTORS[k - 1][3] if k else 0.0)
        kinetic += 0.5 * (m * speed @ speed + spin @ I @ spin)
        potential -= m * G @ (q[0, :3] + R @ (c - centre))
    found = own.energies(q, v, G)
    assert found[0] == pytest.approx(kinetic, rel=1e-14) and found[1] == pytest.approx(potential, rel=1e-14)
    assert 0.5 * v[0] @ own.M(q[0]) @ v[0] == pytest.approx(kinetic, rel=1e-14)
    assert own.weight(G)[:3] == pytest.approx(sum(m for m, _, _ in bodies()) * G) and not own.weight(G)[3:].any()


def test_frames_on_rotors_turn_about_the_axle():
    """Positions and rates of a frame, and their derivatives, against differences (of five points, with errors of
    1e-12)."""
    own, _ = model()
    axes = matrices(RNG.normal(size=(1, 3)))[0].T.ravel()
    for pose in ((0.1, 0.2, -0.3, *axes), (0.1, 0.2, -0.3, *axes, 1), (0.1, 0.2, -0.3, *axes, 2)):
        q, v = RNG.normal(size=(2, own.n))
        v[6:] *= 100.0

        def frame(keys, d=0.0, turn=0.0, own=own, pose=pose, q=q, v=v):
            """At q moved by d."""
            x = np.array(q + d)
            if np.any(d):
                x[3:6] = turned(q[None, 3:6], np.array(d)[None, 3:6])[0]
            return np.array([own.frame(pose, key, x[None], v[None])[0] for key in keys])

        def slope(f, h=1e-4):
            return (8.0 * (f(h) - f(-h)) - f(2 * h) + f(-2 * h)) / (12.0 * h)

        B, rates, of_rates = own.gradient(pose, q, v)
        for j in range(own.n):
            e = np.eye(own.n)[j]
            moved = slope(lambda h, e=e, frame=frame: frame(SPATIAL_POSITIONS, h * e))
            assert B[:, j] == pytest.approx(moved, abs=1e-10)
            faster = slope(lambda h, e=e, frame=frame: frame(SPATIAL_VELOCITIES, h * e))
            assert of_rates[:, j] == pytest.approx(faster, abs=1e-8)
        assert rates @ v == pytest.approx(frame(SPATIAL_VELOCITIES), abs=1e-12 * 100.0)
        assert own.dofs(pose) == tuple(range(6)) if len(pose) == 12 else (*range(6), 5 + pose[12])
