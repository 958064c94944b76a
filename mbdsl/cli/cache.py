"""mbdsl cache: show or empty the folder of machine code and stored runs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from mbdsl.cli._options import Command
from mbdsl.errors import UsageError
from mbdsl.messages import count, few

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from mbdsl.storage.cache_folder import CachedFiles, ChosenFolder

#: content of the cache -> the beginning of the names of its files
CONTENTS = {"step loops": "mbdsl_method_", "equations": "mbdsl_emitted_"}


COMMAND = Command(
    "show or empty the folder of machine code and of runs of studies",
    "Show the folder of machine code and runs of studies, its content, and the reason if it is not used. "
    "MBDSL_CACHE_DIR names another folder; its path has to be absolute, and only you and root may have permission to "
    "write into it.",
    """
    --clear  remove the files that mbdsl wrote there
    """,
)


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
    from mbdsl.compilation import code_cache
    from mbdsl.studies.store import LARGEST

    code = cache_folder.code(choice.path)
    print(f"machine code: {_size(code)} (limit: {cache_folder.LARGEST / 1e6:.0f} MB)")
    present = [entry for entry in code if _folder(entry, choice.path) == code_cache.version()]
    for what, prefix in CONTENTS.items():
        if found := [entry for entry in present if entry.files[0].name.startswith(prefix)]:
            print(f"  {what}: {_size(found)}")
            present = [entry for entry in present if entry not in found]
    if present:
        print(f"  other files: {_size(present)}")
    if others := [entry for entry in code if _folder(entry, choice.path) != code_cache.version()]:
        folders = {_folder(entry, choice.path) for entry in others}
        print(f"  of other versions and settings: {_size(others)}, in {count(len(folders), 'folder')}")
    runs = cache_folder.runs(choice.path / cache_folder.STUDIES)
    print(f"runs of studies: {_size(runs)} (limit: {LARGEST / 1e6:.0f} MB)")
    if problem := cache_folder.unwritable(choice.path):
        print(f"nothing can be stored: {problem}")
    return 0


def _size(entries: Sequence[CachedFiles]) -> str:
    return f"{_entries(len(entries))}, {sum(entry.size for entry in entries) / 1e6:.1f} MB"


def _folder(entry: CachedFiles, root: Path) -> str:
    """The folder of a version that an entry is in."""
    return entry.files[0].relative_to(root).parts[0]


def _clear(choice: ChosenFolder) -> None:
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
