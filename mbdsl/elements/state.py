"""State: a variable x with `der(x) = f`, as a body with one coordinate whose velocity is x.

    s' = x,   1 x' = f

The coordinate s has no meaning: no expression reads it, and norms leave it out. With mass 1, every method integrates x
as it integrates the velocities of bodies, with the derivatives of f in its matrix.
"""

from mbdsl.bodies import spatial_state_kernels as motion_in_space
from mbdsl.bodies import state_kernels as motion
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind, in_space

KIND = BodyKind(
    "State",
    doc="A variable with a derivative.",
    parameters=(
        Parameter("nominal", "any", None, "size of its values, to which errors refer", positive=True),
        Parameter("rate", "any", None, "its derivative at the start, from which its value at the start follows"),
    ),
    coordinates=("s",),
    is_frame=True,
    table=lambda v: (1.0,),
    variant="state",
)
IN_SPACE = in_space(KIND, com=lambda v: (0.0, 0.0, 0.0))

__all__ = ["IN_SPACE", "KIND", "motion", "motion_in_space"]
