"""A uniform beam, and the elastic coordinates that it has in its floating frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from mbdsl.bodies.beam_elements import Reference

Basis = Literal["eigenmodes", "craig-bampton"]


@dataclass(frozen=True)
class UniformBeam:
    """A section, coordinates and damping.

    By default the coordinates are those of the finite elements which the reference conditions leave free: ``u3``,
    ``v3``, ``t3`` at node 3 of nodes 0 to n, ``u3m`` in the middle of element 3, which ends at node 3.

    A ``basis`` of eigenmodes is that under the reference conditions. The basis of Craig and Bampton consists of static
    modes for displacements of the ends and eigenmodes with the ends held, combined to orthogonal modes: displacements
    by forces and torques at the ends are then exact.

    The ``reference`` conditions define the frame: s(0) = v(0) = v(L) = 0; s(0) = v(0) = v'(0) = 0; or elastic rates
    without linear and angular momentum (modes of the free beam; not for coordinates of finite elements).
    """

    L: float  #: length [m]
    rhoA: float  #: mass per length [kg/m]
    EA: float  #: axial stiffness [N]
    EI: float  #: bending stiffness [N m^2]
    J: float = 0.0  #: rotary inertia per length [kg m]
    elements: int = 8  #: finite elements of equal length
    modes: int | None = None  #: the number of modes to keep
    #: the number of axial modes among them; they follow the bending modes. By default the modes of lowest frequency are
    #: kept, in the order of their frequencies (of the modes of Craig and Bampton, three belong to the ends, and the
    #: others are those of lowest frequency with the ends held)
    axial: int | None = None
    basis: Basis = "eigenmodes"
    reference: Reference = "pinned-pinned"
    zeta: float = 0.0  #: damping ratio of every mode
    alpha: float = 0.0  #: Rayleigh damping alpha M_ff [1/s], in addition to ``zeta``
    beta: float = 0.0  #: Rayleigh damping beta K [s]
    stiffening: bool = True  #: whether bending shortens the chord (geometric stiffening)


def check_beam(beam: UniformBeam) -> None:
    """Check the section and the damping.

    Raises
    ------
    ValueError
        If they define no beam.
    """
    for name in ("L", "rhoA", "EA", "EI"):
        value = getattr(beam, name)
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} = {value:g}; a beam's {name} is positive")
    for name in ("J", "zeta", "alpha", "beta"):
        value = getattr(beam, name)
        if not 0.0 <= value < np.inf:
            raise ValueError(f"{name} = {value:g}; a beam's {name} is not negative")
    if beam.elements < 1:
        raise ValueError(f"elements = {beam.elements}; a beam has at least one element")


def check_basis(beam: UniformBeam) -> None:
    """Check the coordinates.

    Raises
    ------
    ValueError
        If they are no basis.
    """
    n, modes, axial, basis, reference = beam.elements, beam.modes, beam.axial, beam.basis, beam.reference
    for found, known in ((basis, Basis), (reference, Reference)):
        if found not in get_args(known):
            raise ValueError(f"{found!r} is none of {', '.join(get_args(known))}")
    if modes is None:
        if reference == "mean-axis":
            raise ValueError("mean-axis conditions are for modes: give a number of modes, or another reference")
        if basis == "craig-bampton" or axial is not None:
            raise ValueError("a basis of modes needs the number of modes")
        if beam.zeta:
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
