"""A planar Euler-Bernoulli beam in the floating frame of reference: its elastic coordinates and their integrals.

A point of the axis at material coordinate x in [0, L] has, in the floating frame at mid-length, the position

    u(x) = (x - L/2 + s(x) - 1/2 q^T N(x) q,  v(x)),   s = S_u q,   v = S_v q,   N(x)_ij = int_0^x v'_i v'_j

A section rotates by v'. The quadratic term is the shortening of the chord by bending; without it, a fast rotation would
soften the beam instead of stiffening it. Frequencies are those of K and M_ff.

The beam is divided into elements of equal length: v is cubic (Hermite), s quadratic (Lagrange, with a mid node), so
that the eigenvalues of both converge with the fourth power of the element length. All integrals are exact.

Sources: Shabana, Dynamics of Multibody Systems, ch. 5 (frame, integrals, reference conditions); Kane, Ryan and
Banerjee, J. Guidance 10 (1987) 139-151 (shortening); Craig and Bampton, AIAA J. 6 (1968) 1313-1319 (boundary modes).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mbdsl.bodies.beam_elements import Array, cubic, element, free, gauss, gram, quadratic, without_dust
from mbdsl.bodies.beam_modes import modal_shapes, shifted
from mbdsl.bodies.uniform_beam import UniformBeam, check_basis, check_beam


@dataclass(frozen=True, eq=False)
class Floating:
    """Elastic coordinates q (k,) of a beam and the integrals of their shapes over its length. Arrays are read-only.

    Coordinates of finite elements are displacements [m] and slopes [rad]. Those of modes have the unit m kg^(1/2); M_ff
    is then the identity, and K is diagonal.
    """

    names: tuple[str, ...]
    L: float  #: length [m]
    m: float  #: mass [kg]
    S_bar: Array  #: (2, k) int rhoA S
    s0: Array  #: (2,) int rhoA (x - L/2, 0), zero
    I0: float  #: int rhoA (x - L/2)^2 + J, about the frame's origin, undeformed [kg m^2]
    h1: Array  #: (k,) int rhoA (x - L/2) S_u
    g0: Array  #: (k,) int rhoA (x - L/2) S_v + J v'
    H: Array  #: (k, k) int rhoA S^T S, without rotary inertia
    M_ff: Array  #: (k, k) H + int J v'^T v'
    G: Array  #: (k, k) int rhoA (S_u^T S_v - S_v^T S_u), antisymmetric
    N_bar: Array  #: (k, k) int rhoA N; zero without stiffening
    N_hat: Array  #: (k, k) int rhoA (x - L/2) N; zero without stiffening
    K: Array  #: (k, k) int EA s'^T s' + EI v''^T v''
    D: Array  #: (k, k) damping
    stiffening: bool
    axial: Array  #: (2 n + 1, k) s for each coordinate at the nodes and mid nodes
    bending: Array  #: (2 n + 2, k) v and v' for each coordinate at the nodes
    modal: bool  #: whether the coordinates are modes

    @property
    def k(self) -> int:
        """Number of elastic coordinates."""
        return len(self.names)

    @property
    def elements(self) -> int:
        return len(self.bending) // 2 - 1

    def station(self, x: float) -> tuple[Array, Array]:
        """U (3, k) with the rows s, v and v' at x, and N (k, k) at x, zero without stiffening; x in [0, L] [m]."""
        L, n = self.L, self.elements
        if not -1e-12 * L <= x <= (1 + 1e-12) * L:
            raise ValueError(f"x = {x:g} m is not on the beam, which reaches from 0 to {L:g} m")
        at = np.array([x])
        v, slope, _ = cubic(at, L, n)
        U = np.concatenate([quadratic(at, L, n)[0] @ self.axial, v @ self.bending, slope @ self.bending])
        if not self.stiffening:
            return U, np.zeros((self.k, self.k))
        start = np.arange(element(at, L, n)[0][0] + 1) * (L / n)
        points, weights = np.polynomial.legendre.leggauss(3)
        length = np.diff(start, append=max(x, start[-1]))[:, None]
        y = (start[:, None] + length * (1 + points) / 2).ravel()
        root = np.sqrt((length * weights / 2).ravel())[:, None]
        slopes = root * (cubic(y, L, n)[1] @ self.bending)
        return U, slopes.T @ slopes

    def frequencies(self) -> Array:
        """Natural frequencies (k,) [rad/s]: of modes in their order, of finite element coordinates ascending."""
        if self.modal:
            return np.sqrt(np.diag(self.K))
        # axial and bending ones separately: the ratio of their eigenvalues may exceed the precision of doubles
        squares = []
        for shapes, per_element in ((self.axial, self.elements), (self.bending, self.elements**2)):
            part = np.flatnonzero(shapes.any(axis=0))
            M, K = (A[np.ix_(part, part)] for A in (self.M_ff, self.K))
            # the geometric mean of the lowest and the highest
            shift = (np.diag(K) / np.diag(M)).max() / per_element
            squares.append(1 / shifted(K, M, shift)[1] - shift)
        return np.sqrt(np.sort(np.concatenate(squares)))


