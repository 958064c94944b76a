"""Figure 16: what a run of each method costs, relative to hht-i3.

The methods alternate within a round, so that disturbances of the machine affect all of them, and a ratio compares runs
of the same round. Times are processor times of the integration alone, warm; they belong to a machine and an hour.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median, quantiles
from time import thread_time

from paper.experiments import SIX, Found, model

import mbdsl
from mbdsl.plotting.figures import Figure, Series
from mbdsl.simulation import simulate as simulation

BASE = "hht-i3"


@dataclass(frozen=True)
class Case:
    name: str
    model: str
    steps: dict[str, float]  #: label -> h [s]; the first is that of the figure
    stop: float


CASES = (
    Case("slider crank", "slider_crank", {"0.5 ms": 5e-4, "2 ms": 2e-3}, 2.0),
    Case("double pendulum", "double_pendulum", {"0.5 ms": 5e-4, "2 ms": 2e-3}, 2.0),
    Case("seven bodies", "seven_body", {"10 us": 1e-5, "20 us": 2e-5}, 0.03),
    Case("flexible slider crank", "flexible_slider_crank", {"0.1 ms": 1e-4, "1 ms": 1e-3}, 1.0),
)


def times(case: Case, h: float, rounds: int) -> dict[str, list[float]]:
    """Method -> seconds of each round."""
    scene, found = model(case.model), {name: [] for name in SIX}
    wall, simulation.perf_counter = simulation.perf_counter, thread_time  # the machine may be busy
    try:
        for k in range(rounds + 1):
            for name in list(SIX) if k % 2 else list(SIX)[::-1]:  # what comes after what changes, too
                run = mbdsl.simulate(scene, method=name, step=h, stop=case.stop, interval=case.stop)
                if k > 0:  # the first round loads what is compiled
                    found[name].append(run.stats["seconds"]["integrate"])
    finally:
        simulation.perf_counter = wall
    return found


def figure_16(quick: bool) -> Found:
    """Medians over the rounds, with quartiles; and the time of a step of the base [us]."""
    found: dict = {}
    cases, rounds = (CASES[:2], 2) if quick else (CASES, 31)
    for case in cases:
        for label, h in case.steps.items():
            seconds = times(case, h, rounds)
            row = found.setdefault(case.name, {})[label] = {}
            for name in SIX:
                ratios = [a / b for a, b in zip(seconds[name], seconds[BASE], strict=True)]
                low, _, high = quantiles(ratios, n=4)
                row[name] = [round(x, 2) for x in (median(ratios), low, high)]
            row["step [us]"] = round(1e6 * median(seconds[BASE]) * h / case.stop, 2)
    series = []
    for k, name in enumerate(SIX):
        x = [i + 1 + 0.08 * (k - 2.5) for i in range(len(cases))]
        y, low, high = zip(*(next(iter(found[case.name].values()))[name] for case in cases), strict=True)
        series.append(Series(name, x, y, low, high, style="marks"))
    ends = (0.6, len(cases) + 0.4)
    series.append(Series("the paper's 1.3", ends, (1.3, 1.3), style="guide"))
    names = ", ".join(f"{i}: {case.name}" for i, case in enumerate(cases, 1))
    return {"ratios": found}, [
        Figure("figure16", "Figure 16", names, "time of a run, relative to hht-i3", series, False, False)
    ]
