"""Writing files: all or nothing, with the mode that a file had, and never over the model or another output.

What is no regular file (a device, a pipe) is written into. A file with further names (hard links) keeps them. A file
that is read-only is left alone, even by root.
"""

from __future__ import annotations

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from mbdsl.errors import UsageError

PART = ".part"


@contextmanager
def writing(path: str | os.PathLike) -> Iterator[BinaryIO]:
    """A stream for the new content of ``path``; the file has it only once it is complete.

    Raises
    ------
    UsageError
        The file cannot be written, or is read-only. What was there is as it was.
    """
    try:
        there = _status(path)
        if there is None or stat.S_ISREG(there.st_mode):
            yield from _replacing(Path(os.path.realpath(path)), there)
        else:
            yield from _into(path)
    except OSError as problem:
        raise UsageError(f"cannot write `{path!s}`: {problem.strerror or problem}") from problem


def write_text(path: str | os.PathLike, text: str) -> None:
    """Write a text file in UTF-8, all or nothing.

    Raises
    ------
    UsageError
        As :func:`writing`.
    """
    with writing(path) as stream:
        stream.write(text.encode("utf-8"))


def _status(path: str | os.PathLike) -> os.stat_result | None:
    """Of what ``path`` names, links followed; None if there is nothing."""
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _replacing(target: Path, there: os.stat_result | None) -> Iterator[BinaryIO]:
    if there is not None and not _writable(target, there):
        raise PermissionError(errno.EACCES, "it is read-only")
    # a long name leaves no room for more; characters take up to 4 bytes
    part = target.with_name(f".{target.name[:50]}.{os.getpid()}{PART}")
    with suppress(FileNotFoundError):
        part.unlink()  # of a process with the same number that was killed
    kept = False
    try:
        # what others may not read, they may not read while it is written
        allowed = 0o666 if there is None else stat.S_IMODE(there.st_mode) & 0o600 | 0o200
        with open(part, "xb", opener=lambda name, flags: os.open(name, flags, allowed)) as stream:
            yield stream
        if there is not None and there.st_nlink > 1:
            kept = True
            _copy_into(part, target)
        else:
            if there is not None:
                _as_before(part, there)
            os.replace(part, target)
    finally:
        if not kept:
            part.unlink(missing_ok=True)


def _writable(target: Path, there: os.stat_result) -> bool:
    """Whether the file is writable. Root could write to a read-only file too, but that is refused as for others."""
    return bool(there.st_mode & 0o222) and os.access(target, os.W_OK)


def _as_before(part: Path, there: os.stat_result) -> None:
    """Give a new file the mode and, where that is allowed, the owner and the group of the old one."""
    if hasattr(os, "chown"):
        for owner, group in ((-1, there.st_gid), (there.st_uid, -1)):  # members of a group may give it, only root both
            with suppress(OSError):
                os.chown(part, owner, group)
    mode = stat.S_IMODE(there.st_mode)
    # what its group may do is not for another group
    os.chmod(part, mode if os.stat(part).st_gid == there.st_gid else mode & ~stat.S_IRWXG)


def _copy_into(part: Path, target: Path) -> None:
    """Of a file with several names the content is replaced, as a new file would have one of the names only."""
    try:
        with open(part, "rb") as source, open(target, "wb") as stream:
            shutil.copyfileobj(source, stream)
    except OSError as problem:
        raise OSError(problem.errno, f"{problem.strerror}; the new content is in `{part}`") from problem
    part.unlink()


def _into(path: str | os.PathLike) -> Iterator[BinaryIO]:
    """A device or a pipe gets the content when it is complete; formats may need to go back in it."""
    with tempfile.TemporaryDirectory(prefix="mbdsl-") as folder:
        part = Path(folder, "content")
        with open(part, "wb") as stream:
            yield stream
        with open(part, "rb") as source, open(path, "wb") as there:
            shutil.copyfileobj(source, there)


# -- before the work -------------------------------------------------------------------------------------------------


def check(outputs: Iterable[str | os.PathLike | None], inputs: Iterable[str | os.PathLike] = ()) -> None:
    """Say now that a file cannot be written, rather than after the work is done.

    Raises
    ------
    UsageError
        There is no such folder, the output is a folder, it cannot be written, it is one of the ``inputs``, or two
        outputs are one file.
    """
    given = [os.fspath(path) for path in outputs if path]
    known = [(name, "the model reads it") for name in (os.fspath(x) for x in inputs)]
    for path in given:
        _check(path)
        for other, why in known:
            if _same(path, other):
                raise UsageError(f"cannot write `{path}`: {why}", hint="give another name, as with --output result.csv")
        known.append((path, f"`{path}` is given for two outputs"))


def _same(a: str, b: str) -> bool:
    """Whether two names are one regular file, now or when both are written."""
    try:
        one, other = os.stat(a), os.stat(b)
    except OSError:
        return os.path.normcase(os.path.realpath(a)) == os.path.normcase(os.path.realpath(b))
    return stat.S_ISREG(one.st_mode) and os.path.samestat(one, other)


def _folder(path: str, target: Path) -> Path:
    """The folder of an output as the user named it; of a link, the one that it leads to."""
    return target.parent if os.path.islink(path) else Path(path).parent


def _check(path: str) -> None:
    try:
        there = _status(path)
        target = Path(os.path.realpath(path))
        if there is None and not target.parent.is_dir():
            raise UsageError(f"cannot write `{path}`: there is no folder `{_folder(path, target)}`")
        if there is not None and stat.S_ISDIR(there.st_mode):
            raise UsageError(f"cannot write `{path}`: it is a folder")
        if there is not None and stat.S_ISREG(there.st_mode) and not _writable(target, there):
            raise UsageError(f"cannot write `{path}`: it is read-only")
        if there is None or stat.S_ISREG(there.st_mode):
            with tempfile.NamedTemporaryFile(dir=target.parent, prefix=".mbdsl"):
                pass  # permissions do not show all that a file system refuses
    except OSError as problem:
        raise UsageError(f"cannot write `{path}`: {problem.strerror or problem}") from problem
