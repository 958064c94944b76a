"""Generalised-alpha: its coefficients and damping by hand, its start, and refused parameters.

Orders: tests/verification; the step itself against its full system: test_full_systems.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError
from mbdsl.integrators.methods.generalized_alpha_i3 import coefficients

METHODS = ("generalized-alpha", "generalized-alpha-i3")


def amplification(rho, x):
    """The matrix that takes (q, h v, h^2 A, h^2 a) of q'' = -w^2 q to the end of a step, x = h w; by the equations."""
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    g = 1 / 2 + af - am
    b = (g + 1 / 2) ** 2 / 4
    # unknown q, hv, A, a at the end; known at the start
    new = np.array([[1, 0, -b, 0], [0, 1, -g, 0], [0, 0, 1 - am, -(1 - af)], [x**2, 0, 0, 1]])
    old = np.array([[1, 1, 1 / 2 - b, 0], [0, 1, 1 - g, 0], [0, 0, -am, af], [0, 0, 0, 0]])
    return np.linalg.solve(new, old)


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.8, 1.0])
def test_rho_is_the_spectral_radius_at_infinity(rho):
    assert np.abs(np.linalg.eigvals(amplification(rho, 1e7))).max() == pytest.approx(rho, abs=2e-3)
    low = np.abs(np.linalg.eigvals(amplification(rho, 1e-2))).max()
    assert 1 - 1e-5 < low <= 1 + 1e-12


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.8, 1.0])
def test_weights(rho):
    """A constant acceleration stays one, and moves q by h^2/2 and v by h; rho = 1 is the trapezoidal rule's family."""
    s, r, *more = coefficients({"rho": rho})
    assert s + sum(more[:2]) == pytest.approx(1 / 2)
    assert r + sum(more[2:4]) == pytest.approx(1.0)
    assert sum(more[4:]) == pytest.approx(1.0)


def oscillator(w):
    b = mbdsl.Builder("Oscillator")
    body = b.Body("body", m=1.0, I=1.0)
    b.Bushing("spring", b.Ground("ground", g=0.0), body.c, k=(w**2, w**2), k_phi=1.0)
    b.initial(body.x, 0.1)
    return b.scene()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rho", [0.0, 0.6, 1.0])
def test_an_oscillator_follows_the_amplification_matrix(method, rho):
    """Twenty steps from the method's own start, with q''' = 0 there, agree with powers of the matrix."""
    w, h, steps = 10.0, 0.02, 20
    r = mbdsl.simulate(oscillator(w), method=method, step=h, stop=steps * h, interval=0.0, options={"rho": rho})
    a = -(w**2) * 0.1 * h**2
    x, G = np.array([0.1, 0.0, a, a]), amplification(rho, w * h)
    for k in range(1, steps + 1):
        x = G @ x
        assert r["body.x"][k] == pytest.approx(x[0], abs=1e-10)
        assert r["body.vx"][k] == pytest.approx(x[1] / h, abs=1e-8)


@pytest.mark.parametrize("method", METHODS)
def test_no_damping_is_refused_on_constrained_models(method):
    b = mbdsl.Builder("Pendulum")
    rod = b.Rod("rod", m=1.0, length=1.0)
    b.Revolute("O", b.Ground("ground"), rod.a)
    with pytest.raises(UsageError, match="rho = 1 does not damp") as caught:
        mbdsl.simulate(b, method=method, stop=0.1, options={"rho": 1.0})
    assert "force" in caught.value.hint
    assert mbdsl.simulate(b, method=method, stop=0.1, options={"rho": 1.0}, force=True).status == "done"
    for rho in (-0.1, 1.1):
        with pytest.raises(UsageError, match=r"rho = .* is outside \[0, 1\]"):
            mbdsl.simulate(b, method=method, stop=0.1, options={"rho": rho})


def test_reactions_are_of_order_two_from_the_first_step():
    """The pendulum let go with a push: the pin's force after 1, 2 and 3 steps against a fine run. (Those of index 3
    have an error of order 1 at first, which dies out like rho^n: v_0 satisfies its constraint, later v do not.)"""
    b = mbdsl.Builder("Pendulum")
    rod = b.Rod("rod", m=1.0, length=1.0)
    b.Revolute("O", b.Ground("ground"), rod.a)
    b.initial(rod.phi, 0.8)
    b.initial(rod.w, 3.0)
    scene, steps = b.scene(), (2e-3, 1e-3, 5e-4, 2.5e-4)
    for k in (1, 2, 3):
        errors = []
        for h in steps:
            found = mbdsl.simulate(scene, method="generalized-alpha", step=h, stop=k * h, interval=0.0)
            fine = mbdsl.simulate(scene, method="hht-si2", step=h / 64, stop=k * h, interval=k * h)
            errors.append(np.hypot(*(found[name][-1] - fine[name][-1] for name in ("O.fx", "O.fy"))))
        assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.85, (k, errors)
