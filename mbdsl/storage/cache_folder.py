"""The cache folder: machine code and stored runs of studies, all of which can be computed again.

``MBDSL_CACHE_DIR`` names it; the default is ``mbdsl`` in ``XDG_CACHE_HOME`` or ``~/.cache``. It is used if its path is
absolute and :mod:`mbdsl.storage.trusted_files` finds no fault. If it cannot be used or written into, a private
temporary folder replaces it for writing, which is removed when the process ends, and a line on standard error reports
this. If that is impossible as well, nothing is stored. A failure to store stops no run.
"""

from __future__ import annotations

import atexit
import os
import re
import stat
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from mbdsl.storage import trusted_files

LARGEST = 500_000_000  #: largest size of the machine code in bytes; the least recently used is removed first
ABANDONED = 600.0  #: seconds after which an incomplete file has no writer any more
FORGOTTEN = 86400.0  #: seconds after which a temporary folder belongs to a killed process; each use renews it
PROBE = 1 << 18  #: bytes, about the size of the largest object
ATTEMPTS = 10  #: number of attempts to write a file while other processes clear the folder
HANDED = "MBDSL_CACHE_OWN"  #: variable by which a process passes its temporary folder to the processes that it starts

TEMPORARY = re.compile(r"mbdsl-cache-(\d{1,9})-\w+")
VERSION = re.compile(r"\d[\w.+]*-py\d+-[0-9a-f]{16}")
CODE = re.compile(r"(\w+)\.(?:o|bc|py|ordinary|tables)")
MACHINE_CODE = (".o", ".tables")  #: suffixes of objects, and of the tables of the parser
NUMBA = re.compile(r"[0-9a-f]{16}")
RUN = re.compile(r"[0-9a-f]{32}(?:-[0-9a-f]{12})?\.npz")
PART = re.compile(r"\.?[\w.-]+\.\d+\.\d+\.part")
OF_NUMBA = re.compile(r".+\.(?:nbi|nbc)(?:\.tmp\.\w+)?")
STUDIES = "studies"

_lock = threading.RLock()
_said: list[str] = []
_written: dict[Path, int] = {}  #: bytes of machine code that this process has written since it last pruned a folder


@dataclass(frozen=True)
class Choice:
    """The chosen folder, and the reason why it cannot be used ("" if it can)."""

    path: Path
    fault: str


