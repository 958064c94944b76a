"""Dominoes against an own solution: differential equations between strikes, a linear system at each."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl

h, d, room, m, mu, g = 48e-3, 8e-3, 12e-3, 8e-3, 0.2, 9.81
D, INERTIA = room + d, m * (h**2 + d**2) / 3.0  #: about the front lower edge
LAST = np.radians(80.0)  #: the angle at which the run ends


def levers(angles):
    """Of the contacts of k dominoes, whose angles fall from each to the next: J (k - 1, k), the rates of the gaps, and
    Q (k, k - 1), the moments about the feet of unit normal forces and the friction that they cause.

    The upper edge of one slides down the back of the next. Normal force and friction on it are along -n and t of the
    back, and act opposite on the next one, with the arm d and the height of the point above its foot.
    """
    k, lean, c = len(angles), -np.diff(angles), np.arange(len(angles) - 1)
    J, Q = np.zeros((k - 1, k)), np.zeros((k, k - 1))
    J[c, c], J[c, c + 1] = -h * np.cos(lean), h * np.cos(lean) - D * np.sin(angles[1:])
    Q[c, c], Q[c + 1, c] = J[c, c] - mu * h * np.sin(lean), J[c, c + 1] - mu * d
    return J, Q


def motion(angles, rates):
    """Angular accelerations of dominoes that lean on each other, and the normal forces [N]."""
    weight, (J, Q) = 0.5 * m * g * (h * np.sin(angles) - d * np.cos(angles)), levers(angles)
    lean, turn = -np.diff(angles), -np.diff(rates)
    bias = h * np.sin(lean) * turn**2 - D * np.cos(angles[1:]) * rates[1:] ** 2
    N = np.linalg.solve(J @ Q, -(INERTIA * bias + J @ weight))
    return (weight + Q @ N) / INERTIA, N


def energy(angles, rates):
    return np.sum(0.5 * INERTIA * rates**2 + 0.5 * m * g * (h * np.cos(angles) + d * np.sin(angles)))


def toppled(n):
    """Times of the n - 1 strikes and of the end, angles, rates and normal forces there, impulses of all contacts at the
    last strike, and the loss of energy."""
    angles, rates, times, P = np.zeros(1), np.array([6.0]), [0.0], np.zeros(0)
    stands = energy(np.zeros(n), np.r_[rates, np.zeros(n - 1)])
    for k in range(1, n + 1):

        def rate(t, y, k=k):
            return np.r_[y[k:], motion(y[:k], y[k:])[0]]

        def meets(t, y, k=k):
            return D - h * np.sin(y[k - 1]) - d if k < n else LAST - y[k - 1]

        meets.terminal = True
        y0 = np.r_[angles, rates]
        run = solve_ivp(rate, (times[-1], times[-1] + 1.0), y0, "DOP853", rtol=1e-10, atol=1e-12, events=meets)
        assert run.status == 1 and all(motion(y[:k], y[k:])[1].min(initial=1.0) > 0.0 for y in run.y.T)  # none opens
        times.append(run.t[-1])
        angles, rates = run.y[:k, -1], run.y[k:, -1]
        if k < n:
            angles, rates = np.r_[angles, 0.0], np.r_[rates, 0.0]
            J, Q = levers(angles)
            P = np.linalg.solve(J @ Q, -INERTIA * (J @ rates))  # plastic: no gap opens
            assert P.min() > 0.0
            rates = rates + Q @ P / INERTIA
    return np.array(times[1:]), angles, rates, motion(angles, rates)[1], P, stands - energy(angles, rates)


def strikes(run):
    """Times of impacts; those of one event count once."""
    return np.array(sorted({event.t for event in run.events if event.kind == "impact"}))


def of_all(run, name, n):
    return np.array([run[name.format(i)][-1] for i in range(1, n + 1)])


def test_eight_dominoes(gallery):
    """With friction of 0.19 the times differ by 1.3 ms, and with restitution of 0.05 there are more strikes."""
    n = 8
    times, angles, rates, forces, impulses, lost = toppled(n)
    run = mbdsl.simulate(gallery("dominoes", {"n": n}), step=1e-3)
    np.testing.assert_allclose(strikes(run), times[:-1], rtol=0, atol=1e-5)
    assert run.t[-1] == pytest.approx(times[-1], abs=1e-5)
    np.testing.assert_allclose(of_all(run, "hinge[{}].phi", n), angles, rtol=0, atol=1e-9)
    np.testing.assert_allclose(of_all(run, "hinge[{}].w", n), rates, rtol=3e-4)
    np.testing.assert_allclose(of_all(run, "touch[{}].impulse", n - 1), impulses, rtol=3e-4)
    np.testing.assert_allclose(of_all(run, "touch[{}].force", n - 1), forces, rtol=1e-3)
    assert run["energy.total"][0] - run["energy.total"][-1] == pytest.approx(lost, rel=3e-3)


def test_thirty_dominoes(whole):
    """All strikes; the wave approaches a constant speed; energy is lost, and never gained."""
    n = 30
    times, _, rates, _, _, lost = toppled(n)
    run = whole("dominoes")
    assert len(run.select(["hinge[*].phi"])) == n
    found = strikes(run)
    np.testing.assert_allclose(found, times[:-1], rtol=0, atol=1e-4)
    np.testing.assert_allclose(of_all(run, "hinge[{}].w", n), rates, rtol=1e-3)
    periods = np.diff(found)
    assert (np.diff(periods[:20]) < 0.0).all()
    np.testing.assert_allclose(D / periods[-5:], D / np.diff(times)[-2], rtol=3e-4)
    energy_of_run = run["energy.total"]
    assert np.diff(energy_of_run).max() < 1e-6 * energy_of_run[0]
    assert energy_of_run[0] - energy_of_run[-1] == pytest.approx(lost, rel=3e-3)


def test_dominoes_that_stand_are_not_struck(gallery):
    """Each strike is an impact of all contacts of those that have fallen, and of nothing else: impulses on heels at
    rest are rounding errors."""
    n = 6
    run = mbdsl.simulate(gallery("dominoes", {"n": n}), step=1e-3)
    struck = [event.name for event in run.events if event.kind == "impact"]
    assert sorted(struck) == [f"touch[{i}]" for i in range(1, n) for _ in range(n - i)]


@pytest.mark.parametrize("method", ["radau5", "radau9", "dop853", "hht-si2"])
def test_dominoes_that_stand_with_error_control(gallery, method):
    """The angles of two of them are rounding until they are struck; their heels and their edges carry m g/2 each."""
    times, angles, rates, *_ = toppled(3)
    run = mbdsl.simulate(gallery("dominoes", {"n": 3}), method=method, tol=1e-6)
    assert run.t[-1] == pytest.approx(times[-1], abs=1e-6)
    np.testing.assert_allclose(of_all(run, "hinge[{}].phi", 3), angles, rtol=0, atol=1e-6)
    np.testing.assert_allclose(of_all(run, "hinge[{}].w", 3), rates, rtol=1e-5)
    stands = run.t < times[0] - 1e-3
    for i in (2, 3):
        np.testing.assert_allclose(run[f"heel[{i}].force"][stands], 0.5 * m * g, rtol=1e-9)
        assert np.abs(run[f"hinge[{i}].phi"][stands]).max() < 1e-12
