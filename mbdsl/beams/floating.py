"""A planar Euler-Bernoulli beam in the floating frame of reference: its elastic coordinates and their integrals.

A point of the axis at material coordinate x in [0, L], seen from the floating frame, which lies at mid-length:

    u(x) = (x - L/2 + s(x) - 1/2 q^T N(x) q,  v(x)),   s = S_u q,   v = S_v q,   N(x)_ij = int_0^x v'_i v'_j

A section turns by v'. The quadratic term is the shortening of the chord by bending, without which a fast rotation
would soften the beam instead of stiffening it. Frequencies are those of K against M_ff.

Inside, elements of equal length: v cubic (Hermite), s quadratic (Lagrange, with a mid node), so that the eigenvalues
of both converge with the fourth power of the length. All integrals are exact.

Sources: Shabana, Dynamics of Multibody Systems, ch. 5 (frame, integrals, reference conditions); Kane, Ryan and
Banerjee, J. Guidance 10 (1987) 139-151 (shortening); Craig and Bampton, AIAA J. 6 (1968) 1313-1319 (boundary modes).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Basis = Literal["eigenmodes", "craig-bampton"]
Reference = Literal["pinned-pinned", "clamped-free", "mean-axis"]

GAUSS = 4  #: points in an element; exact to degree 7, and v v and x^2 v' v' are of degree 6
DUST = 1e-14  #: integrals of modes below this part of the largest they could be are zero
#: reference conditions -> coordinates held, of the axial and of the bending problem; negative ones from the far end
HELD: dict[Reference, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "pinned-pinned": ((0,), (0, -2)),
    "clamped-free": ((0,), (0, 1)),
    "mean-axis": ((), ()),
}
ENDS = ((0, -1), (0, 1, -2, -1))  #: the coordinates at both ends, which are the boundary of Craig and Bampton


@dataclass(frozen=True, eq=False)
class Floating:
    """Elastic coordinates q (k,) of a beam and the integrals of their shapes over its length. Arrays are read-only.

    Coordinates of finite elements are displacements [m] and slopes [rad]; those of modes are in m kg^(1/2), and with
    them M_ff is the identity and K is diagonal.
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
    axial: Array  #: (2 n + 1, k) s of each coordinate at the nodes and mid nodes
    bending: Array  #: (2 n + 2, k) v and v' of each coordinate at the nodes
    modal: bool  #: the coordinates are modes

    @property
    def k(self) -> int:
        """Number of elastic coordinates."""
        return len(self.names)

    @property
    def elements(self) -> int:
        return len(self.bending) // 2 - 1

    def station(self, x: float) -> tuple[Array, Array]:
        """U (3, k), whose rows are s, v and v' at x, and N (k, k) there, zero without stiffening; x in [0, L] [m]."""
        L, n = self.L, self.elements
        if not -1e-12 * L <= x <= (1 + 1e-12) * L:
            raise ValueError(f"x = {x:g} m is not on the beam, which reaches from 0 to {L:g} m")
        at = np.array([x])
        v, slope, _ = _cubic(at, L, n)
        U = np.concatenate([_quadratic(at, L, n)[0] @ self.axial, v @ self.bending, slope @ self.bending])
        if not self.stiffening:
            return U, np.zeros((self.k, self.k))
        start = np.arange(_element(at, L, n)[0][0] + 1) * (L / n)
        points, weights = np.polynomial.legendre.leggauss(3)
        length = np.diff(start, append=max(x, start[-1]))[:, None]
        y = (start[:, None] + length * (1 + points) / 2).ravel()
        root = np.sqrt((length * weights / 2).ravel())[:, None]
        slopes = root * (_cubic(y, L, n)[1] @ self.bending)
        return U, slopes.T @ slopes

    def frequencies(self) -> Array:
        """(k,) [rad/s], of K against M_ff: of modes in the modes' order, of finite element coordinates ascending."""
        if self.modal:
            return np.sqrt(np.diag(self.K))
        # axial and bending ones apart: their eigenvalues may differ by more than a double's digits
        squares = []
        for shapes, per_element in ((self.axial, self.elements), (self.bending, self.elements**2)):
            part = np.flatnonzero(shapes.any(axis=0))
            M, K = (A[np.ix_(part, part)] for A in (self.M_ff, self.K))
            shift = (np.diag(K) / np.diag(M)).max() / per_element  # halfway between the lowest and the highest
            squares.append(1 / _shifted(K, M, shift)[1] - shift)
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
        How many modes to keep; without it the coordinates are those of the finite elements which the reference
        conditions leave: ``u3``, ``v3``, ``t3`` at node 3 of nodes 0 to n, ``u3m`` in the middle of element 3, which
        ends at node 3.
    axial : int, optional
        How many of the modes are axial ones, which then follow those of bending. Without it, modes are the ones of
        lowest frequency (of Craig and Bampton's, three are of the ends, the others those of lowest frequency with the
        ends held), in the order of their frequencies.
    basis : {"eigenmodes", "craig-bampton"}
        Eigenmodes under the reference conditions; or static modes of what the ends can do and eigenmodes with the ends
        held, both combined to modes that are orthogonal: displacements by forces and torques at the ends are exact.
    reference : {"pinned-pinned", "clamped-free", "mean-axis"}
        What ties the frame to the beam: s(0) = v(0) = v(L) = 0; s(0) = v(0) = v'(0) = 0; or no momentum and no angular
        momentum by elastic rates (modes of the free beam; not for coordinates of finite elements).
    zeta : float
        Damping ratio of every mode.
    alpha, beta : float
        Rayleigh damping alpha M_ff + beta K [1/s, s], which is added.
    stiffening : bool
        Whether bending shortens the chord.

    Raises
    ------
    ValueError
        If there is no such beam or no such basis.
    """
    _check_beam(L, rhoA, EA, EI, J, elements, zeta, alpha, beta)
    _check_basis(elements, modes, axial, basis, reference, zeta)
    n = elements
    if modes is None:
        A, B, names = _free(n, reference)
    else:
        A, B = _modal_shapes(L, rhoA, EA, EI, J, n, modes, axial, basis, reference)
        names = tuple(f"q{i + 1}" for i in range(modes))

    x, w = _gauss(L, n)
    arm = x - L / 2
    S_u, stretch = (f @ A for f in _quadratic(x, L, n))
    S_v, slope, curvature = (f @ B for f in _cubic(x, L, n))
    m, I0 = rhoA * L, rhoA * L**3 / 12 + J * L
    H = rhoA * (_gram(S_u, w) + _gram(S_v, w))
    M_ff = H + J * _gram(slope, w)
    K = EA * _gram(stretch, w) + EI * _gram(curvature, w)
    S_bar = rhoA * np.array([w @ S_u, w @ S_v])
    h1 = rhoA * (w * arm) @ S_u
    g0 = rhoA * (w * arm) @ S_v + J * w @ slope
    G = rhoA * (S_u.T * w) @ S_v
    G = G - G.T
    # order of integration exchanged: what lies beyond xi moves by v'(xi)^2
    N_bar = rhoA * stiffening * _gram(slope, w * (L - x))
    N_hat = rhoA * stiffening * _gram(slope, w * x * (L - x) / 2)
    if modes is not None:  # by Cauchy and Schwarz, a mode of mass one has at most these
        M_ff, K = np.eye(modes), np.diag(np.diag(K))
        H = _without_dust(H, 1.0) if J else M_ff.copy()
        S_bar, G = _without_dust(S_bar, m**0.5), _without_dust(G, 1.0)
        h1, g0 = _without_dust(h1, I0**0.5), _without_dust(g0, I0**0.5)
        N_bar, N_hat = (_without_dust(N, np.abs(N).max()) for N in (N_bar, N_hat))
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
                "a damping ratio is one of modes; for finite element coordinates its matrix would be full: "
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


# --- finite elements


def _element(x: Array, L: float, n: int) -> tuple[NDArray[np.intp], Array]:
    """Elements that points lie in, and where in them, from 0 to 1; at nodes and mid nodes exactly so."""
    y = x * (n / L)
    half = np.round(2 * y) / 2
    y = np.where(np.abs(y - half) < 1e-12 * n, half, y)
    e = np.clip(y.astype(np.intp), 0, n - 1)
    return e, y - e


def _spread(parts: list[Array], e: NDArray[np.intp], size: int) -> Array:
    """Table (points, size) of shapes that are ``parts`` in elements e, whose first coordinate is 2 e."""
    table = np.zeros((len(e), size))
    table[np.arange(len(e))[:, None], 2 * e[:, None] + np.arange(len(parts))] = np.array(parts).T
    return table


def _quadratic(x: Array, L: float, n: int) -> tuple[Array, Array]:
    """s and s' at x of each axial coordinate: (points, 2 n + 1) each."""
    e, r = _element(x, L, n)
    s = [(1 - r) * (1 - 2 * r), 4 * r * (1 - r), r * (2 * r - 1)]
    ds = [(4 * r - 3) * (n / L), (4 - 8 * r) * (n / L), (4 * r - 1) * (n / L)]
    return _spread(s, e, 2 * n + 1), _spread(ds, e, 2 * n + 1)


