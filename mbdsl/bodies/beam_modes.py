"""Modal reduction of beams: eigenmodes, and the modes of Craig and Bampton (AIAA J. 6 (1968) 1313-1319)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbdsl.bodies.beam_elements import (
    HELD,
    Array,
    cubic,
    gauss,
    gram,
    quadratic,
)
from mbdsl.bodies.uniform_beam import Basis, UniformBeam

ENDS = ((0, -1), (0, 1, -2, -1))  #: axial and bending coordinates of both ends: the boundary of Craig and Bampton


@dataclass(frozen=True)
class _Family:
    """Axial motion or bending; the two are not coupled."""

    mass: Array  #: (points, c) X, where X^T X is the mass matrix
    strain: Array  #: (points, c) X, where X^T X is the stiffness matrix
    held: tuple[int, ...]  #: coordinates that the reference conditions hold
    ends: tuple[int, ...]  #: coordinates at both ends
    rigid: Array  #: (c, r) rigid-body motions that the reference conditions allow
    static: Array  #: (c, ends) displacements caused by a unit displacement of each end coordinate
    units: Array  #: (c,) factors that convert coordinates to displacements
    slow: float  #: approximate square of the lowest frequency
    power: int  #: the squares of frequencies grow as this power of the mode number


def _families(beam: UniformBeam) -> tuple[_Family, _Family]:
    L, rhoA, J, n, reference = beam.L, beam.rhoA, beam.J, beam.elements, beam.reference
    x, w = gauss(L, n)
    w = np.sqrt(w)[:, None]
    s, ds = quadratic(x, L, n)
    v, dv, ddv = cubic(x, L, n)
    turning = [(J**0.5 * w) * dv] if J else []
    halves, nodes = np.linspace(0.0, L, 2 * n + 1), np.linspace(0.0, L, n + 1)
    # a uniform beam loaded at its ends only has cubic deflection and linear axial displacement: one element is exact
    whole = np.stack(cubic(nodes, L, 1)[:2], axis=1).reshape(2 * n + 2, 4)
    linear = np.stack([1 - halves / L, halves / L], axis=1)
    push = np.ones((2 * n + 1, 1))
    move = np.array([np.ones(n + 1), np.zeros(n + 1)]).T.reshape(-1, 1)
    turn = np.array([nodes - L / 2, np.ones(n + 1)]).T.reshape(-1, 1)
    rigid = (push, np.hstack([move, turn])) if reference == "mean-axis" else (push[:, :0], move[:, :0])
    return (
        _Family(
            mass=(rhoA**0.5 * w) * s,
            strain=(beam.EA**0.5 * w) * ds,
            held=tuple(i % (2 * n + 1) for i in HELD[reference][0]),
            ends=tuple(i % (2 * n + 1) for i in ENDS[0]),
            rigid=rigid[0],
            static=linear,
            units=np.ones(2 * n + 1),
            slow=beam.EA / rhoA * (np.pi / L) ** 2,
            power=2,
        ),
        _Family(
            mass=np.vstack([(rhoA**0.5 * w) * v, *turning]),
            strain=(beam.EI**0.5 * w) * ddv,
            held=tuple(i % (2 * n + 2) for i in HELD[reference][1]),
            ends=tuple(i % (2 * n + 2) for i in ENDS[1]),
            rigid=rigid[1],
            static=whole,
            units=np.tile([1.0, L / n], n + 1),
            slow=beam.EI / rhoA * (np.pi / L) ** 4,
            power=4,
        ),
    )


def modal_shapes(beam: UniformBeam) -> tuple[Array, Array]:
    """Axial (2 n + 1, k) and bending (2 n + 2, k) finite element coordinates of the modes."""
    n, modes, axial, basis, families = beam.elements, beam.modes, beam.axial, beam.basis, _families(beam)
    assert modes is not None
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
    """Numbers of axial and of bending modes among those of lowest frequency, after the modes that the ends require."""
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
    return _orthonormal(f, np.delete(np.diag(1.0 / f.units), f.held, axis=1), f.rigid, count)


def _fixed_modes(f: _Family, count: int) -> tuple[Array, Array]:
    """Eigenmodes with both ends held."""
    return _orthonormal(f, np.delete(np.diag(1.0 / f.units), f.ends, axis=1), f.rigid[:, :0], count)


def _boundary_modes(f: _Family, count: int) -> tuple[Array, Array]:
    """Static modes of the ends and modes with the ends held, orthonormalised, without rigid-body motions."""
    static = (f.static / f.units[list(f.ends)])[:, [end not in f.held for end in f.ends]]
    inner, _ = _fixed_modes(f, count + f.rigid.shape[1] - static.shape[1])
    return _orthonormal(f, np.hstack([static, inner]), f.rigid, count)


def shifted(K: Array, M: Array, shift: float) -> tuple[Array, Array]:
    """X with X^T (K + shift M) X = 1 and mu, descending, with M X = (K + shift M) X mu: lowest frequencies first.

    If the shift is the geometric mean of the lowest and the highest wanted eigenvalue, both are equally accurate.
    """
    C = np.linalg.cholesky(K + shift * M)
    mu, X = np.linalg.eigh(np.linalg.solve(C, np.linalg.solve(C, M).T))
    return np.linalg.solve(C.T, X[:, ::-1]), mu[::-1]


def _orthonormal(f: _Family, T: Array, rigid: Array, count: int) -> tuple[Array, Array]:
    """Modes (c, count) of lowest frequency in the span of T (c, t), with unit mass, and the squares of the frequencies.

    They are orthogonal to the motions ``rigid`` (c, r), which T also spans. The first coordinate of a mode that exceeds
    a tenth of the largest one is positive.
    """
    if not count:
        return np.zeros((len(T), 0)), np.zeros(0)
    M, K = gram(f.mass @ T), gram(f.strain @ T)
    X, _ = shifted(K, M, f.slow * count ** (f.power / 2))
    X = T @ X[:, rigid.shape[1] :][:, :count]
    X = _unit_mass(f, X, rigid)
    # one Jacobi step: the factors of the stiffness matrix give the coupling of the modes more accurately than the
    # eigenvalue problem (errors of the frequencies with 128 modes: 1e-8 before, 1e-13 after)
    S = gram(f.strain @ X)
    d = np.diag(S)
    gap = d - d[:, None]
    X = X + X @ np.divide(S, gap, out=np.zeros_like(S), where=np.abs(gap) > 1e-8 * d)
    X = _unit_mass(f, X, rigid)
    alike = X * f.units[:, None]
    first = (np.abs(alike) > 0.1 * np.abs(alike).max(axis=0)).argmax(axis=0)
    X = X * np.sign(alike[first, np.arange(count)])
    return X, ((f.strain @ X) ** 2).sum(axis=0)


def _unit_mass(f: _Family, X: Array, rigid: Array) -> Array:
    """X with columns orthonormalised, and orthogonal to the rigid-body motions; earlier columns change least."""
    X = np.hstack([rigid, X])
    _, R = np.linalg.qr(f.mass @ X)
    return np.linalg.solve(R.T, X.T).T[:, rigid.shape[1] :]
