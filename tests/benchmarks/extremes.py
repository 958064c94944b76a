"""The cost of extremes over all steps: a run with its results, with and without them, side by side.

    python tests/benchmarks/extremes.py [--repeats 9]

Six models, with default signals. A run is what `mbdsl simulate` does behind its start-up: the model is read and
integrated, and a CSV file of 501 rows is written. `kept` is what a run costs more that keeps the ends of its steps,
relative to one that does not; `notes` is what it costs more if peaks of default signals that rows cut are found as
well, as the command does; `extremes` if the extremes of all default signals are. `a step` is the cost of notes in a
step. The four take turns, and the fastest of each counts, in processor time, which a busy machine disturbs less.
Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import mbdsl
from mbdsl.simulation.mechanism_run import MechanismRun

MODELS = Path(__file__).parents[2] / "models"
#: model: settings of the run
CASES: dict[str, dict] = {
    "seven_body": {},
    "slider_crank": {"stop": 10.0},
    "four_bar": {"stop": 0.6, "step": 1e-4},
    "gallery/triple_pendulum": {"stop": 2.0},
    "space/heavy_top": {"stop": 1.0},
    "pendulum, long": {"stop": 100.0, "step": 1e-4},
}
WAYS = ("without", "kept", "notes", "extremes")


def without_steps(motion: MechanismRun) -> None:
    """As ``MechanismRun.watch``, but the ends of steps are not kept."""
    watch(motion)
    motion.forgo()


watch = MechanismRun.watch


def seconds(model: str, settings: dict, way: str, folder: str) -> tuple[float, int, int]:
    """Processor time of a run, and its numbers of steps and of signals; ``way`` is one of WAYS."""
    MechanismRun.watch = without_steps if way == "without" else watch  # type: ignore[method-assign]
    try:
        clock = time.process_time()
        run = mbdsl.simulate(MODELS / f"{model.partition(',')[0]}.mbd", **settings)
        run.save(f"{folder}/run.csv")
        if way == "notes":
            run.cut_peaks()
        if way == "extremes":
            run.extremes()
        return time.process_time() - clock, run.stats["steps"], len(run.default_names)
    finally:
        MechanismRun.watch = watch  # type: ignore[method-assign]


def table(repeats: int, cases: dict[str, dict] = CASES) -> str:
    """The table of all cases."""
    head = ("model", "steps", "signals", "run [ms]", *WAYS[1:], "a step [ns]")
    lines = ["{:<26}{:>9}{:>9}{:>10}{:>9}{:>9}{:>10}{:>13}".format(*head)]
    with tempfile.TemporaryDirectory() as folder:
        for model, settings in cases.items():
            best: dict[str, float] = {}
            for _ in range(repeats + 1):  # the first one compiles
                for way in WAYS:
                    spent, steps, signals = seconds(model, settings, way, folder)
                    best[way] = min(spent, best.get(way, spent))
            base = best["without"]
            more = [f"{100.0 * (best[way] / base - 1.0):+.1f} %" for way in WAYS[1:]]
            each = f"{1e9 * (best['notes'] - base) / steps:.0f}"
            row = (model, steps, signals, f"{1e3 * base:.1f}", *more, each)
            lines.append("{:<26}{:>9}{:>9}{:>10}{:>9}{:>9}{:>10}{:>13}".format(*row))
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=9)
    print(table(parser.parse_args().repeats))
