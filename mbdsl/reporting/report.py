"""A report of a run: the model, its picture, graph, effects, statistics, signals, energy, constraints and motion."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import cached_property

from mbdsl.errors import MbdslError, UsageError
from mbdsl.explanation.receipt import explain
from mbdsl.mechanism.graph import build
from mbdsl.plotting.html_tables import frame
from mbdsl.reporting import report_page
from mbdsl.reporting.findings import Findings
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage.output_files import check, write_text
from mbdsl.viewing.structure import structure

SUFFIXES = (".html", ".htm")
HEIGHT = 700  #: of the frame in a notebook [px]


class Report(Findings):
    """A report of a run as one HTML page that loads nothing.

    ``report`` makes it. A notebook shows it below the cell that returns it.

    Attributes
    ----------
    trajectory : Trajectory
        The run.
    structure : Structure
        The graph of the mechanism.
    receipt : Receipt or None
        The effects of the model and their costs; None if they could not be found.
    modes : Modes or None
        Eigenmodes, if they were requested and found.
    signals : sequence of str or None
        Names and glob patterns of the plotted signals.
    command : str
        The command that repeats the report.
    problems : list of str
        Reasons why a part is missing.
    """

    def __repr__(self) -> str:
        return f"<Report on {self.trajectory.scene.name}: {len(self.trajectory)} points, {self.trajectory.status}>"

    @cached_property
    def html(self) -> str:
        """The page as the text of one HTML file."""
        return report_page.page(self)

    def _repr_html_(self) -> str:
        """The page in a frame of its own, for notebooks."""
        return frame(self.html, HEIGHT)

    def save(self, path: str | os.PathLike) -> None:
        """Write the page to a file.

        Parameters
        ----------
        path : path
            The file, ``.html``.

        Raises
        ------
        UsageError
            If the suffix is another one, the file cannot be written, or the model was read from it.
        """
        check_suffix(path)
        check([path], self.trajectory.scene.files)
        write_text(path, self.html)


def check_suffix(path: str | os.PathLike) -> None:
    """Check the suffix of a report.

    Raises
    ------
    UsageError
        If it is not that of a page.
    """
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"a report is a page: `{path!s}` does not end with .html")


def report(
    trajectory: Trajectory,
    signals: Sequence[str] | None = None,
    eigen: str | float | None = None,
    *,
    command: str = "",
    announce: Callable[[str], None] | None = None,
) -> Report:
    """Make a report of a run.

    Parameters
    ----------
    trajectory : Trajectory
        The run.
    signals : sequence of str, optional
        Names and glob patterns of signals to plot. Default: those of ``Trajectory.plot``.
    eigen : str or float, optional
        State about which eigenmodes are computed: "static", "start" or a time [s]. Default: no eigenmodes.
    command : str, optional
        The command that repeats the report.
    announce : callable, optional
        Receives a line if code has to be compiled.

    Returns
    -------
    Report
        Its ``save`` writes the page.

    Raises
    ------
    UsageError
        If the trajectory is empty or a pattern matches no signal.
    """
    if not len(trajectory):
        raise UsageError("the trajectory is empty: there is nothing to report")
    if signals is not None:
        trajectory.select(signals)
    scene, problems = trajectory.scene, list[str]()
    found = Report(trajectory, structure(build(scene), True, announce), None, signals=signals, command=command)
    try:
        found.receipt = explain(scene, method=trajectory.stats.get("method"), announce=announce)
    except MbdslError as problem:
        problems.append(f"the effects are not known: {problem.message}")
    if eigen is not None:
        from mbdsl.analysis.eigenmodes import eigen as eigenmodes

        try:
            found.modes = eigenmodes(scene, eigen, announce=announce)
        except MbdslError as problem:
            problems.append(f"there are no eigenmodes: {problem.message}")
    found.problems += problems
    return found
