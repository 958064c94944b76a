"""Laws of contact and impact, against closed forms."""

import numpy as np
import pytest

from mbdsl.numerics.contact_modes import BACKWARD, FORWARD, OPEN, STICK, Contacts, painleve, solve
from mbdsl.numerics.impact import UnsolvableError, at_once, comes_to_rest, gain, in_sequence


def balls(n):
    """W^T (n - 1, n) of the gaps between balls of mass 1 in a row, and their contacts."""
    W = np.eye(n - 1, n, 1) - np.eye(n - 1, n)
    return W, Contacts(W @ W.T, (1,) * (n - 1), np.zeros(n - 1))


@pytest.mark.parametrize(
    ("law", "e", "before", "after"),
    [
        (in_sequence, 1.0, (1, 0, 0), (0, 0, 1)),
        (in_sequence, 1.0, (1, 0, 0, 0, 0), (0, 0, 0, 0, 1)),
        (in_sequence, 1.0, (1, 1, 0, 0, 0), (0, 0, 0, 1, 1)),
        (in_sequence, 0.9, (1, 0, 0), (0.047625, 0.049875, 0.9025)),
        (in_sequence, 0.0, (1, 0, 0), (1 / 3, 1 / 3, 1 / 3)),
        (at_once, 1.0, (1, 0, 0), (-1 / 3, 2 / 3, 2 / 3)),
    ],
)
def test_cradle(law, e, before, after):
    W, contacts = balls(len(before))
    v = np.array(before, float)
    impact = law(contacts, W @ v, np.full(len(W), e))
    np.testing.assert_allclose(v + W.T @ impact.P, after, atol=1e-12)


def block(law, mu=0.0, sideways=0.0):
    """A block of 1 x 0.4 m and 1 kg lands flat with 1 m/s, e = 0.5; x, y, rotation behind the impact."""
    inertia = (1.0 + 0.16) / 12
    rows = []
    for x in (-0.5, 0.5):
        rows += [[0, 1, x], [1, 0, 0.2]]
    W = np.array(rows)
    contacts = Contacts(W @ np.diag([1, 1, 1 / inertia]) @ W.T, (2, 2), np.full(2, mu))
    v = np.array([sideways, -1.0, 0.0])
    impact = law(contacts, W @ v, np.full(2, 0.5))
    return v + np.diag([1, 1, 1 / inertia]) @ W.T @ impact.P, impact


@pytest.mark.parametrize("law", [in_sequence, at_once])
def test_a_block_lands_flat(law):
    v, _ = block(law)
    np.testing.assert_allclose(v, (0, 0.5, 0), atol=1e-12)


def test_a_block_that_lands_flat_slides_on():
    """mu P_N = 0.1 * 1.5 N.s; friction below the centre turns it, and the front leg takes more."""
    v, impact = block(in_sequence, 0.1, 2.0)
    assert impact.modes == (FORWARD, FORWARD)
    np.testing.assert_allclose(v, (2 - 0.15, 0.5, 0), atol=1e-12)


def random_contacts(k, mu, seed, tangents=1):
    """Contacts on a system of 6 coordinates with 2 bilateral rows, and their velocities of approach."""
    rng = np.random.default_rng(seed)
    B = rng.normal(size=(6, 6))
    inverse = np.linalg.inv(B @ B.T + 0.5 * np.eye(6))
    J = rng.normal(size=(2, 6))
    P = inverse - inverse @ J.T @ np.linalg.solve(J @ inverse @ J.T, J @ inverse)
    W = rng.normal(size=(k * (1 + tangents), 6))
    contacts = Contacts(W @ P @ W.T, (1 + tangents,) * k, np.full(k, mu))
    v = P @ np.linalg.solve(P + J.T @ J, rng.normal(size=6))
    u = W @ v
    first = contacts.first
    u[first] = -np.abs(u[first])
    return contacts, u


@pytest.mark.parametrize("tangents", [1, 2])
@pytest.mark.parametrize(("k", "mu"), [(1, 0.6), (2, 0.6), (2, 0.0)])
def test_energy_is_not_gained(k, mu, tangents):
    """The laws hold too: no approach behind the impact, friction inside its cone and against the slip."""
    scaled = 0
    for seed in range(40):
        contacts, u = random_contacts(k, mu, seed, tangents)
        e = np.linspace(0.7, 0.3, k)
        try:
            impact = at_once(contacts, u, e)
        except UnsolvableError:
            assert mu > 0.0, "without friction there is always a solution"
            continue
        P, after = impact.P, u + contacts.G @ impact.P
        assert gain(contacts, u, P) <= 1e-12 * (u @ u)
        scaled += impact.factor < 1.0
        for i, n in enumerate(contacts.first):
            T = contacts.tangents(i)
            assert after[n] >= -impact.factor * e[i] * u[n] - 1e-9 * np.abs(u).max()
            assert np.linalg.norm(P[T]) <= mu * P[n] + 1e-9
            assert P[T] @ after[T] == pytest.approx(-mu * P[n] * np.linalg.norm(after[T]), abs=1e-8)
    if tangents == 1:
        assert (scaled > 0) == (mu > 0.0)


def test_many_contacts_agree_with_quadratic_programming():
    """Without friction the impulses minimise P G P/2 + P b: all 2^7 sets of closed contacts are compared."""
    from itertools import product

    contacts, b = random_contacts(3, 0.0, 5, 1)
    normals = contacts.first
    alone = Contacts(contacts.G[np.ix_(normals, normals)], (1,) * 3, np.zeros(3))
    many = Contacts(np.kron(np.eye(2), alone.G) + 0.01, (1,) * 6, np.zeros(6))
    b = np.concatenate([b[normals], -b[normals][::-1]])
    P, modes = solve(many, b)
    expected = []
    for closed in product((False, True), repeat=6):
        on = np.flatnonzero(closed)
        x = np.zeros(6)
        x[on] = np.linalg.lstsq(many.G[np.ix_(on, on)], -b[on], rcond=None)[0]
        if x.min() >= -1e-12 and (b + many.G @ x).min() >= -1e-10:
            expected.append(x)
    assert expected
    np.testing.assert_allclose(many.G @ P, many.G @ expected[0], atol=1e-9)
    np.testing.assert_allclose(P[[mode == OPEN for mode in modes]], 0.0, atol=1e-15)


