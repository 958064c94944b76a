"""The measurements behind the pages of docs/decisions/.

    python tests/benchmarks/decisions.py [translator] [parser] [svg] [--repeats 5]

``translator``: the equations of a model compiled in processes with empty and with full caches.
``parser``: tokens and the tree of a long text; a process that parses one model, with its parts; `mbdsl check`.
``svg``: a plot as SVG by mbdsl, and by matplotlib. Without a name all three. Times are processor times, the
smallest of the repeats. The matrices have a script of their own, ``sparse_solvers.py``. Nothing is asserted.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODEL = ROOT / "models" / "seven_body.mbd"
COPIES = 40  #: of the model in the text that is parsed in one process

EQUATIONS = f"""
import time
from mbdsl.lang.load import load
from mbdsl.system import build
system = build(load({str(MODEL)!r}))
begin = time.process_time()
system.kernels(2)
print(time.process_time() - begin)
"""
PARSE = f"""
import time
begin = time.process_time()
from mbdsl.lang import parser
imported = time.process_time()
parser._lark()
loaded = time.process_time()
parser.parse(open({str(MODEL)!r}, encoding="utf-8").read())
print({{what}})
"""
CHECK = f"""
import sys, time
from mbdsl.__main__ import main
sys.argv = ["mbdsl", "check", {str(ROOT / "models" / "slider_crank.mbd")!r}]
sys.stdout = sys.stderr
code = main()
print(time.process_time(), file=sys.__stdout__)
"""


PLOT = f"""
import time, mbdsl
run = mbdsl.simulate({str(MODEL)!r}, step="0.1 ms")
names = ["K1.phi", "K2.phi", "K3.phi", "K4.phi"]
begin = time.process_time()
"""
OWN_PLOT = """
run.plot(names, out=FILE)
"""
THEIR_PLOT = """
from matplotlib.figure import Figure
figure = Figure(figsize=(8.6, 4.3))
axes = figure.add_subplot()
for name in names:
    axes.plot(run.t, run[name], label=name)
axes.legend()
axes.grid()
figure.savefig(FILE)
"""


def printed(code: str, cache: str) -> float:
    """The number that a new process prints."""
    environment = {**os.environ, "MBDSL_CACHE_DIR": cache, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    command = [sys.executable, "-c", code]
    return float(subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout)


def best(repeats: int, measure: Callable[[], float]) -> float:
    return min(measure() for _ in range(repeats))


def processor_time(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def translator(repeats: int) -> Iterator[str]:
    yield f"equations of {MODEL.stem}, processor time with the imports of the compiler: compiled, and loaded later"
    first, later = [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as cache:
            first.append(printed(EQUATIONS, cache))
            later.append(printed(EQUATIONS, cache))
    yield f"  {min(first):8.3f} s {min(later):8.3f} s"


def parser(repeats: int) -> Iterator[str]:
    from mbdsl.lang import parser as read
    from mbdsl.lang.lexer import tokenize
    from mbdsl.lang.source import Source

    source = Source(str(MODEL), MODEL.read_text(encoding="utf-8") * COPIES)
    tokens = tokenize(source)
    read._file(tokens)
    yield f"{len(tokens)} tokens"
    for name, work in (("cut", lambda: tokenize(source)), ("to a syntax tree", lambda: read._file(tokens))):
        yield f"  {name:42}{best(repeats, lambda work=work: processor_time(work)):8.3f} s"
    yield f"a process that parses {MODEL.stem}, with a full cache"
    with tempfile.TemporaryDirectory() as folder:
        parts = {"imports of mbdsl": "imported - begin", "import of Lark, and its tables": "loaded - imported"}
        for name, what in {**parts, "the model": "time.process_time() - loaded"}.items():
            code = PARSE.replace("{what}", what)
            printed(code, folder)
            yield f"  {name:42}{best(repeats, lambda code=code: printed(code, folder)):8.3f} s"
        yield f"mbdsl check of slider_crank {best(repeats, lambda: printed(CHECK, folder)):23.3f} s"


def svg(repeats: int) -> Iterator[str]:
    yield f"a plot of four angles of {MODEL.stem} from a trajectory, with the imports; size of the file"
    with tempfile.TemporaryDirectory() as folder:
        for name, work in (("mbdsl", OWN_PLOT), ("matplotlib", THEIR_PLOT)):
            file = Path(folder) / f"{name}.svg"
            code = PLOT + work.replace("FILE", repr(str(file))) + "print(time.process_time() - begin)\n"
            seconds = best(repeats, lambda code=code: printed(code, folder))
            yield f"  {name:12} {seconds:8.3f} s {file.stat().st_size / 1e3:8.0f} kB"


def main() -> None:
    measurements = {"translator": translator, "parser": parser, "svg": svg}
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of {', '.join(measurements)}")
    arguments.add_argument("--repeats", type=int, default=5)
    given = arguments.parse_args()
    for name in given.names or measurements:
        for line in measurements[name](given.repeats):
            print(line, flush=True)


if __name__ == "__main__":
    main()
