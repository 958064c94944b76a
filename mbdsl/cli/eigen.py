"""mbdsl eigen: frequencies, damping and shapes of small motions about a state."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import say
from mbdsl.messages import count
from mbdsl.storage import output_files
from mbdsl.storage.output_files import write_text

if TYPE_CHECKING:
    from mbdsl.analysis.eigenmodes import Modes

TABLES = (".md", ".tex")
SUFFIXES = (".csv", ".json", *TABLES)


NUMBER = values.whole("`{}` is not a number of modes: 1, 2, ...")
COMMAND = Command(
    "eigenmodes of a model: frequencies, damping, shapes",
    "Linearise a model about a state; print frequencies, damping ratios and the bodies that move most.",
    """
    @model at
    --count N  number of modes; default 10
    @units
    --output FILE  write frequencies, damping and shapes (.csv, .json), or a table of the modes (.md, .tex)
    --animate  write a page that animates the mode shapes
    --out FILE  with --animate: a page (.html) or a film of one mode (.gif, .mp4); default: NAME-modes.html
    --mode N  with --animate: the mode of a film, or the first on a page; default: the first that oscillates
    @size
    """,
    count={"type": NUMBER, "default": 10},
    mode=NUMBER,
)


def run(args: argparse.Namespace) -> int:
    out = values.shown_file(args, "animate", "modes")
    size = values.size_of(args, out)
    if args.output:
        output_files.suffix_of(args.output, SUFFIXES)
    scene = values.load_for(args, [args.output, out])

    from mbdsl.analysis.eigenmodes import eigen

    modes = eigen(scene, args.at, args.count, announce=say)
    print(modes)
    if args.output:
        write(modes, args.output)
        shapes = "" if Path(args.output).suffix.lower() in TABLES else " and shapes"
        print(f"{args.output}: {len(modes)} modes, frequencies, damping{shapes}")
    if out:
        from mbdsl.viewing.saved_page import PAGES

        mode = None if args.mode is None else args.mode - 1
        shown = modes.animate(mode=mode)
        shown.save(out, size)
        page = Path(out).suffix.lower() in PAGES
        what = count(len(modes), "mode") if page else f"mode {shown.first + 1}"
        print(values.written(out, f"{values.file_size(out)}, {what}"))
    return 0


def write(modes: Modes, path: str) -> None:
    """One row per mode as CSV, one object per mode with its shape by coordinate as [re, im] as JSON, or the table."""
    if Path(path).suffix.lower() in TABLES:
        from mbdsl.plotting import table_files

        table_files.write(path, [modes.table()], [], str(modes).partition("\n")[0], modes.notes)
        return
    columns = modes.to_dict()
    if Path(path).suffix.lower() == ".csv":
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        text = ",".join(columns) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
    else:
        names = modes.system.names()
        head = [name for name in columns if name.startswith(("mode", "freq", "damp", "eigenvalue."))][:6]
        found = []
        for k, mode in enumerate(modes):
            shape = {name: [float(x.real), float(x.imag)] for name, x in zip(names, mode.shape, strict=True)}
            found.append({name: float(columns[name][k]) for name in head} | {"bodies": mode.bodies, "shape": shape})
        said = {"model": modes.scene.name, "at": modes.at, "t": modes.t, "notes": modes.notes, "modes": found}
        text = json.dumps(said, indent=2) + "\n"
    write_text(path, text)
