"""Spin-up of a flexible beam on a hub (Simo and Vu-Quoc 1986): geometric stiffening, and the steady stretch after it.

Reference of the history: the geometrically exact beam by one polynomial over its length, DOP853, confirmed by Exudyn
(spin_up_beam.json). The floating frame's shortening is of second order: of v'^2 in the strain, v'^4/4 is left out, so
that with slopes up to 0.077 forces and deflections are wrong by v'^2/4 = 1.5e-3 of the largest.

Steady, by EA u'' + rhoA w^2 (x + u) = 0: u(L) = tan(kL)/k - L, k^2 = rhoA w^2/EA.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError

SHIPPED = "modes = modes, axial = 2,"
SPACES = {
    "shipped": SHIPPED,
    "more modes": "modes = 12, axial = 4,",
    "craig-bampton": 'modes = 12, axial = 4, basis = "craig-bampton",',
    "elements": "elements = 8,",
}
THEORY = 1.5e-3
L, K = 10.0, np.sqrt(1.2 * 36 / 28e6)


@pytest.fixture(scope="module")
def variant(model, tmp_path_factory):
    """``variant(text)``: the shipped model with these elastic coordinates."""
    text = model("spin_up_beam").read_text(encoding="utf-8")
    assert SHIPPED in text

    def find(said=SHIPPED, **parameters):
        path = tmp_path_factory.mktemp("spin") / "variant.mbd"
        path.write_text(text.replace(SHIPPED, said), encoding="utf-8")
        return mbdsl.load(path, parameters)

    return find


@pytest.fixture(scope="module")
def exact(reference):
    """u1, u2 and rotation of the tip at 1, 2, ..., 20 s."""
    rows = np.array(reference("spin_up_beam")["rows"])
    assert rows[:, 0] == pytest.approx(np.arange(1.0, 21.0))
    return rows[:, 1:].T


def tip(scene, method, h, stop=20.0):
    run = mbdsl.simulate(scene, method=method, step=h, stop=stop, interval=1.0)
    return np.array([run["u1"], run["u2"], run["beam.b.phi"] - run["hub.phi"]])[:, 1:]


def parts(difference, exact):
    """Largest differences, as parts of the largest values."""
    return np.abs(difference).max(axis=1) / np.abs(exact).max(axis=1)


@pytest.mark.parametrize("space", SPACES)
def test_history(variant, exact, space):
    """Six modes, 12, Craig-Bampton's or eight elements: the error is that of the theory, not of the step."""
    scene = variant(SPACES[space])
    found, fine = (tip(scene, "hht-si2", h) for h in (2e-3, 1e-3))
    assert parts(found - fine, exact).max() < THEORY / 20
    assert parts(fine - exact, exact).max() < THEORY
    # a sixth of a percent is the accuracy of shortening of second order; without it u1 would be zero
    assert parts(fine - exact, exact)[1] > THEORY / 10


def test_absolute_nodal_coordinates(variant, exact):
    """Without the assumption of small deformation, only the elements have an error, of nearly order 4. Both
    formulations agree."""
    coarse, fine = (tip(variant(f'formulation = "ancf", elements = {n},'), "hht-si2", 1e-3) for n in (4, 8))
    errors = [parts(found - exact, exact) for found in (coarse, fine)]
    assert (errors[1] < errors[0] / 8).all()
    assert errors[1].max() < THEORY / 20
    assert parts(tip(variant(), "hht-si2", 1e-3) - fine, exact).max() < THEORY


@pytest.mark.parametrize("method", ["nstiff", "nstiff-si2", "hht-i3"])
def test_methods_agree(variant, exact, method):
    """With 1 ms, where the period of bending is 1 s and more; 16 of 20 s are quasi-static.

    hht-i3 with M(q_{n+1}), as (8c) reads, would be off by 8e-3 m: a_{n+1} belongs to t_{n+1} + alpha h.
    """
    found = tip(variant(), method, 1e-3)
    assert parts(found - exact, exact).max() < THEORY
    assert parts(found - tip(variant(), "hht-si2", 1e-3), exact).max() < THEORY / 20


