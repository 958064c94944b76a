"""The floating frame's elastic coordinates against closed forms of beams, and their integrals against quadrature.

The quadrature uses only ``station`` of a beam, with more points than needed, and computes N from its slopes.
"""

import json
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from mbdsl.bodies.floating_beam_integrals import discretise
from mbdsl.bodies.uniform_beam import UniformBeam

REFERENCE = Path(__file__).parents[2] / "data" / "reference"
L, RHOA, EA, EI, J = 0.7, 2.3, 4.1e5, 37.0, 0.011
BEAM = dict(L=L, rhoA=RHOA, EA=EA, EI=EI)
REFERENCES = ("pinned-pinned", "clamped-free", "mean-axis")

#: beams of the tests below: unreduced, with modes, and with modes of the ends, with and without axial modes
CASES = {
    "elements pinned": dict(elements=3),
    "elements clamped": dict(elements=4, reference="clamped-free", J=J),
    "one element": dict(elements=1, reference="clamped-free"),
    "modes pinned": dict(elements=6, modes=7, axial=3, J=J),
    "modes clamped": dict(elements=5, modes=12, reference="clamped-free"),
    "modes free": dict(elements=5, modes=6, axial=2, reference="mean-axis", J=J),
    "ends pinned": dict(elements=4, modes=6, basis="craig-bampton", J=J),
    "ends clamped": dict(elements=4, modes=7, axial=3, basis="craig-bampton", reference="clamped-free"),
    "ends free": dict(elements=4, modes=5, basis="craig-bampton", reference="mean-axis", J=J),
    "rigid in bending's chord": dict(elements=3, stiffening=False),
}


def beam(**more):
    return discretise(UniformBeam(**(BEAM | more)))


def slope_of(error):
    """Exponent p of error(n) ~ n^-p, fitted over n = 10, 20, 40: h^4 is 8e-9 to 2e-6 of a mode's wavelength."""
    n = np.array([10, 20, 40])
    return -np.polyfit(np.log(n), np.log([error(k) for k in n]), 1)[0]


# --- frequencies


def bending_roots(reference):
    if reference == "pinned-pinned":
        return np.pi * np.arange(1, 4)
    if reference == "clamped-free":
        text = (REFERENCE / "cantilever_frequencies.json").read_text(encoding="utf-8")
        return np.array([float(x) for x in json.loads(text)["data"]])
    near = np.pi * (np.arange(1, 4) + 0.5)
    return np.array(
        [brentq(lambda b: np.cos(b) - 1 / np.cosh(b), b - 0.5, b + 0.5, xtol=1e-15, rtol=1e-15) for b in near]
    )


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("reference", REFERENCES)
def test_frequencies_of_bending_converge_with_order_four(reference, i):
    root = bending_roots(reference)[i]
    exact = root**2 * np.sqrt(EI / RHOA) / L**2

    def error(n):
        found = beam(elements=int(n), modes=3, axial=0, reference=reference).frequencies()[i]
        assert found > exact  # an upper bound, as Rayleigh's quotient
        return found / exact - 1

    assert 3.8 < slope_of(error) < 4.3
    # the constant of the theory, but for a term of order (root / 40)^2, at most 1.5 %
    assert error(40) == pytest.approx((root / 40) ** 4 / 1440, rel=0.2 * (root / 40) ** 2)


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("reference", REFERENCES)
def test_axial_frequencies_converge_with_order_four(reference, i):
    root = np.pi * (i + 1 if reference == "mean-axis" else i + 0.5)
    exact = root * np.sqrt(EA / RHOA) / L

    def error(n):
        return beam(elements=int(n), modes=3, axial=3, reference=reference).frequencies()[i] / exact - 1

    assert 3.8 < slope_of(error) < 4.3
    assert error(40) == pytest.approx((root / 40) ** 4 / 1440, rel=0.2 * (root / 40) ** 2)


