"""Runs of a study: stored, found again, computed in parallel, interrupted, and out of time."""

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from dataclasses import replace
from multiprocessing.context import SpawnProcess
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError
from mbdsl.simulation.provenance import _sources, code, versions
from mbdsl.storage import cache_folder
from mbdsl.studies import runner as running
from mbdsl.studies import workers
from mbdsl.studies.cases import Case, cases, common_points, longer_steps, setting, step_ladder
from mbdsl.studies.runner import Runner
from mbdsl.studies.store import ENDED, OUT_OF_TIME, Computed, Store, key_of

MODELS = Path(__file__).parents[3] / "models"
CRANK = MODELS / "slider_crank.mbd"
CASES = [Case("hht-si2", step=h) for h in (4e-3, 2e-3, 1e-3)]


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


def runner(store, stop=0.2, **given):
    return Runner(setting(CRANK, stop), store, **given)


def test_what_was_computed_is_found(store):
    first = runner(store)
    runs = first.compute(CASES)
    assert (first.computed, first.found) == (3, 0)
    again = runner(Store(store.folder))
    found = again.compute(CASES)
    assert (again.computed, again.found) == (0, 3)
    for case in CASES:
        for name in ("t", "q", "v", "lam"):
            assert np.array_equal(getattr(runs[case], name), getattr(found[case], name))
        assert runs[case].stats == found[case].stats
    anew = runner(Store(store.folder, fresh=True))
    anew.compute(CASES)
    assert (anew.computed, anew.found) == (3, 0)


def test_everything_that_determines_a_run_is_in_its_key(tmp_path, monkeypatch):
    base = setting(CRANK, 0.2)
    case = CASES[0]
    copy = tmp_path / "copy.mbd"
    copy.write_text(CRANK.read_text(encoding="utf-8"), encoding="utf-8")
    assert key_of(setting(copy, 0.2), case) == key_of(base, case)  # the location of the file does not matter
    copy.write_text(CRANK.read_text(encoding="utf-8").replace("k = 100 N/m", "k = 101 N/m"), encoding="utf-8")
    keys = {
        key_of(base, case),
        key_of(setting(copy, 0.2), case),
        key_of(setting(CRANK, 0.3), case),
        key_of(setting(CRANK, 0.2, points=50), case),
        key_of(setting(CRANK, 0.2, {"c": 4.0}), case),
        key_of(setting(CRANK, 0.2, without=("damping",)), case),
        key_of(base, Case("hht-i3", step=4e-3)),
        key_of(base, Case("hht-si2", step=2e-3)),
        key_of(base, Case("hht-si2", tol=4e-3)),
        key_of(base, Case("hht-si2", step=4e-3, options=(("alpha", -0.2),))),
    }
    monkeypatch.setattr("mbdsl.studies.store.code", lambda: "of another version")
    assert len(keys | {key_of(base, case)}) == 11


def test_a_key_does_not_tell_types_of_numbers():
    """Numbers of Python and of numpy determine the same run."""
    numpy = [Case("hht-si2", step=np.float64(4e-3)), Case("hht-si2", step=np.float64(4e-3), options=())]
    assert {key_of(setting(CRANK, 0.2), c) for c in numpy} == {key_of(setting(CRANK, np.float64(0.2)), CASES[0])}


@pytest.mark.parametrize("name", ["numpy", "scipy", "llvmlite", "scikit-sundae"])
def test_what_a_run_is_computed_with_is_in_its_key(name, monkeypatch):
    base, case = setting(CRANK, 0.2), CASES[0]
    before = key_of(base, case)
    of = {**versions(), name: "0.0.0"}
    monkeypatch.setattr("mbdsl.simulation.provenance.versions", lambda: of)
    code.cache_clear()
    try:
        assert key_of(base, case) != before
    finally:
        code.cache_clear()


def test_a_failure_is_kept(store):
    wrong = Case("hht-i3", step=0.5)
    first = Runner(setting(CRANK), store)
    problem = first.compute([wrong])[wrong].problem
    assert "step" in problem or "converge" in problem
    again = Runner(setting(CRANK), store)
    assert again.compute([wrong])[wrong].problem == problem
    assert again.found == 1


