"""mbdsl lsp: the language server for editors."""

from __future__ import annotations

import argparse
import os
import signal
import sys

from mbdsl.cli._options import Command
from mbdsl.errors import UsageError
from mbdsl.simulation.interrupts import SIGNALS

COMMAND = Command(
    "start the language server for editors",
    "Start the language server, which editors use for error messages, completion, documentation and navigation. It "
    "speaks the Language Server Protocol over standard input and output. The page docs/editors.md describes the "
    "settings of editors.",
    """
    --stdio  the default, for editors that add this option
    --allow-imports  allow models to import files from outside their folder; only for models that you trust
    """,
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.cli import INTERRUPTED

    try:
        from mbdsl.editor.server import serve
    except ImportError as problem:
        package = (problem.name or "pygls").partition(".")[0]
        raise UsageError(
            f"the language server needs the package `{package}`, which is not installed",
            hint="install mbdsl with its extra: pip install '.[editor]' in the checkout",
        ) from None
    if sys.stdin.isatty():
        print("the language server waits for an editor on standard input; Ctrl-C ends it", file=sys.stderr)
    for number in SIGNALS:  # pygls would wait for the end of its input, which a thread reads
        signal.signal(number, lambda *_: os._exit(INTERRUPTED))
    return 0 if serve(args.allow_imports) else 1
