"""Times and memory of results of many rows: simulated to a file, plotted, animated, converted, shown by `info`.

    python tests/benchmarks/long_results.py [--rows 1e7] [--folder FOLDER]

prints for each command the processor time and the largest memory of its process, and that of the same command with a
hundredth of the rows, which shows whether the memory grows.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from mbdsl import results
from mbdsl.cli import main
from mbdsl.results.rows_file import RowsFile
from mbdsl.results.stored import open_result

MODEL = Path(__file__).resolve().parents[2] / "models" / "slider_crank.mbd"
CHILD = """
import resource, sys
from mbdsl.cli import main
code = main(sys.argv[1:])
own = resource.getrusage(resource.RUSAGE_SELF)
print(code, own.ru_utime + own.ru_stime, own.ru_maxrss / (1024 if sys.platform == "linux" else 1024**2))
"""


def repeated(short, path, rows):
    """A result with the rows of a short one, over and over, at ascending times; in .csv without velocities."""
    columns = results.read(short)[0]
    result = open_result(short)
    if path.suffix == ".csv":
        columns = {name: x for name, x in columns.items() if name.endswith((".x", ".y", ".phi", "time"))}
    names, period = list(columns), columns["time"][-1] + columns["time"][1]
    block = np.array([np.tile(columns[name], 200) for name in names])
    many = len(columns["time"])
    block[0] += np.repeat(np.arange(200), many) * period
    with RowsFile(names, path) as file:
        while file.count < rows:
            file.append(block[:, : rows - file.count])
            block[0] += 200 * period
        units = {name: result.unit(name) for name in names}
        meta = result.layout.meta
        results.write(path, file.columns(), units, meta if path.suffix == ".npz" else {"complete": True})


def measured(*command):
    began = time.perf_counter()
    found = subprocess.run((sys.executable, "-c", CHILD, *map(str, command)), capture_output=True, text=True)
    if found.returncode:
        raise SystemExit(found.stderr)
    code, seconds, memory = found.stdout.split()[-3:]
    assert code == "0", found.stderr
    return time.perf_counter() - began, float(seconds), float(memory)


def commands(folder, rows):
    span = f"{rows * 1e-5:.17g}s"
    yield "simulate to npz", ("simulate", MODEL, "--step", "10us", "--interval", "10us", "--stop", span, "--quiet")
    for suffix in ("npz", "csv"):
        own = folder / f"{rows}.{suffix}"
        yield f"plot {suffix}", ("plot", own, "--signals", "crank.phi,rod.x,rod.y", "--out", folder / "p.svg")
        animate = ("animate", own) if suffix == "npz" else ("animate", MODEL, "--result", own)
        yield f"animate {suffix}", (*animate, "--out", folder / "a.html")
        yield f"info {suffix}", ("info", own)
    yield "convert npz to mat", ("convert", folder / f"{rows}.npz", "--out", folder / "c.mat")


def run(rows, folder, only=""):
    table = {}
    for count in (max(2, rows // 100), rows):
        short = folder / "short.npz"
        assert main(["simulate", str(MODEL), "--output", str(short), "--quiet"]) == 0
        for suffix in (".npz", ".csv"):
            repeated(short, folder / f"{count}{suffix}", count)
        for name, command in commands(folder, count):
            if only not in name:
                continue
            out = ("--output", folder / "s.npz") if name.startswith("simulate") else ()
            table.setdefault(name, []).append(measured(*command, *out))
        for file in folder.iterdir():
            file.unlink()
    print(f"{'':<20}{'wall [s]':>10}{'processor [s]':>15}{'memory [MB]':>13}{f'with {rows // 100} rows':>20}")
    for name, (few, many) in table.items():
        print(f"{name:<20}{many[0]:>10.1f}{many[1]:>15.1f}{many[2]:>13.0f}{few[2]:>17.0f} MB")
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=float, default=1e7)
    parser.add_argument("--folder", help="where the files are written: 100 MB per million rows and file")
    parser.add_argument("--only", default="", help="commands whose name contains this text")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=given.folder) as name:
        run(int(given.rows), Path(name), given.only)
