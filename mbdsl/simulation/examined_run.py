"""A run on its way from its options to its results, with everything that warnings about it depend on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mbdsl.kernels.arrays import Array
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.run_options import RunOptions
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from mbdsl.simulation.checkpoint import Keeper
    from mbdsl.simulation.steady_start import PointsAtRest
    from mbdsl.simulation.streaming import Stream


@dataclass
class ExaminedRun:
    """A run and its results."""

    options: RunOptions
    motion: MechanismRun
    rest: PointsAtRest | None = None  #: the equilibrium at which the run starts
    stream: Stream | None = None  #: what takes the rows of a streamed run
    keeper: Keeper | None = None  #: what writes the checkpoints of the run
    at_start: list[str] = field(default_factory=list)  #: the warnings before the first step
    trajectory: Trajectory = field(init=False)  #: the results, when the run has ended; of a streamed run, the last rows
    #: q and v (N, n) of each part, at the times of the trajectory
    states: list[tuple[Array, Array]] = field(init=False)
    done: bool = False  #: whether the run has reached its end
    chosen: str = ""  #: why its method was chosen, if several were tried
