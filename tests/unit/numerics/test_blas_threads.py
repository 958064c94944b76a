"""One thread of BLAS during calls of mbdsl, and as many as before afterwards."""

import threading

import numpy as np
import pytest

import mbdsl
from mbdsl.numerics import blas_threads

ARM = """model Arm
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  annotation(experiment(StopTime = 10 ms, Step = 1 ms));
end Arm;"""


@pytest.fixture
def library(monkeypatch):
    found = blas_threads._loaded()
    if not found:
        pytest.skip("this NumPy has no OpenBLAS of its own")
    own = found["numpy"] if "numpy" in found else next(iter(found.values()))
    before = own.get()
    own.set(2)
    yield own
    own.set(before)


def test_threads_in_nested_blocks_and_after_errors(library):
    with blas_threads.one_thread():
        assert library.get() == 1
        with blas_threads.one_thread():
            np.linalg.svd(np.eye(60))
            assert library.get() == 1
        assert library.get() == 1
    assert library.get() == 2
    with pytest.raises(ZeroDivisionError), blas_threads.one_thread():
        1 / 0  # noqa: B018
    assert library.get() == 2


def test_blocks_that_overlap_in_two_threads(library):
    entered, leave = threading.Event(), threading.Event()

    def other():
        with blas_threads.one_thread():
            entered.set()
            leave.wait(10.0)

    thread = threading.Thread(target=other)
    with blas_threads.one_thread():
        thread.start()
        assert entered.wait(10.0)
    assert library.get() == 1
    leave.set()
    thread.join()
    assert library.get() == 2


@pytest.mark.parametrize(
    "call",
    [
        lambda progress: mbdsl.simulate(mbdsl.parse(ARM), progress=progress),
        lambda progress: mbdsl.simulate(mbdsl.parse(ARM), tol=1e-4, progress=progress),
    ],
)
def test_simulations_compute_with_one_thread(library, call, monkeypatch):
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 3)
    seen = []
    call(lambda progress: seen.append(library.get()))
    assert set(seen) == {1} and library.get() == 2


def test_reactions_are_computed_with_one_thread(library, monkeypatch):
    run, seen = mbdsl.simulate(mbdsl.parse(ARM), method="dop853", tol=1e-6), []
    from mbdsl.simulation import derived_signals

    plain = derived_signals.motion
    monkeypatch.setattr(derived_signals, "motion", lambda *given: (seen.append(library.get()), plain(*given))[1])
    assert len(run["pin.fx"]) == len(run.t) and set(seen) == {1} and library.get() == 2
