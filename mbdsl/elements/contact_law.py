"""The normal force of contacts and stops: stiffness, and damping that follows from a coefficient of restitution.

    F = k d max(0, 1 + alpha d')                                                         at the depth d > 0

(K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445, with a linear spring). It is zero at first touch and
never pulls. A mass that arrives at the speed v_0 leaves at e v_0 if

    D (1 + e) = ln((1 + D)/(1 - e D)),  D = alpha v_0

which follows from v dv/dd = -F/m by separation of the variables. It is solved for D; slower impacts lose less.
"""

from collections.abc import Mapping
from math import log

from mbdsl.elements.declaration import Parameter

LEAST = 0.05  #: smallest coefficient of restitution; the damping grows like 1/e


def parameters(stiffness: str, speed: str, unit: str) -> tuple[Parameter, ...]:
    """The parameters of a contact with this unit of stiffness, whose speed is called ``speed``."""
    return (
        Parameter("k", stiffness, doc="stiffness", positive=True),
        Parameter("e", "1", 1.0, f"coefficient of restitution of an impact at the speed {speed}", positive=True),
        Parameter(speed, unit, None, "speed of approach of this impact; required with e < 1", positive=True),
    )


def damping(e: float) -> float:
    """D, for a coefficient of restitution e: the root of D (1 + e) - ln((1 + D)/(1 - e D)) between 0 and 1/e."""
    if e == 1.0:
        return 0.0
    low, high = 0.0, 1.0 / e
    for _ in range(200):  # the difference is positive below the root and negative above it
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if e * middle < 1.0 and middle * (1.0 + e) > log((1.0 + middle) / (1.0 - e * middle)):
            low = middle
        else:
            high = middle
    return low


def check(values: Mapping, speed: str) -> str | None:
    """The error text, if the coefficient of restitution or the speed cannot be used."""
    e = values["e"]
    if not LEAST <= e <= 1.0:
        return f"e is {e:g}, the coefficient of restitution must be between {LEAST:g} and 1"
    if e < 1.0 and values[speed] is None:
        return f"e = {e:g} needs `{speed}`, the speed of approach at which an impact has this restitution"
    return None


def rate(values: Mapping, speed: str) -> float:
    """alpha [s/m, s/rad]."""
    return damping(values["e"]) / values[speed] if values["e"] < 1.0 else 0.0


def elastic(values: Mapping) -> dict:
    """The values without damping."""
    return {"alpha": (0.0,)} if values["alpha"][0] else {}
