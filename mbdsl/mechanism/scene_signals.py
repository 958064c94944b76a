"""The signals of a scene: expressions over its frames, its multipliers and time."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from mbdsl.elements.kind import BodyKind, JointKind, PairKind
from mbdsl.errors import ModelError
from mbdsl.expressions import formulas, spatial_coordinates
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import COORDINATES, RATE, Expr, coordinate, substitute
from mbdsl.mechanism import wrenches
from mbdsl.mechanism.scene_parts import (
    Component,
    Frame,
    Load,
)
from mbdsl.mechanism.signals import ComponentFormulas
from mbdsl.mechanism.sticking import Sticking
from mbdsl.messages import did_you_mean


class SceneSignals:
    """The part of :class:`mbdsl.mechanism.scene.Scene` that follows from the formulas of its kinds."""

    components: Mapping[str, Component]
    frames: Mapping[str, Frame]
    aliases: Mapping[str, str]
    variables: Mapping[str, Expr]
    spatial: bool
    if TYPE_CHECKING:

        @cached_property
        def sticking(self) -> tuple[Sticking, ...]: ...

    def signals(self) -> dict[str, Expr]:
        """Signals of all components, and the variables; those of frames are not listed.

        Returns
        -------
        dict
            Full name -> expression over frames and time, in SI units.
        """
        found = {f"{c.name}.{key}": e for c in self.components.values() for key, e in self.signals_of(c).items()}
        return found | dict(self.variables)

    def signals_of(self, c: Component) -> dict[str, Expr]:
        """All signals of a component, which are formulas of its kind.

        Parameters
        ----------
        c : Component
            A component of this scene.

        Returns
        -------
        dict
            Name, without that of the component -> expression over frames and time, in SI.
        """
        of = self._formulas(c)
        return {key: self._moved(of.signal(key)) for key in c.signals}

    def signal_of(self, c: Component, key: str) -> Expr | None:
        """One signal of a component.

        Parameters
        ----------
        c : Component
            A component of this scene.
        key : str
            The signal's name without that of the component.

        Returns
        -------
        Expr or None
            None if the component has no such signal.
        """
        return self._moved(self._formulas(c).signal(key)) if key in c.signals else None

    def alignment(self, c: Component) -> Expr | None:
        """A number that is positive if the axes of a joint in space have the same sense, and negative if opposite ones.

        Parameters
        ----------
        c : Component
            A component of this scene.

        Returns
        -------
        Expr or None
            None of kinds for which the sense does not matter.
        """
        if not isinstance(c.kind, JointKind) or not c.kind.placing.aligned:
            return None
        return self._moved(self._formulas(c).aligned())

    def signal(self, name: str) -> Expr:
        """A signal by its full name.

        Parameters
        ----------
        name : str
            Name of a signal of a component (``spring.s``), of a signal of a frame (``rod.b.x``), or of a variable.

        Returns
        -------
        Expr
            Expression over frames and time, in SI units.

        Raises
        ------
        ModelError
            If there is none of this name; the message lists the closest.
        """
        if name in self.variables:
            return self.variables[name]
        owner, _, key = name.rpartition(".")
        component = self.components.get(owner)
        if component is not None and key in component.signals:
            return self._moved(self._formulas(component).signal(key))
        frame = self.frames.get(self.aliases.get(owner, owner))
        if frame is None and component is not None and isinstance(component.kind, BodyKind) and component.kind.is_frame:
            frame = self.frames.get(f"{owner}.c")
        if frame is not None and key in (spatial_coordinates.NAMES if self.spatial else COORDINATES):
            return self._coordinate(frame.name, key)
        raise ModelError(f"there is no signal `{name}`", hint=self._closest(name, owner))

    def on_port(self, c: Component, port: str) -> tuple[list[Expr], list[Expr]]:
        """What a joint or force exerts on the body at one of its ports.

        Parameters
        ----------
        c : Component
            A joint or force of this scene.
        port : str
            "frame_a" or "frame_b".

        Returns
        -------
        force, torque : list of Expr [N, N.m]
            At the origin of the frame in world axes: two and one, in space three and three components.
        """
        force, torque = wrenches.on_port(self._formulas(c), port)
        return [self._moved(x) for x in force], [self._moved(x) for x in torque]

    def loads(self, frames: Collection[str]) -> list[Load]:
        """What all joints and forces exert on bodies at some frames.

        Parameters
        ----------
        frames : collection of str
            Names of frames.

        Returns
        -------
        list of Load
            In the order of the components; joints by expressions, such as couplings, act on all frames in these.
        """
        found: list[Load] = []
        for c in self.components.values():
            kind = c.kind
            if isinstance(kind, JointKind) and kind.is_expression:
                exerted = wrenches.of_contact if kind.unilateral else wrenches.of_expressions
                loads = exerted(c.name, c.relations, c.velocity_constraints, self.spatial)
                found += [Load(c.name, x, *loads[x]) for x in loads if x in frames]
            elif isinstance(kind, PairKind) and not kind.contacts:
                for port in (port for port, x in c.ports.items() if x in frames):
                    point = kind.touches if port == "frame_a" else ()
                    place = [self._moved(formulas.evaluate(x, self._formulas(c))) for x in point]
                    found.append(Load(c.name, c.ports[port], *self.on_port(c, port), place))
        return found

    def in_axes(self, force: Sequence[Expr], torque: Sequence[Expr], frame: str) -> dict[str, Expr]:
        """A wrench in world axes by its components in the axes of a frame: fx, fy, tau, in space also fz, tx, ty, tz.

        Parameters
        ----------
        force, torque : list of Expr [N, N.m]
            As of ``on_port``.
        frame : str
            Name of the frame.

        Returns
        -------
        dict
            Name of the component -> expression.
        """
        return wrenches.in_axes(force, torque, lambda key: self._moved(self._coordinate(frame, key)))

    def _formulas(self, c: Component) -> ComponentFormulas:
        found = self._formulas_alone(c)
        if found.sticks:
            found.share(self.sticking)
        return found

    def _formulas_alone(self, c: Component) -> ComponentFormulas:
        def frame_coordinate(port: str, key: str) -> Expr:
            # of frames that drivers move: as in laws, so that a law contains the nodes of the signals that it uses
            return self._moved(self._coordinate(f"{c.name}.c" if port == "c" else c.ports[port], key))

        return ComponentFormulas(c.kind, c.name, c.values.__getitem__, frame_coordinate)

    def _coordinate(self, frame: str, key: str) -> Expr:
        if self.spatial:
            return spatial_coordinates.named(frame, key)
        return coordinate(frame, key)

    def _moved(self, expression: Expr) -> Expr:
        return substitute(expression, self.prescribed) if self._prescribed_frames else expression

    @cached_property
    def _prescribed_frames(self) -> dict[str, tuple[Expr, Expr, Expr]]:
        return {name: frame.motion for name, frame in self.frames.items() if frame.motion is not None}

    def prescribed(self, leaf: Expr) -> Expr | None:
        """A coordinate of a frame that drivers move, as a function of time.

        Parameters
        ----------
        leaf : Expr
            A leaf of an expression.

        Returns
        -------
        Expr or None
            None for leaves that are not such a coordinate.
        """
        if leaf.op != "coordinate":
            return None
        frame, key = leaf.value
        motion = self._prescribed_frames.get(frame)
        if motion is None:
            return None
        return motion[list(RATE).index(key)] if key in RATE else der(motion[list(RATE.values()).index(key)])

    def _closest(self, name: str, owner: str) -> str | None:
        if owner in self.components and (own := [f"{owner}.{key}" for key in self.components[owner].signals]):
            return did_you_mean(name, own, f"`{owner}` has")
        if owner in self.frames or owner in self.aliases:
            return did_you_mean(name, [f"{owner}.{key}" for key in COORDINATES], "it has")
        close = did_you_mean(owner, [*self.components, *self.frames, *self.aliases], "components")
        return close or did_you_mean(name, self.variables)
