"""Cost of large models: time of a step, memory and set-up over the number of links or loops.

    python tests/benchmarks/growth.py [--repeats 5]

Chains (models/chain.mbd) and rows of four bars (models/four_bar.mbd), in few steps of 1 ms: a chain stretched out
horizontally is chaotic soon. The times of a step and of an iteration are fitted by powers of the number of links or
loops; the second is needed because larger models may take more iterations. For comparison, NumPy adds two arrays into a
third one: three arrays of as many bytes in total as an iteration reads and writes (``traffic``), which shows how much
of the growth is that of the machine's caches.

Memory is the peak of a fresh process that loads, builds and integrates a chain; the set-up is the time in this process
from the start of parsing to the end of the first step, by stages, with all code compiled before. Processor time is
measured, which a busy machine disturbs less. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from statistics import median

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import numpy as np

import mbdsl
from mbdsl.initial.consistent import InitialState, initial_state
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import System, build

MODELS = Path(__file__).parents[2] / "models"
METHODS = ("hht-i3", "hht-si2")
SIZES: dict[str, tuple[int, ...]] = {
    "chain": (64, 256, 1024, 4096, 16384),
    "four_bar": (10, 25, 50, 100, 200, 400),
}
#: numbers of links of the chains that are run in processes of their own; all are large enough for sparse matrices
PROCESSES = (128, 1024, 4096, 16384)
STAGES = ("read", "tables", "initial values", "buffers", "first step")  #: of the set-up
#: rows of vectors that an iteration reads or writes, once each
TOUCHED = {"hht-i3": 16, "hht-si2": 23}
STEP, STEPS = 1e-3, 40
OFTEN = 1024  #: a model with this number of links runs once a round; smaller ones run up to 8 times, as they are fast
#: targets: exponents of the cost of a step, of memory and of set-up; memory [MB] and set-up [s] of the longest chain
EXPONENT, MEMORY, SETUP = 1.05, 600.0, 5.0


@dataclass
class Cost:
    """Measurements of one method on one model."""

    us: list[float] = field(default_factory=list)  #: a step, in each round
    iterations: float = 0.0  #: a step
    matrices: float = 0.0
    status: int = S.DONE
    traffic: int = 0  #: bytes that an iteration reads and writes
    adding: list[float] = field(default_factory=list)  #: microseconds for arrays of as many bytes, in each round


def assembled(model: str, n: int) -> tuple[System, InitialState]:
    scene = mbdsl.load(MODELS / f"{model}.mbd", {"N": n})
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    return system, initial_state(system, mechanism, 0.0)


def begun(system: System, start: InitialState, method: str) -> MethodRun:
    run = MethodRun(system, method, STEP, 0.0, STEP * STEPS, np.array([]))
    run.begin(start.q, start.v, start.a, start.lam, start.redundant)
    return run


def traffic(run: MethodRun, method: str) -> int:
    """Bytes that an iteration with a kept matrix reads or writes, each counted once."""
    layout, N = run.layout, run.system.unknowns
    entries = int(layout[layout[L.SPARSE] + 2 * N])  # of a factor
    factors = METHODS.index(method) + 1
    solve = 8 * (4 * entries + factors * (2 * entries + N))
    pairs = 8 * L.PAIR * int(layout[L.N_PHI])
    return solve + pairs + run.frames.nbytes + run.gradients.nbytes + 8 * N * TOUCHED[method]


def adding(size: int, times: int) -> float:
    """Microseconds for c = a + b with three arrays of ``size`` bytes in total, the mean of several."""
    a, b, c = np.ones((3, max(1, size // 24)))
    np.add(a, b, out=c)
    clock = time.process_time()
    for _ in range(times):
        np.add(a, b, out=c)
    return 1e6 * (time.process_time() - clock) / times


def measure(model: str, sizes: Iterable[int], repeats: int) -> dict[str, dict[int, Cost]]:
    """Every size with every method ``repeats`` times, in turn."""
    models = {n: assembled(model, n) for n in sizes}
    costs = {method: {n: Cost() for n in models} for method in METHODS}
    for k in range(repeats + 1):
        for n, (system, start) in models.items():
            for method in METHODS * min(max(1, OFTEN // n), 8):
                run, cost = begun(system, start, method), costs[method][n]
                clock = time.process_time()
                cost.status = run.advance()
                seconds = time.process_time() - clock
                done = max(1, run.integers[S.STEP])
                cost.iterations, cost.matrices = (
                    run.integers[S.ITERATIONS] / done,
                    run.integers[S.MATRICES] / done,
                )
                cost.traffic = traffic(run, method)
                if k > 0:  # the first round loads the compiled code
                    cost.us.append(1e6 * seconds / done)
                    cost.adding.append(adding(cost.traffic, STEPS))
    return costs


def exponent(n: Iterable[float], y: Iterable[float]) -> float:
    """p of y ~ n^p, fitted to the logarithms."""
    return float(np.polyfit(np.log(list(n)), np.log(list(y)), 1)[0])


def met(value: float, aim: float) -> str:
    return f"{aim:g} {'met' if value <= aim else 'MISSED'}"


def rows(model: str, costs: dict[str, dict[int, Cost]]) -> list[str]:
    """The table of one model, and the exponents of its methods."""
    lines = []
    for method, sizes in costs.items():
        for n, cost in sizes.items():
            failed = "" if cost.status == S.DONE else "   VOID: stopped early"
            lines.append(
                f"{model:9} {n:6d} {method:8} {min(cost.us):10.1f} {median(cost.us):10.1f} {min(cost.us) / n:8.3f}"
                f" {cost.iterations:10.2f} {cost.matrices:8.2f} {cost.traffic / n:8.0f} {min(cost.adding) / n:8.4f}"
                f"{failed}"
            )
        least = exponent(sizes, [min(cost.us) for cost in sizes.values()])
        middle = exponent(sizes, [median(cost.us) for cost in sizes.values()])
        each = exponent(sizes, [min(cost.us) / cost.iterations for cost in sizes.values()])
        adds = exponent(sizes, [min(cost.adding) for cost in sizes.values()])
        lines.append(
            f"{'':9} {'':6} {method:8} grows with the power {least:.2f} (minima), {middle:.2f} (medians):"
            f" {met(least, EXPONENT)}; an iteration: {each:.2f}; adding arrays: {adds:.2f}"
        )
    return lines


def peak() -> float:
    """The peak memory of this process [MB]."""
    status = Path("/proc/self/status")
    if status.exists():  # getrusage would include the memory of the parent at the fork
        return float(status.read_text().split("VmHWM:")[1].split()[0]) / 1024
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 1024)


def one(n: int, method: str) -> None:
    """Run a chain in this process, which does nothing else, and print the measurements."""
    clock = [time.process_time()]

    def stage(value):
        clock.append(time.process_time())
        return value

    scene = stage(mbdsl.load(MODELS / "chain.mbd", {"N": n}))
    mechanism = graph.build(scene)
    system = stage(build(scene, mechanism))
    start = stage(initial_state(system, mechanism, 0.0))
    run = stage(MethodRun(system, method, STEP, 0.0, STEP * STEPS, np.array([])))
    run.begin(start.q, start.v, start.a, start.lam, start.redundant)
    stage(run.advance(1))
    run.advance()
    arrays = (run.vectors, run.frames, run.gradients, run.numbers, run.layout, run.matrices, run.pivots)
    buffers = sum(x.nbytes for x in arrays) / 2**20
    print(json.dumps([np.diff(clock).tolist(), peak(), buffers, int(run.integers[S.STEP])]))


@dataclass
class Fresh:
    """Measurements of processes that load, build and integrate one chain: peak memory [MB], the memory of the buffers
    of the step loop [MB], and the times of the stages of the set-up [s]."""

    memory: list[float]
    buffers: float
    stages: list[list[float]]
    steps: set[int]

    @property
    def seconds(self) -> list[float]:
        """The whole set-up."""
        return [sum(times) for times in self.stages]

    @property
    def best(self) -> list[float]:
        """The stages of the fastest set-up."""
        return min(self.stages, key=sum)


def processes(sizes: Iterable[int], repeats: int) -> dict[str, dict[int, Fresh]]:
    """Method -> number of links -> measurements."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    found: dict[str, dict[int, Fresh]] = {method: {} for method in METHODS}
    for method in METHODS:
        for n in sizes:
            command = [sys.executable, __file__, "--one", str(n), method]
            ran = [subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE) for _ in range(repeats)]
            stages, memory, buffers, steps = zip(*(json.loads(r.stdout) for r in ran), strict=True)
            found[method][n] = Fresh(list(memory), max(buffers), list(stages), set(steps))
    return found


