"""Runs that stand still are ended with a diagnosis; runs with legitimately short steps are not."""

import numpy as np
import pytest

from mbdsl import cli
from mbdsl.integrators import standstill
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.standstill import PATIENCE, STALLED, WINDOW, Stall, Standstill, _jumps, _of_state

#: at rest, velocities above 1e-13 m/s change the sign of the force: x'' = -2 tanh(v/1e-13)
STICKING = """model Sticking
  Ground ground(g = 0);
  Body b(m = 1, I = 1);
  Prismatic rail(ground, b.c);
  TranslationalSpringDamper brake(rail, force = (2 N)*tanh(v/(1e-13 m/s)));
initial equation
  rail.s = 0;
  rail.v = 1;
  annotation(experiment(StopTime = 2));
end Sticking;
"""


def test_a_run_that_stands_still_ends_with_its_law_and_its_results(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sticking.mbd").write_text(STICKING)
    code = cli.main(["simulate", "sticking.mbd", "--method", "hht-si2", "--tol", "1e-6", "--output", "kept.npz"])
    said = capsys.readouterr().err
    assert code == 4
    assert "sticking.mbd:5:29: error: the run stands still in the step to t = 0.5" in said
    assert "the law of TranslationalSpringDamper brake jumps back and forth" in said
    assert "\n      TranslationalSpringDamper brake(rail, force" in said and "tanh(v/v_s)" in said
    with np.load("kept.npz") as kept:
        t, v = kept["time"], kept["b.vx"]
    # v = 1 - 2 t vanishes at 0.5 s; an ended run has no error estimate: ten times the tolerance
    assert v == pytest.approx(np.maximum(1.0 - 2.0 * t, 0.0), abs=1e-5)
    assert 0.5 < t[-1] < 0.51


class Run:
    """A run of 1 s whose steps have the given lengths [s]."""

    start, stop, span = 0.0, 1.0, 1.0

    def __init__(self, steps):
        self.ends = np.concatenate([[0.0], np.cumsum(steps)])
        self.steps, self.reals = 0, np.zeros(S.REALS)
        self.reals[S.MOST_H] = 0.02

    @property
    def time(self):
        return float(self.ends[self.steps])

    def state(self):
        return np.zeros(1), np.zeros(1), np.zeros(0)

    def advance(self, steps):
        self.steps += min(steps, len(self.ends) - 1 - self.steps)
        return S.RUNNING


def ended(steps, monkeypatch, jumps=False):
    """Whether a run with these steps is ended, if forces jump or not."""
    run = Run(steps)
    monkeypatch.setattr(Standstill, "_cause", lambda self, rows, n, dt: Stall(n, dt, coordinate="x" if jumps else ""))
    watch = Standstill(run)
    while run.steps < len(steps):
        run.advance(WINDOW)
        if watch.look(S.RUNNING, run.advance) == STALLED:
            return True
    return False


def test_short_steps_that_resolve_a_motion_do_not_end_a_run(monkeypatch):
    start = np.minimum(1e-15 * 1.01 ** np.arange(4 * WINDOW), 1e-3)  # from the rounding error of time
    assert not ended(start, monkeypatch, jumps=True)
    impact = np.r_[np.full(100, 1e-3), np.full(4 * WINDOW, 1e-9), np.full(100, 1e-3)]  # 20 us in 20000 steps
    assert not ended(impact, monkeypatch)
    decay = np.r_[np.full(20 * WINDOW, 1e-13), np.full(100, 1e-3)]  # 10 ns of a motion that decays, in a run of 1 s
    assert not ended(decay, monkeypatch)
    many = np.full(4 * WINDOW, 2e-7)  # 5 million steps in all
    assert not ended(many, monkeypatch, jumps=True)


def test_short_steps_without_an_end_end_a_run(monkeypatch):
    assert ended(np.r_[np.full(100, 1e-3), np.full(4 * WINDOW, 1e-9)], monkeypatch, jumps=True)
    assert ended(np.r_[np.full(100, 1e-3), np.full((PATIENCE + 4) * WINDOW, 4.5e-14)], monkeypatch)  # as reported
    assert ended(np.r_[np.full(100, 1e-3), np.full(2 * WINDOW, 1e-27)], monkeypatch)  # time does not change


def test_what_counts_as_a_jump():
    k = np.arange(128.0)
    assert _jumps(np.sin(2 * np.pi * k / 20)) == 0  # 20 steps a period resolve an oscillation
    assert _jumps(np.where(k > 60, 1.0, 0.0)) == 0  # a single jump
    assert _jumps((-1.0) ** k) > standstill.OFTEN * 128
    assert _jumps(1e3 + (-1.0) ** k) == 0  # a small part of the force
    assert _jumps(np.full(128, np.nan)) == 0 and _jumps(np.zeros(128)) == 0


def test_forces_that_jump_as_functions_of_time_do_not_count():
    k = np.arange(128.0)
    pulses, state = np.where(k % 4 < 2, 1.0, -1.0), (-1.0) ** k
    assert _jumps(pulses) > standstill.OFTEN * 128  # steps end at each of them
    assert _of_state(pulses, held=pulses) == 0
    assert _of_state(state, held=np.ones(128)) == _jumps(state)
