"""Notes on a reduction: what it did or did not do, and why; ``mbdsl explain`` prints them."""

from __future__ import annotations

from dataclasses import dataclass

from mbdsl.errors import Span
from mbdsl.messages import few


@dataclass(frozen=True)
class Note:
    """``action`` (one of ``ACTIONS``) was done to ``names`` because of the components named in ``by``."""

    action: str
    names: tuple[str, ...]
    why: str
    by: tuple[str, ...] = ()
    span: Span | None = None

    def __str__(self) -> str:
        by = f", by {few(self.by)}" if self.by and self.by != self.names else ""
        where = f" ({self.span})" if self.span is not None else ""
        return f"{self.action}: {few(self.names)}{by}: {self.why}{where}"


#: merged: welded bodies became the first of them; grounded: welded to the ground and removed; moved: driven bodies
#: became part of the ground, as functions of time; dropped: acts on nothing that remains; kept: could not be reduced;
#: split: integrated separately; planar: bodies in space that can only move in a plane, and are solved there;
#: gyrostat: rotors, whose angles are the only coordinates that they have in addition to those of their carrier;
#: kinematic: solved from its constraints alone
ACTIONS = ("merged", "grounded", "moved", "dropped", "kept", "split", "planar", "gyrostat", "kinematic")
