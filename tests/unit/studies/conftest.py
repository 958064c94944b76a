"""A clock that counts work: budgets of studies end at the same step on every machine, however busy it is."""

import pytest

from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.studies import workers

STEP = 1e-5  #: [s] for a step or an iteration of Newton's method, about their time
CLOCKS = (
    "simulation.simulate",
    "studies.accuracy",
    "studies.reference_solution",
    "studies.runner",
    "studies.time_limits",
)


@pytest.fixture
def work_clock(monkeypatch):
    """Seconds are counted in steps and iterations: compilation and all other work take no time.

    Studies run in this process, because workers have the clock of the system.
    """
    now, advance = 0.0, MechanismRun.advance

    def work(motion):
        return STEP * (motion.steps + motion.count("iterations"))

    def counted(motion, steps):
        nonlocal now
        before = work(motion)
        status = advance(motion, steps)
        now += max(STEP, work(motion) - before)
        return status

    monkeypatch.setattr(MechanismRun, "advance", counted)
    monkeypatch.setattr(workers, "cores", lambda: 1)
    for module in CLOCKS:
        monkeypatch.setattr(f"mbdsl.{module}.perf_counter", lambda: now)
