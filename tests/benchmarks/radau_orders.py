"""Errors and processor times of radau5, radau9 and radau13.

    python tests/benchmarks/radau_orders.py [--tolerances 1e-6,...] [--repeats 3]

First table: one run with the local tolerance, without calibration; error at the end. Second table: runs with --tol,
calibration runs included; the largest error of all outputs. Errors are those of angles and of positions in the size of
the mechanism, and of velocities relative to the largest one. Reference: radau13 with the smallest tolerance; its own
error, in the heading, is its difference from a run with three times this tolerance. One process; the methods alternate,
and the least processor time of several repetitions is printed.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import mbdsl
from mbdsl.initial.consistent import InitialState, initial_state
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.numerics.error_norm import distance
from mbdsl.system import System, build

MODELS = Path(__file__).parents[2] / "models"
#: models and stop times [s]; non-stiff, except the double pendulum (damper), the stiff knee, and the flexible one
CASES = (
    ("slider_crank", 2.0),
    ("seven_body", 0.03),
    ("double_pendulum", 2.0),
    ("hard/stiff_knee", 1.0),
    ("flexible_slider_crank", 0.5),
)
#: models of the second table
WHOLE = ("slider_crank", "seven_body", "double_pendulum")
METHODS = ("radau5", "radau9", "radau13")
STRICTEST = 3e-13


def single(system: System, start: InitialState, method: str, tol: float, stop: float) -> tuple[float, MethodRun]:
    """Seconds of processor time, and the run."""
    run = MethodRun(system, method, stop, 0.0, stop, np.array([stop]), tol=tol)
    run.begin(start.q, start.v, start.a, start.lam)
    began, status = time.process_time(), S.RUNNING
    while status == S.RUNNING:
        status = run.advance(100_000)
    assert status == S.DONE, status
    return time.process_time() - began, run


def of_single_runs(name: str, stop: float, tolerances: list[float], repeats: int) -> None:
    scene = mbdsl.load(MODELS / f"{name}.mbd")
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    start = initial_state(system, mechanism, 0.0)

    def end(run: MethodRun) -> tuple[np.ndarray, np.ndarray]:
        q, v, _ = run.state()
        return q[None].copy(), v[None].copy()

    exact, other = (end(single(system, start, "radau13", tol, stop)[1]) for tol in (STRICTEST, 3 * STRICTEST))
    scale = system.tables.scale
    print(f"\n{name}, {stop:g} s, reference +- {distance(scale, stop, exact, other):.0e}")
    for tol in tolerances:
        for method in METHODS:
            runs = [single(system, start, method, tol, stop) for _ in range(repeats)]
            seconds, run = min(runs, key=lambda x: x[0])
            counts = [run.steps, *(run.count(x) for x in ("iterations", "factorisations"))]
            error = distance(scale, stop, end(run), exact)
            print(
                f"  {tol:6.0e} {method:8} error {error:8.1e} {1e3 * seconds:9.2f} ms; steps, iterations, LU: {counts}"
            )


def of_whole_runs(name: str, stop: float, tolerances: list[float], repeats: int) -> None:
    path = MODELS / f"{name}.mbd"

    def run(method: str, tol: float) -> tuple[float, mbdsl.Trajectory]:
        began = time.process_time()
        found = mbdsl.simulate(path, method=method, tol=tol, stop=stop, interval=stop / 100)
        return time.process_time() - began, found

    exact = run("radau13", 1e-12)[1]
    scale = exact.system.tables.scale
    print(f"\n{name}, {stop:g} s, with --tol")
    for tol in tolerances:
        for method in METHODS:
            seconds, found = min((run(method, tol) for _ in range(repeats)), key=lambda x: x[0])
            error = distance(scale, stop, (found.q, found.v), (exact.q, exact.v))
            counts = [found.stats["steps"], found.stats["trial_steps"]]
            print(f"  {tol:6.0e} {method:8} error {error:8.1e} {1e3 * seconds:9.1f} ms; steps, trial steps: {counts}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tolerances", default="1e-6,1e-8,1e-10,1e-12")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--models", default=",".join(name for name, _ in CASES))
    given = parser.parse_args()
    wanted = [float(x) for x in given.tolerances.split(",")]
    for name, stop in CASES:
        if name in given.models.split(","):
            of_single_runs(name, stop, wanted, given.repeats)
            if name in WHOLE:
                of_whole_runs(name, stop, [tol for tol in wanted if tol > 1e-11], given.repeats)
