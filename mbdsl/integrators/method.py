"""What a method declares about itself; see any file of a method for how it is used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Option:
    """A parameter of a method: default and the interval it is allowed in."""

    default: float
    lower: float
    upper: float
    doc: str


@dataclass(frozen=True)
class Method:
    """Declaration of an integration method.

    ``coefficients`` turns checked options into the numbers c that the kernels read; ``with_mu`` asks for Phi_q^T mu
    from evaluate; ``matrices`` is the number of iteration matrices kept; ``lag(c)`` tells that the a carried from step
    to step is the acceleration at t_n + lag h.
    """

    name: str
    doc: str
    order: int
    index: int
    enforces: tuple[str, ...]  #: of "Phi", "dPhi"
    source: str
    coefficients: Callable[[Mapping[str, float]], tuple[float, ...]]
    parameters: Mapping[str, Option] = field(default_factory=dict)
    lag: Callable[[tuple[float, ...]], float] = lambda c: 0.0
    with_mu: bool = False
    matrices: int = 1
