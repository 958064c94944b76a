"""The cache folder: machine code, tables of the parser and stored runs of studies. All can be computed again.

``MBDSL_CACHE_DIR`` names it; the default is ``mbdsl`` in ``XDG_CACHE_HOME`` or ``~/.cache``. mbdsl executes the
machine code without further checks, so other users must not be able to write it: mbdsl uses the folder if its path is
absolute, it belongs to the user or to root, and other users cannot write into it. mbdsl creates it with mode 0700. A
process checks the folder once, and does not read files of other users in it. On systems without owners (Windows) all
folders are used.

If the folder cannot be used or written into, a private temporary folder replaces it for writing, which is removed when
the process ends, and a line on standard error reports this. If that is impossible as well, nothing is stored. A failure
to store stops no run.
"""

from __future__ import annotations

import atexit
import os
import re
import secrets
import stat
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import BinaryIO

from mbdsl.storage.folder_rights import fault_of, is_ours

LARGEST = 500_000_000  #: largest size of the machine code in bytes; the least recently used is removed first
ABANDONED = 600.0  #: seconds after which an incomplete file has no writer any more
FORGOTTEN = 86400.0  #: seconds after which a temporary folder belongs to a killed process; each use renews it
PROBE = 1 << 18  #: bytes, about the size of the largest object
ATTEMPTS = 10  #: number of attempts to write a file while other processes clear the folder
HANDED = "MBDSL_CACHE_OWN"  #: variable by which a process passes its temporary folder to the processes that it starts
_SAFELY = 0  #: no links, and no waiting for the other end of a pipe
for _name in ("O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK", "O_NOCTTY", "O_BINARY"):
    _SAFELY |= getattr(os, _name, 0)
TEMPORARY = re.compile(r"mbdsl-cache-\w+")
VERSION = re.compile(r"\d[\w.+]*-py\d+-[0-9a-f]{16}")
CODE = re.compile(r"(\w+)\.(?:o|py|tables)")
RUN = re.compile(r"[0-9a-f]{32}(?:-[0-9a-f]{12})?\.npz")
PART = re.compile(r"\.?[\w.-]+\.\d+\.\d+\.part")
STUDIES = "studies"
_lock = threading.RLock()
_said: list[str] = []
_written: dict[Path, int] = {}  #: bytes of machine code that this process has written since it last pruned a folder


@dataclass(frozen=True)
class ChosenFolder:
    """The chosen folder, and the reason why it cannot be used ("" if it can)."""

    path: Path
    fault: str


