"""Error over processor time of dop853 and radau5, with error-controlled steps, on models that are not stiff.

    python tests/benchmarks/explicit_method.py [--repeats 7] [--models pendulum,...]

One process, one thread, warm; the methods alternate, and the least time of all rounds counts. Times are of the step
loops alone, without trial runs. The error is the largest over 100 outputs and all positions, in the mechanism's size;
the reference is radau5 with the least tolerance. A row interpolates between the errors of a method's runs, so that both
times belong to the same error. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import numpy as np

import mbdsl
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

MODELS = Path(__file__).parents[2] / "models"
METHODS = ("radau5", "dop853")
#: model, parameters and stop time [s]; the spring and the damper of the double pendulum's knee made soft
CASES = {
    "pendulum": ({}, 2.0),
    "double_pendulum": ({"k2": 0.0, "c2": 0.0, "c1": 0.0, "k1": 0.0}, 1.0),
    "slider_crank": ({}, 2.0),
    "four_bar": ({}, 0.3),
    "seven_body": ({}, 0.03),
    "chain": ({"N": 8}, 0.5),
    "chain 64": ({"N": 64}, 0.5),
}
TOLERANCES = tuple(10.0**-k for k in range(2, 15))
FINEST = 3e-15
ERRORS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


class Case:
    """A model that is ready to run."""

    def __init__(self, name: str) -> None:
        parameters, self.stop = CASES[name]
        scene = mbdsl.load(MODELS / f"{name.split()[0]}.mbd", parameters)
        mechanism = graph.build(scene)
        self.system = build(scene, mechanism)
        self.start = initial_state(self.system, mechanism, 0.0)
        self.times = np.linspace(0.0, self.stop, 101)[1:]

    def run(self, method: str, tol: float) -> tuple[np.ndarray | None, float]:
        """Positions at the outputs, None if the run failed, and seconds of processor time."""
        run = MethodRun(self.system, method, self.stop, 0.0, self.stop, self.times, tol=tol)
        start, status = self.start, S.RUNNING
        run.begin(start.q, start.v, start.a, start.lam, start.redundant)
        begun = time.process_time()
        while status == S.RUNNING:
            status = run.advance()
        seconds = time.process_time() - begun
        return (run.out[:, : self.system.n] if status == S.DONE else None), seconds


def curve(case: Case, method: str, exact: np.ndarray, repeats: int) -> list[tuple[float, float]]:
    """(error, least seconds) of the runs that no run with a larger tolerance beats."""
    found = []
    for tol in TOLERANCES:
        q, seconds = case.run(method, tol)
        if q is None:
            continue
        error = float(np.abs((q - exact) * case.system.tables.scale).max())
        for _ in range(repeats):
            seconds = min(seconds, case.run(method, tol)[1])
        if not found or error < 0.7 * found[-1][0]:
            found.append((error, seconds))
    return found


def seconds_at(error: float, runs: list[tuple[float, float]]) -> float:
    """Seconds for an error, interpolated; the fastest run if all are better, nan if none is."""
    if not runs or runs[-1][0] > 1.5 * error:
        return np.nan
    errors, seconds = np.log(np.array(runs[::-1]).T)
    return float(np.exp(np.interp(np.log(error), errors, seconds)))


def table(names: list[str], repeats: int) -> str:
    lines = [f"{'':18}{'error':>8}{'radau5':>12}{'dop853':>12}{'ratio':>8}"]
    for name in names:
        case = Case(name)
        exact, _ = case.run("radau5", FINEST)
        assert exact is not None
        runs = {method: curve(case, method, exact, repeats) for method in METHODS}
        for error in ERRORS:
            one, other = (1e3 * seconds_at(error, runs[method]) for method in METHODS)
            lines.append(f"{name:18}{error:8.0e}{one:9.3f} ms{other:9.3f} ms{other / one:8.2f}")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--models", default=",".join(CASES))
    arguments = parser.parse_args()
    print(table(arguments.models.split(","), arguments.repeats))