@pytest.mark.parametrize("i", range(3))
def test_rotary_inertia_slows_bending(i):
    k = (i + 1) * np.pi / L
    exact = np.sqrt(EI * k**4 / (RHOA + J * k**2))
    assert exact < 0.96 * np.sqrt(EI / RHOA) * k**2
    assert 3.8 < slope_of(lambda n: beam(elements=int(n), modes=3, axial=0, J=J).frequencies()[i] / exact - 1) < 4.3


@pytest.mark.parametrize("reference", ["pinned-pinned", "clamped-free"])
def test_all_modes_have_the_frequencies_of_the_elements(reference):
    n = 6
    found = beam(elements=n, reference=reference, J=J)
    for basis in ("eigenmodes", "craig-bampton"):
        all_modes = beam(elements=n, modes=4 * n, reference=reference, J=J, basis=basis).frequencies()
        np.testing.assert_allclose(all_modes, found.frequencies(), rtol=1e-10)
    direct = eigh(found.K, found.M_ff, eigvals_only=True)
    np.testing.assert_allclose(found.frequencies(), np.sqrt(direct), rtol=1e-8)


@pytest.mark.parametrize("basis", ["eigenmodes", "craig-bampton"])
def test_without_a_number_of_axial_modes_the_lowest_are_taken(basis):
    f = beam(elements=8, modes=9, basis=basis)
    of_axial = int(f.axial.any(axis=0).sum())
    assert 1 <= of_axial < 9
    assert (np.diff(f.frequencies()) > 0).all()
    if basis == "eigenmodes":
        np.testing.assert_allclose(f.frequencies(), beam(elements=8).frequencies()[:9], rtol=1e-10)
    chosen = beam(elements=8, modes=9, axial=of_axial, basis=basis)
    np.testing.assert_allclose(np.sort(chosen.frequencies()), f.frequencies(), rtol=1e-12)


def test_chosen_axial_modes_follow_those_of_bending():
    f = beam(elements=8, modes=7, axial=3)
    assert f.bending.any(axis=0).tolist() == [True] * 4 + [False] * 3
    assert f.axial.any(axis=0).tolist() == [False] * 4 + [True] * 3


@pytest.mark.parametrize("reference", REFERENCES)
def test_modes_of_the_ends_come_close_to_the_eigenmodes_from_above(reference):
    """Craig and Bampton's frequencies are upper bounds, and better ones with more modes."""
    exact = beam(elements=10, modes=4, axial=1, reference=reference).frequencies()
    few, more = (
        beam(elements=10, modes=k, axial=2, reference=reference, basis="craig-bampton").frequencies() for k in (5, 12)
    )
    errors = few[:2] / exact[:2] - 1, more[:2] / exact[:2] - 1
    assert (errors[0] > errors[1]).all()
    assert (errors[1] > 0).all()
    assert (errors[1] < 2e-4).all()


# --- integrals


def stations(f):
    """Points, weights, U and N there: ten Gauss points an element."""
    points, weights = np.polynomial.legendre.leggauss(10)
    h = f.L / f.elements
    x = (h * (np.arange(f.elements)[:, None] + (1 + points) / 2)).ravel()
    return x, np.tile(weights * h / 2, f.elements), *map(np.array, zip(*(f.station(y) for y in x), strict=True))


def strains(f):
    """s' and v'' at the same points, from s and v' at three places of an element, where both are quadratic: exact."""
    places = np.array([0.02, 0.5, 0.98])
    points = (1 + np.polynomial.legendre.leggauss(10)[0]) / 2
    slope = np.array([[0.0, 1.0, 2 * r] for r in points]) @ np.linalg.inv(np.vander(places, increasing=True))
    h = f.L / f.elements
    U = np.array([[f.station((e + r) * h)[0][[0, 2]] for r in places] for e in range(f.elements)])
    return np.einsum("pr,erai->aepi", slope / h, U).reshape(2, -1, f.k)


