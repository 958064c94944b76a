"""What uniform solid bodies have in common: their mass, or their density and volume, and their moments of inertia."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mbdsl.elements import body
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind

MASS = (
    Parameter("m", "kg", None, "mass; or give the density", minimum=0.0),
    Parameter("rho", "kg/m3", None, "density, in place of the mass", positive=True),
)
FRAMES = Parameter("frames", "", (), "further frames")
Formula = Callable[[Mapping], float]


def solid(
    name: str,
    doc: str,
    parameters: tuple[Parameter, ...],
    volume: Formula,
    inertia: Callable[[Mapping], tuple],
    check: Callable[[Mapping], str | None] = lambda v: None,
    **more: Any,
) -> BodyKind:
    """A declaration. ``volume`` [m3] and ``inertia`` [kg.m2], as ``I`` of a Body, are functions of the values."""

    def checked(v: Mapping) -> str | None:
        if (v["m"] is None) == (v["rho"] is None):
            return "the mass is missing: give m or rho" if v["m"] is None else "give either m or rho"
        return check(v)

    def derive(v: Mapping) -> dict:
        m = v["rho"] * volume(v) if v["m"] is None else v["m"]
        return {"m": m, "I": inertia({**v, "m": m})}

    return BodyKind(
        name,
        doc=doc,
        parameters=(*MASS, *parameters, FRAMES),
        signals=body.SIGNALS_IN_SPACE,
        check=checked,
        derive=derive,
        coordinates=body.COORDINATES,
        com=lambda v: (0.0, 0.0, 0.0),
        table=lambda v: (v["m"], *body.inertia(v["I"])),
        spatial=True,
        **more,
    )
