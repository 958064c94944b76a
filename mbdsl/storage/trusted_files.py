"""Files that only the user or root can have written.

Machine code and stored runs are used without further checks, so nobody else may be able to write them. A folder is
trusted if it, and every folder and link on its path, belongs to the user or to root, and others cannot write into it.
For a folder on the path the sticky bit suffices (``/tmp``), because others cannot rename or remove its content. A file
is trusted if it is a regular file, no link, with such an owner and mode.

The owner of ``/`` counts as root: in a user namespace, the files of root have another number. On systems without such
owners (Windows), everything that can be read is trusted.
"""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

OTHERS = stat.S_IWGRP | stat.S_IWOTH
LINKS = 40  #: largest number of links on a path; more are a cycle
_SAFELY = os.O_CLOEXEC if hasattr(os, "O_CLOEXEC") else 0
for _name in ("O_NOFOLLOW", "O_NONBLOCK", "O_NOCTTY", "O_BINARY"):  # opening a pipe must not block
    _SAFELY |= getattr(os, _name, 0)


def has_owners() -> bool:
    """Whether files have owners and modes that determine who can change them."""
    return hasattr(os, "geteuid")


def fault_of(folder: str | os.PathLike) -> str:
    """The reason why others can change the content of a folder, or the folder itself; "" if they cannot.

    Missing folders are not a fault; the existing ones on the path are checked.
    """
    if not has_owners():
        return ""
    folder = os.path.abspath(folder)
    steps: list[tuple[str, os.stat_result]] = []
    try:
        steps.extend(_way(folder))
    except FileNotFoundError:
        reached = False
    except OSError as problem:
        return f"`{folder}` cannot be reached ({problem.strerror})"
    else:
        reached = True
    for k, (at, status) in enumerate(steps):
        if not _is_ours(status.st_uid):
            return f"`{at}` belongs to {_user(status.st_uid)} (try: set MBDSL_CACHE_DIR to a folder of your own)"
        if stat.S_ISLNK(status.st_mode):
            continue
        if not stat.S_ISDIR(status.st_mode):
            return f"`{at}` is not a folder"
        last = reached and k == len(steps) - 1
        if status.st_mode & OTHERS and (last or not status.st_mode & stat.S_ISVTX):
            return f"others can write into `{at}` (mode {stat.S_IMODE(status.st_mode):04o}; try: chmod go-w {at})"
    return ""


def _way(folder: str) -> Iterator[tuple[str, os.stat_result]]:
    """All folders and links on the path of a folder, and the folder itself at the end."""
    at, rest, links = os.sep, folder.split(os.sep)[::-1], LINKS
    yield at, os.lstat(at)
    while rest:
        name = rest.pop()
        if name in ("", "."):
            continue
        if name == "..":
            at = os.path.dirname(at)
            continue
        found = os.path.join(at, name)
        status = os.lstat(found)
        yield found, status
        if not stat.S_ISLNK(status.st_mode):
            at = found
            continue
        links -= 1
        if links < 0:
            raise OSError(0, "too many links")
        target = os.readlink(found)
        at = os.sep if target.startswith(os.sep) else at
        rest += target.split(os.sep)[::-1]


def _is_ours(owner: int) -> bool:
    return owner in (0, os.geteuid(), os.lstat(os.sep).st_uid)


def _user(number: int) -> str:
    try:
        import pwd

        return f"user {pwd.getpwuid(number).pw_name}"
    except (ImportError, KeyError):
        return f"user {number}"


def is_believed(status: os.stat_result) -> bool:
    """Whether only the user or root can write a file or folder with this status; false for links and pipes."""
    if not stat.S_ISREG(status.st_mode) and not stat.S_ISDIR(status.st_mode):
        return False
    return not has_owners() or (_is_ours(status.st_uid) and not status.st_mode & OTHERS)


def opened(path: Path) -> BinaryIO | None:
    """A file for reading; None if it does not exist, or others can have written it."""
    try:
        number = os.open(path, os.O_RDONLY | _SAFELY)
    except OSError:
        return None
    status = os.fstat(number)
    if not stat.S_ISREG(status.st_mode) or not is_believed(status):
        os.close(number)
        return None
    return open(number, "rb")


def make(folder: Path) -> None:
    """Make a folder and its parents, for the user alone.

    Raises
    ------
    OSError
        If a folder cannot be made.
    """
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
    except FileNotFoundError:
        if folder.parent == folder:
            raise
        make(folder.parent)
        folder.mkdir(mode=0o700, exist_ok=True)
    except FileExistsError:
        if os.path.lexists(folder):  # a file
            raise
        make(folder)  # another process has removed the folder in the meantime


def part_of(path: Path) -> Path:
    """A new temporary name of a file; other threads, processes and containers may be writing the same file."""
    return path.with_name(f"{path.name}.{os.getpid()}.{secrets.randbits(64)}.part")


def create(path: Path) -> BinaryIO:
    """A new file for writing, into which only the user can write, with any umask.

    Raises
    ------
    OSError
        If the file exists or cannot be created.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | _SAFELY
    return open(os.open(path, flags, 0o644), "wb")


@contextmanager
def writing(path: Path) -> Iterator[BinaryIO]:
    """A stream whose content replaces the file at once when it is closed; another process may read or write the file.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    part = part_of(path)
    try:
        with create(part) as stream:
            yield stream
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def write(path: Path, data: bytes) -> None:
    """Write a file as by ``writing``."""
    with writing(path) as stream:
        stream.write(data)
