"""Whether a folder and its files are the user's own."""

from __future__ import annotations

import os
import stat
from pathlib import Path

OTHERS = stat.S_IWGRP | stat.S_IWOTH  #: write permissions of the group and of other users


def fault_of(folder: Path) -> str:
    """The reason why others can change the content of a folder; "" if they cannot, or if there is none."""
    try:
        status = folder.stat()
    except FileNotFoundError:
        return ""
    except OSError as problem:
        return f"`{folder}` cannot be reached ({problem.strerror})"
    if not stat.S_ISDIR(status.st_mode):
        return f"`{folder}` is not a folder"
    if not _belongs_to_us(status):
        return f"`{folder}` belongs to {_user(status.st_uid)} (try: set MBDSL_CACHE_DIR to a folder of your own)"
    if not is_ours(status):
        return f"others can write into `{folder}` (mode {stat.S_IMODE(status.st_mode):04o}; try: chmod go-w {folder})"
    return ""


def _belongs_to_us(status: os.stat_result) -> bool:
    """Whether a file belongs to the user or to root, whose number is another one in a user namespace: that of ``/``."""
    return not hasattr(os, "geteuid") or status.st_uid in (0, os.geteuid(), os.stat(os.sep).st_uid)


def is_ours(status: os.stat_result) -> bool:
    """Whether only the user or root can write a file or folder with this status."""
    return _belongs_to_us(status) and not (hasattr(os, "geteuid") and status.st_mode & OTHERS)


def _user(number: int) -> str:
    try:
        import pwd

        return f"user {pwd.getpwuid(number).pw_name}"
    except (ImportError, KeyError):
        return f"user {number}"
