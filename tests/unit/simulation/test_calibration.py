"""Calibration with failing runs: an error is estimated up to the time that two runs have reached."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from mbdsl.integrators.loop import loop_state as S
from mbdsl.simulation.calibration_runs import observed_order
from mbdsl.simulation.plan import Plan
from mbdsl.simulation.tolerance_calibration import calibrated

T, TOL = np.linspace(0.0, 1.0, 201), 1e-4


class Sine:
    """q = sin t, with an error of ``error(eps)`` times t in q and v; a failing run ends at 0.3 or 0.4 s in turn."""

    def __init__(self, fails, steps=10, error=lambda eps: 0.1 * eps, status=S.TOO_SMALL):
        self.plan = Plan("hht-si2", 1.0, 0.0, 1.0, T[1:], {}, tol=TOL)
        self.system = SimpleNamespace(tables=SimpleNamespace(scale=np.ones(1), n=1, states=0), difference=np.subtract)
        self.fails, self.few, self.steps, self.trial_steps, self.failed = fails, steps, steps, 0, 0
        self.error, self.status, self.tried, self.parts = error, status, [], ()

    def restart(self, plan):
        self.eps = plan.tol
        self.steps = round(self.few * (4e-3 / self.eps) ** 0.5)  # as of a method of order 2

    def run(self):
        self.tried.append(self.eps)
        return self.status if self.fails(self.eps) else S.DONE

    def states(self):
        t = T
        if self.fails(self.eps):
            self.failed += 1
            t = T[: 60 + 20 * (self.failed % 2)]
        off = self.error(self.eps) * t[:, None]
        return t, np.sin(t)[:, None] + off, np.cos(t)[:, None] + off

    def keep(self):
        return SimpleNamespace(eps=self.eps, integrations=())

    def recall(self, kept):
        self.eps = kept.eps

    def bent(self):
        return False

    def outgrown(self):
        return False

    def parts_of(self, kept):
        return iter(())


@pytest.mark.parametrize("fails", [(3e-3, 1.0), (1e-4, 3e-3), (5e-5, 1e-4), (5e-5, 3e-3)], ids=str)
@pytest.mark.filterwarnings("error")
def test_trial_runs_that_fail(fails):
    """The estimate is true for the remaining run, whichever run failed."""
    motion = Sine(lambda eps: fails[0] < eps < fails[1])
    status, found = calibrated(motion, TOL, motion.run)
    true = 0.1 * motion.eps
    assert status == S.DONE
    assert true <= found.error <= 10.0 * true
    assert (found.horizon is None) == (found.error <= TOL)


@pytest.mark.parametrize("status", [S.TOO_SMALL, S.DIVERGED])
def test_the_best_run_is_looked_for_behind_a_failure(status):
    """Runs succeed down to an eps of 2e-6, and have errors of 100 eps: 5e-7 would be needed."""
    motion = Sine(lambda eps: eps < 2e-6, error=lambda eps: 100.0 * eps, status=status)
    assert calibrated(motion, TOL, motion.run)[0] == S.DONE
    assert 2e-6 < motion.eps < 8e-6
    motion.tried.clear()
    found = calibrated(motion, TOL, motion.run)[1]
    assert 100.0 * motion.eps <= 2.0 * found.error <= 1000.0 * motion.eps
    assert 0.1 < found.horizon * 100.0 * motion.eps / TOL < 10.0
    assert "with shorter steps" in found.reason
    assert motion.trial_steps == sum(round(10 * (4e-3 / eps) ** 0.5) for eps in motion.tried) - motion.steps


def test_a_failure_behind_a_leap_is_made_up_for():
    """The errors of the first two runs are much more than eps times a constant; the runs that they suggest fail, and
    are not needed."""
    motion = Sine(lambda eps: eps < 1e-5, error=lambda eps: eps + 2500.0 * eps**2)
    status, found = calibrated(motion, TOL, motion.run)
    true = motion.error(motion.eps)
    assert any(motion.fails(eps) for eps in motion.tried)
    assert status == S.DONE and found.horizon is None
    assert true <= found.error <= TOL


def test_what_takes_too_many_steps_is_not_tried():
    """The number of steps grows as eps^-1/2, and 5e-13 would be needed: 4e8 steps at 1e6 of 1e-7."""
    motion = Sine(lambda eps: False, steps=1_000_000)
    found = calibrated(motion, 1e-13, motion.run)[1]
    assert min(motion.tried) > 1e-9
    assert found.reason == "it would take too many steps"
    assert 0.1 * motion.eps <= found.error


def test_the_rung_between_is_tried():
    """Two runs show no order: their difference, as an error, asks for an eps that takes four times the steps that are
    afforded, 2e7. The errors are a seventh of it, and an eps of 1e-5 takes 20 times the steps of the first run."""
    motion = Sine(lambda eps: False, steps=1_000_000, error=lambda eps: 10.0 * eps)
    status, found = calibrated(motion, TOL, motion.run)
    assert motion.steps < 2.001e7
    assert status == S.DONE and found.error <= TOL and not found.reason
    assert 10.0 * motion.eps <= found.error


def test_errors_that_fall_late_are_waited_for():
    """The first runs show the order 1/3 in eps, as those of backends at contacts do: an eps of 1e-13 and less would be
    needed. Behind 1e-8 errors fall by a thousand, and the next run shows it."""
    motion = Sine(lambda eps: False, error=lambda eps: 0.1 * eps ** (1 / 3) * (1e-3 if eps < 1e-8 else 1.0))
    motion.plan = replace(motion.plan, method="scipy-dop853")
    status, found = calibrated(motion, TOL, motion.run)
    assert status == S.DONE and found.error <= TOL and not found.reason


def test_errors_that_do_not_fall_are_not_called_too_many_steps():
    motion = Sine(lambda eps: False, error=lambda eps: 0.03 * eps ** (1 / 6))
    motion.plan = replace(motion.plan, method="scipy-dop853")
    found = calibrated(motion, 1e-6, motion.run)[1]
    assert found.reason == "runs with shorter steps do not converge"


def test_nothing_is_claimed_of_times_that_one_run_has_come_to():
    """One run reaches the stop time, and another one would take too many steps."""
    motion = Sine(lambda eps: eps > 1e-5, steps=15_000_000)
    status, found = calibrated(motion, TOL, motion.run)
    assert status == S.DONE
    assert found.error is None
    assert found.horizon <= 0.4


@pytest.mark.parametrize("p", [0.4, 0.5, 0.75, 1.0])
def test_the_order_of_unequal_rungs(p):
    """Errors eps^p of runs with three tolerances: the differences of runs determine p."""
    rungs = (1e-2, 1e-3, 2e-4, 3e-5)
    trials = [SimpleNamespace(eps=b, differs=0.1 * (a**p - b**p)) for a, b in pairwise(rungs)]
    assert observed_order(trials) == pytest.approx(p, abs=1e-8)
    trials[-1].differs = 2.0 * trials[-2].differs
    assert observed_order(trials) is None