def _cubic(x: Array, L: float, n: int) -> tuple[Array, Array, Array]:
    """v, v' and v'' at x of each coordinate of bending: (points, 2 n + 2) each."""
    e, r = _element(x, L, n)
    h, size = L / n, 2 * n + 2
    v = [(1 - r) ** 2 * (1 + 2 * r), h * r * (1 - r) ** 2, r**2 * (3 - 2 * r), -h * r**2 * (1 - r)]
    d = 6 * r * (1 - r)
    dv = [-d / h, (1 - r) * (1 - 3 * r), d / h, r * (3 * r - 2)]
    c = (6 - 12 * r) / h**2
    ddv = [-c, (6 * r - 4) / h, c, (6 * r - 2) / h]
    return _spread(v, e, size), _spread(dv, e, size), _spread(ddv, e, size)


def _gauss(L: float, n: int) -> tuple[Array, Array]:
    """Points and weights (4 n,) of the elements' quadrature."""
    points, weights = np.polynomial.legendre.leggauss(GAUSS)
    h = L / n
    return (h * (np.arange(n)[:, None] + (1 + points) / 2)).ravel(), np.tile(h * weights / 2, n)


def _gram(f: Array, w: Array | float = 1.0) -> Array:
    """Sum of f^T f w over the points, w >= 0, symmetric to the last digit."""
    f = np.sqrt(w)[..., None] * f
    return f.T @ f


