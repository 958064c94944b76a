"""Workers: other processes that compute cases of a study.

Each worker is a spawned process in a :class:`concurrent.futures.ProcessPoolExecutor` of its own. A pool fails as a
whole when one of its processes dies; with one process in each, the other workers continue, and the lost case is known.
A worker receives the Setting, with its Scene, when it starts, and then one case at a time. It writes the result into
the store and answers with a few words: a worker that is killed while it sends a long message would block its pool.

``concurrent.futures`` leaves the following tasks to its users; :class:`_Process` and :func:`_begin` do them:

- A spawned process imports the main module of its parent again. A script without ``if __name__ == "__main__":`` would
  run once more in every worker. Workers do not import it.
- A worker ends with its parent, even if the parent is killed. The pool alone would wait for the next case for ever.
- Ctrl-C and the closing of a terminal reach all processes of the terminal. Only the parent responds to them.
- Output printed by a worker, or by a solver in it, is discarded.
- A worker's BLAS uses one thread, which has to be set before numpy is loaded.
- A busy worker is killed at once, not after its case.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from mbdsl.integrators import method_files
from mbdsl.storage import cache_folder
from mbdsl.studies.cases import Case, Setting
from mbdsl.studies.compute import compute
from mbdsl.studies.store import ENDED, LOST, OUT_OF_TIME, Computed, Store

#: answer of a worker whose version of mbdsl, or of the method, differs from that of its parent
CHANGED = "mbdsl or the method has changed since the study began"
#: answer of a worker that cannot write its result
UNKEPT = "the result could not be written"


def cores() -> int:
    """Cores that this process may use; 1 if it must not start processes."""
    if multiprocessing.current_process().daemon:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(
    of: Setting,
    store: Store,
    cases: list[Case],
    count: int,
    limits: Callable[[Case], tuple[float, float, float]],
    add: Callable[[Case, Computed], None],
) -> None:
    """Compute cases in several processes.

    A worker that ends during a case is replaced, and the case is not repeated. Workers that cannot be started, or that
    would not compute what this process computes, take no cases.

    Parameters
    ----------
    of : Setting
        The setting of all cases.
    store : Store
        Store for the results.
    cases : list of Case
        Removed one by one; the remaining cases have not been computed.
    count : int
        Number of workers.
    limits : callable
        Returns the time limits [s] of a case that begins now: of its step loop, and of all that it takes; and the
        expected time of a compilation [s].
    add : callable
        Called with each case and its result.
    """
    with suppress(pickle.PicklingError, TypeError, AttributeError):  # e.g. a kind that exists in this process only
        _Team(of, pickle.dumps(of), store, cases, limits, add).work(count)


class _Answer(NamedTuple):
    """The result of a case; ``kept`` if it is in the store."""

    problem: str
    kept: bool = False


# -- in the parent -----------------------------------------------------------------------------------------------------

_starting = threading.Lock()


class _Process(SpawnProcess):
    """A process that starts with the environment of a worker."""

    def start(self) -> None:
        with _starting, _worker_environment(), _no_main_module(), _signals_for_the_parent():
            super().start()


class _Worker(SpawnContext):
    """A pool of one process, and the context in which it starts its process."""

    def __init__(self, setting: bytes, folder: Path) -> None:
        super().__init__()
        self.processes: list[_Process] = []
        self.pool = ProcessPoolExecutor(1, self, _begin, (setting, folder, method_files.paths()))

    def Process(self, *args: Any, **kwargs: Any) -> _Process:  # type: ignore[override]
        self.processes.append(_Process(*args, **kwargs))
        return self.processes[-1]

    def submit(self, function: Callable, *args: object) -> Future:
        return self.pool.submit(function, *args)

    def terminate(self) -> None:
        for process in self.processes:
            if process.pid is not None:
                process.terminate()


@dataclass
class _Team:
    """The workers of :func:`side_by_side`, whose arguments it has; ``setting`` is that of the cases, pickled."""

    of: Setting
    setting: bytes
    store: Store
    cases: list[Case]
    limits: Callable[[Case], tuple[float, float, float]]
    add: Callable[[Case, Computed], None]
    workers: list[_Worker] = field(default_factory=list)
    #: the worker and the case of each answer that is waited for; None: the worker starts
    busy: dict[Future, tuple[_Worker, Case | None]] = field(default_factory=dict)

    def work(self, count: int) -> None:
        """Start ``count`` workers, and give them cases until there are none left."""
        try:
            for _ in range(count):
                self.start()
            while self.busy:
                # a wait without end would not notice Ctrl-C on every system
                for future in wait(self.busy, timeout=0.2, return_when=FIRST_COMPLETED).done:
                    self.answered(future, *self.busy.pop(future))
        finally:
            for worker in self.workers:
                worker.terminate()
            for worker in self.workers:
                worker.pool.shutdown()

    def start(self) -> None:
        with suppress(OSError, RuntimeError, ImportError, NotImplementedError):  # a system without processes or locks
            worker = _Worker(self.setting, self.store.folder)
            self.workers.append(worker)
            self.busy[worker.submit(_ready)] = worker, None

    def feed(self, worker: _Worker) -> None:
        """Give the next case to a worker."""
        while self.cases:
            case = self.cases.pop(0)
            limit, left, compiling = self.limits(case)
            if min(limit, left) <= 0.0:
                self.add(case, Computed(case, problem=OUT_OF_TIME))
                continue
            key = self.store.key(self.of, case)
            try:
                self.busy[worker.submit(_compute, case, key, limit, left, compiling)] = worker, case
            except BrokenExecutor:  # it has ended since its last answer
                self.cases.insert(0, case)
                self.start()
            return

    def answered(self, future: Future, worker: _Worker, case: Case | None) -> None:
        """Take the answer of a worker, and give it the next case."""
        problem = future.exception()
        if case is None:
            if problem is None:
                self.feed(worker)
            return
        answer = _Answer(ENDED) if problem is not None else future.result()
        if answer.problem in (CHANGED, UNKEPT):
            self.cases.insert(0, case)
            return
        key = self.store.key(self.of, case)
        if answer.kept:
            self.store.claim(key)
        kept = None if answer.problem else self.store.get(key, case)
        self.add(case, kept or Computed(case, problem=answer.problem or LOST))
        if not isinstance(problem, BrokenExecutor):
            self.feed(worker)
        elif self.cases:
            self.start()


@contextmanager
def _worker_environment() -> Iterator[None]:
    """Environment variables that a process reads while it starts."""
    # modules of Python must not be imported from the folder of the script or the current folder
    added = {**cache_folder.environment(), "OPENBLAS_NUM_THREADS": "1", "PYTHONSAFEPATH": "1"}
    before = {name: os.environ.get(name) for name in added}
    os.environ.update(added)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _no_main_module() -> Iterator[None]:
    """A main module without name and file, so that the new process does not import it."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _signals_for_the_parent() -> Iterator[None]:
    """Ctrl-C and the end of the terminal are blocked in the new process, from its first instruction on."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


# -- in the worker -----------------------------------------------------------------------------------------------------

_work: tuple[Setting, Store]


def _begin(setting: bytes, folder: Path, methods: tuple[str, ...]) -> None:
    """Make this process a worker."""
    global _work
    threading.Thread(target=_end_with_the_parent, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    for path in methods:
        method_files.load(path)
    _work = pickle.loads(setting), Store(folder)


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(0)  # also during a case: no process waits for the answer


def _ready() -> None:
    """The first task of a worker; a worker that cannot begin does not answer."""


def _compute(case: Case, key: str, limit: float, left: float, compiling: float = 0.0) -> _Answer:
    """Compute a case within its time limits [s] and put the result into the store under ``key``."""
    of, store = _work
    if store.key(of, case) != key:  # another version, which would give other results
        return _Answer(CHANGED)
    run = compute(of, case, limit, None, left, compiling)
    store.put_spent(key, run)
    if run.lasting and not store.put(key, run):
        return _Answer(UNKEPT)
    return _Answer(run.problem, run.lasting)
