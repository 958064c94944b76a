"""Waiting times of a user: whole-process times of commands, from a shell, cold and warm.

python tests/benchmarks/startup.py [--repeats 5]

Cold is a fresh MBDSL_CACHE_DIR, as on a machine's first run (Python's own caches of compiled sources stay). Nothing is
asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

MODEL = Path(__file__).parents[2] / "models" / "slider_crank.mbd"
COMMANDS = {
    "mbdsl --help": ["--help"],
    "mbdsl check --quick": ["check", str(MODEL), "--quick"],
    "mbdsl check": ["check", str(MODEL)],
    "mbdsl signals": ["signals", str(MODEL)],
    "mbdsl simulate, hht-si2": ["simulate", str(MODEL), "--method", "hht-si2", "--quiet", "--output", "out.csv"],
    "mbdsl simulate, hht-i3": ["simulate", str(MODEL), "--method", "hht-i3", "--quiet", "--output", "out.csv"],
}


def seconds(arguments: list[str], cache: str, folder: str) -> float:
    """One process from start to end."""
    paths = [p for p in sys.path if p]
    environment = {**os.environ, "MBDSL_CACHE_DIR": cache, "PYTHONPATH": os.pathsep.join(paths)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package has its bytecode
    begun = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "mbdsl", *arguments], env=environment, cwd=folder, check=True, stdout=subprocess.DEVNULL
    )
    return time.perf_counter() - begun


def table(repeats: int = 5, commands: dict[str, list[str]] = COMMANDS) -> str:
    lines = [f"{'seconds':26} {'cold':>7} {'warm: min':>10} {'median':>7}"]
    for name, arguments in commands.items():
        with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as folder:
            cold = seconds(arguments, cache, folder)
            warm = [seconds(arguments, cache, folder) for _ in range(repeats)]
        lines.append(f"{name:26} {cold:7.2f} {min(warm):10.2f} {median(warm):7.2f}")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    print(table(parser.parse_args().repeats))