def chosen() -> Choice:
    """The folder named by the environment. It need not exist or be writable."""
    return _chosen(os.environ.get("MBDSL_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), os.path.expanduser("~"))


@lru_cache
def _chosen(given: str | None, xdg: str | None, home: str) -> Choice:
    if given and not os.path.isabs(given):
        return Choice(Path(given), f"MBDSL_CACHE_DIR is `{given}`, expected an absolute path")
    base = xdg if xdg and os.path.isabs(xdg) else os.path.join(home, ".cache")
    path = Path(given or os.path.join(base, "mbdsl"))
    if not path.is_absolute():
        return Choice(path, "there is no home folder (HOME is not set, or not absolute); try: set MBDSL_CACHE_DIR")
    return Choice(path, trusted_files.fault_of(path))


def own() -> Path | None:
    """The folder that this process writes into: the chosen one, a temporary one, or None."""
    with _lock:
        choice = chosen()
        return _own(choice, os.environ.get(HANDED))


@lru_cache
def _own(choice: Choice, handed: str | None) -> Path | None:
    problem = choice.fault or unwritable(choice.path)
    if not problem:
        return choice.path
    if handed and not trusted_files.fault_of(handed):
        return Path(handed)
    folder = _temporary()
    say(problem)
    return folder


def unwritable(folder: Path) -> str:
    """The reason why no object can be written into a folder, which is made if necessary, from a trial; "" if it can."""
    try:
        trusted_files.make(folder)
        probe = trusted_files.part_of(folder / "probe")
        try:
            with trusted_files.create(probe) as stream:
                stream.write(bytes(PROBE))
        finally:
            probe.unlink(missing_ok=True)
    except OSError as problem:
        return f"cannot write into `{folder}` ({problem.strerror or problem})"
    return trusted_files.fault_of(folder)


def _temporary() -> Path | None:
    import tempfile

    try:
        parent = Path(os.path.abspath(tempfile.gettempdir()))
        _sweep_temporary(parent)
        folder = Path(tempfile.mkdtemp(prefix=f"mbdsl-cache-{os.getpid()}-", dir=parent))
    except OSError:
        return None
    atexit.register(_remove, folder, os.getpid())
    return None if trusted_files.fault_of(folder) else folder


def _remove(folder: Path, process: int) -> None:
    import shutil

    if os.getpid() == process:  # and no process forked from it
        shutil.rmtree(folder, ignore_errors=True)


def _sweep_temporary(parent: Path) -> None:
    """Remove the temporary folders of processes that were killed."""
    for folder in _folders(parent, TEMPORARY):
        with suppress(OSError):
            process, status = int(TEMPORARY.fullmatch(folder.name)[1]), folder.lstat()  # type: ignore[index]
            old = status.st_mtime < time.time() - FORGOTTEN
            if old and trusted_files.has_owners() and status.st_uid == os.geteuid() and not _runs(process):
                clear(folder)
                folder.rmdir()


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True


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


# -- files -----------------------------------------------------------------------------------------------------------


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
    stream = None if trusted_files.fault_of(path.parent) else trusted_files.opened(path)
    if stream is None:
        return None
    with stream, suppress(OSError):
        return stream.read()
    return None


def _note_use(path: Path) -> None:
    """Record a use for the order of removal; file systems rarely store times of access."""
    if path.suffix in MACHINE_CODE:
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
        fault = _write(path, data)
        if not fault and path.suffix in MACHINE_CODE:
            _prune_sometimes(folder, len(data))
    except OSError as problem:
        fault = f"cannot write `{path}` ({problem.strerror or problem})"
    if fault:
        say(fault)
    return None if fault else path


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


def _write(path: Path, data: bytes, attempts: int = ATTEMPTS) -> str:
    try:
        trusted_files.make(path.parent)
        if fault := trusted_files.fault_of(path.parent):
            return fault
        if _contents(path) != data:  # other processes look at the time of writing
            trusted_files.write(path, data)
    except (FileNotFoundError, FileExistsError):  # another process has removed the empty folder, or is removing it
        if attempts <= 1:
            raise
        return _write(path, data, attempts - 1)
    return ""


def subfolder(name: str) -> Path | None:
    """A folder for the files of another library; None if there is none that contains only our own files."""
    folder = own()
    if folder is None:
        return None
    path = folder / name
    try:
        trusted_files.make(path)
        fault = trusted_files.fault_of(path)
        if not all(trusted_files.is_believed(inner.lstat()) for inner in path.rglob("*")):
            fault = fault or f"others can have written what is in `{path}`; try: mbdsl cache --clear"
    except OSError as problem:
        fault = f"cannot write into `{path}` ({problem.strerror or problem})"
    if fault:
        say(fault)
    return None if fault else path


def close(folder: Path) -> None:
    """Remove permissions that a lax umask has given to others, in a folder that another library wrote into."""
    for path in folder.rglob("*"):
        with suppress(OSError):
            path.chmod(stat.S_IMODE(path.lstat().st_mode) & ~trusted_files.OTHERS)


# -- contents --------------------------------------------------------------------------------------------------------


@dataclass
class Entry:
    """Files that belong together: the time of the last use [s since the epoch], bytes."""

    used: float
    size: int
    files: list[Path]

    def remove(self) -> None:
        for file in self.files:
            file.unlink(missing_ok=True)


def code(root: Path) -> list[Entry]:
    """All machine code in a folder; the files of one emitted module are an entry."""
    entries: dict[tuple[str, str], Entry] = {}
    for version in _folders(root, VERSION):
        for name, path, status in _code_files(version):
            entry = entries.setdefault((version.name, name), Entry(0.0, 0, []))
            entry.used, entry.size = max(entry.used, status.st_mtime), entry.size + status.st_size
            entry.files.append(path)
    return list(entries.values())


def _code_files(version: Path) -> Iterator[tuple[str, Path, os.stat_result]]:
    for path, status in _files(version):
        if match := CODE.fullmatch(path.name):
            yield match[1], path, status
    for folder in _folders(version, NUMBA):
        for inner in (folder, *_folders(folder, re.compile(".*"))):
            for path, status in _files(inner):
                if OF_NUMBA.fullmatch(path.name):
                    yield folder.name, path, status


def runs(folder: Path) -> list[Entry]:
    """The stored runs in a folder of studies."""
    return [Entry(s.st_mtime, s.st_size, [path]) for path, s in _files(folder) if RUN.fullmatch(path.name)]


def parts(folder: Path, age: float) -> list[Entry]:
    """Incomplete files in a folder that have not been written to for ``age`` seconds."""
    files = ((path, s) for path, s in _files(folder) if PART.fullmatch(path.name) and s.st_mtime <= time.time() - age)
    return [Entry(s.st_mtime, s.st_size, [path]) for path, s in files]


def remove_oldest(entries: list[Entry], largest: int) -> None:
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
        for cached in _folders(folder, re.compile("__pycache__")):  # former versions used Python's cache
            removed += [Entry(0.0, status.st_size, [path]) for path, status in _files(cached) if path.suffix == ".pyc"]
    for entry in removed:
        entry.remove()
    for folder in folders:
        _remove_empty(folder)
    return len(removed), sum(entry.size for entry in removed)


def _remove_empty(folder: Path) -> None:
    inside = [f for name in (NUMBA, re.compile("__pycache__")) for f in _folders(folder, name)]
    for empty in (*(f for g in inside for f in _folders(g, re.compile(".*"))), *inside, folder):
        with suppress(OSError):
            empty.rmdir()  # fails if files remain


def _folders(root: Path, name: re.Pattern) -> Iterator[Path]:
    """Folders in a folder, without links and without folders that others can write into."""
    with suppress(OSError):
        for path in list(root.iterdir()):
            with suppress(OSError):
                status = path.lstat()
                if name.fullmatch(path.name) and stat.S_ISDIR(status.st_mode) and trusted_files.is_believed(status):
                    yield path


def _files(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    """Regular files in a folder, without links; other processes may remove some in the meantime."""
    with suppress(OSError):
        for path in list(folder.iterdir()):
            with suppress(OSError):
                status = path.lstat()
                if stat.S_ISREG(status.st_mode):
                    yield path, status
