"""Warnings about the start of a run: an unstable equilibrium, and initial values that the assembly could not keep."""

from __future__ import annotations

from mbdsl.initial.mirrored_poses import MIRRORED
from mbdsl.initial.misfits import misfits
from mbdsl.simulation import steady_start
from mbdsl.simulation.examined_run import ExaminedRun

BEFORE = True  #: a misfit that leaves no direction is an error


def warnings(run: ExaminedRun) -> list[str]:
    """Warnings about the equilibrium, the misfits and the mirrored poses at which a run starts.

    Raises
    ------
    InitialisationError
        As :func:`mbdsl.initial.misfits.misfits`.
    """
    motion = run.motion
    found = steady_start.warnings(run.rest)
    found += [text for p in motion.parts for text in misfits(p.system, p.initial.t, p.initial.q, p.initial.v)]
    found += [MIRRORED.format(name) for _, first in motion.assembled for name in first.mirrored]
    return found + [note for _, first in motion.assembled for note in first.notes]
