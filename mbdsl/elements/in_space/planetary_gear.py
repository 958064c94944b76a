"""PlanetaryGear: a sun, a ring with internal teeth, and a carrier with planets between them, as one part.

g = (sun - carrier) + ratio (ring - carrier) - phi0                                  (1 row, by expression)
"""

from mbdsl.elements import planetary_gear
from mbdsl.elements.in_space.kinds import in_space

DRAWING = planetary_gear.DRAWING
KIND = in_space(planetary_gear.KIND)
