"""The assembly of a mechanism: the pose that is meant, by attempts with sets of unknowns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.initial import telescopes, upside_down
from mbdsl.initial.dependent_rows import without_units
from mbdsl.initial.in_plane import PlanarUnknowns
from mbdsl.initial.least_steps import misses, stack, stacked
from mbdsl.initial.mirrored_poses import unmirrored
from mbdsl.initial.placement import place
from mbdsl.initial.pose_search import Shape, Task, nearest_pose
from mbdsl.initial.undeformed import AsIs, Undeformed
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import InitialValue

Notes = tuple[tuple[str, ...], tuple[str, ...]]  #: of another assembly, and of bodies that turned far


@dataclass(frozen=True)
class Pose:
    """Unknowns, and their values for a pose."""

    shape: Shape
    y: Array

    @property
    def q(self) -> Array:
        """The coordinates (n,)."""
        return self.shape.expand(self.y)


class PoseAssembly:
    """The assembly of the poses of a task."""

    def __init__(self, task: Task, graph: MechanismGraph) -> None:
        self.task, self.graph = task, graph
        self.system, self.t = task.system, task.t

    def shapes(self, positions: list[InitialValue]) -> list[Shape]:
        """The sets of unknowns for assembly, in the order of the attempts."""
        system = self.system
        placed = place(system, self.graph, self.t, positions)
        if begun := system.scene.deformed:  # the shapes of an equilibrium
            placed = np.array([begun.get(name, x) for name, x in zip(system.names(), placed, strict=True)])
            return [AsIs(system, placed)]
        as_is = AsIs(system, placed)
        if system.scene.spatial:
            in_plane = PlanarUnknowns(system, placed)
            return [in_plane, as_is] if self._flat(in_plane) else [as_is]
        return [Undeformed(system, placed), as_is] if system.tables.flexible else [as_is]

    def meant(self, first: Shape) -> tuple[Pose, Notes]:
        """The pose near the placement, or the one that is meant where the model decides nothing, with notes."""
        placed = first.expand(first.start)
        pose, legs = self._reaching(self._pose(first))
        if not isinstance(pose.shape, AsIs | PlanarUnknowns):
            return pose, (legs, ())
        pose, upright = self._upright(pose)
        turned = tuple(upside_down.turned(self.system, self.graph, placed, pose.q))
        return pose, ((*legs, *upright), turned)

    def _pose(self, shape: Shape) -> Pose:
        """The pose; in space with the axes of joints in the intended senses, if possible."""
        system = self.system
        y = nearest_pose(self.task, shape)
        if not system.scene.spatial:
            return Pose(shape, y)
        if isinstance(shape, PlanarUnknowns):
            shape.count_turns(y)
        q = unmirrored(system, self.t, shape.expand(y), lambda q: nearest_pose(self.task, AsIs(system, q)))
        return Pose(AsIs(system, q), q)

    def _upright(self, pose: Pose) -> tuple[Pose, tuple[str, ...]]:
        """The pose, or that in which bodies without initial values are not upside down, with a note for each."""
        system, graph, t = self.system, self.graph, self.t
        free, notes, attempts = upside_down.in_loops(system, graph), list[str](), 0
        for name, placement in free.items():
            q = pose.q
            before = upside_down.angles(system, q)[name]
            if abs(before) <= upside_down.UPRIGHT or attempts == upside_down.MOST:
                continue
            change = upside_down.turned_round(system, graph, placement, t, q)
            if change is None:
                continue
            attempts += 1
            turns = dict(system.tables.first_angles)
            upside_down.follow_turns(system, q, change)
            try:
                found = self._pose(AsIs(system, system.moved(q, change)))
                other = found.q
            except (InitialisationError, TimeoutError):
                other = q
            if upside_down.is_upright(system, placement, graph, q, other):
                pose = found
                after = upside_down.angles(system, other)[name]
                notes.append(upside_down.TAKEN.format(name, np.rad2deg(after), np.rad2deg(before)))
            else:
                for node, angle in turns.items():
                    system.set_first_angle(node, angle)
        return pose, tuple(notes)

    def _reaching(self, pose: Pose) -> tuple[Pose, tuple[str, ...]]:
        """The pose, or that in which telescopic legs without initial values are not turned round, with notes."""
        system, t = self.system, self.t
        legs = telescopes.positions(system) if isinstance(pose.shape, AsIs | PlanarUnknowns) else {}
        before = telescopes.values_at(system, legs, t, pose.q) if legs else np.empty(0)
        if not (before < 0.0).any():
            return pose, ()
        away = [name for name, s in zip(legs, before, strict=True) if s < 0.0]
        other = AsIs(system, telescopes.turned_round(system, away, t, pose.q))
        try:
            found = self._pose(other)
        except (InitialisationError, TimeoutError):
            return pose, ()
        after = telescopes.values_at(system, legs, t, found.q)
        if not after.min() > before.min() + telescopes.SAME * system.tables.size:
            return pose, ()
        each = zip(legs, before, after, strict=True)
        return found, tuple(telescopes.TAKEN.format(name, new, old) for name, old, new in each if old < 0.0)

    def _flat(self, shape: PlanarUnknowns) -> bool:
        """Whether constraints and initial values are those of a mechanism in the plane, at its guess."""
        system, t, given = self.system, self.t, self.task.given
        q = shape.expand(shape.start)
        value, d_q, _v = stack(system, given, t, q, np.zeros(system.n))
        r = np.concatenate([system.Phi(t, q), misses(value, given)])
        return shape.suits(*without_units(stacked(system.Phi_q(t, q), d_q), r, system.tables.scale))
