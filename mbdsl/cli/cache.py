"""mbdsl cache: show or empty the folder of machine code and stored runs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from mbdsl.errors import UsageError
from mbdsl.messages import count, few

if TYPE_CHECKING:
    from mbdsl.storage.cache_folder import Choice


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "cache",
        help="show or empty the folder of machine code and of runs of studies",
        description="Show the folder of machine code and runs of studies, its content, and the reason if it is not "
        "used. MBDSL_CACHE_DIR names another folder; its path has to be absolute, and only you and root may have "
        "permission to write into it.",
    )
    parser.add_argument("--clear", action="store_true", help="remove the files that mbdsl wrote there")
    return parser


def run(args: argparse.Namespace) -> int:
    from mbdsl.storage import cache_folder

    choice = cache_folder.chosen()
    if args.clear:
        _clear(choice)
        return 0
    print(f"folder: {choice.path}")
    if choice.fault:
        print(f"not used: {choice.fault}")
        return 0
    from mbdsl.studies.store import LARGEST

    for what, entries, limit in (
        ("machine code", cache_folder.code(choice.path), cache_folder.LARGEST),
        ("runs of studies", cache_folder.runs(choice.path / cache_folder.STUDIES), LARGEST),
    ):
        size = sum(entry.size for entry in entries)
        print(f"{what}: {_entries(len(entries))}, {size / 1e6:.1f} MB (limit: {limit / 1e6:.0f} MB)")
    if problem := cache_folder.unwritable(choice.path):
        print(f"read-only: {problem}")
    return 0


def _clear(choice: Choice) -> None:
    from mbdsl.storage import cache_folder

    if choice.fault:
        raise UsageError(f"`{choice.path}` is not used, and not emptied: {choice.fault}")
    try:
        number, size = cache_folder.clear(choice.path)
    except OSError as problem:
        raise UsageError(f"cannot empty `{choice.path}`: {problem.strerror or problem}") from problem
    print(f"removed {_entries(number)}, {size / 1e6:.1f} MB, from {choice.path}")
    if left := sorted(path.name for path in choice.path.glob("*")):
        print(f"left unchanged, because mbdsl did not write it or others can write into it: {few(left)}")


def _entries(number: int) -> str:
    return count(number, "entry", "entries")
