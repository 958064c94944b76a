"""What a step of each method costs, relative to hht-i3: the counterpart of figure 16 of Negrut, Jay and Khude (2009).

    python tests/benchmarks/method_costs.py [--repeats 25] [--methods hht-i3,hht-si2,hht-add]

One process, one thread, warm; processor time of the step loops alone. The motion is divided into slices, in each of
which the methods alternate; the time of a method is the sum over the slices of the least time among all rounds, so that
disturbances of a busy machine hardly matter. Beside it is the median over rounds of the ratios of whole runs. Ratios
depend on the step: at a larger one the start of Newton's iteration is worse, and the methods differ in how many
iterations and matrices that takes; hence the second table. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

import numpy as np

import mbdsl
from mbdsl.initial.consistent import InitialState, initial_state
from mbdsl.integrators import compiled as methods
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import System, build

MODELS = Path(__file__).parents[2] / "models"
BASE = "hht-i3"
METHODS = (BASE, *(name for name, m in methods().items() if name != BASE and m.stable == np.inf))  # models are stiff
#: the text on figure 16: an "approximate simulation slowdown of 30%" by enforcing velocity constraints, "unless the
#: model is heavily constrained, as is the case with the seven body mechanism"; the bars' heights are not in the text
PAPER = {
    "hht-i3": "1, the reference",
    "hht-si2": "about 1.3",
    "nstiff-si2": "about 1.3",
    "hht-add": "about 1.3, or more",
}
PAPER_CONSTRAINED = "more than 1.3"
PAPER_FLEXIBLE = {"hht-add": '"very costly": M^{-1} with every iteration'}
WIDTH = 24  #: characters of a bar of ratio 1


@dataclass(frozen=True)
class Case:
    model: str
    h: float
    stop: float
    #: highest ratio aimed at
    targets: dict[str, float] = field(default_factory=dict)


SMALL, LARGE = {"hht-si2": 1.0, "hht-add": 1.5}, {"hht-si2": 1.15, "hht-add": 2.0}
CASES = (
    Case("slider_crank", 5e-4, 2.0, SMALL),
    Case("double_pendulum", 5e-4, 2.0, SMALL),
    Case("seven_body", 1e-5, 0.03, SMALL),
    Case("flexible_slider_crank", 1e-4, 1.0, SMALL),
)
LARGER = (
    Case("slider_crank", 1e-3, 2.0, LARGE),
    Case("slider_crank", 2e-3, 2.0, LARGE),
    Case("double_pendulum", 1e-3, 2.0, LARGE),
    Case("double_pendulum", 2e-3, 2.0, LARGE),
    Case("seven_body", 2e-5, 0.03, LARGE),
    Case("flexible_slider_crank", 1e-3, 2.0, LARGE),
)
#: number of parts of a motion that are timed separately
SLICES = 40


@dataclass
class Cost:
    """Measurements of one method on one case."""

    us: list[list[float]] = field(default_factory=list)  #: in each round, the slices' shares of the time of a step
    iterations: float = 0.0  #: a step
    matrices: float = 0.0
    status: int = S.DONE

    @property
    def rounds(self) -> list[float]:
        """The time of a step in each round."""
        return [sum(slices) for slices in self.us]

    @property
    def least(self) -> float:
        """The time of a step, the least of each slice."""
        return sum(min(x) for x in zip(*self.us, strict=True))


def assembled(model: str) -> tuple[System, InitialState]:
    scene = mbdsl.load(MODELS / f"{model}.mbd")
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    return system, initial_state(system, mechanism, 0.0)


def measure(case: Case, repeats: int, steps: int | None = None, names: Sequence[str] = METHODS) -> dict[str, Cost]:
    """Every method ``repeats`` times, in turn in each slice of the motion."""
    system, start = assembled(case.model)
    steps = steps or round(case.stop / case.h)
    ends = np.unique(np.linspace(0, steps, SLICES + 1).round().astype(int))
    costs = {name: Cost() for name in names}
    for k in range(repeats + 1):
        runs = {}
        for name in names:
            runs[name] = run = MethodRun(system, name, case.h, 0.0, case.h * steps, np.array([]))
            run.begin(start.q, start.v, start.a, start.lam, start.redundant)
            costs[name].us += [[]]
        for j, count in enumerate(np.diff(ends)):
            for name in names if (j + k) % 2 else names[::-1]:
                begun = time.thread_time_ns()
                costs[name].status = runs[name].advance(int(count))
                costs[name].us[-1].append(1e-3 * (time.thread_time_ns() - begun) / steps)
        for name, run in runs.items():
            done, cost = max(1, run.integers[S.STEP]), costs[name]
            cost.iterations = run.integers[S.ITERATIONS] / done
            cost.matrices = run.integers[S.MATRICES] / done
            if k == 0:  # the first round loads the compiled code
                cost.us.clear()
    return costs


def ratios(costs: dict[str, Cost], name: str) -> tuple[float, float]:
    """Ratios to the base method: of the least times, and the median over rounds."""
    base, cost = costs[BASE], costs[name]
    return cost.least / base.least, median(a / b for a, b in zip(cost.rounds, base.rounds, strict=True))


def duration(seconds: float) -> str:
    return f"{seconds * 1e3:g} ms" if seconds >= 1e-3 else f"{seconds * 1e6:g} us"


def rows(case: Case, costs: dict[str, Cost]) -> list[str]:
    """The table of one case."""
    lines = [f"{case.model}, h = {duration(case.h)}"]
    for name, cost in costs.items():
        low, middle = ratios(costs, name)
        target = case.targets.get(name)
        aim = "" if target is None else f"   {target:4.2f} {'met' if low < target + 0.005 else 'MISSED'}"
        failed = "" if cost.status == S.DONE else "   VOID: stopped early"
        lines.append(
            f"  {name:11} {cost.least:8.3f} {median(cost.rounds):8.3f}   {low:5.2f} {middle:6.2f}"
            f" {cost.iterations:10.2f} {cost.matrices:8.3f}{aim}{failed}"
        )
    return lines


def bars(case: Case, costs: dict[str, Cost]) -> list[str]:
    """Ratios as bars, with the statements of the paper."""
    lines = [case.model]
    for name in costs:
        ratio = ratios(costs, name)[0]
        said = PAPER.get(name, "")
        if case.model == "seven_body" and name in PAPER and name != BASE:
            said = PAPER_CONSTRAINED
        if case.model == "flexible_slider_crank":
            said = PAPER_FLEXIBLE.get(name, said)
        lines.append(f"  {name:11} {'#' * round(WIDTH * ratio):{2 * WIDTH}} {ratio:4.2f}   {said}".rstrip())
    return lines


def table(repeats: int = 25, steps: int | None = None, larger: bool = True, names: Sequence[str] = METHODS) -> str:
    """Everything as text; ``steps`` shortens the runs."""
    head = f"{'':13} {'us/step':>8} {'':8}   {'ratio':5} {'':6} {'iterations':>10} {'matrices':>8}   target\n"
    head += f"{'':13} {'min':>8} {'median':>8}   {'min':>5} {'median':>6} {'a step':>10} {'a step':>8}   (min)"
    found = [(case, measure(case, repeats, steps, names)) for case in CASES]
    lines = [head] + [line for case, costs in found for line in rows(case, costs)]
    lines += [
        "",
        f"Cost of a step relative to {BASE}; on the right what the paper's text says",
    ]
    lines += [line for case, costs in found for line in bars(case, costs)]
    if larger:
        lines += ["", "The same at larger steps", head]
        lines += [line for case in LARGER for line in rows(case, measure(case, repeats, steps, names))]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=25)
    parser.add_argument("--steps", type=int, default=None, help="fewer steps, for a quick look")
    parser.add_argument("--methods", default=",".join(METHODS), help="the first one has to be " + BASE)
    arguments = parser.parse_args()
    print(table(arguments.repeats, arguments.steps, names=arguments.methods.split(",")))