def beyond(used: dict[int, float]) -> tuple[float, list[float]]:
    """The exponent of what grows beyond the smallest chain, and the amount for each link more than the chain before."""
    first, *rest = used
    power = exponent([n - first for n in rest], [max(used[n] - used[first], 1e-3) for n in rest])
    return power, [(used[n] - used[before]) / (n - before) for before, n in pairwise(used)]


def of_processes(found: dict[str, dict[int, Fresh]]) -> list[str]:
    """The table of memory and set-up."""
    lines = []
    for method, sizes in found.items():
        used = {n: max(fresh.memory) for n, fresh in sizes.items()}
        power, each = beyond(used)
        for (n, fresh), kb in zip(sizes.items(), [0.0, *each], strict=True):
            failed = "" if fresh.steps == {STEPS} else "   VOID: stopped early"
            stages = "".join(f" {seconds:8.2f}" for seconds in fresh.best)
            lines.append(
                f"chain     {n:6d} {method:8} {used[n]:8.0f} {1024 * kb:8.2f} {1024 * fresh.buffers / n:8.2f} {stages}"
                f" {min(fresh.seconds):8.2f} {median(fresh.seconds):8.2f}{failed}"
            )
        setup, _ = beyond({n: min(fresh.seconds) for n, fresh in sizes.items()})
        lines += [
            f"{'':16} {method:8} memory: {met(used[n], MEMORY)}; it grows with the power {power:.2f}:"
            f" {met(power, EXPONENT)}",
            f"{'':16} {method:8} set-up: {met(median(fresh.seconds), SETUP)}; it grows with the power {setup:.2f}:"
            f" {met(setup, EXPONENT)}",
        ]
    return lines


