"""The numbers and modes of rigid contacts, for integrators, which see a System and not the parts of a scene."""

from mbdsl.mechanism.contacts import CLOSED, COUNT, DEPENDENT, EDGE, IMPULSE, MODE, OPEN, number

__all__ = ["CLOSED", "COUNT", "DEPENDENT", "EDGE", "IMPULSE", "MODE", "OPEN", "number"]
