"""Checks of the structure of a mechanism, independent of its numbers: errors and warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbdsl.elements.kind import BodyKind, ForceKind
from mbdsl.errors import ModelError, ModelWarning
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.messages import count, few


def ground_and_bodies(scene: Scene, grounds: Sequence[Component]) -> None:
    """Check that there are a ground, a single gravity field, and bodies."""
    if not grounds:
        raise ModelError(
            f"model `{scene.name}` has no Ground, which defines the inertial frame and gravity",
            hint="declare one, such as:  Ground world;",
        )
    first = grounds[0]
    if not scene.with_coordinates():
        raise ModelError(
            f"model `{scene.name}` has no bodies: there is nothing to move",
            first.span,
            "declare one, such as:  Rod link(m = 1 kg, length = 1 m);",
        )
    for other in grounds[1:]:
        if any(first.values.get(key) != other.values.get(key) for key in ("g", "n")):
            raise ModelError(
                f"grounds `{first.name}` and `{other.name}` disagree about gravity; there is only one world",
                other.span,
                "give both the same g and n",
                ((f"`{first.name}` is declared here", first.span),),
            )


def joints_join(joints: Sequence[Edge], ground: Component) -> None:
    """Check that every joint has its frames on two different bodies, or on one and the ground."""
    for e in joints:
        if e.body_i == e.body_j and not e.component.ports:
            raise ModelError(
                f"{e.component.kind.name} `{e.name}` depends on no body: nothing in its expression can move",
                e.component.span,
                "it takes velocities of bodies, such as `rod.w` or `rod.b.vx`"
                if e.velocity_rows
                else "it takes coordinates of bodies and joints, such as `rod.b.x` or `pin.phi`",
            )
        if e.body_i == e.body_j:
            kind, frames = e.component.kind.name, " and ".join(e.component.ports.values())
            owner = f"body `{e.body_i}`" if e.body_i else f"the ground `{ground.name}`"
            raise ModelError(
                f"{kind} `{e.name}` joins {owner} to itself: {frames} are both fixed to it",
                e.component.span,
                "a joint needs frames of two different bodies, or of one body and the ground",
            )


def forces_act(forces: Sequence[Edge]) -> None:
    """Check that no torque acts between two frames of one body, where its two parts cancel."""
    for e in forces:
        if e.component.kind.name == "Torque" and e.body_i == e.body_j and e.body_i and len(e.component.ports) == 2:
            frames = " and ".join(e.component.ports.values())
            raise ModelError(
                f"Torque `{e.name}` does nothing: {frames} belong to the same body, on which both parts cancel",
                e.component.span,
                f"with one frame it acts on the body: `Torque {e.name}({e.component.ports['frame_b']}, tau = ..."
                f"""{', axes = "frame_b"' if e.component.kind.spatial else ""})`""",
            )


def all_held(bodies: Mapping[str, Component], floating: Sequence[Sequence[str]], ground: Component) -> None:
    """Check that joints or forces connect every group of bodies with the ground."""
    if not floating:
        return

    def message(group: Sequence[str]) -> str:
        if len(group) == 1:
            return f"body `{group[0]}` has no path to ground: no joint or force holds it"
        return f"bodies {few(group)} have no path to ground: no joint or force leads from them to `{ground.name}`"

    first = bodies[floating[0][0]]
    frame = first.name if isinstance(first.kind, BodyKind) and first.kind.is_frame else f"{first.name}.c"
    raise ModelError(
        message(floating[0]),
        first.span,
        f"add a joint or a force; if it is meant to fly:  FreeMotion free({ground.name}, {frame});",
        tuple((message(group), bodies[group[0]].span) for group in floating[1:4]),
    )


def warnings(joints: Sequence[Edge], forces: Sequence[Edge]) -> tuple[ModelWarning, ...]:
    """Warnings about repeated joints, and about springs that cannot move anything."""
    found = []
    seen: dict[tuple, Edge] = {}
    for e in joints:
        rows = e.rows + e.velocity_rows
        if not rows:
            continue
        key = (e.component.kind.name, frozenset(e.component.ports.values()))
        first = seen.setdefault(key, e)
        if first is not e and dict(first.component.values) == dict(e.component.values):
            found.append(
                ModelWarning(
                    f"{e.component.kind.name} `{e.name}` repeats `{first.name}`: same frames, same values",
                    e.component.span,
                    f"its {count(rows, 'constraint row')} can only be redundant; leave one of the two out",
                    ((f"`{first.name}` is declared here", first.component.span),),
                )
            )
    for e in forces:
        if e.body_i == e.body_j and isinstance(e.component.kind, ForceKind) and e.component.kind.springs:
            found.append(
                ModelWarning(
                    f"{e.component.kind.name} `{e.name}` has both frames on one body and cannot move anything",
                    e.component.span,
                    "attach one of its frames to another body",
                )
            )
    return tuple(found)