def shortening(f, x):
    """N(x) from slopes, eight points on each smooth part."""
    points, weights = np.polynomial.legendre.leggauss(8)
    nodes = np.append(np.arange(0.0, 1.0, 1 / f.elements) * f.L, f.L)
    nodes = np.append(nodes[nodes < x], x)
    N = np.zeros((f.k, f.k))
    for a, b in pairwise(nodes):
        for y, w in zip(a + (b - a) * (1 + points) / 2, weights * (b - a) / 2, strict=True):
            slope = f.station(y)[0][2]
            N += w * np.outer(slope, slope)
    return N


@pytest.mark.parametrize("case", CASES)
def test_integrals_are_those_of_the_fields(case):
    f, inertia = beam(**CASES[case]), CASES[case].get("J", 0.0)
    x, w, U, N = stations(f)
    s, v, slope = U.swapaxes(0, 1)
    arm, mass = x - L / 2, RHOA * w
    H = np.einsum("p,pai,paj->ij", mass, U[:, :2], U[:, :2])
    expected = {
        "S_bar": np.array([mass @ s, mass @ v]),
        "h1": (mass * arm) @ s,
        "g0": (mass * arm) @ v + inertia * w @ slope,
        "H": H,
        "M_ff": H + inertia * (slope.T * w) @ slope,
        "G": np.einsum("p,pi,pj->ij", mass, s, v) - np.einsum("p,pi,pj->ij", mass, v, s),
        "N_bar": np.einsum("p,pij->ij", mass, N),
        "N_hat": np.einsum("p,pij->ij", mass * arm, N),
    }
    for name, value in expected.items():
        size = np.abs(value).max()
        floor = {"S_bar": f.m**0.5, "h1": f.I0**0.5, "g0": f.I0**0.5}.get(name, 1.0) if f.modal else size
        np.testing.assert_allclose(getattr(f, name), value, rtol=0, atol=2e-13 * max(size, floor), err_msg=name)
    ds, ddv = strains(f)
    K = EA * (ds.T * w) @ ds + EI * (ddv.T * w) @ ddv
    scale = np.sqrt(np.diag(K))
    np.testing.assert_allclose(f.K / np.outer(scale, scale), K / np.outer(scale, scale), rtol=0, atol=1e-12)
    assert f.m == RHOA * L
    assert pytest.approx(mass @ arm**2 + inertia * L, rel=1e-14) == f.I0
    assert not f.s0.any()


@pytest.mark.parametrize("case", CASES)
def test_shortening_is_the_integral_of_squared_slopes(case):
    f = beam(**CASES[case])
    assert not f.station(0.0)[1].any()
    for x in (0.11 * L, 0.5 * L, 0.83 * L, L):
        N = shortening(f, x)
        expected = N if f.stiffening else np.zeros_like(N)
        np.testing.assert_allclose(f.station(x)[1], expected, rtol=0, atol=1e-13 * np.abs(N).max())
    assert f.stiffening == f.N_bar.any() == f.N_hat.any()


@pytest.mark.parametrize("case", CASES)
def test_slope_is_that_of_the_deflection_and_fields_are_continuous(case):
    f = beam(**CASES[case])
    h = L / f.elements
    for x in (np.arange(f.elements) + 0.37) * h:
        v = np.array([f.station(x + k * h / 10)[0][1] for k in (-2, -1, 1, 2)])
        slope = f.station(x)[0][2]  # cubic fields: the difference over five points is exact
        np.testing.assert_allclose(np.array([1, -8, 8, -1]) / 12 @ v * 10 / h, slope, atol=1e-13 * np.abs(v).max() / h)
    for i in range(1, f.elements):
        node, d = i * L / f.elements, 1e-11 * L
        U = [f.station(node + k * d)[0] for k in (-1, 0, 1)]
        np.testing.assert_allclose(U[0], U[1], rtol=0, atol=1e-8 * np.abs(U[1]).max())
        np.testing.assert_allclose(U[2], U[1], rtol=0, atol=1e-8 * np.abs(U[1]).max())


