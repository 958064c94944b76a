"""mbdsl plot: signals of results, over the time or against a signal, to a file or in characters."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import can_write
from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Scene
from mbdsl.plotting.terminal_text import coloured
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.plotting.signal_plots import Plot
    from mbdsl.results.stored import Result
    from mbdsl.simulation.trajectory import Trajectory

MODEL = ".mbd"
BRAILLE = "⠿┤─−"  #: characters that the encoding of the terminal needs, or ASCII is used


COMMAND = Command(
    "plot signals of results",
    "Plot signals of results: to a file, or without --out in characters on the terminal.",
    f"""
    results RESULT  result file ({{results}}), or a model ({MODEL}), which is simulated with its own settings
    @model_name
    --signals PATTERN,...  signals to plot (globs, expressions); default: coordinates of joints, drivers, free bodies
        that change
    --against SIGNAL  signal on the horizontal axis; default: the time
    --difference  the second and further results minus the first, at its times
    --spectrum  amplitude spectra over the frequency
    --along PATTERN,...  signals along an array (`joint[:].tau`), or in the sections of a rod or beam (`beam.M`), at the
        times --at, as a table or with --out as a plot
    --at TIME,...  times of --along; default: the end
    @units
    --out FILE  picture or page: .png, .pdf (extra `plot`), .svg, .html; with --along also a table: .csv, .md, .tex
    | --list  print the names and units of the signals
    """,
    results={"nargs": "+"},
    at={"type": values.list_of(values.seconds), "default": None},
)


def run(args: argparse.Namespace) -> int:
    if args.out:
        from mbdsl.plotting import profiles, signal_plots

        known = profiles.SUFFIXES if args.along else signal_plots.SUFFIXES
        output_files.suffix_of(args.out, known)  # never that of a model, or of a result in its place
        output_files.check([args.out], args.results)
    if args.model_name and not any(Path(name).suffix.lower() == MODEL for name in args.results):
        raise UsageError("--model belongs to a model, and these are results", hint="omit --model")
    if args.along or args.at:
        return _along(args)
    from mbdsl.reporting.shown_runs import check_plotted, computed, source

    patterns = values.signals(args)
    sources = [source(name, patterns) for name in args.results]
    if not args.list:
        check_plotted(sources, args.results, patterns, args.against, args.spectrum)
    opened, failure = computed(sources, args.results, patterns, args.units, _computed)
    if args.list:
        _list(opened)
    else:
        from mbdsl.plotting.signal_plots import plot

        shown = plot(opened, patterns, against=args.against, difference=args.difference, spectrum=args.spectrum)
        if args.out:
            _save(shown, args.out)
        else:
            show(shown)
    if failure:
        raise failure
    return 0


def _computed(scene: Scene) -> tuple[Trajectory, BaseException | None]:
    """The run of a model with its own settings, and the error that ended it early."""
    from mbdsl.cli._runs import kept
    from mbdsl.cli._summary import print_warnings

    trajectory, failure = kept(scene, quiet=False)
    if isinstance(failure, KeyboardInterrupt):
        raise failure
    print_warnings(trajectory, quiet=True)
    return trajectory, failure


def _along(args: argparse.Namespace) -> int:
    """Profiles: a table on the terminal, or a plot in a file."""
    from mbdsl.lang.asked_signals import AskedSignals
    from mbdsl.lang.display_units import asked
    from mbdsl.plotting.profiles import of_result
    from mbdsl.reporting.shown_runs import source
    from mbdsl.simulation import profiles

    if not args.along:
        raise UsageError("--at belongs to --along", hint="write --along 'joint[:].tau' --at 1.2s")
    others = ("signals", "against", "difference", "spectrum", "list")
    if given := [f"--{name}" for name in others if getattr(args, name)]:
        raise UsageError(f"--along and {given[0]} exclude each other")
    if len(args.results) > 1:
        raise UsageError(f"--along takes one result, found {len(args.results)}")
    patterns, failure = values.patterns(args.along), None
    found = source(args.results[0])
    if isinstance(found, Scene):
        profiles.check(AskedSignals(found), patterns)
        trajectory, failure = _computed(found)
        shown = profiles.along(trajectory.in_units(args.units), patterns, args.at)
    else:
        found.display = asked(args.units, found.display)
        shown = of_result(found, patterns, args.at)
    if args.out:
        _save(shown, args.out)
    else:
        print(shown)
    if failure:
        raise failure
    return 0


def _list(opened: list[Result]) -> None:
    """Names and units, of several results each name once."""
    units: dict[str, str] = {}
    for result in opened:
        for name in result.names:
            units[name] = units.get(name) or result.display.of(result.unit(name), name).symbol
    for name, unit in units.items():
        print(f"{name} [{unit}]" if unit else name)


def _save(plot: Plot, out: str) -> None:
    """Write a plot, and print its file, what it shows and its notes."""
    plot.save(out)
    print(values.written(out, ", ".join(panel.y_label for panel in plot.panels)))
    for note in plot.notes:
        print(note)


def show(plot: Plot) -> None:
    """Print a plot in characters."""
    from mbdsl.plotting.characters import COLUMNS, text

    stream, terminal = sys.stdout, sys.stdout.isatty()
    size = shutil.get_terminal_size((COLUMNS, 24)) if terminal else os.terminal_size((COLUMNS, 0))
    shown = text(plot.page(), size.columns, size.lines, coloured(stream), not can_write(BRAILLE))
    getattr(stream, "write_raw", stream.write)(shown + "\n")  # names are escaped by ``text``
