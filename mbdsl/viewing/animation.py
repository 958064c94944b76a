"""The animation of a trajectory: a page that can be written to a file and that a notebook shows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

from mbdsl.elements.kind import JointKind
from mbdsl.errors import UsageError
from mbdsl.lang.modelica_names import PORTS
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean, duration
from mbdsl.plotting.pictures import converted
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.version import __version__
from mbdsl.viewing import page, projection
from mbdsl.viewing.motion import motion
from mbdsl.viewing.overlays import Overlays
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.projection import drawing
from mbdsl.viewing.saved_page import VECTORS, SavedPage
from mbdsl.viewing.shapes import Drawing, behind
from mbdsl.viewing.signals import signals
from mbdsl.viewing.space import shapes as solids
from mbdsl.viewing.space.shapes import SpaceDrawing
from mbdsl.viewing.svg_picture import still
from mbdsl.viewing.tracks import AnyMotion, Motion
from mbdsl.viewing.vectors import FORCES, REACTIONS, Vector, largest, loads, vectors
from mbdsl.viewing.writers import svg


class Animation(SavedPage):
    """An animation of a mechanism, as one HTML page that loads nothing.

    ``Trajectory.animate`` makes it. A notebook shows it below the cell that returns it.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    patterns : iterable of str or None
        Names and glob patterns of the signals that are plotted with the motion.
    traced : sequence of str
        Names of frames, bodies and joints whose path is drawn.
    ghost : Trajectory, optional
        Another motion, which is drawn pale behind the first.
    arrows : str or sequence of str, optional
        Arrows in a film, or in a page when it opens: any of "forces" and "reactions".
    view : str, optional
        Of a model in space: "iso", "front", "side" or "top".

    Attributes
    ----------
    motion : Motion or SpaceMotion
        The poses of all bodies at the frames of the page.
    """

    _one_scale = False  #: whether arrows of forces and reactions have one scale
    _with_loads = False  #: whether weights and forces of springs are among the arrows

    def __init__(
        self,
        trajectory: Trajectory,
        patterns: str | Iterable[str] | None,
        traced: str | Sequence[str],
        ghost: Trajectory | None = None,
        arrows: str | Sequence[str] = (FORCES,),
        view: str | None = None,
    ) -> None:
        scene = trajectory.scene
        if view is not None and not scene.spatial:
            raise UsageError(f"{scene.name} is a planar model, and views are of models in space")
        self._view = view or "iso"
        if scene.spatial:
            projection.view(scene, self._view)  # whether there is one of this name
        self._trajectory, self._patterns = trajectory, None if patterns is None else _several(patterns)
        self.motion: AnyMotion = motion(trajectory)
        self._ghost = None if ghost is None else motion(ghost)
        self._arrows = tuple(_several(arrows))
        for group in self._arrows:
            if group not in (FORCES, REACTIONS):
                hint = f"there are `{FORCES}` and `{REACTIONS}`"
                raise UsageError(f"there are no arrows called `{group}`", hint=hint)
        self._traced = [traced_point(scene, name) for name in _several(traced)]

    def __repr__(self) -> str:
        span = f"{self.motion.t[0]:g} ... {self.motion.t[-1]:g} s"
        return f"<Animation of {self.motion.scene.name}: {len(self.motion.t)} frames, {span}>"

    @cached_property
    def html(self) -> str:
        """The page as the text of one HTML file."""
        drawn, arrows = self._drawing(), self._vectors()
        pale = None
        if (ghost := self._ghost) is not None:
            back = drawn_of(ghost)
            pale = ghost, behind(back, drawn) if isinstance(back, Drawing) and isinstance(drawn, Drawing) else back
        traced = self._traced or (drawn.paths if isinstance(drawn, Drawing) else [])
        data = page.document(self.motion, drawn, signals(self._trajectory, self._patterns), arrows, traced, pale)
        more: dict[str, Any] = {"arrows": self._arrows, "pale": self._pale, "mark": self._mark()}
        more |= {"about": [list(item) for item in self._about()], "largest": largest(arrows, self._one_scale)}
        if self.scene.spatial:  # for browsers without WebGL
            start = projection.projected(self._trajectory, self._view, 2)
            more |= {"view": self._view, "picture": still(start, 0, "still", f"{self.scene.name} at the start")}
        return page.html(data | more)

    def _drawing(self) -> Drawing | SpaceDrawing:
        """The shapes or solids of the page."""
        return drawn_of(self.motion)

    def _vectors(self) -> list[Vector]:
        found = vectors(self._trajectory, self.motion)
        return [*found, *loads(self._trajectory, self.motion)] if self._with_loads else found

    @property
    def _pale(self) -> str:
        """The pale motion in words."""
        return ""

    def _mark(self) -> str:
        """The remark on a run that was not completed, or not to its tolerance."""
        status = self._trajectory.status
        if status == "inaccurate":
            return "The tolerance was not reached."
        if status == "done" or not len(self._trajectory.t):
            return ""
        what = "was interrupted" if status == "interrupted" else "failed"
        return f"The run {what} at t = {self._trajectory.t[-1]:.6g} s."

    def _about(self) -> list[tuple[str, str]]:
        trajectory, stats = self._trajectory, self._trajectory.stats
        rows = f"{stats.get('rows', len(trajectory.t))} stored, {len(self.motion.t)} shown"
        found = [("model", trajectory.scene.name), ("frames", rows)]
        if stats.get("method"):
            found.append(("method", str(stats["method"])))
        if stats.get("h"):
            found.append(("step", duration(stats["h"])))
        if stats.get("tol"):
            found.append(("tolerance", f"{stats['tol']:g}"))
        if trajectory.status != "done":
            found.append(("status", trajectory.status))
        return [*found, ("made by", f"mbdsl {__version__}")]

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.motion.scene

    def _content(self, suffix: str, width: int, height: int) -> bytes:
        flat, drawn = projection.flat(self.motion, self._view), self._drawing()
        shown = [v for v in self._vectors() if v.group in self._arrows]
        if isinstance(flat, projection.Projection):
            drawn, shown = drawing(flat), projection.projected_vectors(shown, flat)
        assert isinstance(drawn, Drawing)
        ghost = None if self._ghost is None else projection.flat(self._ghost, self._view)
        overlays = Overlays(self._traced or drawn.paths, shown, ghost, self._one_scale)
        if suffix in VECTORS:
            picture = svg(Picture(flat, drawn, width, height, overlays).marks(0), width, height)
            return picture.encode() if suffix == ".svg" else converted(picture, suffix)
        from mbdsl.viewing.film import film

        return film(flat, suffix, width, height, overlays, drawn)


def drawn_of(motion: AnyMotion) -> Drawing | SpaceDrawing:
    """The shapes of a motion in the plane, or the solids of one in space."""
    return drawing(motion) if isinstance(motion, Motion) else solids.drawing(motion)


def animate(
    trajectory: Trajectory,
    signals: str | Iterable[str] | None = None,
    traces: str | Sequence[str] = (),
    ghost: Trajectory | None = None,
    arrows: str | Sequence[str] = (FORCES,),
    view: str | None = None,
) -> Animation:
    """Animate a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    signals : str or iterable of str, optional
        Names and glob patterns of the signals that are plotted with the motion. Default: coordinates, velocities and
        signals of elements that change.
    traces : str or sequence of str, optional
        Names of frames, bodies and joints whose path is drawn; that of a joint is the path of its frame_b, or of its
        frame_a if frame_b does not move.
    ghost : Trajectory, optional
        Another motion, which is drawn pale behind the first at the same time.
    arrows : str or sequence of str, optional
        Arrows in a film, or in a page when it opens: any of "forces" and "reactions".
    view : str, optional
        Of a model in space: "iso" (default), "front", "side" or "top".

    Returns
    -------
    Animation
        The page.

    Raises
    ------
    UsageError
        If the trajectory is empty or a name is unknown, or a view is given for a planar model.
    """
    return Animation(trajectory, signals, traces, ghost, arrows, view)


def _several(names: str | Iterable[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def traced_point(scene: Scene, name: str) -> str:
    """The name of a frame whose path can be drawn, from its own or another name of it, or that of a body or joint.

    Raises
    ------
    UsageError
        If there is no frame of this name, or it does not move.
    """
    own = scene.aliases.get(name, name)
    owner, _, port = own.rpartition(".")
    attached = scene.components[own].ports if own in scene.components else {}
    named = scene.components[owner].ports.get(PORTS.get(port, port)) if owner in scene.components else None
    ends = list(attached.values())[::-1]
    known = [x for x in (own, f"{own}.c", named, *ends) if x is not None and x in scene.frames]
    moving = [x for x, frame in scene.frames.items() if scene.components[frame.body].coordinates]
    if (found := next((x for x in known if x in moving), None)) is not None:
        return found
    if known:
        raise UsageError(f"`{name}` does not move: it has no path", hint="give a frame of a body")
    joints = [c.name for c in scene.components.values() if isinstance(c.kind, JointKind)]
    hint = did_you_mean(name, [*moving, *joints], "frames and joints")
    raise UsageError(f"there is no frame or joint `{name}` in {scene.name}", hint=hint)
