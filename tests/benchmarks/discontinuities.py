"""Benefit of stepping onto discontinuities: error and work with and without it, for known solutions.

python tests/benchmarks/discontinuities.py [tolerance ...]

The scenes and their solutions are those of tests/unit/integrators/test_events.py. Without it, the steps are controlled
by their errors alone.
"""

import sys
from pathlib import Path
from time import perf_counter
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).parents[1] / "unit" / "integrators"))

from test_events import CASES, solved

from mbdsl.integrators.events import SwitchEvents

METHODS = ("hht-si2", "nstiff")
HEAD = f"{'scene':12} {'method':8} {'tol':>6} {'':8} {'error':>8} {'steps':>7} {'rejected':>8} {'events':>6} {'ms':>6}"


def lines(tols, methods=METHODS, cases=tuple(CASES)):
    yield HEAD
    for name in cases:
        scene, solution, _ = CASES[name]
        for method in methods:
            for tol in tols:
                for located in (True, False):
                    with patch.object(
                        SwitchEvents, "begin", SwitchEvents.begin if located else lambda self, *state: None
                    ):
                        solved(scene, solution, method, tol)  # compiles
                        start = perf_counter()
                        found, error = solved(scene, solution, method, tol)
                        time = 1e3 * (perf_counter() - start)
                    counts = found.stats
                    yield (
                        f"{name:12} {method:8} {tol:6.0e} {'located' if located else 'not':8} {error:8.1e} "
                        f"{counts['steps']:7} {counts['rejected']:8} {counts['events']:6} {time:6.1f}"
                    )


if __name__ == "__main__":
    for line in lines([float(x) for x in sys.argv[1:]] or [1e-3, 1e-5]):
        print(line, flush=True)
