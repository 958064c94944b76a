"""The model and the kernels of each body of a scene, by its kind and its values."""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType

from mbdsl.bodies.contract import POSITIONS, Body, Pose, model_class
from mbdsl.bodies.rigid_body import Rigid
from mbdsl.elements import Declared, declaring
from mbdsl.elements.kind import BodyKind
from mbdsl.expressions import spatial_coordinates
from mbdsl.mechanism.scene import Component


def motion_module(component: Component) -> ModuleType:
    """The module whose kernels move a body's frames; for kinds with several modules it depends on the values."""
    found = declaring(component.kind).motion
    found = found(component.values) if callable(found) else found
    model_class(found)  # checks the contract
    return found


def motion_modules(module: Declared) -> list[ModuleType]:
    """All modules that may move bodies of a kind."""
    return list(getattr(module, "MOTIONS", [module.motion]))


def model(component: Component) -> Body:
    """The model of a body with coordinates."""
    return model_class(motion_module(component))(component)


def body_models(bodies: Iterable[Component]) -> dict[str, Body]:
    """Name of each body -> its model; rigid bodies with the same values, as in an array, share one."""
    found: dict[str, Body] = {}
    shared: dict[tuple[int, int], Body] = {}
    for body in bodies:
        key = id(body.kind), id(body.values)
        own = shared[key] if key in shared else model(body)
        if isinstance(own, Rigid):
            shared[key] = own
        found[body.name] = own
    return found


def body_pose(component: Component, frame) -> Pose:
    """A frame's (x, y, phi) from the centre of mass (of a beam: from its centre), in the body's axes; of bodies in
    space the origin and the axes (12 numbers), followed on a rotor of a gyrostat by its number."""
    if isinstance(component.kind, BodyKind) and component.kind.spatial:
        x, y, z = component.kind.com(component.values)
        return frame.x - x, frame.y - y, frame.z - z, *frame.axes, *((frame.rotor,) if frame.rotor else ())
    cx, cy = component.kind.com(component.values) if isinstance(component.kind, BodyKind) else (0.0, 0.0)
    return frame.x - cx, frame.y - cy, frame.phi


def at_rest(component: Component, frame, key: str) -> float:
    """A coordinate of a frame on a body that does not move: "x", "y" [m], "phi" [rad] or a rate."""
    keys = spatial_coordinates.POSITIONS if component.kind.spatial else POSITIONS
    return dict(zip(keys, body_pose(component, frame), strict=True)).get(key, 0.0)
