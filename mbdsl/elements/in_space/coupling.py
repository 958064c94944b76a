"""Coupling: two coordinates in a fixed ratio, as by gears, belts, racks and cables whose parts are not modelled.

g = b - ratio a,   g = offset(t)                                                     (1 row, by expression)
"""

from mbdsl.elements import coupling
from mbdsl.elements.in_space.kinds import in_space

DRAWING = coupling.DRAWING
KIND = in_space(coupling.KIND)
