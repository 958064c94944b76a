"""What a report contains: the run, the graph, the effects and the modes of a model, and how to repeat the run."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mbdsl.explanation.receipt import Receipt
from mbdsl.simulation import provenance
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.viewing.structure import Structure

if TYPE_CHECKING:
    from mbdsl.analysis.eigenmodes import Modes


@dataclass
class Findings:
    """The data of a report; ``Report`` describes the attributes."""

    trajectory: Trajectory
    structure: Structure
    receipt: Receipt | None
    modes: Modes | None = None
    signals: Sequence[str] | None = None
    command: str = ""
    problems: list[str] = field(default_factory=list)

    @property
    def digest(self) -> str:
        """SHA-256 of the times, coordinates and velocities of the run, as 64-bit numbers, little-endian."""
        found = hashlib.sha256()
        for values in (self.trajectory.t, self.trajectory.q, self.trajectory.v):
            found.update(values.astype("<f8").tobytes())
        return found.hexdigest()

    def facts(self) -> list[tuple[str, str]]:
        """List what is required to repeat the run.

        Returns
        -------
        list of (str, str)
            Names and values: the command, digests of the model and of the states, versions, the machine.
        """
        found = [("command", self.command)] if self.command else []
        scene = self.trajectory.scene
        texts = {os.path.basename(name): text for name, text in scene.files.items()}
        for name, text in {**texts, "the resolved model": scene.fingerprint}.items():
            found.append((f"SHA-256 of {name}", hashlib.sha256(text.encode()).hexdigest()))
        found.append(("SHA-256 of the states", self.digest))
        found += [(f"version of {name}", version) for name, version in provenance.versions().items()]
        machine = provenance.machine()
        return found + [(name, machine[name]) for name in ("processor", "cores", "system")]
