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
from typing import get_args

import numpy as np

from mbdsl.bodies.beam_elements import Array, Reference, cubic, element, free, gauss, gram, quadratic, without_dust
from mbdsl.bodies.beam_modes import Basis, modal_shapes, shifted


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
def discretise(
    L: float,
    rhoA: float,
    EA: float,
    EI: float,
    J: float = 0.0,
    elements: int = 8,
    modes: int | None = None,
    axial: int | None = None,
    basis: Basis = "eigenmodes",
    reference: Reference = "pinned-pinned",
    zeta: float = 0.0,
    alpha: float = 0.0,
    beta: float = 0.0,
    stiffening: bool = True,
) -> Floating:
    """Elastic coordinates of a uniform beam and their integrals.

    Parameters
    ----------
    L, rhoA, EA, EI, J : float
        Length [m], mass per length [kg/m], axial stiffness [N], bending stiffness [N m^2], rotary inertia per length
        [kg m].
    elements : int
        Finite elements of equal length.
    modes : int, optional
        The number of modes to keep. By default the coordinates are those of the finite elements which the reference
        conditions leave free: ``u3``, ``v3``, ``t3`` at node 3 of nodes 0 to n, ``u3m`` in the middle of element 3,
        which ends at node 3.
    axial : int, optional
        The number of axial modes among them; they follow the bending modes. By default the modes of lowest frequency
        are kept, in the order of their frequencies (of the modes of Craig and Bampton, three belong to the ends, and
        the others are those of lowest frequency with the ends held).
    basis : {"eigenmodes", "craig-bampton"}
        Eigenmodes under the reference conditions; or static modes for displacements of the ends and eigenmodes with the
        ends held, combined to orthogonal modes: displacements by forces and torques at the ends are then exact.
    reference : {"pinned-pinned", "clamped-free", "mean-axis"}
        The reference conditions, which define the frame: s(0) = v(0) = v(L) = 0; s(0) = v(0) = v'(0) = 0; or elastic
        rates without linear and angular momentum (modes of the free beam; not for coordinates of finite elements).
    zeta : float
        Damping ratio of every mode.
    alpha, beta : float
        Rayleigh damping alpha M_ff + beta K [1/s, s], in addition to ``zeta``.
    stiffening : bool
        Whether bending shortens the chord (geometric stiffening).

    Raises
    ------
    ValueError
        If the arguments define no beam or no basis.
    """
    _check_beam(L, rhoA, EA, EI, J, elements, zeta, alpha, beta)
    _check_basis(elements, modes, axial, basis, reference, zeta)
    n = elements
    if modes is None:
        A, B, names = free(n, reference)
    else:
        A, B = modal_shapes(L, rhoA, EA, EI, J, n, modes, axial, basis, reference)
        names = tuple(f"q{i + 1}" for i in range(modes))

    x, w = gauss(L, n)
    arm = x - L / 2
    S_u, stretch = (f @ A for f in quadratic(x, L, n))
    S_v, slope, curvature = (f @ B for f in cubic(x, L, n))
    m, I0 = rhoA * L, rhoA * L**3 / 12 + J * L
    H = rhoA * (gram(S_u, w) + gram(S_v, w))
    M_ff = H + J * gram(slope, w)
    K = EA * gram(stretch, w) + EI * gram(curvature, w)
    S_bar = rhoA * np.array([w @ S_u, w @ S_v])
    h1 = rhoA * (w * arm) @ S_u
    g0 = rhoA * (w * arm) @ S_v + J * w @ slope
    G = rhoA * (S_u.T * w) @ S_v
    G = G - G.T
    # order of integration exchanged: v'(xi)^2 displaces the part of the beam beyond xi
    N_bar = rhoA * stiffening * gram(slope, w * (L - x))
    N_hat = rhoA * stiffening * gram(slope, w * x * (L - x) / 2)
    if modes is not None:  # upper bounds for modes of unit mass by the Cauchy-Schwarz inequality
        M_ff, K = np.eye(modes), np.diag(np.diag(K))
        H = without_dust(H, 1.0) if J else M_ff.copy()
        S_bar, G = without_dust(S_bar, m**0.5), without_dust(G, 1.0)
        h1, g0 = without_dust(h1, I0**0.5), without_dust(g0, I0**0.5)
        N_bar, N_hat = (without_dust(N, np.abs(N).max()) for N in (N_bar, N_hat))
    D = alpha * M_ff + beta * K + np.diag(2 * zeta * np.sqrt(np.diag(K)))
    arrays = dict(S_bar=S_bar, s0=np.zeros(2), h1=h1, g0=g0, H=H, M_ff=M_ff, G=G, N_bar=N_bar, N_hat=N_hat, K=K, D=D)
    arrays |= dict(axial=A, bending=B)
    for a in arrays.values():
        a.flags.writeable = False
    return Floating(names=names, L=L, m=m, I0=I0, stiffening=stiffening, modal=modes is not None, **arrays)


def _check_beam(L, rhoA, EA, EI, J, elements, zeta, alpha, beta) -> None:
    for name, value in dict(L=L, rhoA=rhoA, EA=EA, EI=EI).items():
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} = {value:g}; a beam's {name} is positive")
    for name, value in dict(J=J, zeta=zeta, alpha=alpha, beta=beta).items():
        if not 0.0 <= value < np.inf:
            raise ValueError(f"{name} = {value:g}; a beam's {name} is not negative")
    if elements < 1:
        raise ValueError(f"elements = {elements}; a beam has at least one element")


def _check_basis(n, modes, axial, basis, reference, zeta) -> None:
    for found, known in ((basis, Basis), (reference, Reference)):
        if found not in get_args(known):
            raise ValueError(f"{found!r} is none of {', '.join(get_args(known))}")
    if modes is None:
        if reference == "mean-axis":
            raise ValueError("mean-axis conditions are for modes: give a number of modes, or another reference")
        if basis == "craig-bampton" or axial is not None:
            raise ValueError("a basis of modes needs the number of modes")
        if zeta:
            raise ValueError(
                "a damping ratio is defined for modes; for finite element coordinates its matrix would be full: "
                "give a number of modes, or Rayleigh damping"
            )
        return
    of_ends = (1, 2) if basis == "craig-bampton" else (0, 0)
    why = ", as many as the ends need" if basis == "craig-bampton" else ""
    if axial is None:
        groups = (("modes", modes, max(sum(of_ends), 1), 4 * n),)
    else:
        groups = (("modes", modes, 1, 4 * n), ("axial modes", axial, of_ends[0], 2 * n))
        groups += (("modes of bending", modes - axial, of_ends[1], 2 * n),)
    for what, count, least, most in groups:
        if count < least:
            raise ValueError(f"{what}: {count}, but there must be at least {least}{why}")
        if count > most:
            raise ValueError(f"{what}: {count}, but elements = {n} give {most} at most; take more elements")
