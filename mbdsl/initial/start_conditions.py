"""Conditions on the initial state in addition to the constraints: required values, and the range of beam theories."""

from __future__ import annotations

import numpy as np

from mbdsl.bodies.contract import LARGEST_BEND
from mbdsl.errors import InitialisationError
from mbdsl.initial.consistent import InitialState
from mbdsl.mechanism.reduction import Reduction
from mbdsl.system import System
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
                f"{item.name} = {item.value:g} is required at the start, but welds and drivers make it {value:g}",
                item.span,
                hint="leave it out, or say `guess`, or change what holds the body",
            )


def check_bending(system: System, initial: InitialState) -> None:
    """Check that bodies that had to be deformed for the assembly are within the range of their theory.

    Raises
    ------
    InitialisationError
        If one is not.
    """
    for name, body in system.tables.models.items():
        d = system.tables.coordinates[name]
        (angle,) = body.bend(initial.q[None, d : d + body.n])
        if angle > LARGEST_BEND:
            raise InitialisationError(
                f"{name} has to bend by {angle:.2g} rad to be assembled: "
                "in a floating frame deformation is taken as small",
                system.scene.components[name].span,
                hint='check lengths and initial values; formulation = "ancf" allows large deformation',
            )
