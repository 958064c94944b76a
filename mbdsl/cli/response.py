"""mbdsl response: amplitude and phase of signals over the frequency of an input, and resonances."""

from __future__ import annotations

import argparse
from dataclasses import replace

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import say
from mbdsl.errors import UsageError
from mbdsl.storage import output_files

COMMAND = Command(
    "frequency response: amplitude, phase, resonances",
    "Linearise a model about a state; print amplitudes and phases of signals over the frequency of an input (a Bode "
    "diagram), and name its resonances.",
    """
    @model
    --input, --inputs NAME,...  what oscillates: an input of the model, a force (push.fx), a driver (base.s), or
        rotating(push.fx, push.fy); default: all inputs of the model
    --output, --signals SIGNAL,...  outputs, such as pin.phi; default: coordinates
    --range F1:F2  frequencies, 0.1:100Hz or "1:600 rad/s"; default: those of the poles
    @at
    --amplitude {1,w,w^2,1/w,1/w^2}  how the amplitude of the input depends on the angular frequency: w^2 for an
        unbalance; with 1/w^2 the acceleration of a driver has the same amplitude at all frequencies, as on a shaker;
        default 1
    @units
    --plot  draw amplitude and phase in characters
    --out FILE ...  write the values (.csv, .json), tables (.md, .tex), a plot (.svg, .png, .pdf) or a page (.html);
        (.png and .pdf need the extra `plot`); repeatable
    """,
    input={"type": values.patterns},
    output={"type": values.patterns},
    amplitude={"default": "1"},
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.analysis.response_files import SUFFIXES

    for name in args.output or ():
        if name.lower().endswith(SUFFIXES):
            raise UsageError(f"--output {name}: expected signals", hint=f"files are written by --out {name}")
    for path in args.out:
        output_files.suffix_of(path, SUFFIXES)
    scene = values.load_for(args, args.out)

    from mbdsl.analysis.frequency_response import response

    found = response(
        scene,
        args.input,
        args.output,
        args.range,
        at=args.at,
        amplitude=args.amplitude,
        announce=say,
    )
    print(found)
    if args.plot:
        from mbdsl.cli.plot import show

        show(replace(found.plot(), title="", notes=()))  # both are printed above
    for path in args.out:
        found.save(path)
        print(values.written(path, f"{len(found.f)} frequencies"))
    return 0
