"""The measurements behind the pages of docs/decisions/.

    python tests/benchmarks/decisions.py [translator] [parser] [svg] [--repeats 5]

``translator``: the equations of a model compiled in processes with empty and with full caches.
``parser``: the parser's own loop, and Lark's with the same tokens; and what a process pays for importing Lark.
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
parser.parse(open({str(MODEL)!r}, encoding="utf-8").read())
if by_lark:
    import lark
    with open({{saved!r}}, "rb") as stream:
        lark.Lark.load(stream)
print(time.process_time() - begin)
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
    import lark
    from lark.lexer import Lexer

    from mbdsl.lang import lalr
    from mbdsl.lang import parser as own
    from mbdsl.lang.lexer import tokenize
    from mbdsl.lang.source import Source

    text = MODEL.read_text(encoding="utf-8") * COPIES
    source = Source(str(MODEL), text)
    tokens = tokenize(source)

    class Given(Lexer):
        """The tokens of mbdsl, for Lark."""

        def __init__(self, conf: object) -> None:
            pass

        def lex(self, data: object) -> Iterator[lark.Token]:
            return (lark.Token(token.type, token.text) for token in tokens if token.type != "$END")

    options = {"parser": "lalr", "start": list(lalr.STARTS), "maybe_placeholders": False}
    grammar = lalr.GRAMMAR.read_text(encoding="utf-8")
    theirs = lark.Lark(grammar, lexer=Given, **options)
    yield f"{len(tokens)} tokens, without cutting them"
    lalr.tables()
    builders = own._Builders(source).table()
    yield f"  own loop, to the nodes of the syntax tree {best(repeats, lambda: _own(lalr, tokens, builders)):8.3f} s"
    yield f"  Lark, to its trees                        {best(repeats, lambda: _lark(theirs, text)):8.3f} s"
    yield f"a process that parses {MODEL.stem}, from its first import"
    with tempfile.TemporaryDirectory() as folder:
        saved = Path(folder) / "saved.lark"
        with saved.open("wb") as stream:
            lark.Lark(grammar, lexer="basic", **options).save(stream)
        for name, choice in (("as it is", "by_lark = False"), ("and loads a saved parser of Lark", "by_lark = True")):
            code = choice + PARSE.replace("{saved!r}", repr(str(saved)))
            yield f"  {name:42}{best(repeats, lambda code=code: printed(code, folder)):8.3f} s"


def _own(lalr, tokens, builders) -> float:
    return processor_time(lambda: lalr.parse(tokens, "file", builders))


def _lark(theirs, text: str) -> float:
    return processor_time(lambda: theirs.parse(text, start="file"))


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
