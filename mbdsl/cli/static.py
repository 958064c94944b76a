"""mbdsl static: the static equilibrium of a model, its reactions and its stability."""

from __future__ import annotations

import argparse

from mbdsl import results
from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import say
from mbdsl.cli.simulate import check_signals

COMMAND = Command(
    "find the static equilibrium of a model",
    "Find the equilibrium that overdamped motion reaches from the initial positions of a model, and print positions, "
    "reactions and stability.",
    """
    @model
    --start T0  time at which drivers and forces are evaluated; default: start time
    --signals PATTERN,...  signals to print or write (globs)
    --output FILE  write one row to a result file ({results})
    @units_of_file
    --show  draw the equilibrium, its forces and the initial positions as a page
    --out FILE  with --show: a page (.html) or a picture (.png, .svg, .pdf); default: NAME-equilibrium.html
    @size
    """,
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.viewing.saved_page import PAGES, PICTURES

    out = values.shown_file(args, "show", "equilibrium", *PAGES, *PICTURES)
    size = values.size_of(args, out)
    if args.output:
        results.format_of(args.output)
    scene = values.load_for(args, [args.output, out])
    if args.signals:
        check_signals(scene, values.patterns(args.signals))

    from mbdsl.analysis.equilibria import listed, static
    from mbdsl.simulation.result_file import about
    from mbdsl.simulation.result_units import converted

    found = static(scene, start=args.start, announce=say)
    point = found.trajectory
    default = [*found.system.names(), *found.reactions]
    names = [n for n in point.select(values.patterns(args.signals)) if n != "time"] if args.signals else default
    lines = str(found).splitlines()
    if args.output:
        columns = {"time": point.t, **{name: point[name] for name in names}}
        units = {"time": "s", **{name: point.unit(name) for name in names}}
        columns, units = converted(args.output, columns, units, scene.display)
        said = about(point) | {"stability": found.stability}
        results.write(args.output, columns, units, said, values.row_of_units(args))
    if args.output or args.signals:
        notes = [f"note: {text}" for text in found.notes]
        rows = listed([(name, found[name], point.unit(name)) for name in names], scene.display) if args.signals else []
        lines = [lines[0], *rows, *notes]
    if args.output:
        lines.append(f"{args.output}: 1 row, time and {len(names)} signals")
    if out:
        found.show().save(out, size)
        lines.append(values.written(out, values.file_size(out)))
    print("\n".join(lines))
    return 0
