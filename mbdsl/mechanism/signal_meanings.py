"""The meanings of signals in words."""

from __future__ import annotations

from mbdsl.elements.kind import BodyKind, PairKind
from mbdsl.expressions import spatial_coordinates
from mbdsl.mechanism import sections
from mbdsl.mechanism.scene import ENERGIES, Component, Description, Scene

#: meanings of signals that a kind does not describe, by the last part of their names
MEANINGS = {
    "x": "position along x",
    "y": "position along y",
    "phi": "angle",
    "vx": "velocity along x",
    "vy": "velocity along y",
    "w": "angular velocity",
    "ax": "acceleration along x",
    "ay": "acceleration along y",
    "alpha": "angular acceleration",
    "Phi": "residual of a constraint",
    "dPhi": "residual of a constraint, its rate",
    "Gam": "residual of a constraint of velocities",
    "q": "elastic coordinate",
    "dq": "elastic coordinate, its rate",
    "friction": "friction",
    "f": "size of the force",
    "t": "size of the torque",
    "v": "size of the velocity",
    "a": "size of the acceleration",
}
OF_SPAN = {"tension": "tension of this span", "s": "length of this span"}  #: of the further spans of a rope
#: of what a joint or force exerts on the body at one of its frames
ON_PORT = {f"f{i}": f"force on the body along {i} of this frame" for i in "xyz"}
ON_PORT |= {f"t{i}": f"torque on the body about {i} of this frame" for i in "xyz"}
ON_PORT |= {"tau": "torque on the body about z of this frame", "f": MEANINGS["f"], "t": MEANINGS["t"]}
IN_SPACE = spatial_coordinates.MEANINGS | {f"a{i}": f"acceleration along {i}" for i in "xyz"}
IN_SPACE |= {f"alpha{i}": f"angular acceleration about the {i} axis of the world" for i in "xyz"}
OF_ENERGIES = dict(zip(ENERGIES, ("kinetic energy", "energy of gravity and springs", "total energy"), strict=True))


def meaning(scene: Scene, name: str) -> str:
    """The meaning of a signal: as its kind describes it, else by the last part of its name."""
    if name == "time" or name in OF_ENERGIES:
        return OF_ENERGIES.get(name, "time")
    if name in scene.variables:
        said = scene.descriptions.get(name, Description()).doc
        return said or ("input" if name in scene.inputs else "variable of the model")
    owner, _, key = name.rpartition(".")
    component = scene.components.get(owner)
    said = _described(component, key) if component is not None else _of_frame(scene, owner, key)
    if scene.spatial:
        said = said or IN_SPACE.get(key, "")
    return said or MEANINGS.get(key.partition("[")[0], "")


def _of_frame(scene: Scene, frame: str, key: str) -> str:
    """The meaning of a signal of a port, or of a section of a rod or beam."""
    owner, _, port = frame.rpartition(".")
    component = scene.components.get(owner)
    if component is not None and isinstance(component.kind, PairKind) and port in component.ports:
        return ON_PORT.get(key, "")
    return sections.MEANINGS.get(key, "")


def _described(c: Component, key: str) -> str:
    kind = c.kind
    known = {p.name: p.doc for p in kind.parameters if p.law}
    known |= {s.name: s.doc for s in (*kind.signals, *kind.outputs)}
    if getattr(kind, "path", None) is not None and len(c.signals) == len(OF_SPAN):
        known |= OF_SPAN
    said = known.get(key, "").removesuffix(", a number or an expression")
    return f"{said}, {key}" if said and isinstance(kind, BodyKind) and key in ("x", "y", "z") else said
