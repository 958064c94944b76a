"""A run on its way from its options to its results, with everything that warnings about it depend on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.run_options import RunOptions
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from mbdsl.simulation.checkpoint import Keeper
    from mbdsl.simulation.steady_start import AtRest
    from mbdsl.simulation.streaming import Stream

Array = NDArray[np.float64]


@dataclass
class ExaminedRun:
    """A run and its results.

    Attributes
    ----------
    options : RunOptions
    motion : MechanismRun
    rest : AtRest or None
        The equilibrium at which the run starts.
    stream : Stream or None
        What takes the rows of a streamed run.
    keeper : Keeper or None
        What writes the checkpoints of the run.
    at_start : list of str
        The warnings before the first step.
    trajectory : Trajectory
        The results, when the run has ended; of a streamed run, the last rows.
    states : list of (Array, Array)
        q and v (N, n) of each part, at the times of the trajectory.
    done : bool
        Whether the run has reached its end.
    chosen : str
        Why its method was chosen, if several were tried.
    """

    options: RunOptions
    motion: MechanismRun
    rest: AtRest | None = None
    stream: Stream | None = None
    keeper: Keeper | None = None
    at_start: list[str] = field(default_factory=list)
    trajectory: Trajectory = field(init=False)
    states: list[tuple[Array, Array]] = field(init=False)
    done: bool = False
    chosen: str = ""