@pytest.mark.parametrize("case", CASES)
def test_kinetic_and_strain_energies_are_positive(case):
    """T of the frame's and the elastic rates, in the undeformed beam, and the strain energy of any deformation."""
    f = beam(**CASES[case])
    M = np.zeros((3 + f.k, 3 + f.k))
    M[:2, :2], M[2, 2], M[3:, 3:] = f.m * np.eye(2), f.I0, f.M_ff
    M[:2, 3:], M[3:, :2] = f.S_bar, f.S_bar.T
    M[2, 3:] = M[3:, 2] = f.g0
    for A in (M, f.K, f.M_ff, f.H):
        d = np.sqrt(np.diag(A))
        assert (A == A.T).all()
        assert np.linalg.eigvalsh(A / np.outer(d, d))[0] > 1e-8
    assert (f.G == -f.G.T).all()


# --- modes


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("basis", ["eigenmodes", "craig-bampton"])
def test_many_modes_are_orthonormal(basis, reference):
    """M and K of 60 modes by quadrature; every pair is orthogonal, K's by their frequencies."""
    f = beam(elements=40, modes=60, axial=12, basis=basis, reference=reference)
    _, w, U, _ = stations(f)
    np.testing.assert_allclose(np.einsum("p,pai,paj->ij", RHOA * w, U[:, :2], U[:, :2]), np.eye(60), rtol=0, atol=2e-14)
    assert (f.M_ff == np.eye(60)).all()
    assert not (f.K - np.diag(np.diag(f.K))).any()
    ds, ddv = strains(f)
    omega = f.frequencies()
    K = (EA * (ds.T * w) @ ds + EI * (ddv.T * w) @ ddv) / np.outer(omega, omega)
    np.testing.assert_allclose(K, np.eye(60), rtol=0, atol=2e-12)


@pytest.mark.parametrize("basis", ["eigenmodes", "craig-bampton"])
@pytest.mark.parametrize("J", [0.0, J])
def test_mean_axis_modes_have_no_momentum(basis, J):
    f = beam(elements=9, modes=14, axial=5, basis=basis, reference="mean-axis", J=J)
    assert not f.S_bar.any()
    assert not f.g0.any()
    assert f.h1.any()
    # they are zero exactly, not by a threshold
    x, w, U, _ = stations(f)
    assert np.abs(RHOA * np.einsum("p,pai->ai", w, U[:, :2])).max() < 1e-14 * f.m**0.5
    angular = RHOA * (w * (x - L / 2)) @ U[:, 1] + J * w @ U[:, 2]
    assert np.abs(angular).max() < 1e-14 * f.I0**0.5


@pytest.mark.parametrize("case", [case for case in CASES if "modes" in CASES[case]])
def test_modes_are_axial_or_of_bending(case):
    f = beam(**CASES[case])
    axial = f.axial.any(axis=0)
    assert (axial != f.bending.any(axis=0)).all()
    apart = axial[:, None] != axial
    assert not f.G[~apart].any()
    assert not f.H[apart].any()
    assert not f.N_bar[axial].any() and not f.N_hat[axial].any()
    assert not f.S_bar[1, axial].any() and not f.S_bar[0, ~axial].any()
    assert not f.h1[~axial].any() and not f.g0[axial].any()


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("basis", ["eigenmodes", "craig-bampton"])
def test_modes_keep_their_signs_with_more_elements(basis, reference):
    coarse, fine = (beam(elements=n, modes=9, axial=3, basis=basis, reference=reference) for n in (12, 30))
    for x in np.linspace(0, L, 8):
        U, W = coarse.station(x)[0], fine.station(x)[0]
        assert np.abs(U - W)[:2].max() < 0.05 * np.sqrt(2 / coarse.m)


def test_odd_and_even_modes_of_a_symmetric_beam_have_exact_zeros():
    f = beam(elements=8, modes=6, axial=0)
    even = np.arange(6) % 2 == 0
    assert not f.S_bar[1, ~even].any() and not f.g0[even].any()
    assert f.S_bar[1, even].all() and f.g0[~even].all()


# --- reference conditions and coordinates


@pytest.mark.parametrize("case", [case for case in CASES if CASES[case].get("reference") != "mean-axis"])
def test_reference_conditions_hold_exactly(case):
    f = beam(**CASES[case])
    start, end = f.station(0.0)[0], f.station(L)[0]
    assert not start[:2].any()
    assert not (start[2] if CASES[case].get("reference") == "clamped-free" else end[1]).any()


