"""The animation of a trajectory: a page that can be written to a file and that a notebook shows."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable, Sequence
from functools import cached_property

from mbdsl.errors import UsageError
from mbdsl.messages import did_you_mean, duration
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage.output_files import check, write_text, writing
from mbdsl.version import __version__
from mbdsl.viewing import page
from mbdsl.viewing.motion import Motion, motion
from mbdsl.viewing.shapes import drawing
from mbdsl.viewing.signals import signals
from mbdsl.viewing.vectors import vectors

PAGES, FILMS = (".html", ".htm"), (".gif", ".mp4")
HEIGHT = 560  #: of the frame in a notebook [px]


class Animation:
    """An animation of a planar mechanism, as one HTML page that loads nothing.

    ``Trajectory.animate`` makes it. A notebook shows it below the cell that returns it.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    patterns : iterable of str or None
        Names and glob patterns of the signals that are plotted with the motion.
    traced : sequence of str
        Names of frames and bodies whose path is drawn.
    ghost : Trajectory, optional
        Another motion, which is drawn pale behind the first.

    Attributes
    ----------
    motion : Motion
        The poses of all bodies at the frames of the page.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        patterns: Iterable[str] | None,
        traced: Sequence[str],
        ghost: Trajectory | None = None,
    ) -> None:
        self.motion: Motion = motion(trajectory)
        self._ghost = None if ghost is None else motion(ghost)
        self._trajectory, self._patterns = trajectory, None if patterns is None else list(patterns)
        self._traced = [_point(self.motion, name) for name in traced]

    def __repr__(self) -> str:
        span = f"{self.motion.t[0]:g} ... {self.motion.t[-1]:g} s"
        return f"<Animation of {self.motion.scene.name}: {len(self.motion.t)} frames, {span}>"

    @cached_property
    def html(self) -> str:
        """The page as the text of one HTML file."""
        drawn = drawing(self.motion)
        data = page.document(
            self.motion,
            drawn,
            signals(self._trajectory, self._patterns),
            vectors(self._trajectory, self.motion),
            self._traced or drawn.paths,
            self._about(),
            None if self._ghost is None else (self._ghost, drawing(self._ghost)),
        )
        return page.html(data)

    def _about(self) -> list[tuple[str, str]]:
        trajectory, stats = self._trajectory, self._trajectory.stats
        rows = f"{len(trajectory.t)} stored, {len(self.motion.t)} shown"
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

    def _repr_html_(self) -> str:
        """The page in a frame of its own, for notebooks."""
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts allow-modals" width="100%" '
            f'height="{HEIGHT}" style="border: 1px solid #8888; border-radius: 6px" loading="lazy"></iframe>'
        )

    def save(self, path: str | os.PathLike, size: tuple[int, int] = (640, 400)) -> None:
        """Write the page or a film.

        Parameters
        ----------
        path : path
            The file: a page for ``.html``, a film for ``.gif`` or ``.mp4``.
        size : (int, int), optional [px]
            Width and height of a film.

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, the model was read from it, or a film needs a package
            or a program that is missing.
        """
        suffix = check_suffix(path)
        check([path], self.motion.scene.files)
        if suffix in PAGES:
            write_text(path, self.html)
            return
        from mbdsl.viewing.film import film

        content = film(self.motion, suffix, *size, traced=self._traced or drawing(self.motion).paths)
        with writing(path) as stream:
            stream.write(content)


def check_suffix(path: str | os.PathLike) -> str:
    """The suffix of a page or a film.

    Raises
    ------
    UsageError
        If it is unknown.
    """
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix not in (*PAGES, *FILMS):
        raise UsageError(f"unknown suffix of the animation `{path!s}`", hint=f"known are {', '.join((*PAGES, *FILMS))}")
    return suffix


def animate(
    trajectory: Trajectory,
    signals: Iterable[str] | None = None,
    traces: Sequence[str] = (),
    ghost: Trajectory | None = None,
) -> Animation:
    """Animate a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    signals : iterable of str, optional
        Names and glob patterns of the signals that are plotted with the motion. Default: coordinates, velocities and
        signals of elements that change.
    traces : sequence of str, optional
        Names of frames and bodies whose path is drawn.
    ghost : Trajectory, optional
        Another motion, which is drawn pale behind the first at the same time.

    Returns
    -------
    Animation
        The page.

    Raises
    ------
    UsageError
        If the trajectory is empty or a name is unknown.
    """
    return Animation(trajectory, signals, traces, ghost)


def _point(motion: Motion, name: str) -> str:
    """The name of a frame, from its own, another name of it, or that of its body."""
    name_ = motion.scene.aliases.get(name, name)
    for known in (name_, f"{name_}.c"):
        if known in motion.spots:
            if motion.spots[known].track < 0:
                raise UsageError(f"`{name}` does not move: it has no path", hint="give a frame of a body")
            return known
    raise UsageError(f"there is no frame `{name}` in {motion.scene.name}", hint=did_you_mean(name, motion.spots))