def chosen() -> ChosenFolder:
    """The folder named by the environment. It need not exist or be writable."""
    return _chosen(os.environ.get("MBDSL_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), os.path.expanduser("~"))


@lru_cache
def _chosen(given: str | None, xdg: str | None, home: str) -> ChosenFolder:
    if given and not os.path.isabs(given):
        return ChosenFolder(Path(given), f"MBDSL_CACHE_DIR is `{given}`, expected an absolute path")
    base = xdg if xdg and os.path.isabs(xdg) else os.path.join(home, ".cache")
    path = Path(given or os.path.join(base, "mbdsl"))
    if not path.is_absolute():
        return ChosenFolder(
            path, "there is no home folder (HOME is not set, or not absolute); try: set MBDSL_CACHE_DIR"
        )
    return ChosenFolder(path, fault_of(path))


def own() -> Path | None:
    """The folder that this process writes into: the chosen one, a temporary one, or None."""
    with _lock:
        choice = chosen()
        return _own(choice, os.environ.get(HANDED))


@lru_cache
def _own(choice: ChosenFolder, handed: str | None) -> Path | None:
    problem = choice.fault or unwritable(choice.path)
    if not problem:
        return choice.path
    if handed and not fault_of(Path(handed)):
        return Path(handed)
    folder = _temporary()
    say(problem)
    return folder


def unwritable(folder: Path) -> str:
    """The reason why no object can be written into a folder, which is made if necessary, from a trial; "" if it can."""
    try:
        folder.mkdir(0o700, parents=True, exist_ok=True)
        probe = _part_of(folder / "probe")
        try:
            with _created(probe) as stream:
                stream.write(bytes(PROBE))
        finally:
            probe.unlink(missing_ok=True)
    except OSError as problem:
        return f"cannot write into `{folder}` ({problem.strerror or problem})"
    return fault_of(folder)


def _temporary() -> Path | None:
    import shutil
    import tempfile

    try:
        parent = Path(os.path.abspath(tempfile.gettempdir()))
        for left in _folders(parent, TEMPORARY):  # of processes that were killed
            with suppress(OSError):
                if left.stat().st_mtime < time.time() - FORGOTTEN and is_ours(left.stat()):
                    clear(left)
                    left.rmdir()
        folder = Path(tempfile.mkdtemp(prefix="mbdsl-cache-", dir=parent))
    except OSError:
        return None
    owner = os.getpid()
    atexit.register(lambda: shutil.rmtree(folder, True) if os.getpid() == owner else None)  # not in a forked process
    return folder


def say(problem: str) -> None:
    """Print the reason why nothing is stored, once in a process, on standard error."""
    if not _said and sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"note: nothing is stored for later runs: {problem}; see `mbdsl cache`", file=sys.stderr)
    _said.append(problem)


def compiling(what: Sequence[str] = ()) -> str:
    """The announcement of a compilation of code with these descriptions."""
    named = f": {' and '.join(what)}" if what else ""
    if own() == chosen().path and not _said:
        return f"compiling for the first time{named}; the code is stored, and later runs start at once ..."
    return f"compiling for the first time{named}; the code cannot be stored ..."


def environment() -> Mapping[str, str]:
    """Additions to the environment of other processes, so that they share the temporary folder."""
    folder = own()
    return {} if folder is None or folder == chosen().path else {HANDED: str(folder)}


def read(name: str) -> bytes | None:
    """The stored content of a name (a path within the folder); None if there is none, or others can have written it."""
    choice, handed = chosen(), os.environ.get(HANDED)
    folders = [] if choice.fault else [choice.path]
    with _lock:
        other = own() if _said or handed else None  # there may be a temporary folder
    if other is not None and other not in folders:
        folders.insert(0, other)
    for folder in folders:
        data = _contents(folder / name)
        if data is not None:
            _note_use(folder / name)
            return data
    return None


def _contents(path: Path) -> bytes | None:
    if (stream := opened(path)) is None:
        return None
    with stream, suppress(OSError):
        return stream.read()
    return None


def opened(path: Path) -> BinaryIO | None:
    """A file for reading; None if there is no such file, it is a link or a pipe, or others can have written it."""
    try:
        number = os.open(path, os.O_RDONLY | _SAFELY)
    except OSError:
        return None
    status = os.fstat(number)
    if not stat.S_ISREG(status.st_mode) or not is_ours(status):
        os.close(number)
        return None
    return open(number, "rb")


@contextmanager
def writing(path: Path) -> Iterator[BinaryIO]:
    """A stream whose content replaces a file at once when it is closed; other processes may read or write the file.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    part = _part_of(path)
    try:
        with _created(part) as stream:
            yield stream
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def _part_of(path: Path) -> Path:
    """A new temporary name of a file; other threads, processes and containers may be writing the same file."""
    return path.with_name(f"{path.name}.{os.getpid()}.{secrets.randbits(64)}.part")


def _created(part: Path) -> BinaryIO:
    """A new file for writing, into which only the user can write, with any umask."""
    return open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _SAFELY, 0o644), "wb")


def _note_use(path: Path) -> None:
    """Record a use for the order of removal; file systems rarely store times of access."""
    if path.suffix == ".o":
        with suppress(OSError):
            if path.stat().st_mtime < time.time() - FORGOTTEN:
                os.utime(path)


def keep(name: str, data: bytes) -> Path | None:
    """Write a file (a path within the folder); return its path, or None if it cannot be stored."""
    folder = own()
    if folder is None:
        return None
    path = folder / name
    try:
        _write(path, data)
        if path.suffix == ".o":
            _prune_sometimes(folder, len(data))
    except OSError as problem:
        say(f"cannot write `{path}` ({problem.strerror or problem})")
        return None
    return path


def _prune_sometimes(folder: Path, size: int) -> None:
    """Prune when a process writes its first file, and again after each hundredth of ``LARGEST`` that it writes.

    Listing all files of a full cache takes longer than the compilation of a small kernel.
    """
    with _lock:
        written = _written.get(folder, LARGEST) + size
        due = written > LARGEST // 100
        _written[folder] = 0 if due else written
    if due:
        prune(folder)


def _write(path: Path, data: bytes, attempts: int = ATTEMPTS) -> None:
    try:
        path.parent.mkdir(0o700, parents=True, exist_ok=True)
        if _contents(path) != data:  # other processes look at the time of writing
            with writing(path) as stream:
                stream.write(data)
    except (FileNotFoundError, FileExistsError):  # another process has removed the empty folder, or is removing it
        if attempts <= 1:
            raise
        _write(path, data, attempts - 1)


@dataclass
class CachedFiles:
    """Files that belong together: the time of the last use [s since the epoch], bytes."""

    used: float
    size: int
    files: list[Path]

    def remove(self) -> None:
        for file in self.files:
            file.unlink(missing_ok=True)


def code(root: Path) -> list[CachedFiles]:
    """All machine code in a folder; the files of one emitted module are an entry."""
    entries: dict[tuple[str, str], CachedFiles] = {}
    for version in _folders(root, VERSION):
        for name, path, status in _code_files(version):
            entry = entries.setdefault((version.name, name), CachedFiles(0.0, 0, []))
            entry.used, entry.size = max(entry.used, status.st_mtime), entry.size + status.st_size
            entry.files.append(path)
    return list(entries.values())


def _code_files(version: Path) -> Iterator[tuple[str, Path, os.stat_result]]:
    for path, status in _files(version):
        if match := CODE.fullmatch(path.name):
            yield match[1], path, status


def runs(folder: Path) -> list[CachedFiles]:
    """The stored runs in a folder of studies."""
    return [CachedFiles(s.st_mtime, s.st_size, [path]) for path, s in _files(folder) if RUN.fullmatch(path.name)]


def parts(folder: Path, age: float) -> list[CachedFiles]:
    """Incomplete files in a folder that have not been written to for ``age`` seconds."""
    files = ((path, s) for path, s in _files(folder) if PART.fullmatch(path.name) and s.st_mtime <= time.time() - age)
    return [CachedFiles(s.st_mtime, s.st_size, [path]) for path, s in files]


def remove_oldest(entries: list[CachedFiles], largest: int) -> None:
    """Remove the least recently used entries beyond ``largest`` bytes."""
    total = 0
    for entry in sorted(entries, key=lambda entry: -entry.used):
        total += entry.size
        if total > largest or not largest:
            entry.remove()


def prune(root: Path) -> None:
    """Keep the machine code in a folder below ``LARGEST`` bytes; remove abandoned files."""
    remove_oldest(code(root), LARGEST)
    for folder in (root, *_folders(root, VERSION)):
        remove_oldest(parts(folder, ABANDONED), 0)
    for version in _folders(root, VERSION):
        _remove_empty(version)


def clear(root: Path) -> tuple[int, int]:
    """Remove all files that mbdsl wrote into a folder; return the number of entries and bytes.

    Raises
    ------
    OSError
        If a file cannot be removed.
    """
    folders = [*_folders(root, VERSION), *_folders(root, re.compile(STUDIES))]
    removed = [*code(root), *runs(root / STUDIES), *parts(root, 0.0)]
    for folder in folders:
        removed += parts(folder, 0.0)
    for entry in removed:
        entry.remove()
    for folder in folders:
        _remove_empty(folder)
    return len(removed), sum(entry.size for entry in removed)


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()  # fails if files remain


def _folders(root: Path, name: re.Pattern) -> Iterator[Path]:
    """Folders in a folder, without links."""
    with suppress(OSError):
        for path in list(root.iterdir()):
            with suppress(OSError):
                if name.fullmatch(path.name) and stat.S_ISDIR(path.lstat().st_mode):
                    yield path


def _files(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    """Regular files in a folder, without links; other processes may remove some in the meantime."""
    with suppress(OSError):
        for path in list(folder.iterdir()):
            with suppress(OSError):
                status = path.lstat()
                if stat.S_ISREG(status.st_mode):
                    yield path, status
