"""The command line. Each command is a module of this package; the modules are discovered.

A command module has ``COMMAND``, which declares its help and options (:mod:`mbdsl.cli._options`), and ``run(args)``,
which does the work and returns the exit code. It may have ``add_options(parser, words)`` for options that load slowly;
this function is called with the words of the command if it is run, but not for its help. Modules whose names begin with
an underscore are shared helpers. Packages that load slowly are imported inside ``run``, so that ``mbdsl --help``
responds immediately.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import re
import sys
import warnings
from collections.abc import Sequence
from functools import cache
from types import ModuleType
from typing import Any

from mbdsl.cli._arguments import Parser as Parser
from mbdsl.cli._streams import BROKEN_PIPE as BROKEN_PIPE
from mbdsl.cli._streams import Streams, print_problem
from mbdsl.errors import MbdslError, UsageError
from mbdsl.messages import did_you_mean
from mbdsl.numerics.blas_threads import one_thread
from mbdsl.simulation.interrupts import terminated
from mbdsl.storage.compilation_notice import silent
from mbdsl.version import __version__

#: the start of a negative value, such as -1ms
NEGATIVE = re.compile(r"-\.?\d")
INTERRUPTED = 130
#: options that may precede the command
_OPTIONS = ("--help", "--version", "--debug")
EPILOG = """\
exit codes: 0 done, 2 wrong input, 3 no consistent initial state or no equilibrium, \
4 the integration failed or did not reach the given accuracy, 130 interrupted. See also mbdsl COMMAND --help."""


class Help(argparse.HelpFormatter):
    """Wide enough for the longest command: argparse ignores that commands are indented further than options."""

    def __init__(self, *given, **named) -> None:
        super().__init__(*given, **named)
        self._action_max_length = 4 + max(map(len, names()))


@cache
def names() -> tuple[str, ...]:
    """The names of the commands, without importing their modules."""
    return tuple(sorted(info.name for info in pkgutil.iter_modules(__path__) if not info.name.startswith("_")))


def commands() -> dict[str, ModuleType]:
    """Command name -> its module."""
    return {name: importlib.import_module(f"{__name__}.{name}") for name in names()}


def make_parser(running: str = "", words: Sequence[str] | None = None) -> Parser:
    """The parser of one command with its options (those that the ``words`` need), or, without a name, of all commands.

    Importing the modules of all commands takes longer than checking a model.
    """
    parser = Parser(
        prog="mbdsl",
        description="Declarative multibody dynamics: models as text, simulated as differential-algebraic equations.",
        epilog=EPILOG,
        formatter_class=Help,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"mbdsl {__version__}")
    debug: dict[str, Any] = {"action": "store_true", "default": argparse.SUPPRESS, "help": "show a traceback of errors"}
    parser.add_argument("--debug", **debug)
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", dest="command", required=True)
    for name in [running] if running in names() else names():
        module = importlib.import_module(f"{__name__}.{name}")
        subparser = module.COMMAND.register(subparsers, name)
        if name == running and hasattr(module, "add_options"):
            module.add_options(subparser, words)
        subparser.add_argument("--debug", **debug)
        subparser.set_defaults(run=module.run)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code; errors are printed as messages, with ``--debug`` after a traceback."""
    argv = sys.argv[1:] if argv is None else list(argv)
    with Streams() as streams, warnings.catch_warnings(), silent(), one_thread():
        if "--debug" not in argv:  # numpy's warnings of overflows; their consequences are reported as errors
            warnings.simplefilter("ignore", RuntimeWarning)
        return streams.exit_code(_answer(argv))


def _answer(argv: list[str]) -> int:
    heard: list[int] = []
    try:
        with terminated() as heard:
            return _run(argv)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except MbdslError as problem:
        if "--debug" in argv:
            _print_traceback()
        print_problem(problem)
        return problem.exit_code
    except Exception as problem:
        if "--debug" in argv:
            _print_traceback()
        if heard:  # a consequence of the interruption
            print("interrupted", file=sys.stderr)
            return INTERRUPTED
        if found := _of_a_method(problem):
            print(found.render(), file=sys.stderr)
            return found.exit_code
        reason = " ".join(str(problem).split())
        print(f"internal error: {type(problem).__name__}: {reason}", file=sys.stderr)
        print("  = this is a defect of mbdsl; please report it with the traceback of --debug", file=sys.stderr)
        return 1


def _print_traceback() -> None:
    import traceback

    traceback.print_exc()


def _of_a_method(problem: Exception) -> MbdslError | None:
    """The error of an exception that a file of the user raised (``--method file.py``)."""
    loaded = sys.modules.get("mbdsl.integrators.method_files")
    return loaded.blamed(problem) if loaded else None


def _run(argv: list[str]) -> int:
    if not argv:
        make_parser().print_help()
        return 0
    _check_command(argv[0])
    argv = _with_values(argv)
    parser = make_parser("" if {"-h", "--help"} & set(argv) else argv[0], argv[1:])
    try:
        args, rest = parser.parse_known_args(argv)
    except SystemExit as stop:  # --help and --version have been answered
        return int(stop.code or 0)
    if rest:
        raise UsageError(f"unrecognized arguments: {' '.join(rest)}", hint=_long_form(rest[0], args))
    if getattr(args, "contacts", None):
        from mbdsl.lang.experiment import check_effects

        args.without = check_effects(args.without, args.contacts)
    from mbdsl.cli import _values as values
    from mbdsl.lang.library import imports_allowed
    from mbdsl.lang.load import model_chosen

    with imports_allowed(getattr(args, "allow_imports", False)), model_chosen(getattr(args, "model_name", None)):
        values.load_methods(args)
        return args.run(args)


def _with_values(argv: list[str]) -> list[str]:
    """``--step -1ms`` as ``--step=-1ms``, because argparse interprets ``-1ms`` as an option."""
    joined: list[str] = []
    for word in argv:
        option = joined[-1] if joined else ""
        if NEGATIVE.match(word) and option.startswith("--") and len(option) > 2 and "=" not in option:
            joined[-1] = f"{option}={word}"
        else:
            joined.append(word)
    return joined


def _long_form(word: str, args: argparse.Namespace) -> str:
    """The remedy for an unknown argument: options have long names only, ``-o`` is ``--output`` or ``--out``."""
    given = vars(args)
    for name in ("output", "out") if word == "-o" else ():
        if name in given:
            return f"write `--{name}`"
    return f"see mbdsl {args.command} --help"


def _check_command(word: str) -> None:
    if word.startswith("--") and word.partition("=")[0] not in _OPTIONS:
        hint = did_you_mean(word[2:], [option[2:] for option in _OPTIONS])
        raise UsageError(
            f"mbdsl has no option `{word}`", hint=hint.replace(" `", " `--") if hint else "see mbdsl --help"
        )
    if word.startswith("-") or word in names():
        return
    if word.endswith(".mbd"):
        raise UsageError(f"what to do with `{word}`?", hint=f"try:  mbdsl simulate {word}")
    raise UsageError(f"there is no command `{word}`", hint=did_you_mean(word, names(), "commands"))
