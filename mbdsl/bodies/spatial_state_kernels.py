"""The frame of a state in a model in space: see :mod:`mbdsl.bodies.state_kernels`."""

from mbdsl.bodies.state_kernels import MASS, MODEL, gather, jacobians, place
from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

__all__ = ["MASS", "MODEL", "gather", "jacobians"]


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write s and x of every state to its frame, and zero wrenches."""
    place(C, block, vectors, frames, layout)
