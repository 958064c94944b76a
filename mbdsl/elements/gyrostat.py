"""Gyrostat: a body with the rotors on it, the variant of ``Body`` that takes their place in a reduced scene.

``J`` is the inertia of all of them about their common centre of mass ``com``; ``rotors`` are the axle, a unit vector,
and the moment of inertia about it, of each; all in the axes of the body.
"""

from dataclasses import fields

from mbdsl.bodies import gyrostat_kernels as motion
from mbdsl.elements import body
from mbdsl.elements.kind import BodyKind

_given = {x.name: getattr(body.IN_SPACE, x.name) for x in fields(body.IN_SPACE)}
IN_SPACE = BodyKind(
    **{
        **_given,
        "doc": "A rigid body in space with rotors.",
        "parameters": (),
        "signals": (),
        "size": "",
        "table": lambda v: (v["m"], *v["J"]),
        "coordinates_of": lambda v: (*body.COORDINATES, *(f"theta{k + 1}" for k in range(len(v["rotors"])))),
        "variant": "gyrostat",
    }
)

__all__ = ["IN_SPACE", "motion"]