def _without_dust(A: Array, size: float) -> Array:
    return np.where(np.abs(A) < DUST * size, 0.0, A)


def _free(n: int, reference: Reference) -> tuple[Array, Array, tuple[str, ...]]:
    """Finite element coordinates that the reference conditions leave, as shapes, node by node along the beam."""
    size = 4 * n + 3
    bends = np.isin(np.arange(size) % 4, (1, 2))
    axial, bending = np.flatnonzero(~bends), np.flatnonzero(bends)
    held = [*axial[list(HELD[reference][0])], *bending[list(HELD[reference][1])]]
    A, B = (np.delete(np.eye(size)[part], held, axis=1) for part in (axial, bending))
    names = [name for i in range(n + 1) for name in (f"u{i}", f"v{i}", f"t{i}", f"u{i + 1}m")][:size]
    return A, B, tuple(name for i, name in enumerate(names) if i not in held)


# --- modes


@dataclass(frozen=True)
class _Family:
    """Axial motion or bending, which do not know of each other."""

    mass: Array  #: (points, c) whose square is the mass matrix
    strain: Array  #: (points, c) whose square is the stiffness matrix
    held: tuple[int, ...]  #: coordinates that the reference conditions hold
    ends: tuple[int, ...]  #: coordinates at both ends
    rigid: Array  #: (c, r) motions without strain that the reference conditions leave
    static: Array  #: (c, ends) what a displacement of each end coordinate does to the others
    units: Array  #: (c,) what coordinates are divided by to be alike
    slow: float  #: about the lowest frequency's square
    power: int  #: squares of frequencies grow as this power of their number


