"""Other processes that compute cases: each reads them line by line, and puts what comes of them into the store."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from mbdsl.compilation import code_cache
from mbdsl.errors import MbdslError
from mbdsl.lang.library import imports_allowed
from mbdsl.storage import cache_folder
from mbdsl.studies.cases import Case, Setting, setting
from mbdsl.studies.compute import compute
from mbdsl.studies.store import ENDED, LOST, OUT_OF_TIME, Computed, Store, key_of

#: what a process answers that would not run what it was asked to
CHANGED = "the model, the method or mbdsl itself is not what it was when the study began"
#: what it answers that has no room to write the result
UNKEPT = "the result could not be written"


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(
    of: Setting,
    store: Store,
    cases: list[Case],
    count: int,
    left: Callable[[], float],
    add: Callable[[Case, Computed], None],
) -> None:
    """Compute ``cases``, which are taken out one by one, in ``count`` processes; ``add`` gets each as it is done.

    What is left of ``cases`` is not done: processes that have ended, or that found the model changed, take no more.
    """
    results: queue.Queue[tuple[Case, Computed] | None] = queue.Queue()
    lock = threading.Lock()
    processes = [_start() for _ in range(count)]

    def feed(process: subprocess.Popen) -> None:
        assert process.stdin is not None and process.stdout is not None
        try:
            while True:
                with lock:
                    if not cases:
                        return
                    case = cases.pop(0)
                limit, said, whole = left(), "", True
                key = key_of(of, case)
                if limit > 0.0:
                    job = json.dumps(_job(of, store, case, key, min(limit, 1e9)), default=float)
                    try:
                        process.stdin.write(job + "\n")
                        process.stdin.flush()
                        said = process.stdout.readline()
                    except OSError:
                        pass
                    whole = said.endswith("\n")
                    answer = json.loads(said) if whole else {"problem": ENDED}
                else:
                    answer = {"problem": OUT_OF_TIME}
                if answer["problem"] in (CHANGED, UNKEPT):
                    with lock:
                        cases.insert(0, case)
                    return
                if answer.get("kept"):
                    store.claim(key)
                kept = None if answer["problem"] else store.get(key, case)
                results.put((case, kept or Computed(case, problem=answer["problem"] or LOST)))
                if not whole:
                    return
        finally:
            results.put(None)

    threads = [threading.Thread(target=feed, args=(process,), daemon=True) for process in processes]
    try:
        for thread in threads:
            thread.start()
        ended = 0
        while ended < count:
            try:
                found = results.get(timeout=0.2)  # a wait without end would not hear Ctrl-C everywhere
            except queue.Empty:
                continue
            if found is None:
                ended += 1
            else:
                add(*found)
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    with contextlib.suppress(OSError):
                        stream.close()


def _start() -> subprocess.Popen:
    """A process that imports from where this one does; Ctrl-C is for this one alone to hear."""
    environment = {**os.environ, **cache_folder.environment(), "OPENBLAS_NUM_THREADS": "1"}
    code = f"import sys; sys.path[:] = {sys.path!r}; from mbdsl.studies.workers import main; main()"
    return subprocess.Popen(
        [sys.executable, "-I", "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
        text=True,
        start_new_session=True,
    )


def _job(of: Setting, store: Store, case: Case, key: str, limit: float) -> dict:
    where = {"path": of.path, "stop": of.stop, "points": of.points, "without": of.without}
    where["imports"] = of.allow_imports if isinstance(of.allow_imports, bool) else os.fspath(of.allow_imports)
    return {
        **where,
        "parameters": dict(of.parameters),
        "case": asdict(case),
        "store": str(store.folder),
        "key": key,
        "limit": limit,
    }


def main() -> None:
    """Read a job a line, answer each with a line, until there are no more or the process that asks has ended."""
    code_cache.alone()
    jobs: queue.Queue[str] = queue.Queue()

    def read() -> None:
        for line in sys.stdin:
            jobs.put(line)
        os._exit(0)  # in the midst of a job, too: nobody waits for its answer

    threading.Thread(target=read, daemon=True).start()
    # what a solver prints must not be taken for an answer
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    known: dict[str, Setting] = {}
    while True:
        job = json.loads(jobs.get())
        answers.write(json.dumps(_answer(job, known)) + "\n")
        answers.flush()


def _answer(job: Mapping[str, Any], known: dict[str, Setting]) -> dict:
    """Run a job; ``kept`` where the store has it now."""
    case = _case(job["case"])
    try:
        of = _setting(job, known)
        same = key_of(of, case) == job["key"]
    except (MbdslError, OSError):  # it cannot even be read any more
        same = False
    if not same:  # a file was edited since: what it says now must not be taken for what it said
        return {"problem": CHANGED}
    run = compute(of, case, job["limit"])
    if run.lasting and not Store(job["store"]).put(job["key"], run):
        return {"problem": UNKEPT}
    return {"problem": run.problem, "kept": run.lasting}


def _case(said: Mapping[str, Any]) -> Case:
    return Case(said["method"], said["step"], said["tol"], tuple((n, x) for n, x in said["options"]), said["ends"])


def _setting(job: Mapping[str, Any], known: dict[str, Setting]) -> Setting:
    """The model is read once."""
    arguments = (job["path"], job["stop"], job["parameters"], tuple(job["without"]), job["points"])
    if repr(arguments) not in known:
        with imports_allowed(job["imports"]):
            known[repr(arguments)] = setting(*arguments)
    return known[repr(arguments)]