def test_a_spoilt_file_is_computed_anew(store):
    runner(store).compute(CASES)
    (store.folder / f"{key_of(setting(CRANK, 0.2), CASES[0])}.npz").write_bytes(b"half a")
    again = runner(store)
    again.compute(CASES)
    assert (again.computed, again.found) == (1, 2)


def test_no_damage_of_a_file_is_read(store):
    """A file that is cut anywhere, or has a bit flipped anywhere, gives the stored values or nothing."""
    case = CASES[0]
    t = np.linspace(0.0, 1.0, 6)
    store.put("run", Computed(case, t, t[:, None], t[:, None], t[:, None], {"steps": 5}))
    store.put_times("run", "session", [0.25, 0.5])
    for path in sorted(store.folder.glob("*.npz")):
        whole = path.read_bytes()
        cut = [whole[:n] for n in range(0, len(whole), 41)]
        turned = [whole[:n] + bytes([whole[n] ^ 16]) + whole[n + 1 :] for n in range(0, len(whole), 5)]
        for damaged in cut + turned:
            path.write_bytes(damaged)
            run, times = store.get("run", case), store.times("run")
            assert run is None or (run.stats == {"steps": 5} and np.array_equal(run.q[:, 0], t) and len(run.lam) == 6)
            assert times in (("", []), ("session", [0.25, 0.5]))
        path.write_bytes(whole)
    assert store.get("run", case).stats == {"steps": 5} and store.times("run")[1] == [0.25, 0.5]


def test_a_damaged_length_is_not_read(store):
    """numpy abbreviates long arrays in their text."""
    t = np.linspace(0.0, 1.0, 10_000)
    store.put("run", Computed(CASES[0], t, t[:, None], t[:, None], t[:, None]))
    path = store.folder / "run.npz"
    whole = path.read_bytes()
    assert whole.count(b"(10000,") == 4
    path.write_bytes(whole.replace(b"(10000,", b"(5000 ,"))
    assert store.get("run", CASES[0]) is None


def test_what_passes_is_not_kept(store, monkeypatch):
    """There may be more memory on another day."""

    def full(*args, **given):
        raise MemoryError("Unable to allocate 8 GiB")

    with monkeypatch.context() as patch:
        patch.setattr("mbdsl.studies.compute.simulated", full)
        short = runner(store)
        assert "not enough memory" in short.compute(CASES)[CASES[0]].problem
    assert not list(store.folder.iterdir()) and not short.kept
    assert runner(store).compute(CASES)[CASES[0]].done


def test_an_interruption_keeps_what_is_done(store):
    def tell(reported):
        if reported.done == 2:
            raise KeyboardInterrupt

    first = runner(store, tell=tell)
    with pytest.raises(KeyboardInterrupt):
        first.compute(CASES)
    assert len(first.kept) == 2
    again = runner(store)
    again.compute(CASES)
    assert (again.computed, again.found) == (1, 2)


def test_out_of_time(store, monkeypatch, work_clock):
    """A run that does not fit into the budget is reported, and not stored."""
    runs = runner(store, budget=1e-9).compute(CASES)
    assert {run.problem for run in runs.values()} == {OUT_OF_TIME}
    long = Case("hht-si2", step=1e-7)  # 2e7 steps
    part = Runner(setting(CRANK), store, budget=0.3)
    assert part.compute([long])[long].problem == OUT_OF_TIME
    assert -0.3 < part.left < 0.0 and not part.kept and part.store.get(key_of(part.setting, long), long) is None
    spent = part.store.spent(key_of(part.setting, long))
    assert 0.3 < spent < 0.6
    monkeypatch.setattr(running, "compute", forbidden)  # it is not repeated with the same limit
    assert Runner(setting(CRANK), store).compute([long], limit=spent)[long].problem == OUT_OF_TIME


def test_side_by_side_is_the_same(store, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "ALONE", -1.0)
    wrong = Case("hht-add", step=0.2)
    every = [*CASES, wrong]
    many = runner(store, workers=2)
    found = many.compute(every)
    alone = runner(Store(tmp_path / "other"), workers=1).compute(every)
    for case in every:
        assert found[case].problem == alone[case].problem
        assert np.array_equal(found[case].q, alone[case].q)
        assert np.array_equal(found[case].lam, alone[case].lam)
    assert many.computed == 4
    assert runner(store).compute(CASES).keys() == set(CASES)


