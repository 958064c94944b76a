"""Values and model arguments on the command line, with units as in the language."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mbdsl.errors import MbdslError, UsageError
from mbdsl.messages import visible
from mbdsl.numerics.tolerance import misfit
from mbdsl.results.selection import split

if TYPE_CHECKING:
    from mbdsl.mechanism.scene import Scene


def quantity(text: str, unit: str) -> float:
    """The number in ``text``, in ``unit``; bare numbers are in ``unit`` already.

    Raises
    ------
    argparse.ArgumentTypeError
        If the text is not a number with a unit of this dimension.
    """
    from mbdsl.lang import units

    try:
        return units.measure(text, unit)
    except ValueError as problem:
        raise argparse.ArgumentTypeError(str(problem)) from None


def seconds(text: str) -> float:
    return quantity(text, "s")


def _bounded(parse: Callable[[str], float], fits: Callable[[float], bool], wanted: str) -> Callable[[str], float]:
    def checked(text: str) -> float:
        value = parse(text)
        if not fits(value):
            raise argparse.ArgumentTypeError(f"`{text}` is {value:g}, expected a value {wanted}")
        return value

    return checked


positive_seconds = _bounded(seconds, lambda x: 0.0 < x < float("inf"), "above 0")
interval_seconds = _bounded(seconds, lambda x: 0.0 <= x < float("inf"), "of 0 or more")


def tolerance(text: str) -> float:
    value = _bounded(number, lambda x: 0.0 < x < 1.0, "between 0 and 1")(text)
    if (wrong := misfit(value)) is not None:
        raise argparse.ArgumentTypeError(wrong)
    return value


def number(text: str) -> float:
    return quantity(text, "1")


def assignment(text: str) -> tuple[str, str]:
    """NAME=VALUE; the value remains a text, which the language parses."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"expected NAME=VALUE, found `{text}`")
    return name.strip(), value.strip()


def variation(text: str) -> tuple[str, str]:
    """NAME=VALUES of a sweep, as :func:`assignment`."""
    try:
        return assignment(text)
    except argparse.ArgumentTypeError:
        name = text.partition("=")[0].strip() or "L"
        hint = f"write {name}=1:2:11 (11 values from 1 to 2) or {name}=0.5,1,2"
        raise UsageError(f"--vary: found `{text}`, expected NAME=VALUES", hint=hint) from None


def sought(text: str) -> tuple[str, str]:
    """NAME=START:STOP of a parameter that is sought, as :func:`assignment`."""
    try:
        return assignment(text)
    except argparse.ArgumentTypeError:
        hint = f"write {text.partition('=')[0].strip() or 'm'}=1:10, with a unit after it"
        raise UsageError(f"--vary: found `{text}`, expected NAME=START:STOP", hint=hint) from None


def state(text: str) -> str | float | dict[str, str]:
    """``static``, ``start``, a time, or initial values as NAME=VALUE,..."""
    if "=" in text:
        return dict(map(assignment, split(text)))
    return text if text in ("static", "start") else seconds(text)


def whole(wrong: str, below: float = float("inf")) -> Callable[[str], int]:
    """A whole number above 0 and below a limit; ``wrong`` is the message about other texts."""

    def checked(text: str) -> int:
        if not (text.isdecimal() and 0 < int(text) < below):
            raise argparse.ArgumentTypeError(wrong.format(text))
        return int(text)

    return checked


def named_number(name: str) -> Callable[[str], tuple[str, str]]:
    """X as ``assignment`` reads NAME=X, after a check that X is a number."""
    return lambda text: (name, f"{number(text)!r}")


def numbers(assignments: list[tuple[str, str]]) -> dict[str, float]:
    """Numbers by name, from results of ``assignment``.

    Raises
    ------
    UsageError
        If a value is not a number.
    """
    try:
        return {name: number(value) for name, value in assignments}
    except argparse.ArgumentTypeError as problem:
        raise UsageError(f"argument --option: {problem}") from None


def patterns(text: str) -> list[str]:
    """Patterns and expressions of signals, separated by commas."""
    return split(text)


def signals(args: argparse.Namespace) -> list[str] | None:
    """The patterns and expressions of ``--signals``; None without."""
    return patterns(args.signals) if args.signals else None