def test_newmark_is_of_first_order(variant, exact, order):
    """It errs by 1.4 % of the largest deflection with 1 ms, and in proportion to the step."""
    steps, scene = [2e-3, 1e-3, 5e-4], variant()
    fine = tip(scene, "hht-si2", 5e-4)
    errors = np.array([parts(tip(scene, "newmark", h) - fine, exact) for h in steps])
    assert errors[1, 1] < 0.016
    assert order(steps, errors[:, 1]) > 0.95
    # and it tends to the same solution
    assert parts(2 * tip(scene, "newmark", 5e-4) - tip(scene, "newmark", 1e-3) - fine, exact).max() < THEORY / 5


def test_hht_add_says_that_it_cannot(model):
    """It needs the inverse of the beam's own M, which kinetic energy of second order leaves indefinite here: nearly
    rigid rotations, which the clamp excludes, are cut short by the deflection. The chord as a reference bears it."""
    with pytest.raises(IntegrationError, match=r"mass matrix of beam .* positive definite"):
        mbdsl.simulate(model("spin_up_beam"), method="hht-add", step=2e-3)


def partial_sum(axial):
    """Steady u(L) with this number of eigenmodes sin(k_j x), k_j = (2 j - 1) pi/(2 L)."""
    k = (2 * np.arange(1, axial + 1) - 1) * np.pi / (2 * L)
    return (2 * K**2 / L / (k**2 * (k**2 - K**2))).sum()


def steady(variant, said):
    """u1 in steady rotation, by extrapolation of the terms of h^3: 1e-5 of it with 0.5 ms, 1e-6 with 0.25 ms.

    Bending, excited by the spin-up to 0.03 m at 5 s, is damped by beta w_1^2/2 = 1.4 1/s (w_1 = 3.8 rad/s at rest), to
    exp(-17); a steady deflection, of h^2, remains, 22 to 50 um with 1 ms, whose square shortens nothing. Terms of h^2,
    by (w h)^2 = 2e-6 at the smallest step, are below 3e-7: bounds are 5e-7, where k^2 is 6e-5 of the stretch.
    """
    scene = variant(f"beta = 0.2 s, {said}", ts=5.0)
    values = []
    for h in (5e-4, 2.5e-4):
        run = mbdsl.simulate(scene, method="hht-si2", step=h, stop=17.0, interval=17.0)
        assert abs(run["u2"][-1]) < 2e-5
        values.append(run["u1"][-1])
    assert values[1] == pytest.approx(values[0], rel=2e-5)
    return (8 * values[1] - values[0]) / 7


@pytest.mark.parametrize("axial", [1, 2, 4])
def test_steady_stretch_by_eigenmodes(variant, axial):
    """Eigenmodes sum it up slowly: 1.4 %, 0.2 %, 0.03 % are missing, as the series says."""
    found = steady(variant, f"modes = {2 + axial}, axial = {axial}, elements = 64,")
    assert found == pytest.approx(partial_sum(axial), rel=5e-7)
    assert abs(found / (np.tan(K * L) / K - L) - 1) > 2e-4


def test_series_sums_up_to_the_closed_form():
    assert partial_sum(10000) == pytest.approx(np.tan(K * L) / K - L, rel=1e-10)


def test_steady_stretch_by_elements(variant):
    """Quadratic elements with exact loads are exact at their nodes except for the term of k^2: (kL)^2 = 1.5e-4 of
    1/4^4."""
    assert steady(variant, "elements = 4,") == pytest.approx(np.tan(K * L) / K - L, rel=5e-7)


def test_steady_stretch_by_craig_bampton(variant):
    """A static mode and eigenmodes sin(n pi x/L) of fixed ends: Ritz's method in a space that does not contain x^3."""
    k = np.pi / L
    # EA u'' = -rhoA w^2 (x + u) weakly, in x/L and sin(k x): 2 equations
    stiffness = np.diag([1 / L, k**2 * L / 2])
    mass = np.array([[L / 3, 1 / k], [1 / k, L / 2]])
    load = np.array([L**2 / 3, L / k])
    found = np.linalg.solve(stiffness - K**2 * mass, K**2 * load)[0]
    assert steady(variant, 'modes = 6, axial = 2, basis = "craig-bampton", elements = 64,') == pytest.approx(
        found, rel=5e-7
    )
    assert found == pytest.approx(np.tan(K * L) / K - L, rel=1e-6)


def test_without_stiffening_it_bends_without_end(model):
    """Centrifugal forces soften a beam that does not shorten: beyond w_1 = 3.8 rad/s, straight is unstable."""
    with pytest.raises(IntegrationError, match="bend"):
        mbdsl.simulate(model("spin_up_beam"), parameters={"stiffening": "false"})