def _families(L, rhoA, EA, EI, J, n, reference) -> tuple[_Family, _Family]:
    x, w = _gauss(L, n)
    w = np.sqrt(w)[:, None]
    s, ds = _quadratic(x, L, n)
    v, dv, ddv = _cubic(x, L, n)
    turning = [(J**0.5 * w) * dv] if J else []
    halves, nodes = np.linspace(0.0, L, 2 * n + 1), np.linspace(0.0, L, n + 1)
    # a uniform beam with loads at its ends alone bends to cubic and stretches to linear fields: those of one element
    cubic = np.stack(_cubic(nodes, L, 1)[:2], axis=1).reshape(2 * n + 2, 4)
    linear = np.stack([1 - halves / L, halves / L], axis=1)
    push = np.ones((2 * n + 1, 1))
    move = np.array([np.ones(n + 1), np.zeros(n + 1)]).T.reshape(-1, 1)
    turn = np.array([nodes - L / 2, np.ones(n + 1)]).T.reshape(-1, 1)
    rigid = (push, np.hstack([move, turn])) if reference == "mean-axis" else (push[:, :0], move[:, :0])
    return (
        _Family(
            mass=(rhoA**0.5 * w) * s,
            strain=(EA**0.5 * w) * ds,
            held=tuple(i % (2 * n + 1) for i in HELD[reference][0]),
            ends=tuple(i % (2 * n + 1) for i in ENDS[0]),
            rigid=rigid[0],
            static=linear,
            units=np.ones(2 * n + 1),
            slow=EA / rhoA * (np.pi / L) ** 2,
            power=2,
        ),
        _Family(
            mass=np.vstack([(rhoA**0.5 * w) * v, *turning]),
            strain=(EI**0.5 * w) * ddv,
            held=tuple(i % (2 * n + 2) for i in HELD[reference][1]),
            ends=tuple(i % (2 * n + 2) for i in ENDS[1]),
            rigid=rigid[1],
            static=cubic,
            units=np.tile([1.0, L / n], n + 1),
            slow=EI / rhoA * (np.pi / L) ** 4,
            power=4,
        ),
    )


def _modal_shapes(L, rhoA, EA, EI, J, n, modes, axial, basis, reference) -> tuple[Array, Array]:
    """Modes as finite element coordinates of each: axial (2 n + 1, k) and bending (2 n + 2, k)."""
    families = _families(L, rhoA, EA, EI, J, n, reference)
    build = _boundary_modes if basis == "craig-bampton" else _eigenmodes
    if axial is None:
        counts = _lowest(families, modes, basis)
    else:
        counts = (axial, modes - axial)
    (A, a), (B, b) = (build(f, count) for f, count in zip(families, counts, strict=True))
    order = np.argsort(np.concatenate([b, a]), kind="stable") if axial is None else np.arange(modes)
    A = np.hstack([np.zeros((2 * n + 1, len(b))), A])
    B = np.hstack([B, np.zeros((2 * n + 2, len(a)))])
    return A[:, order], B[:, order]


