"""Writing files: atomically, with the mode of the existing file, and never over the model or another output.

Devices and pipes are written into. A file with several names (hard links) keeps them. A read-only file is not written,
even by root. Several threads, processes and machines may write at the same time, even the same file: each writer has a
temporary file of its own.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from mbdsl.errors import UsageError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PART = ".part"  #: suffix of temporary files
NEW = ".new"  #: suffix of a complete file whose content could not be copied


@contextmanager
def writing(path: str | os.PathLike) -> Iterator[BinaryIO]:
    """A stream for the new content of ``path``; the file gets the content when it is complete.

    Raises
    ------
    UsageError
        If the file cannot be written or is read-only. The existing file is then unchanged.
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
    """Write a text file in UTF-8 atomically.

    Raises
    ------
    UsageError
        As :func:`writing`.
    """
    with writing(path) as stream:
        stream.write(text.encode("utf-8"))


def _status(path: str | os.PathLike) -> os.stat_result | None:
    """The status of the file that ``path`` names, after following links; None if there is none."""
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _replacing(target: Path, there: os.stat_result | None) -> Iterator[BinaryIO]:
    if there is not None and not _writable(target, there):
        raise PermissionError(errno.EACCES, "it is read-only")
    _remove_abandoned(target)
    # others must not read it while it is written if they may not read the result
    allowed = 0o666 if there is None else stat.S_IMODE(there.st_mode) & 0o600 | 0o200
    with _new_part(target, allowed) as (stream, part):
        yield stream
        stream.flush()
        os.fsync(stream.fileno())
        stream.close()
        if there is not None and there.st_nlink > 1:
            _copy_into(part, target)
        else:
            if there is not None:
                _as_before(part, there)
            os.replace(part, target)


def _beginning(target: Path) -> str:
    """The beginning of the names of temporary files; shortened for long names, whose characters take up to 4 bytes."""
    return f".{target.name[:50]}."


@contextmanager
def _new_part(target: Path, mode: int) -> Iterator[tuple[BinaryIO, Path]]:
    """A temporary file beside ``target``, which no other writer uses: its stream, and its name.

    It is locked until it is renamed or removed, by a second descriptor because the stream is closed before.
    """
    while True:
        part = target.with_name(f"{_beginning(target)}{secrets.token_hex(8)}{PART}")
        stream = open(part, "xb", opener=lambda name, flags: os.open(name, flags, mode))  # noqa: SIM115
        held = None
        try:
            if fcntl is not None:
                held = os.dup(stream.fileno())
                if _lock(held, wait=True) and not part.exists():
                    continue  # another writer has removed it as abandoned before it was locked
            yield stream, part
            return
        finally:
            with suppress(OSError):  # it is closed already, unless the writing has failed
                stream.close()
            if held is not None:
                os.close(held)
            part.unlink(missing_ok=True)


def _lock(file: int, wait: bool = False) -> bool:
    """Lock an open file; False if another writer has locked it, or if the system has no locks."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # also some network file systems
        return False
    return True


def _remove_abandoned(target: Path) -> None:
    """Remove the temporary files of ``target`` that killed writers have left: those that are not locked."""
    name = re.compile(re.escape(_beginning(target)) + r"([0-9a-f]{16}|\d+)" + re.escape(PART))
    with suppress(OSError), os.scandir(target.parent) as entries:
        for path in [entry.path for entry in entries if name.fullmatch(entry.name)]:
            with suppress(OSError):
                file = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
                try:
                    if _lock(file):
                        os.unlink(path)
                finally:
                    os.close(file)


def _writable(target: Path, there: os.stat_result) -> bool:
    """Whether the file is writable. A read-only file is not, not even for root."""
    return bool(there.st_mode & 0o222) and os.access(target, os.W_OK)


def _as_before(part: Path, there: os.stat_result) -> None:
    """Give a new file the mode and, if permitted, the owner and the group of the old one."""
    if hasattr(os, "chown"):
        for owner, group in ((-1, there.st_gid), (there.st_uid, -1)):  # members of a group may set it, only root both
            with suppress(OSError):
                os.chown(part, owner, group)
    mode = stat.S_IMODE(there.st_mode)
    # the permissions of the group must not apply to another group
    os.chmod(part, mode if os.stat(part).st_gid == there.st_gid else mode & ~stat.S_IRWXG)


def _copy_into(part: Path, target: Path) -> None:
    """Replace the content of a file with several names, because a new file would have only one of them."""
    try:
        with open(part, "rb") as source, open(target, "wb") as stream:
            shutil.copyfileobj(source, stream)
    except OSError as problem:
        kept = part.with_suffix(NEW)
        os.replace(part, kept)
        raise OSError(problem.errno, f"{problem.strerror}; the new content is in `{kept}`") from problem


def _into(path: str | os.PathLike) -> Iterator[BinaryIO]:
    """Write the complete content into a device or a pipe; formats may need to seek before."""
    with tempfile.TemporaryDirectory(prefix="mbdsl-") as folder:
        part = Path(folder, "content")
        with open(part, "wb") as stream:
            yield stream
        with open(part, "rb") as source, open(path, "wb") as there:
            shutil.copyfileobj(source, there)


# -- before the work -------------------------------------------------------------------------------------------------


def suffix_of(path: str | os.PathLike | None, known: Sequence[str]) -> str:
    """The suffix of an output file, in lower case; "" without a file.

    Raises
    ------
    UsageError
        If it is not one of the ``known``.
    """
    if path is None:
        return ""
    suffix = Path(path).suffix
    if suffix.lower() not in known:
        problem = f"unknown suffix `{suffix}` of" if suffix else "no suffix on"
        raise UsageError(f"{problem} `{path!s}`", hint=f"known suffixes are {', '.join(known)}")
    return suffix.lower()


def check(outputs: Iterable[str | os.PathLike | None], inputs: Iterable[str | os.PathLike] = ()) -> None:
    """Check before the work begins that files can be written.

    Raises
    ------
    UsageError
        If the folder does not exist, the output is a folder or cannot be written, it is one of the ``inputs``, or two
        outputs are the same file.
    """
    given = [os.fspath(path) for path in outputs if path]
    known = [(name, "it is an input of this command") for name in (os.fspath(x) for x in inputs)]
    for path in given:
        _check(path)
        for other, why in known:
            if _same(path, other):
                raise UsageError(f"cannot write `{path}`: {why}", hint="give another name, as with --output result.csv")
        known.append((path, f"`{path}` is given for two outputs"))


def _same(a: str, b: str) -> bool:
    """Whether two names are the same regular file, now or when both are written."""
    try:
        one, other = os.stat(a), os.stat(b)
    except OSError:
        return os.path.normcase(os.path.realpath(a)) == os.path.normcase(os.path.realpath(b))
    return stat.S_ISREG(one.st_mode) and os.path.samestat(one, other)


def _folder(path: str, target: Path) -> Path:
    """The folder of an output as the user named it; for a link, that of its target."""
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
                pass  # permissions do not show all restrictions of a file system
    except OSError as problem:
        raise UsageError(f"cannot write `{path}`: {problem.strerror or problem}") from problem