def test_coordinates_of_elements_are_displacements_at_nodes():
    f = beam(elements=4, reference="clamped-free")
    assert f.names == tuple("u1m u1 v1 t1 u2m u2 v2 t2 u3m u3 v3 t3 u4m u4 v4 t4".split())
    assert beam(elements=2).names == tuple("t0 u1m u1 v1 t1 u2m u2 t2".split())
    for i, name in enumerate(f.names):
        x = (int(name[1]) - (0.5 if name[-1] == "m" else 0.0)) * L / 4
        row = f.station(x)[0]["uvt".index(name[0])]
        assert row.tolist() == [float(k == i) for k in range(f.k)]


@pytest.mark.parametrize("reference", ["pinned-pinned", "clamped-free"])
def test_matrices_of_elements_are_banded(reference):
    """An element has seven coordinates in a row: nothing further than six places from the diagonal."""
    f = beam(elements=9, reference=reference, J=J, alpha=0.3, beta=1e-4)
    i, j = np.indices((f.k, f.k))
    for A in (f.H, f.M_ff, f.G, f.N_bar, f.N_hat, f.K, f.D, f.station(0.77 * L)[1]):
        assert A.any()
        assert not A[np.abs(i - j) > 6].any()
    assert f.k == 36


# --- statics


@pytest.mark.parametrize("n", [1, 2, 7])
@pytest.mark.parametrize("basis", [None, "craig-bampton"])
def test_cantilever_with_loads_at_its_tip(n, basis):
    kept = {} if basis is None else dict(basis=basis, modes=min(4 * n, 5))
    f = beam(elements=n, reference="clamped-free", **kept)
    tip = f.station(L)[0]
    load = np.array([310.0, -5.3, 2.9])  # axial, transverse [N], moment [N m]
    stretch, P, M = np.linalg.solve(f.K, tip.T * load).T
    x = 0.37 * L
    expected = {
        (0, L): load[0] * L / EA,
        (0, x): load[0] * x / EA,
    }
    for (row, at), value in expected.items():
        assert f.station(at)[0][row] @ stretch == pytest.approx(value, rel=1e-10)
    assert tip[1] @ P == pytest.approx(load[1] * L**3 / (3 * EI), rel=1e-10)
    assert tip[2] @ P == pytest.approx(load[1] * L**2 / (2 * EI), rel=1e-10)
    assert tip[1] @ M == pytest.approx(load[2] * L**2 / (2 * EI), rel=1e-10)
    assert tip[2] @ M == pytest.approx(load[2] * L / EI, rel=1e-10)
    assert f.station(x)[0][1] @ P == pytest.approx(load[1] * x**2 * (3 * L - x) / (6 * EI), rel=1e-10)


@pytest.mark.parametrize("n", [1, 2, 7])
@pytest.mark.parametrize("basis", [None, "craig-bampton"])
def test_simply_supported_beam_with_a_moment_at_its_end(n, basis):
    kept = {} if basis is None else dict(basis=basis, modes=3)
    f, M = beam(elements=n, **kept), 3.7
    start, end = f.station(0.0)[0], f.station(L)[0]
    q = np.linalg.solve(f.K, end[2] * M)
    assert end[2] @ q == pytest.approx(M * L / (3 * EI), rel=1e-10)
    assert start[2] @ q == pytest.approx(-M * L / (6 * EI), rel=1e-10)
    x = 0.4 * L
    assert f.station(x)[0][1] @ q == pytest.approx(-M * x * (L**2 - x**2) / (6 * EI * L), rel=1e-10)


@pytest.mark.parametrize("n", [2, 6])
def test_simply_supported_beam_with_a_load_in_the_middle(n):
    f, P = beam(elements=n), 51.0
    middle = f.station(L / 2)[0]
    assert middle[1] @ np.linalg.solve(f.K, middle[1] * P) == pytest.approx(P * L**3 / (48 * EI), rel=1e-10)


