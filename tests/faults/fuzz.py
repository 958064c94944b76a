"""Fuzzing of the language for any length of time: tests/unit/lang/test_fuzz.py with one seed after another.

::

    python tests/faults/fuzz.py --minutes 10 --seed 7

The test suite runs the same tests with fixed examples.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
TESTS = "tests/unit/lang/test_fuzz.py"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    until, seed = time.monotonic() + 60.0 * args.minutes, args.seed
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-k", "not bombs", TESTS]
    while time.monotonic() < until:
        found = subprocess.run(
            [*command, f"--hypothesis-seed={seed}"],
            cwd=ROOT,
            env={**os.environ, "MBDSL_FUZZ": "2"},  # above 1, examples depend on the seed
            capture_output=True,
            text=True,
        )
        if found.returncode:
            sys.exit(f"seed {seed}:\n{found.stdout}{found.stderr}")
        seed += 1
    print(f"{seed - args.seed} seeds, nothing wrong")


if __name__ == "__main__":
    main()