def names(text: str) -> list[str]:
    """Names, separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def list_of(parse: Callable[[str], float]) -> Callable[[str], list[float]]:
    """Values, separated by commas, each with its unit."""
    return lambda text: [parse(part) for part in names(text)]


def check_folder(path: Path) -> None:
    """Check before the work begins that a folder can be written into.

    Raises
    ------
    UsageError
        If it is a file, its parent folder does not exist, or it cannot be written into.
    """
    around = Path(os.path.realpath(path)).parent
    try:
        os.stat(path)
        if not path.is_dir():
            raise UsageError(f"cannot write into `{path}`: it is a file")
        _try_to_write(path)
    except FileNotFoundError as problem:
        if not around.is_dir():
            raise UsageError(f"cannot write into `{path}`: there is no folder `{path.parent}`") from problem
        _try_to_write(around)
    except OSError as problem:
        raise UsageError(f"cannot write into `{path}`: {problem.strerror or problem}") from problem


def _try_to_write(folder: Path) -> None:
    """Write a temporary file, because permissions do not show all restrictions of a file system."""
    import tempfile

    try:
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".mbdsl"):
            pass
    except OSError as problem:
        raise UsageError(f"cannot write into `{folder}`: {problem.strerror or problem}") from problem


def effects(text: str) -> tuple[str, ...]:
    """Effects to leave out."""
    return tuple(names(text))


def display_units(text: str) -> str:
    """Units in which values are displayed, checked."""
    from mbdsl.lang.display_units import asked

    asked(text)
    return text


def row_of_units(args: argparse.Namespace) -> bool:
    """Whether a ``.csv`` file has a row of units; False in checkpoints of earlier versions."""
    return getattr(args, "units", None) not in (None, False)


def check_table(args: argparse.Namespace) -> None:
    """Check before the work begins that the tables can be written.

    Raises
    ------
    UsageError
        If the suffix is unknown, or the file cannot be written.
    """
    if args.table:
        from mbdsl.plotting.table_files import SUFFIXES
        from mbdsl.storage import output_files

        output_files.suffix_of(args.table, SUFFIXES)
        output_files.check([args.table], [args.model])


def shown_file(args: argparse.Namespace, flag: str, ending: str, *suffixes: str) -> str | None:
    """The file of a page or picture that a command makes with ``--flag``: its name, or that of the model + ``ending``.

    Raises
    ------
    UsageError
        If it has another suffix than these, or options of it are given without the flag.
    """
    if not getattr(args, flag):
        given = next((name for name in ("out", "mode", "size") if getattr(args, name, None) is not None), None)
        if given:
            raise UsageError(f"--{given} belongs to --{flag}", hint=f"add --{flag}, or write numbers by --output")
        return None
    from mbdsl.storage.output_files import suffix_of
    from mbdsl.viewing.saved_page import SavedPage

    out = args.out or f"{stem(args)}-{ending}.html"
    suffix_of(out, suffixes or SavedPage.suffixes)
    return out


def size_of(args: argparse.Namespace, out: str | None) -> tuple[int, int]:
    """The size of the film or picture ``out``.

    Raises
    ------
    UsageError
        If a size is given for a page.
    """
    from mbdsl.viewing.saved_page import PAGES

    if args.size and out and Path(out).suffix.lower() in PAGES:
        raise UsageError("--size is for films and pictures; a page has the size of its window", hint="omit --size")
    return args.size or (640, 400)


def size(text: str) -> tuple[int, int]:
    """Width and height in pixels; even numbers, as films require."""
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT in pixels, found `{text}`")
    found = int(width), int(height)
    if not all(64 <= n <= 4096 and n % 2 == 0 for n in found):
        raise argparse.ArgumentTypeError(f"`{text}`: expected even numbers from 64 to 4096")
    return found


def file_size(path: str) -> str:
    """The size of a written file, in words; "written" for a device or a pipe."""
    if not Path(path).is_file():
        return "written"
    size = Path(path).stat().st_size
    return f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{size / 1e3:.0f} KB"


def written(path: str, what: str) -> str:
    """The line about a written file."""
    return f"{visible(path, line=True)}: {what}"


def load_methods(args: argparse.Namespace) -> None:
    """Replace Python files among the chosen methods by the names of the methods that they define."""

    def name(given: str) -> str:
        if not given.lower().endswith(".py"):
            return given
        from mbdsl.integrators import method_files

        return method_files.load(given)

    if getattr(args, "method", None):
        args.method = name(args.method)
    if getattr(args, "methods", None):
        args.methods = [name(given) for given in args.methods]


def load_for(args: argparse.Namespace, outputs: Sequence[str | None]) -> Scene:
    """The model of a command that writes files, which are checked before.

    Raises
    ------
    UsageError
        If a file cannot be written, or is one of those of the model.
    """
    from mbdsl.storage import output_files

    output_files.check(outputs, [args.model])
    scene = load_model(args)
    output_files.check(outputs, scene.files)
    return scene


def load_model(args: argparse.Namespace) -> Scene:
    from mbdsl.lang.load import load

    # missing in checkpoints of earlier versions
    allowed, name = getattr(args, "allow_imports", False), getattr(args, "model_name", None)
    try:
        scene = load(args.model, dict(args.set), name, args.without, allowed)
    except MbdslError as problem:
        first, *others = _all_errors(problem, args)
        first.others = tuple(others)
        raise first from problem.__cause__
    for warning in scene.warnings:
        print(warning.render(), file=sys.stderr)
    units = getattr(args, "units", None)
    if not isinstance(units, str) or not units:
        return scene
    from mbdsl.lang.display_units import in_units

    return in_units(scene, units)


def _all_errors(problem: MbdslError, args: argparse.Namespace) -> list[MbdslError]:
    """The errors of the model's file that do not follow from each other; ``problem`` is one of them."""
    if problem.span is None or problem.span.file != args.model:
        return [problem]
    from mbdsl.editor import all_errors
    from mbdsl.lang.library import Library, read
    from mbdsl.lang.load import read_scene

    def scene(text: str) -> Scene:
        return read_scene(Library(), text, args.model, dict(args.set), without=args.without)

    found, _ = all_errors.find(read(args.model), args.model, scene)
    return found if problem.message in (each.message for each in found) else [problem]


def stem(args: argparse.Namespace) -> str:
    """The name of output files without a given name: that of the chosen model, else of the model's file."""
    return getattr(args, "model_name", None) or Path(args.model).stem