def forbidden(*arguments):
    raise AssertionError("this process computes nothing")


@pytest.mark.parametrize("kind", ["file that is edited", "builder"])
def test_workers_get_the_scene(kind, store, tmp_path, monkeypatch):
    """From any source of the scene: workers read no file."""
    if kind == "builder":
        model = mbdsl.Builder("P")
        model.Revolute("pin", model.Ground("ground"), model.Rod("rod", m=1.0, length=1.0).a)
        model.Torque("motor", "rod.a", tau="1 N.m*sin(3*time) - 0.1*rod.w")
        model = model.scene()
    else:
        model = tmp_path / "crank.mbd"
        model.write_text(CRANK.read_text(encoding="utf-8"), encoding="utf-8")
    of = setting(model, 0.2)
    here = running.compute(of, CASES[0])
    if kind == "file that is edited":
        model.write_text("no model at all", encoding="utf-8")
    with monkeypatch.context() as patch:
        patch.setattr(running, "ALONE", -1.0)
        patch.setattr(running, "compute", forbidden)
        found = Runner(of, store, workers=2).compute(CASES[:2])
    assert all(run.done for run in found.values())
    for name in ("t", "q", "v", "lam"):
        assert np.array_equal(getattr(found[CASES[0]], name), getattr(here, name))


def test_a_worker_that_ends_loses_its_case_only(store, monkeypatch):
    """The system kills a worker during a long run: another one takes its place."""
    long, done = Case("hht-si2", step=1e-7), {}
    submit = workers._Worker.submit

    def killed(worker, function, *arguments):
        future = submit(worker, function, *arguments)
        if long in arguments:
            while not future.running():  # the worker has the case
                time.sleep(0.01)
            worker.processes[0].kill()
        return future

    monkeypatch.setattr(workers._Worker, "submit", killed)
    waiting = [long, *CASES[:2]]
    workers.side_by_side(setting(CRANK), store, waiting, 1, lambda case: (1e9, 1e9, 0.0), done.__setitem__)
    assert waiting == [] and [done[case].problem for case in (long, *CASES[:2])] == [ENDED, "", ""]
    assert multiprocessing.active_children() == []


def cannot_start(self):
    raise OSError("no more processes")


def dies_at_once(self):
    SpawnProcess.start(self)
    self.kill()


@pytest.mark.parametrize("start", [cannot_start, dies_at_once])
def test_workers_that_cannot_begin_take_no_cases(start, store, monkeypatch):
    monkeypatch.setattr(running, "ALONE", -1.0)
    monkeypatch.setattr(workers._Process, "start", start)
    said = []
    many = runner(store, workers=2, announce=said.append)
    runs = many.compute(CASES)
    assert all(run.done for run in runs.values()) and len(many.kept) == 3
    assert any("could not start" in line for line in said)


def test_a_scene_that_cannot_travel_is_computed_here(store, monkeypatch):
    monkeypatch.setattr(running, "ALONE", -1.0)
    of = replace(setting(CRANK, 0.2), parameters={"f": lambda: None})
    assert all(run.done for run in Runner(of, store, workers=2).compute(CASES[:2]).values())


