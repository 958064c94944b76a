"""The error norm of tolerances, compared with values by hand, and under changes of units."""

import numpy as np
import pytest

import mbdsl
from mbdsl.numerics.error_norm import differences, distance, fastest
from mbdsl.system import build

#: a mechanism of 0.1 m with one length and one angle
SCALE = np.array([10.0, 1.0])


def test_lengths_count_in_the_size_of_the_mechanism_and_angles_in_radians():
    assert differences(SCALE, 1.0, np.array([[1e-3, 0.0], [0.0, 2e-3]]), np.zeros((2, 2))) == pytest.approx(
        [1e-2, 2e-3]
    )


def test_velocities_count_relative_to_the_fastest():
    v = np.array([[0.5, 2.0], [-0.4, 1.0]])  # 0.5 m/s are 5 sizes a second
    assert fastest(SCALE, v, 10.0) == pytest.approx(5.0)
    assert distance(SCALE, 10.0, (0 * v, v + [0.0, 1e-3]), (0 * v, v)) == pytest.approx(2e-4)


def test_a_slow_motion_counts_as_one_size_in_the_time_of_the_run():
    assert fastest(SCALE, np.full((3, 2), 1e-6), 4.0) == 0.25
    assert fastest(SCALE, np.zeros((1, 2)), 0.0) == 1.0


def test_positions_of_bodies_count_alike_in_all_directions():
    """A spring of 2 m is the size of this mechanism."""
    scene = mbdsl.parse("""
model S
  Ground g;
  Frame p(g, r = {2 m, 0});
  Body a(m = 1 kg, I = 1 kg.m2);
  PointMass b(m = 1 kg);
  SpringDamper s(p, a.c, k = 1 N/m, s0 = 2 m);
  SpringDamper t(g, b, k = 1 N/m, s0 = 2 m);
end S;
""")
    assert build(scene).tables.scale.tolist() == [0.5, 0.5, 1.0, 0.5, 0.5]


TEXT = """
model S
  Ground g(g = 0 m/s2);
  Frame p(g, r = {{{L} m, 0}});
  PointMass b(m = {M} kg);
  SpringDamper s(p, b, k = {k} N/m, s0 = {L} m);
initial equation
  b.x = {x} m;
  b.y = 0 m;
  annotation(experiment(StopTime = {T} s));
end S;
"""
#: units of length [m], mass [kg] and time [s]: powers of two, so that nothing is rounded otherwise
UNITS = [(1.0, 1.0, 1.0), (2.0**-10, 1.0, 1.0), (1.0, 2.0**-20, 1.0), (1.0, 1.0, 2.0**10), (2.0**10, 2.0**10, 2.0**-10)]


@pytest.fixture(scope="module")
def runs():
    """A mass on a spring in each of these units, and its motion by the closed form."""
    found = []
    for L, M, T in UNITS:
        text = TEXT.format(L=repr(2.0 * L), M=repr(M), k=repr(1024.0 * M / T**2), x=repr(3.25 * L), T=repr(T))
        scene = mbdsl.parse(text)
        run = mbdsl.simulate(scene, method="hht-si2", tol=1e-4)
        w = 32.0 / T
        x, v = 4.0 * L - 0.75 * L * np.cos(w * run.t), 0.75 * L * w * np.sin(w * run.t)
        found.append((run, x, v))
    return found


def test_units_change_neither_steps_nor_the_error_that_is_claimed(runs):
    counts = [(run.stats["steps"], run.stats["trial_steps"]) for run, _, _ in runs]
    assert counts == counts[:1] * len(UNITS)
    assert [run.stats["error"] for run, _, _ in runs] == pytest.approx(
        [runs[0][0].stats["error"]] * len(UNITS), rel=1e-6
    )


def test_the_true_error_is_what_is_claimed_in_all_units(runs):
    """A run with half the error estimates at most that; the closed form gives the error."""
    for (run, x, v), (L, _, _) in zip(runs, UNITS, strict=True):
        true = max(np.abs(run["b.x"] - x).max() / (2.0 * L), np.abs(run["b.vx"] - v).max() / np.abs(v).max())
        assert true < 3e-4
        assert 0.1 < true / run.stats["error"] < 10.0
