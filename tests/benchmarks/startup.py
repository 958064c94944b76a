"""Waiting times of a user: whole processes from a shell, on a fresh machine and later.

    python tests/benchmarks/startup.py [--rounds 2] [--repeats 5]

A round begins with an empty folder MBDSL_CACHE_DIR, as on a fresh machine (Python's own caches of compiled sources
stay, as after an installation), and runs the commands below in their order. Before a command is repeated, the script
waits until the folder does not change any more, because code may be compiled in other processes after a command has
ended. Wall-clock times: a busy machine makes them longer. Nothing is asserted.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

MODELS = Path(__file__).parents[2] / "models"
QUIET, LONGEST = 2.0, 120.0  #: seconds without a change of the folder, and the longest wait for them


@dataclass(frozen=True)
class Wait:
    """A command, the text that describes it, and whether it is repeated within a round."""

    text: str
    command: Sequence[str]
    again: bool = False


def simulate(model: str, *more: str) -> list[str]:
    return ["simulate", str(MODELS / f"{model}.mbd"), "--quiet", "--output", "out.csv", *more]


WAITS = (
    Wait("--help", ["--help"], True),
    Wait("the very first run: simulate slider_crank", simulate("slider_crank")),
    Wait("the same again", simulate("slider_crank"), True),
    Wait("with another number", simulate("slider_crank", "--set", "L1=0.31 m"), True),
    Wait("another structure: check seven_body", ["check", str(MODELS / "seven_body.mbd")]),
    Wait("the same again", ["check", str(MODELS / "seven_body.mbd")], True),
    Wait("another structure: simulate seven_body", simulate("seven_body")),
    Wait("the same again", simulate("seven_body"), True),
    Wait("another method: simulate --method radau5", simulate("slider_crank", "--method", "radau5")),
    Wait("the same again", simulate("slider_crank", "--method", "radau5"), True),
)


def seconds(arguments: Sequence[str], cache: str, folder: str) -> float:
    """One process from start to end.

    Raises
    ------
    RuntimeError
        If the command fails.
    """
    paths = [p for p in sys.path if p]
    environment = {**os.environ, "MBDSL_CACHE_DIR": cache, "PYTHONPATH": os.pathsep.join(paths)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package has its bytecode
    begun = time.perf_counter()
    ran = subprocess.run(
        [sys.executable, "-m", "mbdsl", *arguments], env=environment, cwd=folder, capture_output=True, text=True
    )
    spent = time.perf_counter() - begun
    if ran.returncode:
        raise RuntimeError(f"mbdsl {' '.join(arguments)} returned {ran.returncode}:\n{ran.stderr}")
    return spent


def settled(folder: str) -> None:
    """Wait until no file of a folder changes."""
    begun, before, since = time.perf_counter(), None, time.perf_counter()
    while time.perf_counter() - since < QUIET and time.perf_counter() - begun < LONGEST:
        now = {path: _size(path) for path in Path(folder).rglob("*")}
        if now != before:
            before, since = now, time.perf_counter()
        time.sleep(QUIET / 10.0)


def _size(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except OSError:  # removed in the meantime
        return 0, 0
    return found.st_size, found.st_mtime_ns


def measure(rounds: int = 2, repeats: int = 5, waits: Sequence[Wait] = WAITS) -> list[list[float]]:
    """The seconds of every command."""
    found: list[list[float]] = [[] for _ in waits]
    for _ in range(rounds):
        with (
            tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as cache,
            tempfile.TemporaryDirectory() as folder,
        ):
            for wait, spent in zip(waits, found, strict=True):
                if wait.again:
                    settled(cache)
                spent += [seconds(wait.command, cache, folder) for _ in range(repeats if wait.again else 1)]
            settled(cache)
    return found


def table(rounds: int = 2, repeats: int = 5, waits: Sequence[Wait] = WAITS) -> str:
    return as_text(measure(rounds, repeats, waits), waits)


def as_text(found: Sequence[Sequence[float]], waits: Sequence[Wait] = WAITS) -> str:
    lines = [f"{'seconds':42} {'least':>7} {'median':>7}"]
    for wait, spent in zip(waits, found, strict=True):
        lines.append(f"{wait.text:42} {min(spent):7.2f} {median(spent):7.2f}")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=2, help="rounds with an empty folder")
    parser.add_argument("--repeats", type=int, default=5, help="runs of a command whose code is compiled, in a round")
    given = parser.parse_args()
    print(table(given.rounds, given.repeats))
