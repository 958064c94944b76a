"""The numbers and modes of rigid contacts, for integrators, which see a System and not the parts of a scene."""

from mbdsl.mechanism.contacts import (
    ALONG,
    ALONG_2,
    CLOSED,
    COEFFICIENT,
    COUNT,
    DEPENDENT,
    EDGE,
    FRICTION,
    HELD,
    IMPULSE,
    MODE,
    OPEN,
    SLIDING,
    SLOW,
    number,
)

__all__ = [
    "ALONG",
    "ALONG_2",
    "CLOSED",
    "COEFFICIENT",
    "COUNT",
    "DEPENDENT",
    "EDGE",
    "FRICTION",
    "HELD",
    "IMPULSE",
    "MODE",
    "OPEN",
    "SLIDING",
    "SLOW",
    "number",
]
