"""Benefit of specialisation: time of a step of the general path relative to the specialised one.

    python tests/benchmarks/general_path.py [--repeats 25]

The general path (``mbdsl simulate --general``) is one code for all scenes, with the loops of all kinds, and solves the
scene as written. The specialised path has only the code that the scene needs, and solves the scene after its welds are
merged, its driven bodies are turned into functions of time, and its independent parts are separated. Every shipped
model, with its own step and stop time, and one scene with all of these reductions are run. One process, one thread,
warm; the two alternate within a round, and a ratio compares runs of the same round. Times are of the step loops alone,
and the processor's, which a busy machine disturbs less. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

import mbdsl
from mbdsl.integrators.loop import loop_state as S
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import plan
from mbdsl.simulation.run_options import RunOptions

MODELS = Path(__file__).parents[2] / "models"
PATHS = {"specialised": False, "general": True}
#: a bracket on the ground with two independent pendulums, one of them on a driven arm; each consists of three welded
#: bodies
WELDED = """
model Welded "welds, a driven arm and two independent parts"
  Ground ground;
  Rod bracket(m = 5 kg, length = 1 m);
  Fixed foot(ground, bracket.a, phi0 = 90 deg);
  Rod a(m = 2 kg, length = 1 m);
  Rod a2(m = 1 kg, length = 0.6 m);
  Body a3(m = 0.5 kg, I = 0.01 kg.m2);
  Revolute A(bracket.b, a.a);
  Fixed a_corner(a.b, a2.a, phi0 = 90 deg);
  Fixed a_weight(a2.b, a3.c);
  Rod arm(m = 1 kg, length = 0.3 m);
  Revolute S(bracket.b, arm.a);
  RotationalDriver drive(S, phi = 0.5 rad*sin(3 rad/s*time));
  Rod b(m = 2 kg, length = 0.8 m);
  Rod b2(m = 1 kg, length = 0.4 m);
  Body b3(m = 0.5 kg, I = 0.01 kg.m2);
  Revolute B(arm.b, b.a);
  Fixed b_corner(b.b, b2.a, phi0 = -90 deg);
  Fixed b_weight(b2.b, b3.c);
initial equation
  a.phi = -60 deg;
  b.phi = -80 deg;
  annotation(experiment(StopTime = 2 s));
end Welded;
"""


@dataclass
class Cost:
    """Measurements of one path on one scene."""

    us: list[float] = field(default_factory=list)  #: a step, in each round
    iterations: float = 0.0  #: a step
    sizes: dict[str, int] = field(default_factory=dict)
    status: int = S.DONE


def cases() -> dict[str, Scene]:
    """Every shipped model, and the scene with welds."""
    found = {path.stem: mbdsl.load(path) for path in sorted(MODELS.glob("*.mbd"))}
    return {**found, "welded": mbdsl.parse(WELDED)}


def measure(scene: Scene, repeats: int, method: str | None = None, steps: int | None = None) -> dict[str, Cost]:
    """Both paths ``repeats`` times, in turn; ``steps`` shortens the runs."""
    costs = {name: Cost() for name in PATHS}
    for k in range(repeats + 1):
        for name in PATHS if k % 2 else reversed(PATHS):  # warm up again after the parameters have changed
            run = plan(scene, RunOptions(method=method, general=PATHS[name], interval=scene.experiment.stop))
            motion = MechanismRun(scene, run)
            motion.prepare()
            begun = time.process_time()
            status = motion.advance(steps or round((run.stop - run.start) / run.h))
            seconds = time.process_time() - begun
            done = max(1, motion.steps)
            cost = costs[name]
            cost.iterations, cost.sizes = motion.count("iterations") / done, motion.sizes
            cost.status = S.DONE if steps and status == S.RUNNING else status
            if k > 0:  # the first round loads the compiled code
                cost.us.append(1e6 * seconds / done)
    return costs


def ratios(costs: dict[str, Cost]) -> tuple[float, float]:
    """General over specialised: of the minima, and the median over rounds."""
    one, other = costs["specialised"].us, costs["general"].us
    return min(other) / min(one), median(b / a for a, b in zip(one, other, strict=True))


def rows(name: str, costs: dict[str, Cost]) -> list[str]:
    """The two lines of one scene."""
    lines, (low, middle) = [name], ratios(costs)
    for path, cost in costs.items():
        sizes = "{n:4} {m:4} {p:2} {parts:5}".format(**cost.sizes)
        ratio = f"   {low:5.2f} {middle:6.2f}" if path == "general" else ""
        failed = "" if cost.status == S.DONE else "   VOID: stopped early"
        line = f"  {path:12} {sizes} {min(cost.us):9.3f} {median(cost.us):8.3f} {cost.iterations:10.2f}{ratio}{failed}"
        lines.append(line)
    return lines


def table(repeats: int = 25, steps: int | None = None, method: str | None = None) -> str:
    """Everything as text."""
    head = f"{'':15}{'':17} {'us/step':>9} {'':8} {'iterations':>10}   {'ratio':5}\n"
    head += f"{'':15}{'n':>4} {'m':>4} {'p':>2} {'parts':>5} {'min':>9} {'median':>8} {'a step':>10}   "
    lines = [head + f"{'min':>5} {'median':>6}"]
    for name, scene in cases().items():
        lines += rows(name, measure(scene, repeats, method, steps))
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=25)
    parser.add_argument("--steps", type=int, default=None, help="fewer steps, for a quick look")
    parser.add_argument("--method", default=None, help="default: that of each model")
    arguments = parser.parse_args()
    print(table(arguments.repeats, arguments.steps, arguments.method))
