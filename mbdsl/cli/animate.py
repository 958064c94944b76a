"""mbdsl animate: a page that shows the motion of a model or of a result."""

from __future__ import annotations

import argparse
from pathlib import Path

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._runs import of_arguments
from mbdsl.cli.simulate import add_options as add_options
from mbdsl.errors import UsageError
from mbdsl.messages import count
from mbdsl.storage import output_files


def _arrows(text: str) -> tuple[str, ...]:
    """Groups of arrows."""
    found = () if text.strip() == "none" else tuple(values.names(text))
    for group in found:
        if group not in ("forces", "reactions"):
            raise argparse.ArgumentTypeError(f"`{text}`: expected forces, reactions, both with a comma, or none")
    return found


COMMAND = Command(
    "show the motion of a model or of a result as a page or a film",
    "Write one HTML page that plays the motion of a model or of a result of `mbdsl simulate`. The page loads nothing "
    "and can be mailed; it works in every browser, also on a phone. Or write a film.",
    """
    model MODEL|RESULT  the model's file (.mbd), or a result (.npz) of mbdsl simulate
    @changes
    --result FILE  result of the model, of a format that does not contain the model (.csv, ...)
    @method_and_option step tol start stop interval
    --signals PATTERN,...  signals to plot with the motion (globs, expressions); default: coordinates, velocities,
        signals of elements
    @units
    --trace FRAME,...  frames and bodies whose path is drawn
    --arrows GROUP,...  arrows in a film, or in a page when it opens: forces, reactions, both, or none; default: forces
    --ghost RESULT  another result, which is drawn pale behind the motion at the same time
    --out FILE  a page (.html) or a film (.gif, .mp4); default: the name of the model or result + .html
    --view {iso,front,side,top}  of a model in space; default: iso, from above
    @size
    @quiet
    """,
    arrows={"type": _arrows, "default": ("forces",)},
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.reporting.shown_runs import check_ghost
    from mbdsl.reporting.views import animate
    from mbdsl.viewing.saved_page import PAGES, SavedPage
    from mbdsl.viewing.stored_result import is_result

    out = args.out or f"{values.stem(args)}.html"
    output_files.suffix_of(out, SavedPage.suffixes)
    size = values.size_of(args, out)
    output_files.check([out], [path for path in (args.model, args.result, args.ghost) if path])
    stored = is_result(args.model)
    check_ghost(args.ghost)
    shown, failure = args.model, None
    if stored or args.result:
        if not (stored and args.result):
            _refuse(args, stored)
        if not stored:
            shown = values.load_model(args)
    else:
        shown, failure = of_arguments(args, out)
    page = animate(
        shown,
        signals=values.signals(args),
        traces=values.names(args.trace) if args.trace else (),
        ghost=args.ghost,
        arrows=args.arrows,
        view=args.view,
        result=args.result,
        units=args.units,
    )
    page.save(out, size)
    if not args.quiet:
        motion = page.motion
        frames = f"{count(len(motion.t), 'frame')} of " if Path(out).suffix.lower() in PAGES else ""
        print(values.written(out, f"{values.file_size(out)}, {frames}{motion.t[-1] - motion.t[0]:.6g} s"))
    if failure is not None:
        raise failure
    return 0


def _refuse(args: argparse.Namespace, stored: bool) -> None:
    """Options of a simulation, which a result excludes."""
    given = [name for name in ("method", "step", "tol", "start", "stop", "interval") if getattr(args, name) is not None]
    given += ["option"] if args.option else []
    if stored:
        given += [name for name in ("model_name", "set", "without") if getattr(args, name)]
    if given:
        raise UsageError(
            f"--{given[0].partition('_')[0]} belongs to a simulation, and the result is computed already",
            hint="give the model alone to simulate it",
        )