@pytest.mark.parametrize("tangents", [1, 2])
def test_many_contacts_from_those_of_the_step_before(tangents):
    """Velocities change from step to step; the solution is the one that a search from nothing finds."""
    rng, size = np.random.default_rng(2), 1 + tangents
    W = np.eye(8 * size) + 0.1 * rng.normal(size=(8 * size, 8 * size))
    contacts, u = Contacts(W @ W.T, (size,) * 8, np.full(8, 0.3)), rng.normal(size=8 * size)
    P, modes = solve(contacts, u)
    for _ in range(20):
        u = u + 0.3 * rng.normal(size=len(u))
        found = solve(contacts, u, modes, guess=P)
        P, modes = solve(contacts, u)
        np.testing.assert_allclose(found[0], P, atol=1e-8)
        assert found[1] == modes


def rod(tan, mu, slips):
    """A uniform rod of mass 1 and half length 1 whose lower end touches the ground, at an angle of this tangent."""
    c, s = 1 / np.hypot(1, tan), tan / np.hypot(1, tan)
    W = np.array([[0, 1, -c], [1, 0, s]])  # from the centre to the end: (-c, -s)
    return Contacts(W @ np.diag([1, 1, 3]) @ W.T, (2,), np.array([mu]), (slips,))


def test_painleve():
    """1 + 3 cos^2 - 3 mu sin cos <= 0, first at mu = 4/3 and tan = 2."""
    assert painleve(rod(2, 4 / 3 - 1e-9, -1)) is None
    assert painleve(rod(2, 4 / 3 - 1e-9, 1)) is None
    contact, least = painleve(rod(2, 1.5, -1))
    assert contact == 0
    assert least == pytest.approx(4 / 3, rel=1e-9)
    assert painleve(rod(2, 1.5, 1)) is None  # slides the other way
    inside = [painleve(rod(np.tan(np.radians(x)), 1.5, -1)) is not None for x in (50.63, 50.65, 73.04, 73.06)]
    assert inside == [False, True, True, False]


def test_painleve_of_many(monkeypatch):
    """A row of thirty masses that slide on each other: no paradox, without a search of millions of combinations."""
    n, mu = 30, 0.2
    G = np.zeros((2 * n, 2 * n))
    G[::2, ::2] = 2.0 * np.eye(n) - 0.9 * np.eye(n, k=1) - 0.9 * np.eye(n, k=-1)
    G[1::2, 1::2] = 2.0 * np.eye(n)
    G[::2, 1::2] = 0.5 * np.eye(n)
    G[1::2, ::2] = 0.5 * np.eye(n)
    row = Contacts(G, (2,) * n, np.full(n, mu), (1,) * n)
    minors = [np.linalg.det(G[: 2 * k : 2, : 2 * k : 2] - mu * G[: 2 * k : 2, 1 : 2 * k : 2]) for k in range(1, n + 1)]
    assert min(minors) > 0.0
    monkeypatch.setattr("mbdsl.numerics.contact_modes._least_minor", None)
    assert painleve(row) is None


def test_lasting_contact():
    """Weight 10 N pulled by 2 N and 4 N sideways, mu = 0.3: it sticks, and slides with 1 m/s2."""
    point = Contacts(np.eye(2), (2,), np.array([0.3]))
    P, modes = solve(point, np.array([-10.0, 2.0]))
    assert modes == (STICK,)
    np.testing.assert_allclose(P, (10, -2))
    P, modes = solve(point, np.array([-10.0, -4.0]))
    assert modes == (BACKWARD,)
    np.testing.assert_allclose(P, (10, 3))
    assert solve(point, np.array([1.0, -4.0]))[1] == (OPEN,)
    P, modes = solve(Contacts(np.eye(2), (2,), np.array([0.3]), (1,)), np.array([-10.0, -2.0]))
    assert modes == (FORWARD,)  # it slides already, and is braked
    np.testing.assert_allclose(P, (10, -3))


def test_friction_in_space():
    """A mass on the ground, pulled obliquely: friction is opposite to its acceleration."""
    point = Contacts(np.eye(3), (3,), np.array([0.5]))
    P, modes = solve(point, np.array([-10.0, 6.0, 8.0]))
    assert modes == (FORWARD,)
    np.testing.assert_allclose(P, (10, -3, -4), atol=1e-12)
    P, modes = solve(point, np.array([-10.0, 1.8, 2.4]))
    assert modes == (STICK,)
    np.testing.assert_allclose(P, (10, -1.8, -2.4), atol=1e-12)


def test_no_solution():
    """The rod between 50.64 and 73.05 deg that is pressed on: no force is possible."""
    assert solve(rod(2, 1.5, -1), np.array([-1.0, 0.0])) is None


def test_rest():
    """A ball, e = 0.8, that leaves with v: it rests after 2 v/(g (1 - e))."""
    assert comes_to_rest(0.01, 10.0, 0.8, 1.0) == pytest.approx(0.01)
    assert comes_to_rest(0.01, 10.0, 0.8, 0.0099) is None
    assert comes_to_rest(0.01, -10.0, 0.8, 1.0) is None
    assert comes_to_rest(0.01, 10.0, 1.0, 1e9) is None
