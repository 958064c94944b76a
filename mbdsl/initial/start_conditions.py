"""Conditions on the initial state in addition to the constraints: required values, and the range of beam theories."""

from __future__ import annotations

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.initial.consistent import InitialState
from mbdsl.mechanism.reduction import Reduction
from mbdsl.system import System
from mbdsl.system.bending import REMEDY, SMALL, first_bend
from mbdsl.system.signals import values


def check_loose(reduction: Reduction, system: System, t: float) -> None:
    """Check the initial values of parts that do not move freely.

    Raises
    ------
    InitialisationError
        If an initial value contradicts the welds and drivers.
    """
    if not reduction.loose:
        return
    still = System(reduction.scene, reduction.graph, system.tables)
    nowhere = np.zeros((1, system.n))
    found = values(still, [x.target for x in reduction.loose], np.array([t]), nowhere, nowhere)
    for item, (value,) in zip(reduction.loose, found, strict=True):
        if item.fixed and not abs(value - item.value) <= 1e-9 * (1.0 + abs(item.value)):
            raise InitialisationError(
                f"{item.name} = {item.unit.text(item.value)} is required at the start, but welds and drivers make it "
                f"{item.unit.text(value)}",
                item.span,
                hint="leave it out, or say `guess`, or change what holds the body",
            )


def check_assembled_shapes(system: System, initial: InitialState) -> None:
    """Check that bodies that had to be deformed for the assembly are within the range of their theory.

    Raises
    ------
    InitialisationError
        If one is not.
    """
    if (bend := first_bend(system, initial.q[None])) is not None:
        raise InitialisationError(
            f"{bend.name} has to bend by {bend.angle:.2g} rad to be assembled: {SMALL}",
            system.scene.components[bend.name].span,
            hint=f"check lengths and initial values; {REMEDY}",
        )
