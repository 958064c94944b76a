"""Error over tolerance of runs with error control, and their run times compared with fixed steps of the same error.

    python tests/benchmarks/tolerances.py [--models pendulum,...] [--methods hht-si2,...] [--tolerances 1e-3,...]

The error is the largest over all outputs and coordinates: positions in the mechanism's size and angles in radians,
velocities relative to the largest one of the run. Reference: hht-si2 with fixed steps much shorter, extrapolated from
two lengths; ``+-`` is a bound of its own error. Runs that would take more than ``MOST`` steps are left out.

The second table compares run times at equal error, trial runs included: the least times of controlled runs and of fixed
ones in turn, the fixed step being the one with the same error, by interpolation between the errors of several. The
third table compares the time of a step in a single run with controlled steps with that of fixed steps of their mean
size. All times are processor times of the integration, in this thread; ratios are those with controlled steps over
those with fixed ones.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import thread_time

import numpy as np

import mbdsl
from mbdsl.errors import MbdslError
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import available
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism import graph
from mbdsl.numerics.error_norm import distance
from mbdsl.simulation import simulate as simulation
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system import build

MODELS = Path(__file__).parents[2] / "models"
#: longer step of the two references
STEPS = {
    "chain": 1e-5,
    "chaplygin_sleigh": 5e-4,
    "crank_ivp": 1e-6,
    "double_pendulum": 1e-5,
    "driven_crank": 1e-3,
    "flexible_pendulum": 1e-5,
    "flexible_slider_crank": 2e-5,
    "four_bar": 1e-4,
    "hoist": 1e-5,
    "pendulum": 1e-4,
    "rolling_disc": 5e-4,
    "seven_body": 1e-6,
    "slider_crank": 1e-4,
    "spin_up_beam": 2e-4,
    "spring_mass": 2e-4,
    "stick_slip_belt": 2e-6,
}
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
MOST = 1_000_000
#: cases of the second table: a model, its changed parameters, and the range of steps for the search
STIFF = (
    ("double_pendulum", {}, (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6e-5, 3e-5, 1.5e-5, 1e-5)),
    ("slider_crank", {"c": "2e5 N.s/m"}, (1e-2, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5, 2.5e-5, 1.2e-5, 6e-6)),
)
#: further cases of the third table
EVEN: tuple[tuple[str, dict[str, str]], ...] = (("slider_crank", {}), ("seven_body", {}))


@dataclass
class Reference:
    """q and v at the outputs, and bounds of their errors."""

    q: np.ndarray
    v: np.ndarray
    wrong: float

    def error(self, run: Trajectory) -> float:
        return distance(run.system.tables.scale, run.t[-1] - run.t[0], (run.q, run.v), (self.q, self.v))


def reference(name: str, h: float | None = None, parameters: dict[str, str] | None = None) -> Reference:
    path, h = MODELS / f"{name}.mbd", h or STEPS[name]
    one, two, four = (mbdsl.simulate(path, method="hht-si2", step=h / k, parameters=parameters) for k in (1, 2, 4))
    first, second = ([x + (x - y) / 3 for x, y in zip(z, w, strict=True)] for z, w in (
        ((two.q, two.v), (one.q, one.v)), ((four.q, four.v), (two.q, two.v))))  # fmt: skip
    wrong = distance(one.system.tables.scale, one.t[-1] - one.t[0], tuple(first), tuple(second))
    return Reference(second[0], second[1], wrong)


def table(names: Sequence[str], chosen: Sequence[str], tolerances: Sequence[float]) -> str:
    """Error attained over tolerance, for each model and method."""
    lines = [f"{'model':22}{'method':12}{'+-':>8}" + "".join(f"{tol:>9.0e}" for tol in tolerances) + "   steps"]
    for name in names:
        exact = reference(name)
        for method in chosen:
            cells, steps, expected = [], [], 0.0
            for tol in tolerances:
                run = None
                if expected <= MOST and not (available()[method].order == 1 and tol < 0.99e-5):
                    try:
                        run = mbdsl.simulate(MODELS / f"{name}.mbd", method=method, tol=tol)
                    except MbdslError:
                        cells.append(f"{'failed':>9}")
                        continue
                if run is None:
                    cells.append(f"{'-':>9}")
                    continue
                cells.append(f"{exact.error(run) / tol:9.2g}")
                steps.append(run.stats["steps"])
                expected = 10.0 ** (1.0 / available()[method].order) * steps[-1]
            lines.append(f"{name:22}{method:12}{exact.wrong:8.0e}{''.join(cells)}   {', '.join(map(str, steps))}")
    return "\n".join(lines)


def seconds(path: Path, parameters: dict[str, str], **how) -> tuple[float, Trajectory]:
    wall, simulation.perf_counter = simulation.perf_counter, thread_time  # the machine may be busy
    try:
        run = mbdsl.simulate(path, parameters=parameters, **how)
    finally:
        simulation.perf_counter = wall
    return run.stats["seconds"]["integrate"], run


def beside_fixed(method: str, tolerances: Sequence[float], repeats: int = 7) -> str:
    """Processor seconds of runs with controlled and with fixed steps of the same error."""
    lines = [f"{'model':18}{'tol':>8}{'error':>10}{'steps':>8}{'ms':>8}   fixed:{'h':>9}{'steps':>8}{'ms':>8}   ratio"]
    for name, parameters, fixed in STIFF:
        path = MODELS / f"{name}.mbd"
        exact = reference(name, 4e-6, parameters)
        errors = [exact.error(seconds(path, parameters, method=method, step=h)[1]) for h in fixed]
        for tol in tolerances:
            if available()[method].order == 1 and tol < 0.99e-5:
                continue
            error = exact.error(seconds(path, parameters, method=method, tol=tol)[1])
            if not errors[-1] <= error <= errors[0]:
                lines.append(f"{name:18}{tol:8.0e}{error:10.1e}   none of the fixed steps has that error")
                continue
            h = float(np.exp(np.interp(np.log(error), np.log(errors[::-1]), np.log(fixed[::-1]))))
            ours = theirs = np.inf
            for _ in range(repeats):
                one, run = seconds(path, parameters, method=method, tol=tol)
                other, like = seconds(path, parameters, method=method, step=h)
                ours, theirs = min(ours, one), min(theirs, other)
            steps = run.stats["steps"] + run.stats["trial_steps"]
            lines.append(
                f"{name:18}{tol:8.0e}{error:10.1e}{steps:8}{1e3 * ours:8.2f}   {'':6}{h:9.1e}{like.stats['steps']:8}"
                f"{1e3 * theirs:8.2f}   {ours / theirs:5.2f}"
            )
    return "\n".join(lines)


def steps_beside_fixed(method: str, tolerances: Sequence[float], repeats: int = 15) -> str:
    """Processor time of an accepted step, controlled and fixed; the tolerances are those of the local error."""
    lines = [f"{'model':18}{'eps':>8}{'steps':>8}{'rejected':>10}{'us':>8}   fixed:{'us':>8}   ratio"]
    for name, parameters in (*((name, parameters) for name, parameters, _ in STIFF), *EVEN):
        scene = as_scene(MODELS / f"{name}.mbd", parameters)
        mechanism = graph.build(scene)
        system, stop = build(scene, mechanism), scene.experiment.stop
        first, times = initial_state(system, mechanism, 0.0), np.linspace(0.0, stop, 201)[1:]

        def run(h: float, tol: float | None, of=(system, stop, first, times)) -> tuple[float, MethodRun]:
            system, stop, first, times = of
            found = MethodRun(system, method, h, 0.0, stop, times, tol=tol)
            found.begin(first.q, first.v, first.a, first.lam, first.redundant)
            begun = thread_time()
            while found.advance() == S.RUNNING:
                pass
            return thread_time() - begun, found

        for tol in tolerances:
            ours = theirs = np.inf
            for _ in range(repeats):
                one, like = run(1e-3 * stop, tol)
                other, _ = run(stop / like.steps, None)
                ours, theirs = min(ours, one), min(theirs, other)
            lines.append(
                f"{name:18}{tol:8.0e}{like.steps:8}{like.count('rejected'):10}{1e6 * ours / like.steps:8.2f}   {'':6}"
                f"{1e6 * theirs / like.steps:8.2f}   {ours / theirs:5.2f}"
            )
    return "\n".join(lines)


@cache
def names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in MODELS.glob("*.mbd")))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", default=",".join(names()))
    parser.add_argument("--methods", default="hht-si2")
    parser.add_argument("--tolerances", default=",".join(f"{tol:g}" for tol in TOLERANCES))
    given = parser.parse_args()
    tolerances = [float(x) for x in given.tolerances.split(",")]
    if given.models:
        print(table(given.models.split(","), given.methods.split(","), tolerances))
    for each in given.methods.split(","):
        print(f"\n{each}, beside fixed steps of the same error\n{beside_fixed(each, tolerances)}")
        print(f"\n{each}, a step beside a fixed one of the mean size\n{steps_beside_fixed(each, tolerances)}")
