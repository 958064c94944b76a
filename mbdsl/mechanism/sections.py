"""Forces in the sections of rods and beams, by name: ``rod.b.N`` in the section at the frame b of a rod.

The normal of a section is the x axis of the rod, from frame a to frame b. The signals are what the part beyond the
section, towards frame b, exerts on the part before it: the normal force N is positive in tension, Q and M are positive
along y and about z of the rod. A load at the section itself belongs to the nearer end; in the middle, to frame b.
"""

from __future__ import annotations

from mbdsl.mechanism.scene import Component, Scene

UNITS = {"N": "N", "Q": "N", "M": "N.m"}
UNITS_IN_SPACE = {"N": "N", "Qy": "N", "Qz": "N", "Mx": "N.m", "My": "N.m", "Mz": "N.m", **UNITS}
MEANINGS = {
    "N": "normal force, positive in tension",
    "Q": "shear force along y of the section",
    "M": "bending moment about z of the section",
    "Qy": "shear force along y of the section",
    "Qz": "shear force along z of the section",
    "Mx": "torsional moment about the axis",
    "My": "bending moment about y of the section",
    "Mz": "bending moment about z of the section",
}
KINDS = ("Rod", "FlexibleBeam")  #: uniform bodies along their x axis


def keys(spatial: bool) -> dict[str, str]:
    """Names of the signals of a section, and their units."""
    return UNITS_IN_SPACE if spatial else UNITS


def has_sections(c: Component) -> bool:
    return c.kind.name in KINDS


def stations(scene: Scene, body: str) -> dict[str, float]:
    """Frames on the axis of a rod or beam -> their position from the middle [m]."""
    found = {}
    for name, frame in scene.frames.items():
        if frame.body == body and not any(frame.pose[1 : 3 if scene.spatial else 2]):
            found[name] = frame.x
    return found


def units(scene: Scene) -> dict[str, str]:
    """Signal name -> unit, of the sections at all frames of rods and beams, also by other names of frames."""
    bodies = {c.name for c in scene.components.values() if has_sections(c)}
    if not bodies:
        return {}
    at = {name: frame for name, frame in scene.frames.items() if frame.body in bodies}
    own = {name for body in bodies for name in stations(scene, body)}
    named = {name: name for name in at if name in own and name.rpartition(".")[0] not in _elements(scene)}
    named |= {name: frame for name, frame in scene.aliases.items() if frame in own}
    return {f"{name}.{key}": unit for name in named for key, unit in keys(scene.spatial).items()}


def _elements(scene: Scene) -> set[str]:
    """Joints and forces, whose own frames are named like their ports."""
    return {c.name for c in scene.components.values() if c.ports}
