"""Small steps: iteration matrices stay well conditioned as h -> 0, and results stay near rounding.

The rows of the constraints are divided by h or h^2 in every method. With that an iteration matrix tends to a
saddle-point matrix of M and Phi_q; without it the condition number would grow like 1/h or 1/h^2. Scaling cannot change
that a position is known to eps only: an index-3 method finds v from differences of positions, with noise of eps/h, and
a and the reactions with noise of eps/h^2. A stabilised method finds v from its own constraints, to eps.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import compiled, modules
from mbdsl.integrators.loop import linear_solve
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

EPS = np.finfo(float).eps
STEPS = [10.0**-k for k in range(2, 9)]
INDEX3 = [name for name, method in compiled().items() if method.index == 3]
#: the powers of h by which the constraint rows of A[0] and A[1] are scaled (A[1] is the projection of positions)
POWERS = {name: (2,) if name in INDEX3 else (1, 2) for name, method in compiled().items() if method.stable == np.inf}
PHI, W = np.deg2rad(40), 6.0  #: the crank's angle and angular velocity at the start: all bodies move


@pytest.fixture(scope="module")
def crank(model):
    """The slider crank, moving from the start: (scene, system, initial state)."""
    text = model("slider_crank").read_text(encoding="utf-8")
    for old, new in (
        ("phi = 0 deg;\n  crank.w = 0", f"phi = 40 deg;\n  crank.w = {W}"),
        ("rod.phi = 0", "rod.phi = -19"),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    scene = mbdsl.parse(text)
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    return scene, system, initial_state(system, mechanism, 0.0)


def factorised(run, k):
    """The k-th matrix that the method factorised last: L times U, with the row exchanges undone."""
    N = run.system.unknowns
    factors = run.matrices[k, : N * N].reshape(N, N)
    matrix = (np.tril(factors, -1) + np.eye(N)) @ np.triu(factors)
    for i in reversed(range(N)):
        matrix[[i, run.pivots[k, i]]] = matrix[[run.pivots[k, i], i]]
    return matrix


def matrices(crank, method, h):
    """The matrices of the fourth step, in dense form; A[0], and A[1] if the method has two systems."""
    _scene, system, start = crank
    run = MethodRun(system, method, h, 0.0, 10 * h, np.array([]))
    run.use_solver(linear_solve.DENSE)
    run.begin(start.q, start.v, start.a, start.lam)
    assert run.advance(3) == S.RUNNING
    run.integers[S.FRESH] = 0
    assert run.advance(1) == S.RUNNING
    assert run.integers[S.MATRICES] >= 2
    return [factorised(run, k) for k in range(len(POWERS[method]))]


def test_matrices_are_read_back(crank):
    """hht-si2's projection is [[2 M, Phi_q^T], [Phi_q, 0]], with Phi_q some steps of 1e-8 s later."""
    _scene, system, start = crank
    expected = system.tangent(0.0, start.q, start.v, start.lam, cM=2.0, cP=1.0)
    assert matrices(crank, "hht-si2", 1e-8)[1] == pytest.approx(expected, abs=4e-8 * W * 2)


def test_every_factorised_matrix_is_looked_at():
    for name, powers in POWERS.items():
        assert (modules()[name].METHOD.matrices > 1) == (len(powers) == 2)


def test_condition_tends_to_a_limit(crank, method):
    """The part of a matrix that depends on h is of order h; the limit is that of a well-conditioned mechanism."""
    found = np.array([[np.linalg.cond(A) for A in matrices(crank, method, h)] for h in STEPS])
    limit = found[-1]
    assert (limit < 100).all()
    for h, conditions in zip(STEPS, found, strict=True):
        # between 1e-2 s and 1e-3 s springs and dampers change it by a tenth, a hundredth, ...
        assert conditions == pytest.approx(limit, rel=20 * h + 1e-9), h


def test_condition_without_scaling(crank, method):
    """The same rows without the division: the test above would detect it."""
    _scene, system, _start = crank
    for k, power in enumerate(POWERS[method]):
        found = []
        for h in STEPS[2:5]:
            A = matrices(crank, method, h)[k].copy()
            A[system.n :] *= h**power
            found.append(np.linalg.cond(A))
        slope = np.polyfit(np.log(STEPS[2:5]), np.log(found), 1)[0]
        assert slope == pytest.approx(-power, abs=1e-3)  # terms of other powers of h are smaller by 10 h


# -- results at a tiny step --------------------------------------------------------------------------------------


def rod(th, L1=0.3, L2=0.6):
    """The rod's angle as a function of the crank's, with first and second derivative."""
    ph = -np.arcsin(L1 * np.sin(th) / L2)
    d = -L1 * np.cos(th) / (L2 * np.cos(ph))
    return ph, d, (L1 * np.sin(th) + L2 * np.sin(ph) * d**2) / (L2 * np.cos(ph))