@lru_cache(maxsize=64)
def discretise(beam: UniformBeam) -> Floating:
    """Elastic coordinates of a beam and their integrals.

    Raises
    ------
    ValueError
        If the arguments define no beam or no basis.
    """
    check_beam(beam)
    check_basis(beam)
    n, L = beam.elements, beam.L
    if beam.modes is None:
        A, B, names = free(n, beam.reference)
    else:
        A, B = modal_shapes(beam)
        names = tuple(f"q{i + 1}" for i in range(beam.modes))
    arrays = _integrals(beam, A, B)
    m, I0 = beam.rhoA * L, beam.rhoA * L**3 / 12 + beam.J * L
    if beam.modes is not None:
        arrays |= _of_modes(arrays, m, I0, beam.J)
    K, M_ff = arrays["K"], arrays["M_ff"]
    arrays["D"] = beam.alpha * M_ff + beam.beta * K + np.diag(2 * beam.zeta * np.sqrt(np.diag(K)))
    arrays |= dict(axial=A, bending=B)
    for a in arrays.values():
        a.flags.writeable = False
    modal = beam.modes is not None
    return Floating(names=names, L=L, m=m, I0=I0, stiffening=beam.stiffening, modal=modal, **arrays)


def _integrals(beam: UniformBeam, A: Array, B: Array) -> dict[str, Array]:
    """The integrals of the shapes A (2 n + 1, k) of s and B (2 n + 2, k) of v."""
    L, n, rhoA, J = beam.L, beam.elements, beam.rhoA, beam.J
    x, w = gauss(L, n)
    arm = x - L / 2
    S_u, stretch = (f @ A for f in quadratic(x, L, n))
    S_v, slope, curvature = (f @ B for f in cubic(x, L, n))
    H = rhoA * (gram(S_u, w) + gram(S_v, w))
    G = rhoA * (S_u.T * w) @ S_v
    return dict(
        S_bar=rhoA * np.array([w @ S_u, w @ S_v]),
        s0=np.zeros(2),
        h1=rhoA * (w * arm) @ S_u,
        g0=rhoA * (w * arm) @ S_v + J * w @ slope,
        H=H,
        M_ff=H + J * gram(slope, w),
        G=G - G.T,
        # order of integration exchanged: v'(xi)^2 displaces the part of the beam beyond xi
        N_bar=rhoA * beam.stiffening * gram(slope, w * (L - x)),
        N_hat=rhoA * beam.stiffening * gram(slope, w * x * (L - x) / 2),
        K=beam.EA * gram(stretch, w) + beam.EI * gram(curvature, w),
    )


def _of_modes(found: dict[str, Array], m: float, I0: float, J: float) -> dict[str, Array]:
    """Integrals of modes of unit mass without rounding; upper bounds follow from the Cauchy-Schwarz inequality."""
    M_ff = np.eye(len(found["K"]))
    clean = {name: without_dust(found[name], np.abs(found[name]).max()) for name in ("N_bar", "N_hat")}
    return clean | dict(
        M_ff=M_ff,
        K=np.diag(np.diag(found["K"])),
        H=without_dust(found["H"], 1.0) if J else M_ff.copy(),
        S_bar=without_dust(found["S_bar"], m**0.5),
        G=without_dust(found["G"], 1.0),
        h1=without_dust(found["h1"], I0**0.5),
        g0=without_dust(found["g0"], I0**0.5),
    )
