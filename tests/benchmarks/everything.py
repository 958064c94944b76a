"""All measured figures of README.md, docs/speed.md and docs/work-precision.md, by one command.

    python tests/benchmarks/everything.py [--only PART ...] [--repeats 2] [--dry]

measures on this machine, prints every table, and writes the figures into the pages, between the marks of
:mod:`doc_parts`. It takes some minutes, and needs a machine without other work, and the extras ``bench`` and ``plot``.
With ``--dry`` nothing is written. A figure whose program is not installed keeps its old value. No figure is asserted.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from statistics import median

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import against_exudyn
import against_mujoco
import growth
import sparse_solvers
import startup
import work_precision
from doc_parts import ROOT, markdown, put, rounded, spread
from work_precision_text import conclusions

import mbdsl
from mbdsl.studies.error_measures import error, quantities
from mbdsl.studies.report import as_text

Texts = dict[str, str]  #: "page: part" -> text
FOLDER = ROOT / "docs" / "work-precision"
PAGES = {
    "README": ROOT / "README.md",
    "speed": ROOT / "docs" / "speed.md",
    "work-precision": ROOT / "docs" / "work-precision.md",
}
#: names of the rows of docs/speed.md
NAMES = {
    "pendulum": "pendulum",
    "slider_crank": "slider crank",
    "seven_body": "seven bodies",
    "four_bar_2": "four-bar, 2 loops",
    "four_bar_40": "four-bar, 40 loops",
    "chain_8": "chain, 8 links",
    "chain_64": "chain, 64 links",
    "chain_512": "chain, 512 links",
    "chain_4096": "chain, 4,096 links",
}
MATRICES = (
    ("slider_crank", 0, "slider crank"),
    ("seven_body", 0, "seven bodies"),
    ("four_bar", 40, "four-bar, 40 loops"),
    ("chain", 64, "chain, 64 links"),
    ("chain", 512, "chain, 512 links"),
    ("chain", 4096, "chain, 4,096 links"),
)
BUDGET, PATIENCE = 200.0, 4.0  #: seconds of our runs of a model, and of one run of Exudyn
CONSTRAINED = ("slider_crank", "double_pendulum", "seven_body", "four_bar")


def exudyn(repeats: int) -> Texts:
    """Ratios of times to Exudyn's on nine models."""
    if find_spec("exudyn") is None:
        print("Exudyn is not installed: pip install 'mbdsl[bench]'")
        return {}
    warnings.simplefilter("ignore", DeprecationWarning)  # Exudyn renames its items from time to time
    exu = against_exudyn.load()
    found = []
    for case in against_exudyn.CASES:
        shorter = replace(case, halvings=case.halvings - 1)  # the smallest step takes half of the time
        found.append(against_exudyn.compare(exu, shorter, repeats))
        print(against_exudyn.verdict(found[-1]), flush=True)
    valid = [c for c in found if not c.void and len(c.errors())]
    ratios = {c.case.name: [r[1] for r in against_exudyn.worst(c)] for c in valid}
    rows = [(NAMES[name], f"{step:.2f}", f"{other:.2f}") for name, (step, other) in ratios.items()]
    texts = {
        "speed: against Exudyn": markdown(("model", "equal step", "equal error"), rows),
        "speed: version of Exudyn": ".".join(against_exudyn.version("exudyn").split(".")[:2]),
        "README: Exudyn": spread([other for _, other in ratios.values()], 2),
    }
    for c in valid:
        if c.case.name == "pendulum":
            smallest = c.smallest()
            us = [1e6 * smallest[m][k] / (n - 1) for m in against_exudyn.METHODS for k, n in enumerate(c.sizes)]
            texts["speed: step of the pendulum"] = rounded(min(us), 1)
    kept = [seen.matrices for c in valid for m in against_exudyn.METHODS for seen in c.curves[m].seen]
    texts["speed: steps per factorisation"] = spread([1.0 / m for m in kept if m > 0.0])
    return texts


