"""The page of a report: its sections, each of which is left out if it would be empty."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mbdsl.analysis.operating_points import about
from mbdsl.explanation.receipt_text import cells, head, remarks
from mbdsl.messages import count, duration
from mbdsl.plotting.documents import asset, document, frame, sheet
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figures import Figure, TextTable
from mbdsl.plotting.pages import fine_print, fragments
from mbdsl.reporting import run_figures
from mbdsl.reporting.findings import Findings
from mbdsl.reporting.highlighting import highlighted
from mbdsl.reporting.mode_pictures import mode_pictures
from mbdsl.simulation.extremes import Extremes
from mbdsl.version import __version__
from mbdsl.viewing import structure_files, structure_svg
from mbdsl.viewing.animation import animate
from mbdsl.viewing.projection import pictured
from mbdsl.viewing.svg_picture import still

HERE = Path(__file__).parent
MOST_MODES = 6  #: number of modes with a picture
POSES, MANY_BODIES = 7, 60  #: poses in the picture of the mechanism, and number of bodies up to which there are several


@dataclass
class Section:
    """A part of the page: HTML, and figures and tables, in their order."""

    key: str
    title: str
    content: list[str | Figure | TextTable] = field(default_factory=list)


def page(report: Findings) -> str:
    """The page of a report.

    Returns
    -------
    str
        HTML.
    """
    frames: list[str] = []
    scene = report.trajectory.scene
    panels, looks, notes = run_figures.signal_figures(report.trajectory, report.signals)
    drifts = [*run_figures.energy_figures(report.trajectory), run_figures.constraint_figure(report.trajectory)]
    sections = [
        _extremes(report, panels),
        _mechanism(report),
        _motion(report, frames),
        Section("graph", "Graph", list(structure_files.section(report.structure))),
        _model(report),
        Section("signals", "Signals", [*panels, *(_paragraph(note, "note") for note in notes)]),
        Section("drift", "Energy and constraints", [f for f in drifts if f is not None]),
        _effects(report),
        _run(report),
        _modes(report, frames),
        Section("repeat", "How to repeat it", ["\n".join(fine_print(report.facts())).replace(REPEAT, "", 1)]),
    ]
    sections = [section for section in sections if section.content]
    items = [item for section in sections for item in section.content if not isinstance(item, str)]
    colours, drawn = fragments(items, {**looks, **run_figures.looks(drifts)})
    body = [f"<h1>{escape(scene.name)}</h1>", *_lead(report)]
    body.append(f"<nav>{''.join(f'<a href=#{s.key}>{escape(s.title)}</a>' for s in sections)}</nav>")
    parts = iter(drawn)
    for section in sections:
        body.append(f'<section id="{section.key}"><h2>{escape(section.title)}</h2>')
        body += [item if isinstance(item, str) else next(parts) for item in section.content]
        body.append("</section>")
    styles = [sheet(), colours, structure_svg.style(), asset("report.css", HERE)]
    return document(f"Report on {scene.name}", body, styles, [asset("page.js")], frames)


REPEAT = "<h2>How to repeat it</h2>\n"  #: the heading of the fine print; the section has its own


def _paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def _lead(report: Findings) -> Iterator[str]:
    trajectory, stats = report.trajectory, report.trajectory.stats
    if trajectory.scene.doc:
        yield _paragraph(trajectory.scene.doc)
    text = f"{count(len(trajectory), 'state')} from t = {trajectory.t[0]:g} s to {trajectory.t[-1]:g} s"
    if stats.get("method"):
        text += f" by {stats['method']}"
    if (error := stats.get("error")) is not None and trajectory.status != "inaccurate":
        text += f", estimated error {error:.1e}"
    yield _paragraph(f"{text}; mbdsl {__version__}.", "note")
    if trajectory.status != "done":
        yield _paragraph(f"Status: {trajectory.status}. {trajectory.message}".strip(), "warning")
    for text in (*stats.get("warnings", ()), *report.problems):
        yield _paragraph(f"Warning: {text}", "warning")


def _extremes(report: Findings, panels: Sequence[Figure]) -> Section:
    """A table of the signals that are plotted."""
    known = report.trajectory
    names = dict.fromkeys(s.name for panel in panels for s in panel.series if s.name in known)
    found = known.extremes([*names]) if names else Extremes([])
    note = "; ".join(found.remarks())
    return Section("extremes", "Extremes over all steps", [found.table(note)] if found else [])


def _mechanism(report: Findings) -> Section:
    moving = pictured(report.trajectory, POSES)
    name = report.trajectory.scene.name
    behind = range(len(moving.t) - 1, 0, -1) if len(report.trajectory.scene.bodies()) <= MANY_BODIES else ()
    title = f"{name} at t = {moving.t[0]:g} s"
    more = ", and pale at later times" if behind else ""
    picture = still(moving, 0, "picture", title, behind)
    caption = f'<figcaption class="note">{escape(title)}{more}.</figcaption>'
    content = f'<figure class="picture"><div class="scroll">{picture}</div>{caption}</figure>'
    return Section("mechanism", "Mechanism", [content])


def _motion(report: Findings, frames: list[str]) -> Section:
    frames.append(animate(report.trajectory, report.signals).html)
    note = _paragraph("The animation plays in the page on a screen; it is not printed.", "note on-paper")
    return Section(
        "motion", "Motion", [f'<div class="frame">{frame(frames[-1], "animation of the motion")}</div>', note]
    )


def _model(report: Findings) -> Section:
    found = Section("model", "Model")
    files = list(report.trajectory.scene.files.items())
    for k, (name, text) in enumerate(files):
        code = highlighted(text if k == 0 or name.endswith(".mbd") else _head(text))
        title = escape(os.path.basename(name))
        found.content.append(
            f"<p><code>{title}</code></p>{code}" if k == 0 else f"<details><summary>{title}</summary>{code}</details>"
        )
    rows = list(run_figures.rows_of_parameters(report.trajectory))
    if rows:
        found.content.append(TextTable("Parameters", ("name", "value", "unit", "description"), rows))
    left_out = list(report.trajectory.scene.without)
    if left_out:
        found.content.append(_paragraph(f"Left out on request: {', '.join(left_out)}."))
    return found


def _head(text: str, most: int = 8) -> str:
    """The first lines of a file of numbers."""
    lines = text.splitlines()
    return "\n".join(lines[:most] + ([f"... ({len(lines)} lines)"] if len(lines) > most else []))


def _effects(report: Findings) -> Section:
    found = Section("effects", "Effects and costs")
    if report.receipt is not None:
        names, *rows = cells(report.receipt)
        lines = [line for line in remarks(report.receipt) if line]
        found.content += [_paragraph(line) for line in head(report.receipt)]
        plain = [line for line in lines if line.startswith("a step")]
        rest = "\n".join(line for line in lines if line not in plain)
        found.content += [TextTable("", names, rows), *map(_paragraph, plain), f"<pre>{escape(rest)}</pre>"]
    return found


def _run(report: Findings) -> Section:
    stats = report.trajectory.stats
    rows = []
    names = {"steps": "steps", "rejected": "rejected steps", "events": "restarts", "iterations": "Newton iterations"}
    names |= {"evaluations": "evaluations", "matrix_evaluations": "matrices", "factorisations": "factorisations"}
    for key, label in (("method", "method"), ("tol", "tolerance"), ("error", "estimated error")):
        if (value := stats.get(key)) is not None:
            rows.append((label, value if isinstance(value, str) else f"{value:.3g}"))
    if stats.get("h"):
        rows.append(("step", duration(stats["h"])))
    rows += [(label, str(stats[key])) for key, label in names.items() if stats.get(key)]
    if kinds := stats.get("kinds of events"):
        rows.append(("events", ", ".join(f"{n} {kind}" for kind, n in kinds.items())))
    if stats.get("terminated"):
        rows.append(("ended by terminate", stats["terminated"]))
    if solved := stats.get("solved"):
        sizes = ", ".join(f"{key} = {stats[key]}" for key in ("n", "m", "p"))
        rows.append(("unknowns as written", sizes))
        sizes = ", ".join(f"{key} = {solved[key]}" for key in ("n", "m", "p"))
        rows.append(("unknowns as solved", f"{sizes}, parts = {solved.get('parts', 1)}"))
    rows += [(f"time to {key}", duration(value)) for key, value in stats.get("seconds", {}).items() if value]
    found = Section("run", "Run", [TextTable("", ("quantity", "value"), rows)] if rows else [])
    moved = report.trajectory.moved
    if moved:
        cells = [(m.name, *m.shown(report.trajectory.display).texts(9)) for m in moved]
        found.content.append(TextTable("Initial values that were guessed", ("name", "guess", "found"), cells))
    return found


def _modes(report: Findings, frames: list[str]) -> Section:
    found = Section("modes", "Eigenmodes")
    modes = report.modes
    if modes is None:
        return found
    state = f"the {about(modes.at, modes.t)}"
    found.content.append(
        _paragraph(f"Small motions about {state}." if len(modes) else f"There are none about {state}.")
    )
    hertz = report.trajectory.display.of("Hz")
    rows: Sequence[tuple[str, ...]] = [
        (
            str(k),
            f"{mode.frequency / hertz.factor:.6g}",
            f"{mode.damped_frequency / hertz.factor:.6g}",
            f"{mode.damping if abs(mode.damping) > 1e-9 else 0.0:.4g}",
            ", ".join([f"{name} {part:.0%}" for name, part in mode.bodies.items() if part >= 0.05][:4]),
            "unstable" if mode.unstable else "moves freely" if mode.omega == 0.0 else "",
        )
        for k, mode in enumerate(modes, 1)
    ]
    columns = ("mode", f"frequency [{hertz.symbol}]", f"damped [{hertz.symbol}]", "damping ratio", "moving bodies", "")
    if rows:
        found.content.append(TextTable("", columns, rows))
        frames.append(modes.animate().html)
        found.content.append(f'<div class="frame">{frame(frames[-1], "animation of the eigenmodes")}</div>')
        found.content.append(f'<div class="modes">{"".join(mode_pictures(modes, MOST_MODES))}</div>')
    found.content += [_paragraph(f"Note: {text}", "note") for text in modes.notes]
    return found