def table(repeats: int = 5, sizes: dict[str, tuple[int, ...]] = SIZES, fresh: tuple[int, ...] = PROCESSES) -> str:
    """Everything as text."""
    lines = [
        f"{'':25} {'us/step':>10} {'':10} {'us/step':>8} {'iterations':>10} {'matrices':>8} {'bytes an':>8}"
        f" {'adding':>8}",
        f"{'model':9} {'N':>6} {'method':8} {'min':>10} {'median':>10} {'and N':>8} {'a step':>10} {'a step':>8}"
        f" {'it., N':>8} {'us/N':>8}",
    ]
    for model, counts in sizes.items():
        lines += rows(model, measure(model, counts, repeats))
    lines += [
        "",
        "Fresh processes, everything compiled before",
        f"{'':25} {'memory':>8} {'kB a':>8} {'buffers':>8}  set-up, s:",
        f"{'model':9} {'N':>6} {'method':8} {'MB':>8} {'link':>8} {'kB/link':>8} "
        + "".join(f" {stage.split()[0]:>8}" for stage in STAGES)
        + f" {'min':>8} {'median':>8}",
        *of_processes(processes(fresh, repeats)),
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--one", nargs=2, metavar=("N", "METHOD"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        one(int(arguments.one[0]), arguments.one[1])
    else:
        print(table(arguments.repeats))
