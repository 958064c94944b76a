"""Cost of elastic coordinates: the flexible slider crank with 2 ... 128 of them, in both formulations.

    python tests/benchmarks/flexible_bodies.py [--steps 2000] [--repeats 5]

The rod is modelled by eigenmodes and by all coordinates of its finite elements (floating frame of reference), and by
absolute nodal coordinates. One process, one thread, warm; processor time of the step loops alone. More coordinates add
higher frequencies, which change the numbers of evaluations and factorisations of Newton's iteration; times are
therefore also given per iteration. ``power`` is the exponent by which the time of an iteration has grown since the line
before: 1 is linear. Matrices of modes are full by nature, those of elements are banded. Nothing is asserted: times
belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import mbdsl
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import plan
from mbdsl.simulation.run_options import RunOptions

H = 1e-4
METHODS = ("hht-i3", "hht-si2")
SIZES = (2, 8, 32, 128)
TEXT = """
model FlexibleSliderCrank
  Ground ground;
  Rod crank(m = 3 kg, length = 0.3 m);
  FlexibleBeam rod(mass = 0.9 kg, length = 0.6 m, S = 5.74e-6 m2, I = 2.765e-8 m4, E = 200 GPa, {how});
  Revolute O(ground, crank.a);
  Revolute A(crank.b, rod.a);
  PointOnLine B(ground, rod.b);
initial equation
  crank.phi = 0 deg;
  crank.w = 1 rad/s;
  guess rod.phi = 0 deg;
end FlexibleSliderCrank;
"""


def formulations(k: int) -> dict[str, str]:
    """Models of the rod with (about) ``k`` elastic coordinates, by name; ANCF has 4 a node, 3 of them rigid."""
    found = {"modes": f"modes = {k}, axial = {max(1, k // 4)}"}
    if k % 4 == 0:
        found["elements"] = f"elements = {k // 4}"
    found["ancf"] = f'formulation = "ancf", elements = {max(1, k // 4)}'
    return found


@dataclass(frozen=True)
class Cost:
    coordinates: int  #: elastic ones
    us: float  #: a step
    iterations: float  #: a step
    matrices: float  #: a step
    entries: int  #: of the factorised matrix

    @property
    def of_iteration(self) -> float:
        return self.us / self.iterations


def measure(how: str, method: str, steps: int, repeats: int) -> Cost:
    """The fastest of ``repeats`` runs."""
    from mbdsl.lang.load import parse_text

    scene = parse_text(TEXT.format(how=how))
    least = math.inf
    for _ in range(repeats):
        motion = MechanismRun(scene, plan(scene, RunOptions(method=method, step=H, stop=steps * H, interval=steps * H)))
        motion.prepare()
        begun = time.process_time()
        motion.advance(steps)
        least = min(least, time.process_time() - begun)
    (part,) = motion.parts
    done = max(1, motion.steps)
    counts = (motion.count(k) / done for k in ("iterations", "matrix_evaluations"))
    size = part.integration.matrices.shape[1]
    return Cost(part.system.tables.models["rod"].n - 3, 1e6 * least / done, *counts, size)


def table(steps: int = 2000, repeats: int = 5, sizes: Sequence[int] = SIZES) -> str:
    head = f"{'':10} {'method':8} {'coordinates':>11} {'us/step':>9} {'iterations':>10} {'matrices':>9}"
    lines = [
        f"mbdsl {mbdsl.__version__}, h = {1e3 * H:g} ms",
        f"{head} {'us/iteration':>12} {'entries':>8} {'power':>6}",
    ]
    for name in ("modes", "elements", "ancf"):
        for method in METHODS:
            before = None
            for k in sizes:
                how = formulations(k).get(name)
                if how is None:
                    continue
                c = measure(how, method, steps, repeats)
                line = f"{name:10} {method:8} {c.coordinates:11} {c.us:9.2f} {c.iterations:10.2f} {c.matrices:9.4f}"
                line += f" {c.of_iteration:12.3f} {c.entries:8}"
                if before is not None and c.coordinates > before.coordinates:
                    growth = math.log(c.of_iteration / before.of_iteration)
                    line += f" {growth / math.log(c.coordinates / before.coordinates):6.2f}"
                lines.append(line)
                before = c
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    print(table(arguments.steps, arguments.repeats))
