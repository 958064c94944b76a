"""Cost of many events: processor time and memory over the number of impacts and of samples.

    python tests/benchmarks/event_costs.py [--most 100000]

A body strikes two walls in turn, 1 mm apart, at 1 m/s and e = 1; a sampled controller acts in every step of 1 ms, and
the same steps without it are measured as well. Memory is the peak of the process so far. Nothing is asserted: times
depend on the machine and its load; tests/verification/test_event_costs.py asserts numbers of evaluations.
"""

from __future__ import annotations

import argparse
import resource
from collections.abc import Iterator
from time import process_time

import mbdsl

HEAD = """model {name}
  Ground ground(g = 0 m/s2);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic s(ground, b.c);
"""
WALLS = (
    HEAD.format(name="Walls")
    + """  Contact right(gap = 1 mm - s.s, e = 1), left(gap = s.s, e = 1);
initial equation
  s.s = 0.5 mm; s.v = 1 m/s;
end Walls;"""
)
SAMPLED = (
    HEAD.format(name="Sampled")
    + """  discrete Real F(unit = "N", start = 0);
  Force f(b.c, fx = F);
initial equation
  s.s = 1 m; s.v = 0 m/s;
equation
  when sample(0, 1 ms) then
    F = -1 N/m*s.s - 1 N.s/m*s.v;
  end when;
end Sampled;"""
)
CONTINUOUS = (
    HEAD.format(name="Continuous")
    + """  Force f(b.c, fx = -1 N/m*s.s - 1 N.s/m*s.v);
initial equation
  s.s = 1 m; s.v = 0 m/s;
end Continuous;"""
)
MODELS = {"impacts": WALLS, "samples": SAMPLED, "steps without": CONTINUOUS}
TABLE = f"{'':14} {'count':>9} {'seconds':>9} {'us each':>9} {'peak MB':>9}"


def run(model: str, count: int):
    """A run of so many impacts, samples or steps."""
    return mbdsl.simulate(mbdsl.parse(MODELS[model]), stop=count * 1e-3, step=1e-3, interval=count * 1e-5)


def lines(most: int) -> Iterator[str]:
    yield TABLE
    for model in MODELS:
        run(model, 10)  # compiles
        count = max(10, most // 100)
        while count <= (most if model == "impacts" else 10 * most):
            begun = process_time()
            run(model, count)
            seconds = process_time() - begun
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            yield f"{model:14} {count:9} {seconds:9.2f} {1e6 * seconds / count:9.1f} {memory:9.0f}"
            count *= 10


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=int, default=10_000, help="impacts; ten times as many samples")
    for line in lines(parser.parse_args().most):
        print(line, flush=True)