def coordinates(th, L1=0.3, L2=0.6):
    """q(th), q'(th), q''(th), all six coordinates."""
    ph, d, dd = rod(th)
    s, c, sp, cp = np.sin(th), np.cos(th), np.sin(ph), np.cos(ph)
    q = [L1 / 2 * c, L1 / 2 * s, th, L1 * c + L2 / 2 * cp, L1 * s + L2 / 2 * sp, ph]
    q1 = [-L1 / 2 * s, L1 / 2 * c, 1.0, -L1 * s - L2 / 2 * sp * d, L1 * c + L2 / 2 * cp * d, d]
    x2, y2 = -L1 * c - L2 / 2 * (cp * d**2 + sp * dd), -L1 * s + L2 / 2 * (cp * dd - sp * d**2)
    return np.array(q), np.array(q1), np.array([-L1 / 2 * c, -L1 / 2 * s, 0.0, x2, y2, dd])


def acceleration(th, w, L1=0.3, L2=0.6, m1=3.0, m2=0.9, k=100.0, c=5.0, g=9.81):
    """th'' from d'Alembert's principle, q'(th) . (M q'' - Q) = 0."""
    _q, q1, q2 = coordinates(th)
    M = np.array([m1, m1, m1 * L1**2 / 12, m2, m2, m2 * L2**2 / 12])
    ph, d, _dd = rod(th)
    xB, dxB = L1 * np.cos(th) + L2 * np.cos(ph), -L1 * np.sin(th) - L2 * np.sin(ph) * d
    power = (k * (1.2 - xB - 0.3) - c * dxB * w) * dxB - g * (m1 * q1[1] + m2 * q1[4])
    return (power - (M * q1 * q2).sum() * w**2) / (M * q1**2).sum()


def reference(system, times):
    """q, v and multipliers of the ODE of one degree of freedom."""
    solution = solve_ivp(
        lambda t, y: (y[1], acceleration(*y)), (0, times[-1]), (PHI, W), "DOP853", times, rtol=3e-14, atol=1e-15
    )
    found = []
    for t, th, w in zip(times, *solution.y, strict=True):
        q, q1, q2 = coordinates(th)
        v, a = q1 * w, q1 * acceleration(th, w) + q2 * w**2
        forces = system.Q(t, q, v) - system.mass() * a
        found.append((q, v, np.linalg.lstsq(system.Phi_q(t, q).T, forces, rcond=None)[0]))
    return [np.array(x) for x in zip(*found, strict=True)]


def test_reference(crank):
    """It starts where the model does, accelerations and multipliers included."""
    _scene, system, start = crank
    q, v, lam = (x[0] for x in reference(system, np.array([0.0, 1e-3])))
    assert q == pytest.approx(start.q, abs=1e-15)
    assert v == pytest.approx(start.v, abs=1e-14)
    assert lam == pytest.approx(start.lam, abs=1e-12)


def test_tiny_steps(crank, method):
    """20000 steps of 1e-7 s; q is of size 1, v of size 6, reactions of 10 N, masses up to 3 kg.

    The discretisation's error is below rounding (1e-14), but for newmark's of order 1, some 7e-9 in v.
    Stabilised methods: N roundings of v add up to no more than N eps |v|, and move q by T times that beside q's own N
    eps/2; the reactions of a step follow from velocities known to eps |v|, by m/h. hht-add's are found from q and v:
    their errors are those of q and v times (c, 2 m w, k, ...) < 100.
    Index 3: a constraint is met to a few eps, with 1/beta < 4 and gamma/beta < 3 in between, and joints add
    up: 64 eps/h in v and, with masses, 64 eps/h^2 in the reactions, which leaves no digits of these.
    """
    scene, system, _start = crank
    h, N = 1e-7, 20_000
    T = N * h
    r = mbdsl.simulate(scene, method=method, step=h, stop=T, interval=T / 20)
    assert len(r) == 21
    q, v, lam = reference(system, r.t)
    found = [np.abs(x - y).max() for x, y in ((r.q, q), (r.v, v), (r.lam, lam))]
    sum_v = N * EPS * W
    if method in INDEX3:
        noise = 64 * EPS / h
        bounds = [N * EPS / 2 + T * noise, noise, 64 * EPS / h**2]
        assert found[1] > sum_v  # so the bound of the others can be broken
    else:
        bounds = [N * EPS / 2 + T * sum_v, sum_v, 100 * sum_v if method == "hht-add" else 3 * EPS * W / h]
    assert np.abs(r.q[-1] - r.q[0]).max() > 1e-2  # it moves
    assert (np.array(found) < bounds).all(), (found, bounds)
