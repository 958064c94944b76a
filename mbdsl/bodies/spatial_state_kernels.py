"""The frame of a state in a model in space: see :mod:`mbdsl.bodies.state_kernels`."""

from mbdsl.bodies.state_kernels import MASS, MODEL, gather, jacobians, place
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

__all__ = ["MASS", "MODEL", "jacobians"]


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write s and x of every state to its frame, and zero wrenches."""
    place(C, block, vectors, frames, layout)


@kernel
def collect(block, vectors, frames, layout):
    """vectors[FORCE] += the derivative of every state."""
    gather(block, C.WRENCH, L.FORCE, vectors, frames, layout)


@kernel
def collect_with_mu(block, vectors, frames, layout):
    """As ``collect``; also vectors[FORCE2], of constraints that contain the state."""
    gather(block, C.WRENCH, L.FORCE, vectors, frames, layout)
    gather(block, C.MU_WRENCH, L.FORCE2, vectors, frames, layout)


@kernel
def collect_past(block, vectors, frames, layout):
    """vectors[PAST_FORCE] += that of the wrenches of psi."""
    gather(block, C.PAST_WRENCH, L.PAST_FORCE, vectors, frames, layout)