def test_free_beam_bent_by_moments_at_both_ends():
    """Three modes of the ends: opposite moments bend to a parabola and opposite forces stretch evenly, exactly."""
    f, M, F = beam(elements=5, modes=3, basis="craig-bampton", reference="mean-axis"), 2.2, 130.0
    start, middle, end = (f.station(x)[0] for x in (0.0, L / 2, L))
    q = np.linalg.solve(f.K, M * (end[2] - start[2]))
    assert (end[1] - middle[1]) @ q == pytest.approx(M * L**2 / (8 * EI), rel=1e-10)
    assert (end[2] - start[2]) @ q == pytest.approx(M * L / EI, rel=1e-10)
    q = np.linalg.solve(f.K, F * (end[0] - start[0]))
    assert (end[0] - start[0]) @ q == pytest.approx(F * L / EA, rel=1e-10)
    plain = beam(elements=5, modes=3, axial=1, reference="mean-axis")
    start, end = (plain.station(x)[0] for x in (0.0, L))
    assert (end[2] - start[2]) @ np.linalg.solve(plain.K, M * (end[2] - start[2])) < 0.9 * M * L / EI


def test_buckling_load_converges_with_order_four():
    """Potential of a load P on the end: -P/2 q^T N(L) q; Euler's load is pi^2 EI/L^2."""
    euler = np.pi**2 * EI / L**2

    def error(n):
        f = beam(elements=int(n))
        bends = f.bending.any(axis=0)
        part = np.ix_(bends, bends)
        found = 1 / eigh(f.station(L)[1][part], f.K[part], eigvals_only=True)[-1]
        assert found > euler
        return found / euler - 1

    assert 3.8 < slope_of(error) < 4.3


# --- damping


def test_damping_ratio_of_every_mode():
    f = beam(elements=6, modes=5, zeta=0.03)
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-f.K, -f.D]])
    roots = np.linalg.eigvals(A)
    np.testing.assert_allclose(-roots.real / np.abs(roots), 0.03, rtol=1e-9)


@pytest.mark.parametrize("kept", [{}, {"modes": 5}])
def test_rayleigh_damping(kept):
    f = beam(elements=6, alpha=0.7, beta=2e-5, J=J, **kept)
    np.testing.assert_allclose(f.D, 0.7 * f.M_ff + 2e-5 * f.K, rtol=1e-15)
    assert not beam(elements=6, **kept).D.any()


def test_dampings_add_up():
    parts = beam(modes=5, zeta=0.02).D + beam(modes=5, alpha=0.7, beta=2e-5).D
    np.testing.assert_allclose(beam(modes=5, zeta=0.02, alpha=0.7, beta=2e-5).D, parts, rtol=1e-15)


# --- units, caching, errors


@pytest.mark.parametrize(
    ("basis", "reference"),
    [(None, "pinned-pinned"), (None, "clamped-free"), *product(("eigenmodes", "craig-bampton"), REFERENCES)],
)
def test_a_beam_of_micrometres_is_the_same_beam(basis, reference):
    kept = {} if basis is None else dict(basis=basis, modes=6, axial=2)
    sizes = (1.0, 1e-6)
    big, small = (
        discretise(UniformBeam(l, 2.0 * l**2, 3e4 * l**2, 0.5 * l**4, elements=5, reference=reference, **kept))
        for l in sizes
    )
    np.testing.assert_allclose(small.frequencies(), 1e6 * big.frequencies(), rtol=1e-9)
    assert ((small.M_ff != 0) == (big.M_ff != 0)).all()
    assert ((small.N_hat != 0) == (big.N_hat != 0)).all()
    for x in (0.0, 0.3, 1.0):
        if kept:  # signs too
            U, W = big.station(x)[0][:2] * big.m**0.5, small.station(x * 1e-6)[0][:2] * small.m**0.5
            np.testing.assert_allclose(W, U, rtol=0, atol=1e-9)


