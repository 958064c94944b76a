"""The time budget of a study, and its continuation, by a clock of its own: no run is simulated."""

import math
import types
from pathlib import Path

import numpy as np
import pytest

from mbdsl.studies import runner as running
from mbdsl.studies import workers
from mbdsl.studies.cases import Case, setting
from mbdsl.studies.runner import Runner
from mbdsl.studies.store import OUT_OF_TIME, Computed, Store
from mbdsl.studies.survey import rows_of

PENDULUM = Path(__file__).parents[3] / "models" / "pendulum.mbd"
STEPS = [0.01 / 2**k for k in range(8)]
CASES = [Case(method, step=h) for method in ("hht-si2", "newmark") for h in STEPS]
CASES += [Case("radau5", tol=10.0**-k) for k in range(3, 11)]


class World:
    """A clock, and runs that take a prescribed time."""

    def __init__(self, monkeypatch):
        self.now, self.speed, self.made, self.timed = 100.0, 1.0, [], []
        monkeypatch.setattr(running, "perf_counter", lambda: self.now)
        monkeypatch.setattr(running, "compute", self.compute)
        monkeypatch.setattr(running, "simulate_case", self.simulate)
        monkeypatch.setattr("mbdsl.studies.time_limits.perf_counter", lambda: self.now)
        monkeypatch.setattr(workers, "cores", lambda: 1)

    def cost(self, case):
        """Order 1 takes long; one case of ten hangs."""
        if case in (Case("newmark", step=STEPS[2]),):
            return math.inf
        own = {"hht-si2": 1e-3, "newmark": 2e-3, "radau5": 5e-2}[case.method]
        return self.speed * own * (case.size ** -(1.0 / 6.0) if case.tol else 1.0 / case.size)

    def compute(self, of, case, limit, announce, left, compiling):
        cost = self.cost(case)
        self.made.append(case)
        if cost > min(limit, left):
            self.now += min(limit, left)
            return Computed(case, stats={"seconds": {"integrate": min(limit, left)}}, problem=OUT_OF_TIME)
        self.now += cost
        t = np.linspace(0.0, 1.0, 3)
        stats = {"seconds": {"integrate": cost, "compile": 0.0}, "steps": 10}
        return Computed(case, t, t[:, None], t[:, None], t[:, None], stats)

    def simulate(self, of, case, progress):
        cost = self.cost(case)
        self.timed.append(case)
        self.now += cost
        status = "done"
        try:
            progress(types.SimpleNamespace(seconds=cost))
        except KeyboardInterrupt:
            status = "interrupted"
        seconds = {"integrate": cost, "compile": 0.0}
        return types.SimpleNamespace(status=status, t=[0.0], stats={"seconds": seconds})


@pytest.fixture
def world(monkeypatch):
    return World(monkeypatch)


def study(tmp_path, budget=math.inf):
    return Runner(setting(PENDULUM, 0.5), Store(tmp_path / "store"), budget=budget, workers=1)


def test_short_runs_come_first_whatever_their_method(world, tmp_path):
    """What a limited time completes is never slower than what it leaves out."""
    runs = study(tmp_path, 4.0).compute(CASES)
    done = [world.cost(case) for case, run in runs.items() if run.done]
    left = [world.cost(case) for case, run in runs.items() if run.late]
    assert len(done) + len(left) == len(CASES) and len(done) >= 10
    assert world.now <= 104.0 + 1e-9
    # one long run may have been ended after a part of the time
    assert max(done) < min(left)


@pytest.mark.parametrize("budget", [1.0, 4.0])
def test_the_budget_is_kept_and_the_next_study_goes_on(world, tmp_path, budget):
    """Each repetition completes more, and none repeats a run without giving it more time."""
    complete = 0
    for _ in range(40):
        begun, before = world.now, len(world.made)
        runs = study(tmp_path, budget).compute(CASES)
        assert world.now - begun <= budget + 1e-9
        done = sum(run.done for run in runs.values())
        assert done >= complete
        complete = done
        if len(world.made) == before:
            break
    # in the end, only runs are missing that take longer than the whole budget
    missing = [world.cost(case) for case, run in runs.items() if not run.done]
    assert missing and min(missing) > 0.5 * budget
    assert len(world.made) < 3 * len(CASES)


def test_a_run_that_hangs_does_not_take_the_time_of_the_others(world, tmp_path):
    """Of 200 s the others need 83 s; the run is ended, tried again with the remaining time, and reported."""
    hangs = Case("newmark", step=STEPS[2])
    runs = study(tmp_path, 200.0).compute(CASES)
    assert [case for case, run in runs.items() if not run.done] == [hangs] and runs[hangs].late
    assert world.now <= 300.0 + 1e-9


def test_a_part_of_the_budget_is_kept_for_later_phases(world, tmp_path):
    of = study(tmp_path, 4.0)
    of.reserved = 2.0
    of.compute(CASES)
    assert world.now <= 102.0 + 1e-9 and of.left <= 1e-9
    of.reserved = 0.0
    assert of.left == pytest.approx(104.0 - world.now)


def test_runs_at_the_ends_of_steps_have_their_part(world, tmp_path):
    """Cases whose steps do not reach the output times are run twice: in a short time, both runs of some."""
    of = study(tmp_path, 4.0)
    of.trajectory = lambda run: run
    rows = rows_of(of, CASES)
    twice = [row for row in rows if row.run.done and row.own is not row.trajectory]
    assert twice and world.now <= 104.0 + 1e-9


def test_timing_begins_with_the_fast_ones_and_goes_on(world, tmp_path):
    """Stored rounds are not repeated while the machine has the same speed."""
    some = [case for case in CASES if world.cost(case) < 0.5]
    total = sum(map(world.cost, some))
    first = study(tmp_path, 0.6 * total).time(some, 3, world.cost)
    assert 0 < len(first) < len(some) and world.now <= 100.0 + 0.6 * total
    assert max(map(world.cost, first)) <= min(world.cost(case) for case in some if case not in first)
    before = len(world.timed)
    second = study(tmp_path, 0.9 * total).time(some, 3, world.cost)
    assert set(first) < set(second) and all(second[case][: len(times)] == times for case, times in first.items())
    anew = [case for case in world.timed[before:] if case in first and len(second[case]) == 1]
    assert len(set(anew)) <= 1  # one case shows the speed of the machine


def test_times_of_a_machine_of_another_speed_are_not_mixed(world, tmp_path):
    """A machine may be half as fast on another day: methods are compared by times at one speed."""
    some = CASES[:3]
    study(tmp_path).time(some[:2], 2, world.cost)
    world.speed = 2.0
    times = study(tmp_path).time(some, 2, world.cost)
    assert times == {case: [pytest.approx(world.cost(case))] * 2 for case in some}


def test_a_run_that_is_being_timed_is_ended(world, tmp_path):
    """It took 0.01 s before, and takes 100 s now."""
    case = CASES[0]
    world.speed = 1e3
    assert study(tmp_path, 5.0).time([case], 3, lambda case: 0.01) == {}
