"""What a run prints: its steps, error, peaks between outputs, extremes, and guesses that the assembly has changed."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from mbdsl.messages import count, few, visible

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mbdsl.initial.consistent import Moved
    from mbdsl.simulation.streaming import Stream
    from mbdsl.simulation.trajectory import Trajectory

MOST_PEAKS = 3  #: number of peaks between outputs that are printed
MOST_EXTREMES = 12  #: number of signals whose extremes are printed without --verbose


def print_warnings(trajectory: Trajectory, quiet: bool) -> None:
    for text in trajectory.stats.get("warnings", ()):
        print(f"warning: {text}", file=sys.stderr)
    if trajectory.undetermined and not quiet:
        where = ", ".join(f"{t:g}" for t in trajectory.undetermined[:5])
        more = " ..." if len(trajectory.undetermined) > 5 else ""
        print(f"accelerations and reactions have no value (nan) at t = {where}{more} s", file=sys.stderr)


def summary(trajectory: Trajectory, output: str, names: list[str], verbose: bool, stream: Stream | None = None) -> str:
    from mbdsl.integrators import compiled

    rows = stream.file.count if stream and stream.file else len(trajectory.t)
    stats, seconds = trajectory.stats, trajectory.stats["seconds"]
    steps, iterations = stats["steps"], stats["iterations"]
    reached = trajectory.t[-1] if len(trajectory.t) else 0.0
    work, what = (stats["evaluations"], "evaluation") if stats["evaluations"] else (iterations, "iteration")
    each = work / max(1, steps)
    per_step = f" ({each:.{2 if each < 10 else 0}f} a step)" if steps else ""
    known = error(stats) if steps or stats["status"] == "done" else "no step was accepted"
    lines = [
        f"{trajectory.scene.name}: {count(steps, 'step')} of {stats['method']} to t = {reached:g} s, "
        f"{count(work, what)}{per_step}, in {seconds['integrate']:.3g} s; {known}",
        f"{visible(output, line=True)}: {count(rows, 'row')}, time and {count(len(names), 'signal')}",
    ]
    if acted := stats.get("acted"):
        first, most = next(iter(acted.items()))
        where = f"line {first}" if first[:1] != "`" and ":" in first else first
        kinds = ", ".join(f"{n} {kind}" for kind, n in stats["kinds of events"].items())
        lines.append(f"{count(sum(acted.values()), 'event')} ({kinds}); most of them by {where}: {most}")
    if stats.get("terminated"):
        lines.append(f"ended by terminate at t = {reached:.9g} s: {stats['terminated']}")
    peaks = trajectory.cut_peaks(names)
    lines += [f"note: {peak.text(trajectory.display)} (--interval 0 writes every step)" for peak in peaks[:MOST_PEAKS]]
    if len(peaks) > MOST_PEAKS:
        lines.append(f"note: outputs cut {len(peaks) - MOST_PEAKS} more peaks")
    if chosen := stats.get("chosen"):
        lines[0] += f"; {chosen}"
    if (line := _pivoting(trajectory, verbose)) is not None:
        lines.append(line)
    if found := stats.get("accuracy"):
        lines.append(
            f"accuracy {found['asked']:g}: estimated error {found['estimated']:.1e} ({found['by']}); "
            + (f"checked by {found['checked by']}" if found["checked by"] else f"not checked: {found['not checked']}")
        )
    if verbose:
        sizes = ", ".join(f"{key} = {stats[key]}" for key in ("n", "m", "p"))
        rejected = stats["rejected"] or (0 if stats["method"] in compiled() else None)
        counts = f"{stats['matrix_evaluations']} matrices, {stats['factorisations']} factorisations"
        refused = "rejected steps not counted" if rejected is None else f"{rejected} steps rejected"
        lines.append(f"{sizes}; {refused}, {counts}")
        lines.append("seconds: " + ", ".join(f"{phase} {spent:.3g}" for phase, spent in seconds.items()))
        lines += [_moved(m.shown(trajectory.display)) for m in trajectory.moved]
    elif trajectory.moved:
        lines.append(guesses([m.shown(trajectory.display) for m in trajectory.moved]))
    return "\n".join(lines)


def _pivoting(trajectory: Trajectory, verbose: bool) -> str | None:
    """Why equations are solved with a search for pivots; None if they are not, or only since a body has no inertia."""
    from mbdsl.system.massless import bodies_without_inertia

    since = trajectory.stats["pivoting_from"]
    if since is None:
        return None
    light = bodies_without_inertia(trajectory.system.tables)
    if not light or since > trajectory.t[0]:
        return (
            f"from t = {since:g} s on, equations are solved with a search for pivots: rows nearly depend on each other"
        )
    why = f"of {few(light)} a coordinate has no inertia, and joints or springs hold it"
    return f"equations are solved with a search for pivots: {why}" if verbose else None


def extreme_lines(trajectory: Trajectory, names: Sequence[str], verbose: bool) -> list[str]:
    """The extremes of signals over all steps, as a table."""
    shown = names if verbose else names[:MOST_EXTREMES]
    lines = str(trajectory.extremes(shown)).splitlines()
    left = f"... {len(names) - len(shown)} more signals (--verbose lists all)"
    return ["over all steps:", *lines, *([left] if len(shown) < len(names) else [])]


def error(stats: dict) -> str:
    """The error estimate of a run, as a text."""
    from mbdsl.simulation.result_checks import LITTLE_KNOWN

    if found := stats.get("accuracy"):
        return f"estimated error {found['estimated']:.1e}"
    if stats.get("error") is None:
        return "error not known (--tol controls it, --verify checks it)"
    if stats.get("status") == "inaccurate" and stats["error"] >= LITTLE_KNOWN:
        return "error not known"  # the message gives the time
    return f"estimated error {stats['error']:.1e}"


def guesses(moved: Sequence[Moved]) -> str:
    """One line about the guesses that the assembly has changed, with the largest change."""
    most = max(moved, key=lambda m: abs(m.value - m.guess))
    furthest = "" if len(moved) == 1 else "furthest "
    shown = f"{furthest}{most.change()} (--verbose lists all)"
    return f"{count(len(moved), 'guess', 'guesses')} moved: {shown}"


def _moved(m: Moved) -> str:
    guess, value = m.texts(9)
    return f"initial value of {m.name}: guessed {guess}, found {value}"