def test_the_surroundings_of_a_worker(store, capfd, monkeypatch, tmp_path):
    """Workers use BLAS with one thread, import no main module, ignore Ctrl-C, and print nothing; this process is
    unchanged."""
    monkeypatch.setattr(cache_folder, "environment", lambda: {cache_folder.HANDED: str(tmp_path)})
    monkeypatch.setattr(sys.modules["__main__"], "__file__", str(tmp_path / "script.py"), raising=False)
    (tmp_path / "script.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    before, main = dict(os.environ), sys.modules["__main__"]
    worker = workers._Worker(pickle.dumps(setting(CRANK, 0.2)), store.folder)
    try:
        worker.submit(os.write, 1, b"noise").result()
        worker.submit(os.write, 2, b"noise").result()
        names = ("OPENBLAS_NUM_THREADS", cache_folder.HANDED)
        assert [worker.submit(os.getenv, name).result() for name in names] == ["1", str(tmp_path)]
        assert worker.submit(signal.getsignal, signal.SIGINT).result() == signal.SIG_IGN
        if hasattr(signal, "pthread_sigmask"):
            blocked = worker.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
            assert {signal.SIGINT, signal.SIGHUP} <= blocked
            assert not {signal.SIGINT, signal.SIGHUP} & signal.pthread_sigmask(signal.SIG_BLOCK, ())
    finally:
        worker.terminate()
        worker.pool.shutdown()
    assert capfd.readouterr() == ("", "")
    assert dict(os.environ) == before and sys.modules["__main__"] is main and not (tmp_path / "ran").exists()


SCRIPT = """
import multiprocessing, sys
from mbdsl.studies import runner
from mbdsl.studies.cases import Case, setting
from mbdsl.studies.store import Store
print("begun", flush=True)
runner.ALONE = -1.0
def tell(progress):
    print(progress.done, *(process.pid for process in multiprocessing.active_children()), flush=True)
cases = [Case("hht-si2", step=h) for h in (4e-3, 2e-3, 2e-9, 1e-9)]
runner.Runner(setting({model!r}), Store({folder!r}), workers=2, tell=tell).compute(cases)
"""


def runs_on(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{pid}/stat")
    return not (stat.exists() and stat.read_text().rpartition(")")[2].split()[0] == "Z")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("by", [signal.SIGKILL, signal.SIGINT] if sys.platform != "win32" else [])
def test_a_worker_ends_with_its_parent(by, store, tmp_path, default_signals):
    """During long runs: by SIGKILL, or by Ctrl-C, which only the parent receives. The script has no guard."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(model=str(CRANK), folder=str(store.folder)))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment}
    with subprocess.Popen([sys.executable, script], start_new_session=True, **pipes) as process:
        try:
            lines = [process.stdout.readline().split() for _ in range(3)]
            assert lines[0] == ["begun"] and [line[0] for line in lines[1:]] == ["1", "2"]  # the long ones are next
            pids = [int(pid) for pid in lines[2][1:]]
            assert len(pids) == 2 and all(map(runs_on, pids))
            if by == signal.SIGINT:
                os.killpg(process.pid, by)
            else:
                process.kill()
            rest, said = process.communicate(timeout=300.0)
        finally:
            process.kill()
    assert rest == "" and said.count("Traceback") == (by == signal.SIGINT)
    limit = time.monotonic() + 300.0  # the runs take far longer
    while any(map(runs_on, pids)) and time.monotonic() < limit:
        time.sleep(0.05)
    assert not any(map(runs_on, pids))


def test_the_code_that_makes_a_run_is_in_its_key():
    package = Path(running.__file__).parents[1]
    names = {path.relative_to(package).as_posix() for path in _sources()}
    assert {"simulation/simulate.py", "integrators/loop/driver.py", "studies/compute.py", "studies/cases.py"} <= names
    assert not {"cli/study.py", "studies/report.py", "plotting/pages.py"} & names


def test_a_method_that_is_edited_while_it_runs(store, monkeypatch):
    monkeypatch.setattr(running, "ALONE", -1.0)
    monkeypatch.setattr("mbdsl.studies.store.code", lambda: "as this process knows it")
    reported = []
    runs = runner(store, workers=2, announce=reported.append).compute(CASES)
    assert all(run.done for run in runs.values()) and any("has changed" in line for line in reported)


def test_a_worker_says_that_it_has_no_room(store, monkeypatch):
    """The parent then computes the case, as after any worker that accepts no more cases."""
    of, case = setting(CRANK, 0.2), CASES[0]
    monkeypatch.setattr(workers, "_work", (of, store), raising=False)
    assert workers._compute(case, key_of(of, case), 9.0, 9.0) == ("", True)
    monkeypatch.setattr(Store, "put", lambda self, key, run: False)
    assert workers._compute(case, key_of(of, case), 9.0, 9.0) == (workers.UNKEPT, False)
    assert workers._compute(case, "another key", 9.0, 9.0) == (workers.CHANGED, False)


def test_the_oldest_runs_go(store):
    runner(store).compute(CASES)
    files = sorted(store.folder.glob("*.npz"))
    for age, file in enumerate(files):
        os.utime(file, (1e9 - age, 1e9 - age))
    store.prune(largest=files[0].stat().st_size + 1)
    assert list(store.folder.glob("*.npz")) == files[:1]


def test_what_a_process_left_that_was_ended_goes(store):
    old, new = (store.folder / f".key.npz.{n}.{n}.part" for n in (1, 2))
    for part in (old, new):
        part.write_bytes(b"half a run")
    os.utime(old, (1e9, 1e9))
    store.prune()
    assert not old.exists() and new.exists()


def test_times_alternate_and_are_kept(store):
    first, second = CASES[:2]
    reported = []
    timed = runner(store, tell=lambda t: reported.append(t.what))
    runs = timed.compute([first, second])
    reported.clear()
    seconds = timed.time([first, second], 3, lambda case: runs[case].stats["seconds"]["integrate"])
    assert [len(x) for x in seconds.values()] == [3, 3] and min(map(min, seconds.values())) > 0.0
    rounds = [sorted(reported[k : k + 2]) for k in range(0, 6, 2)]
    assert rounds == [sorted([f"timing {first}", f"timing {second}"])] * 3
    reported.clear()
    assert runner(store, tell=lambda t: reported.append(t.what)).time([first], 3, lambda case: 0.0) == {
        first: seconds[first]
    }
    assert reported == []


def timing(store, cases, rounds, **given):
    of = runner(store, **given)
    reported = []
    of.tell = lambda t: reported.append(t.what)
    return of.time(cases, rounds, lambda case: 0.01), reported


def test_a_session_may_be_continued(store):
    first, second = CASES[:2]
    runner(store).compute(CASES)
    both, reported = timing(store, [first, second], 2)
    assert len(reported) == 4 and timing(store, [first, second], 2) == (both, [])
    again = runner(store)
    one = again.time([first, second], 4, lambda case: 0.0)
    more = again.time([first, second], 5, lambda case: 0.0)
    assert [more[case][:4] for case in (first, second)] == [one[case] for case in (first, second)]


def test_what_does_not_fit_into_the_budget_is_not_timed(store):
    runner(store).compute(CASES)
    assert timing(store, CASES, 3, budget=1e-9) == ({}, [])


# -- which runs there are --------------------------------------------------------------------------------------------


def test_cases_of_methods():
    found, refused = cases(["hht-si2", "nstiff"], [1e-3, 2e-3], None)
    assert [str(c) for c in found] == [
        "hht-si2, h = 0.002 s",
        "hht-si2, h = 0.001 s",
        "nstiff, h = 0.002 s",
        "nstiff, h = 0.001 s",
    ]
    assert refused == []
    with pytest.raises(UsageError, match="not a step"):
        cases(["hht-si2"], [0.0], None)
    with pytest.raises(UsageError, match="not a tolerance"):
        cases(["hht-si2"], None, [2.0])


def test_ladders_reach_all_output_times():
    for name in ("slider_crank", "pendulum", "seven_body", "stick_slip_belt"):
        of = setting(MODELS / f"{name}.mbd")
        steps = np.array(step_ladder(of))
        counts = of.interval / steps
        assert np.allclose(counts, np.round(counts), rtol=1e-12) and counts[0] >= 1
        assert np.allclose(steps[:-1] / steps[1:], 2.0)


def test_methods_of_high_order_have_longer_steps():
    of = setting(MODELS / "slider_crank.mbd")
    steps = step_ladder(of)
    longer = longer_steps(of, steps)
    assert len(longer) == len(steps) and np.allclose(np.divide(longer[:-1], longer[1:]), 2.0)
    assert longer[0] == 8.0 * steps[0]
    found, _ = cases(["radau5", "hht-si2"], steps, None, high=longer)
    assert [x.step for x in found] == [*longer, *steps]
    short = replace(of, stop=of.start + 25.0 * steps[0])
    assert longer_steps(short, steps)[0] == 2.0 * steps[0]  # at least ten steps in a run


def test_output_points_that_steps_share():
    assert common_points(2.0, [8e-3, 4e-3, 2e-3]) == 125  # of 250, 500 and 1000 steps
    assert common_points(2.0, [1e-3, 0.7e-3]) == 100  # no common step times: outputs lie between steps


def test_no_time_to_look_at():
    with pytest.raises(UsageError, match="needs a stop time"):
        setting(CRANK, 0.0)