def size(repeats: int) -> Texts:
    """Cost of large models."""
    rows, growing, adding, by_links = [], [], [], {}
    for model, unit in (("chain", "links"), ("four_bar", "loops")):
        costs = growth.measure(model, growth.SIZES[model], repeats)
        print("\n".join(growth.rows(model, costs)), flush=True)
        for method, sizes in costs.items():
            least = {n: min(cost.us) for n, cost in sizes.items()}
            first, last = min(least), max(least)
            power = growth.exponent(least, least.values())
            name = f"{model.replace('_', '-')}, {first} ... {last:,} {unit}, `{method}`"
            of_iteration = growth.exponent(least, [us / sizes[n].iterations for n, us in least.items()])
            of_adding = growth.exponent(least, [min(cost.adding) for cost in sizes.values()])
            exponents = (f"{power:.2f}", f"{of_iteration:.2f}", f"{of_adding:.2f}")
            rows.append((name, f"{rounded(least[first])} ... {rounded(least[last])}", *exponents))
            if model == "chain":
                each = {n: us / n / sizes[n].iterations for n, us in least.items()}
                growing.append(each[last] / each[first])
                adds = {n: min(cost.adding) / n for n, cost in sizes.items()}
                adding.append(adds[last] / adds[first])
                by_links[method] = sizes
    links = [
        (
            f"{n:,}",
            *(
                text
                for sizes in by_links.values()
                for us in [min(sizes[n].us)]
                for text in (rounded(us), f"{us / n:.2f}", f"{sizes[n].iterations:.1f}", f"{sizes[n].matrices:.2f}")
            ),
        )
        for n in growth.SIZES["chain"]
    ]
    heads = ("µs a step", "and link", "iterations", "matrices")
    processes = growth.processes(growth.PROCESSES, min(repeats, 3))
    print("\n".join(growth.of_processes(processes)), flush=True)
    last = max(growth.PROCESSES)
    fresh = [sizes[last] for sizes in processes.values()]
    memory, seconds = max(max(f.memory) for f in fresh), max(median(f.seconds) for f in fresh)
    most = max(cost.traffic for cost in by_links[growth.METHODS[-1]].values())
    largest = processes[growth.METHODS[-1]]
    _, each_link = growth.beyond({n: max(f.memory) for n, f in largest.items()})
    stages = [
        (
            f"{n:,}",
            *(f"{x:.2f}" for x in (*f.best, sum(f.best))),
            f"{max(f.memory):.0f}",
            kb,
            f"{1024 * f.buffers / n:.1f}",
        )
        for (n, f), kb in zip(largest.items(), ["", *(f"{1024 * mb:.0f}" for mb in each_link)], strict=True)
    ]
    return {
        "speed: size": markdown(
            ("", "microseconds a step", "exponent of growth", "of an iteration", "of adding arrays"), rows
        ),
        "speed: links": markdown(("links", *(f"`{m}`: {h}" for m in by_links for h in heads)), links),
        "speed: stages": markdown(
            ("links", *(f"{x} [s]" for x in (*growth.STAGES, "total")), "peak [MB]", "kB a link", "of buffers"), stages
        ),
        "speed: memory": f"{rounded(memory)} MB",
        "speed: set-up": f"{rounded(seconds)} s",
        "speed: memory of a link": f"{rounded(1024 * each_link[-1])} kB",
        "speed: growth of an iteration": spread(growing, 2),
        "speed: growth of adding": spread(adding, 2),
        "speed: traffic": f"{rounded(most / max(growth.SIZES['chain']) / 1e3)} kB",
    }


def matrices(repeats: int) -> Texts:
    """Times of sparse factorisations."""
    rows, ratios = [], []
    for model, n, name in MATRICES:
        costs = {cost.solver.split(",")[0]: cost for cost in sparse_solvers.compare(model, n, repeats)[::-1]}
        print("\n".join(map(str, costs.values())), flush=True)
        ours, theirs, dense = costs["ours"], costs["SuperLU"], costs.get("LAPACK")
        three = (ours, theirs, dense)
        factor = ["" if cost is None else rounded(cost.factor) for cost in three]
        solve = ["" if cost is None else rounded(cost.solve) for cost in three]
        rows.append((name, str(ours.unknowns), *factor, *solve))
        if ours.unknowns > 1000:
            ratios += [theirs.factor / ours.factor, theirs.solve / ours.solve]
    columns = ("matrix", "unknowns", "factorise: mbdsl", "SuperLU", "LAPACK", "solve: mbdsl", "SuperLU", "LAPACK")
    return {"speed: matrices": markdown(columns, rows), "speed: SuperLU": spread(ratios)}


def shell(repeats: int) -> Texts:
    """Waiting times of commands."""
    found = startup.measure(2, repeats + 1)
    print(startup.as_text(found), flush=True)
    rows = [(f"{wait.text}", f"{rounded(median(spent))} s") for wait, spent in zip(startup.WAITS, found, strict=True)]
    seconds = {wait.text: median(spent) for wait, spent in zip(startup.WAITS[:3], found[:3], strict=True)}
    first, again = list(seconds.values())[1:]
    return {
        "speed: start-up": markdown(("", "time from the shell"), rows),
        "README: first run": f"{rounded(first)} s",
        "README: later run": f"{rounded(again, 1)} s",
    }


