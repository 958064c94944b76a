"""The run times of the statements of the emitted code, each measured separately, and of a whole run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter
from typing import Any

from mbdsl.integrators import modules
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.part_run import PartRun
from mbdsl.system.emit import FACTORS, CodeLine, load_repeated

#: duration of the measurement of one statement and of one run [s]
PATIENCE, RUN_PATIENCE = 0.01, 0.2


def measure(motion: MechanismRun) -> tuple[float, dict[tuple[str, str], float]]:
    """Seconds of a step of all parts, and the seconds of a step for each statement, by (effect, function)."""
    total = 0.0
    spent: dict[tuple[str, str], float] = {}
    for p in motion.parts:
        seconds, often, rarely = _run(p)
        total += seconds
        for line, one, tangent in _lines(p):
            key = line.effect, line.text.split("(")[0]
            spent[key] = spent.get(key, 0.0) + one * (rarely if tangent else often)
    return total, spent


def _run(p: PartRun) -> tuple[float, float, float]:
    """Seconds of a step, evaluations and tangents a step, from as many steps as the time limit allows."""
    assert isinstance(p.integration, MethodRun)
    integers, slice_, spent = p.integration.integers, 64, 0.0
    p.integration.advance(4)  # initial overhead
    start, least = integers.copy(), float("inf")
    while spent < RUN_PATIENCE:
        before, begun = int(integers[S.STEP]), perf_counter()
        status = p.integration.advance(slice_)
        now = perf_counter() - begun
        spent += now
        # the fastest interval, because other work on the machine slows down the rest
        least = min(least, now / max(1, int(integers[S.STEP]) - before))
        if status != S.RUNNING:
            break
    done = integers - start
    steps = max(1, int(done[S.STEP]))
    matrices = int(done[S.MATRICES]) * modules()[p.method].METHOD.matrices
    return least, int(done[S.ITERATIONS]) / steps, matrices / steps


def _lines(p: PartRun) -> Iterator[tuple[CodeLine, float, bool]]:
    """Every statement of the part's code with its time, and whether it belongs to ``tangent``."""
    t, run = p.system.tables, p.integration
    assert isinstance(run, MethodRun)
    repeated = load_repeated(t.blocks, t.has_tape, modules()[p.method].METHOD.sets)
    arrays = [x.copy() for x in (run.vectors, run.frames, run.gradients, run.numbers, run.layout, run.matrices[0])]
    for lines, tangent in ((repeated.evaluate, False), (repeated.tangent, True)):
        for line, function in lines:
            yield line, _seconds(function, run.time, *[1.0] * len(FACTORS), *arrays), tangent


def _seconds(call: Callable[..., None], *arguments: Any) -> float:
    """Seconds of one repetition: the least of three sufficiently long runs; the number of repetitions comes first."""
    number, spent = 1, 0.0
    while spent < PATIENCE / 4 and number < 1 << 24:
        number *= 4
        begun = perf_counter()
        call(number, *arguments)
        spent = perf_counter() - begun
    found = [spent]
    for _ in range(2):
        begun = perf_counter()
        call(number, *arguments)
        found.append(perf_counter() - begun)
    return min(found) / number
