"""mbdsl plot: signals of results, over the time or against a signal, to a file or in characters."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mbdsl import results
from mbdsl.cli import _values as values
from mbdsl.cli._progress import Display
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import once, visible
from mbdsl.plotting.terminal_text import coloured
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mbdsl.plotting.signal_plots import Plot
    from mbdsl.results.stored import Result

MODEL = ".mbd"
BRAILLE = "⠿┤─−"  #: characters that the encoding of the terminal needs, or ASCII is used


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "plot",
        help="plot signals of results",
        description="Plot signals of results: to a file, or without --out in characters on the terminal.",
    )
    suffixes = ", ".join(results.formats())
    parser.add_argument(
        "results",
        metavar="RESULT",
        nargs="+",
        help=f"result file ({suffixes}), or a model ({MODEL}), which is simulated with its own settings",
    )
    values.add_model_name(parser)
    parser.add_argument(
        "--signals",
        metavar="PATTERN,...",
        help="signals to plot (globs); default: coordinates of the first three bodies, without constant ones",
    )
    parser.add_argument("--against", metavar="SIGNAL", help="signal on the horizontal axis; default: the time")
    parser.add_argument(
        "--difference", action="store_true", help="the second and further results minus the first, at its times"
    )
    parser.add_argument("--spectrum", action="store_true", help="amplitude spectra over the frequency")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--out", metavar="FILE", help="picture or page: .png, .pdf (extra `plot`), .svg, .html")
    what.add_argument("--list", action="store_true", help="print the names and units of the signals")
    return parser


def run(args: argparse.Namespace) -> int:
    if args.out:
        from mbdsl.plotting.signal_plots import suffix_of

        suffix_of(args.out)  # never that of a result or a model
        output_files.check([args.out])
    if args.model_name and not any(Path(name).suffix.lower() == MODEL for name in args.results):
        raise UsageError("--model belongs to a model, and these are results", hint="omit --model")
    failure: IntegrationError | None = None
    sources = [_source(name) for name in args.results]
    if not args.list:
        _check_names(args, sources)
    opened = []
    for name, source in zip(args.results, sources, strict=True):
        result, problem = _simulated(source, name) if isinstance(source, Scene) else (source, None)
        opened.append(result)
        failure = failure or problem
    if args.list:
        _list(opened)
    else:
        from mbdsl.plotting.signal_plots import plot

        patterns = values.patterns(args.signals) if args.signals else None
        found = plot(opened, patterns, against=args.against, difference=args.difference, spectrum=args.spectrum)
        _show(found, args.out)
    if failure:
        raise failure
    return 0


def _source(name: str) -> Result | Scene:
    """The result in a file, or the model in it."""
    if Path(name).suffix.lower() == MODEL:
        from mbdsl.lang.load import load

        return load(name)
    from mbdsl.results.stored import open_result

    known = {MODEL, *results.formats()}
    if Path(name).suffix.lower() not in known:
        raise UsageError(
            f"`{name}` is neither a result file nor a model", hint=f"known suffixes are {', '.join(sorted(known))}"
        )
    return open_result(name)


def _check_names(args: argparse.Namespace, sources: Sequence[Result | Scene]) -> None:
    """Check the names of signals before models are simulated."""
    if any(isinstance(source, Scene) for source in sources):
        from mbdsl.mechanism.signal_names import SignalNames
        from mbdsl.plotting.signal_plots import check_names

        known = [SignalNames(x).names[1:] if isinstance(x, Scene) else x.names for x in sources]
        patterns = values.patterns(args.signals) if args.signals else None
        check_names(known, args.results, patterns, args.against, args.spectrum)


def _simulated(scene: Scene, name: str) -> tuple[Result, IntegrationError | None]:
    """The result of a model that is simulated, and the failure of its integration.

    Raises
    ------
    KeyboardInterrupt
        If the simulation is interrupted.
    """
    from mbdsl.api import simulated
    from mbdsl.cli.simulate import print_warnings
    from mbdsl.results.stored import of_trajectory

    display, failure = Display(sys.stderr), None
    try:
        trajectory = simulated(scene, progress=display, announce=once(display.say, set()))
    except IntegrationError as problem:
        if problem.trajectory is None or not len(problem.trajectory.t):
            raise
        trajectory, failure = problem.trajectory, problem
    finally:
        display.close()
    if trajectory.status == "interrupted":
        raise KeyboardInterrupt
    print_warnings(trajectory, quiet=True)
    return of_trajectory(trajectory, name), failure


def _list(opened: list[Result]) -> None:
    """Names and units, of several results each name once."""
    units: dict[str, str] = {}
    for result in opened:
        for name in result.names:
            units[name] = units.get(name) or result.unit(name)
    for name, unit in units.items():
        print(f"{name} [{unit}]" if unit else name)


def _show(plot: Plot, out: str | None) -> None:
    if out:
        plot.save(out)
        print(f"{visible(out, line=True)}: {', '.join(panel.y_label for panel in plot.panels)}")
        for note in plot.notes:
            print(note)
        return
    from mbdsl.plotting.characters import COLUMNS, text

    stream, terminal = sys.stdout, sys.stdout.isatty()
    size = shutil.get_terminal_size((COLUMNS, 24)) if terminal else os.terminal_size((COLUMNS, 0))
    shown = text(plot, size.columns, size.lines, coloured(stream), not _braille(stream.encoding))
    getattr(stream, "write_raw", stream.write)(shown + "\n")  # names are escaped by ``text``


def _braille(encoding: str | None) -> bool:
    try:
        BRAILLE.encode(encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