def _lowest(families: tuple[_Family, _Family], modes: int, basis: Basis) -> tuple[int, int]:
    """How many of the modes of lowest frequency are axial and of bending; those that the ends need count first."""
    if basis == "craig-bampton":
        of_ends, modes = (1, 2), modes - 3
        squares = [_fixed_modes(f, min(modes, len(f.units) - len(f.ends)))[1] for f in families]
    else:
        of_ends = (0, 0)
        most = [len(f.units) - len(f.held) - f.rigid.shape[1] for f in families]
        squares = [_eigenmodes(f, min(modes, c))[1] for f, c in zip(families, most, strict=True)]
    first = np.argsort(np.concatenate(squares), kind="stable")[:modes]
    a = int((first < len(squares[0])).sum())
    return of_ends[0] + a, of_ends[1] + modes - a


def _eigenmodes(f: _Family, count: int) -> tuple[Array, Array]:
    return _orthonormal(f, np.delete(np.eye(len(f.units)), f.held, axis=1), f.rigid, count)


def _fixed_modes(f: _Family, count: int) -> tuple[Array, Array]:
    """Eigenmodes with both ends held."""
    return _orthonormal(f, np.delete(np.eye(len(f.units)), f.ends, axis=1), f.rigid[:, :0], count)


def _boundary_modes(f: _Family, count: int) -> tuple[Array, Array]:
    """Static modes of the ends and modes with the ends held, orthonormalised; rigid ones left out."""
    static = f.static[:, [end not in f.held for end in f.ends]]
    inner, _ = _fixed_modes(f, count + f.rigid.shape[1] - static.shape[1])
    return _orthonormal(f, np.hstack([static, inner]), f.rigid, count)


def _shifted(K: Array, M: Array, shift: float) -> tuple[Array, Array]:
    """X with X^T (K + shift M) X = 1 and mu, descending, with M X = (K + shift M) X mu: lowest frequencies first.

    With a shift halfway between the lowest and the highest frequency wanted (as logarithms) both have alike digits.
    """
    C = np.linalg.cholesky(K + shift * M)
    mu, X = np.linalg.eigh(np.linalg.solve(C, np.linalg.solve(C, M).T))
    return np.linalg.solve(C.T, X[:, ::-1]), mu[::-1]


def _orthonormal(f: _Family, T: Array, rigid: Array, count: int) -> tuple[Array, Array]:
    """Modes (c, count) of lowest frequency in the span of T (c, t), of mass one, and the squares of their frequencies.

    They are orthogonal to the motions ``rigid`` (c, r), which T spans too. Of each mode, what first comes to a tenth of
    its largest coordinate is positive.
    """
    if not count:
        return np.zeros((len(T), 0)), np.zeros(0)
    M, K = _gram(f.mass @ T), _gram(f.strain @ T)
    X, _ = _shifted(K, M, f.slow * count ** (f.power / 2))
    X = T @ X[:, rigid.shape[1] :][:, :count]
    X = _unit_mass(f, X, rigid)
    # one step of Jacobi's: the factors of the stiffness know more digits of what couples the modes than the eigenvalue
    # problem did (1e-8 of their frequencies with 128 modes, 1e-13 after it)
    S = _gram(f.strain @ X)
    d = np.diag(S)
    gap = d - d[:, None]
    X = X + X @ np.divide(S, gap, out=np.zeros_like(S), where=np.abs(gap) > 1e-8 * d)
    X = _unit_mass(f, X, rigid)
    alike = X / f.units[:, None]
    first = (np.abs(alike) > 0.1 * np.abs(alike).max(axis=0)).argmax(axis=0)
    X = X * np.sign(alike[first, np.arange(count)])
    return X, ((f.strain @ X) ** 2).sum(axis=0)


def _unit_mass(f: _Family, X: Array, rigid: Array) -> Array:
    """Columns of X made orthonormal to each other, and orthogonal to the rigid ones; the first ones change least."""
    X = np.hstack([rigid, X])
    _, R = np.linalg.qr(f.mass @ X)
    return np.linalg.solve(R.T, X.T).T[:, rigid.shape[1] :]