def chains(repeats: int) -> Texts:
    """The pendulum chain beside MuJoCo and Exudyn."""
    texts = {}
    for links in against_mujoco.LINKS:
        chain = against_mujoco.compare(links, max(4, repeats))
        print(f"\n{against_mujoco.report(chain)}", flush=True)
        if all(chain.of(name) for name in against_mujoco.PROGRAMS):
            texts |= against_mujoco.written(chain, FOLDER)
    return {f"work-precision: {name}": text for name, text in texts.items()}


def accuracy(repeats: int) -> Texts:
    """Every method, and Exudyn, on two models."""
    work_precision.PATIENCE = PATIENCE
    texts, known = {}, {}
    for name in work_precision.CASES:
        study, theirs = work_precision.compare(name, repeats, BUDGET, longest=1.0)
        read_out, numbers = work_precision.table(study, theirs), work_precision.numbers(study, theirs)
        print(f"\n{study.title}\n\n{as_text(read_out)}\n", flush=True)
        known[name] = numbers["points"]
        if theirs:
            work_precision.draw_best(numbers["points"], FOLDER / f"{name}.png")
            (FOLDER / f"{name}.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
            texts[f"work-precision: {name}"] = markdown(read_out.columns, read_out.rows)
    if texts:
        texts["work-precision: conclusions"] = conclusions(known)
    return texts


def constraints(repeats: int) -> Texts:
    """The largest violations of constraints by the default method at its default step."""
    largest = {"Phi": 0.0, "dPhi": 0.0}
    for name in CONSTRAINED:
        path = ROOT / "models" / f"{name}.mbd"
        step = mbdsl.load(path).experiment.step or 1e-3
        run = mbdsl.simulate(path, method="hht-si2", step=step, interval=step)
        for q in quantities(run, run):
            if q.key in largest:
                largest[q.key] = max(largest[q.key], error(q, run, run).scaled)
        print(f"{name}: so far {largest['Phi']:.1e} and {largest['dPhi']:.1e}", flush=True)
    power = {key: f"1e{math.ceil(math.log10(x))}" for key, x in largest.items()}
    return {"README: positions": power["Phi"], "README: velocities": power["dPhi"]}


PARTS: dict[str, Callable[[int], Texts]] = {
    "shell": shell,
    "constraints": constraints,
    "matrices": matrices,
    "size": size,
    "exudyn": exudyn,
    "chains": chains,
    "accuracy": accuracy,
}


def warm() -> None:
    """Compile all code that the parts need, so that no budget of a study is spent on it."""
    names = {"pendulum", "slider_crank", "seven_body", "four_bar", "chain", *CONSTRAINED}
    models = [str(ROOT / "models" / f"{name}.mbd") for name in sorted(names)]
    paths = os.pathsep.join(p for p in sys.path if p)
    command = [sys.executable, "-m", "mbdsl", "warm", "--quiet", *models]
    subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, check=True)


def machine() -> str:
    """The processor, the system, and the versions."""
    info = Path("/proc/cpuinfo")
    names = (
        [line.split(":")[1].strip() for line in info.read_text().splitlines() if "model name" in line]
        if (info.exists())
        else []
    )
    processor = names[0] if names else platform.processor() or platform.machine()
    return f"{processor}, {os.cpu_count()} processors, {platform.system()}, Python {platform.python_version()}"


def write(texts: Texts) -> None:
    """Write texts into their pages."""
    for name, page in PAGES.items():
        own = {key.split(": ", 1)[1]: text for key, text in texts.items() if key.startswith(f"{name}: ")}
        put(page, own)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), metavar="PART")
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--dry", action="store_true", help="write nothing")
    given = parser.parse_args()
    if given.dry:
        FOLDER = Path(tempfile.mkdtemp())  # pictures and numbers
    print(f"mbdsl {mbdsl.__version__}, {machine()}", flush=True)
    if set(given.only) - {"shell"}:
        warm()
    for name in given.only:
        begun = time.perf_counter()
        print(f"\n== {name}: {PARTS[name].__doc__}", flush=True)
        made = PARTS[name](given.repeats)
        for key, text in made.items():
            print(f"   {key}: {text}" if "\n" not in text else f"   {key}: {len(text.splitlines())} lines")
        if not given.dry:
            write(made)
        print(f"== {name}: {time.perf_counter() - begun:.0f} s", flush=True)
