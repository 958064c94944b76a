"""Faults at random moments: a process that is killed, a disk that is full, a reader that has left.

Run by hand, for any length of time::

    python tests/faults/faults.py --minutes 10 --seed 7

tests/faults/test_faults.py runs a few. Each fault returns nothing, or raises AssertionError with the reason.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from mbdsl import UsageError, results

MODELS = Path(__file__).parents[2] / "models"
#: a run of some tenths of a second after the start of Python
RUN = ("simulate", str(MODELS / "slider_crank.mbd"), "--step", "2e-5", "--stop", "1s", "--quiet")
LONGEST = 300.0  #: [s] after which a process counts as hanging
EXITS = {0, 2, 4, 130, 141}  #: exit codes that mbdsl promises
OLD = b"time,x\r\n0.0,1.0\r\n"


def start(folder: Path, *arguments: str, **more) -> subprocess.Popen:
    given = {"cwd": folder, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **more}
    return subprocess.Popen([sys.executable, "-m", "mbdsl", *arguments], **given)


def ended(process: subprocess.Popen) -> str:
    """Standard error of a process, which must end with one of the exit codes and without a traceback."""
    _, said = process.communicate(timeout=LONGEST)
    assert process.returncode in EXITS, (process.returncode, said)
    assert "Traceback" not in said and "internal error" not in said, said
    return said


def whole(path: Path) -> bool:
    """Whether the result file exists; if it does, it must hold all results of RUN."""
    if not path.exists():
        return False
    columns, about = results.read(path)
    assert about["complete"] and len(columns["time"]) == 501 and all(np.isfinite(x).all() for x in columns.values())
    return True


def only(folder: Path, *names: str) -> None:
    """A folder contains these files and, at most, hidden partial files."""
    extra = {p.name for p in folder.iterdir() if not p.name.startswith(".")} - set(names)
    assert not extra, extra


# -- the faults ------------------------------------------------------------------------------------------------------
def killed(folder: Path, draw: random.Random) -> None:
    """SIGKILL at any moment: the old file or the whole new one is there, never a part of it."""
    path = folder / f"r{draw.choice(['.csv', '.npz', '.nc'])}"
    before = draw.random() < 0.5 and path.suffix == ".csv"
    if before:
        path.write_bytes(OLD)
    process = start(folder, *RUN, "--output", path.name)
    time.sleep(draw.uniform(0.0, 2.5))
    process.kill()
    process.communicate(timeout=LONGEST)
    only(folder, path.name)
    if not (before and path.read_bytes() == OLD):
        whole(path)


def killed_and_resumed(folder: Path, draw: random.Random) -> None:
    """SIGKILL during a run with checkpoints: `mbdsl resume` gives the result of a run that was not killed."""
    process = start(folder, *RUN, "--output", "r.csv", "--checkpoint", "r.cp", "--checkpoint-every", "0")
    time.sleep(draw.uniform(0.5, 2.5))
    process.kill()
    process.communicate(timeout=LONGEST)
    if (folder / "r.cp").exists():
        ended(start(folder, "resume", "r.cp"))
    else:
        ended(start(folder, *RUN, "--output", "r.csv"))
    ended(start(folder, *RUN, "--output", "same.csv"))
    assert (folder / "r.csv").read_bytes() == (folder / "same.csv").read_bytes()
    only(folder, "r.csv", "same.csv")


def interrupted(folder: Path, draw: random.Random) -> None:
    """Ctrl-C, SIGTERM or SIGHUP: the computed results are written and marked incomplete, and the exit code is that of
    the signal."""
    # a shell's background job ignores SIGINT, and under nohup SIGHUP
    code = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    code += "signal.signal(signal.SIGHUP, signal.SIG_DFL); from mbdsl.cli import main; sys.exit(main(sys.argv[1:]))"
    given = {"cwd": folder, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-c", code, *RUN, "--output", "r.csv"], **given)
    time.sleep(draw.uniform(1.0, 2.5))
    process.send_signal(draw.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP]))
    _, said = process.communicate(timeout=LONGEST)
    if process.returncode in (0, 130) and "import" not in said and (folder / "r.csv").exists():
        columns, about = results.read(folder / "r.csv")
        assert about["complete"] == (columns["time"][-1] == 1.0), about
        assert process.returncode == 130 or about["complete"]
    only(folder, "r.csv", "r.csv.incomplete")


def disk_full(folder: Path, draw: random.Random) -> None:
    """The size of files is limited: the old file stays as it was, and the exit code reports the failure."""
    import resource

    limit = draw.randrange(0, 40_000)
    (folder / "r.csv").write_bytes(OLD)

    def bounded() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    process = start(folder, *RUN, "--output", "r.csv", preexec_fn=bounded)
    said = ended(process)
    if process.returncode == 0:
        assert whole(folder / "r.csv")
    else:
        assert "cannot write `r.csv`" in said, said
        assert (folder / "r.csv").read_bytes() == OLD
    only(folder, "r.csv")


def reader_gone(folder: Path, draw: random.Random) -> None:
    """Standard output or standard error is a closed pipe: the result file is complete all the same."""
    read, write = os.pipe()
    os.close(read)
    which = draw.choice(["stdout", "stderr"])
    arguments = [x for x in RUN if x != "--quiet"]
    process = start(folder, *arguments, "--output", "r.csv", **{which: write})
    os.close(write)
    process.communicate(timeout=LONGEST)
    assert process.returncode in EXITS, process.returncode
    assert whole(folder / "r.csv")


def cut(folder: Path, draw: random.Random) -> None:
    """A result file that was cut anywhere is refused when it is read."""
    path = folder / f"r{draw.choice(['.csv', '.npz'])}"
    n = draw.randrange(1, 600)
    results.write(path, {"time": np.linspace(0.0, 1.0, n), "x": np.sin(np.arange(n))})
    content = path.read_bytes()
    path.write_bytes(content[: draw.randrange(len(content))])
    try:
        results.read(path)
    except UsageError:
        return
    raise AssertionError(f"{path.name} of {n} rows, cut to {path.stat().st_size} of {len(content)} bytes, was read")


FAULTS = (killed, killed_and_resumed, interrupted, disk_full, reader_gone, cut)


def one(fault, seed: int) -> None:
    """Run a fault in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="mbdsl-fault-") as folder:
        fault(Path(folder), random.Random(seed))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mbdsl-fault-") as folder:
        ended(start(Path(folder), *RUN))  # compile once
    until, count, wrong = time.monotonic() + 60.0 * args.minutes, Counter[str](), 0
    while time.monotonic() < until:
        seed = args.seed + count.total()
        fault = FAULTS[count.total() % len(FAULTS)]
        count[fault.__name__] += 1
        try:
            one(fault, seed)
        except (AssertionError, subprocess.TimeoutExpired, UsageError) as problem:
            wrong += 1
            print(f"{fault.__name__}, seed {seed}: {problem}", flush=True)
    print(f"{count.total()} faults, {wrong} of them with a wrong result: {dict(count)}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