def test_arrays_are_read_only_as_they_are_shared():
    f = beam(modes=4)
    assert beam(modes=4) is f
    for a in vars(f).values():
        if isinstance(a, np.ndarray):
            assert not a.flags.writeable


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(L=0.0), "L = 0; a beam's L is positive"),
        (dict(EI=-1.0), "EI = -1; a beam's EI is positive"),
        (dict(rhoA=float("nan")), "rhoA = nan"),
        (dict(J=-1e-3), "J = -0.001; a beam's J is not negative"),
        (dict(zeta=-0.1), "zeta = -0.1"),
        (dict(elements=0), "elements = 0; a beam has at least one element"),
        (dict(basis="krylov"), "'krylov' is none of eigenmodes, craig-bampton"),
        (dict(reference="tangent"), "'tangent' is none of pinned-pinned, clamped-free, mean-axis"),
        (dict(reference="mean-axis"), "mean-axis conditions are for modes"),
        (dict(basis="craig-bampton"), "a basis of modes needs the number of modes"),
        (dict(axial=2), "a basis of modes needs the number of modes"),
        (dict(zeta=0.01), "a damping ratio is defined for modes"),
        (dict(modes=0), "modes: 0, but there must be at least 1"),
        (dict(modes=9, elements=2), "modes: 9, but elements = 2 give 8 at most; take more elements"),
        (dict(modes=8, axial=5, elements=2), "axial modes: 5, but elements = 2 give 4 at most"),
        (dict(modes=8, axial=3, elements=2), "modes of bending: 5, but elements = 2 give 4 at most"),
        (dict(modes=5, axial=3, elements=1), "modes: 5, but elements = 1 give 4 at most"),
        (dict(modes=3, axial=-1), "axial modes: -1, but there must be at least 0"),
        (dict(modes=3, axial=4), "modes of bending: -1, but"),
        (dict(modes=2, basis="craig-bampton"), "modes: 2, but there must be at least 3, as many as the ends need"),
        (
            dict(modes=3, axial=0, basis="craig-bampton"),
            "axial modes: 0, but there must be at least 1, as many as the ends",
        ),
        (dict(modes=3, axial=2, basis="craig-bampton"), "modes of bending: 1, but there must be at least 2"),
    ],
)
def test_what_is_no_beam_or_no_basis_is_told(wrong, message):
    with pytest.raises(ValueError, match=message.replace("(", r"\(")):
        beam(**wrong)


def test_a_station_lies_on_the_beam():
    f = beam()
    for x in (-0.01, 1.01 * L, float("nan")):
        with pytest.raises(ValueError, match="is not on the beam"):
            f.station(x)


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("basis", ["eigenmodes", "craig-bampton"])
def test_every_number_of_modes_that_elements_have(basis, reference):
    for n in (1, 2, 3):
        for k in range(3, 4 * n + 1):
            f = beam(elements=n, modes=k, basis=basis, reference=reference)
            assert f.k == k
            assert (f.frequencies() > 0).all()
        with pytest.raises(ValueError, match="take more elements"):
            beam(elements=n, modes=4 * n + 1, basis=basis, reference=reference)


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("basis", ["eigenmodes", "craig-bampton"])
def test_modes_are_those_of_any_unit_of_length(basis, reference):
    """A beam of the same mass in a unit of length 2^10 times as small: lengths, also those of modes, are 2^10 times as
    large; slopes and signs are the same. Rounding of 11 modes in 64 coordinates: 1e-12."""
    unit = 2.0**10
    more = dict(elements=16, modes=11, basis=basis, reference=reference)
    one = discretise(UniformBeam(L, RHOA, EA, EI, J, **more))
    other = discretise(UniformBeam(L * unit, RHOA / unit, EA * unit, EI * unit**3, J * unit, **more))
    close = dict(rtol=0.0, atol=1e-12 * np.abs(one.bending).max())
    np.testing.assert_allclose(other.bending[::2], one.bending[::2], **close)
    np.testing.assert_allclose(other.bending[1::2] * unit, one.bending[1::2], **close)
    np.testing.assert_allclose(other.axial, one.axial, **close)
