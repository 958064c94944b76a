"""Every claim against every method: ``python tests/verification/claims/table.py --output docs/claims.md``.

Results go, one a line, to ``--results`` (default claims.jsonl in the cache); existing results of the same sources are
not computed again. Two processes; a cell that takes longer than ``--limit`` seconds of computing is called too slow.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import sys
import tempfile
import threading
import time
import warnings
from collections import Counter
from dataclasses import asdict
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
HERE = Path(__file__).parent
ROOT = HERE.parents[2]
sys.path[:0] = [str(HERE)]
sys.path.append(str(ROOT))

import judge  # noqa: E402
import mechanisms  # noqa: E402
from claim import OUTPUTS  # noqa: E402

from models import CLAIMS  # noqa: E402

#: (way, method, requested accuracy): for every model
ALWAYS = [("--tol", "hht-si2", 1e-4), ("--tol", "radau5", 1e-6), ("--accuracy", "", 1e-4)]
#: number of these for every model, in turn; --all takes all of them
IN_TURN = [
    ("--tol", "scipy-dop853", 1e-6),
    ("--tol", "generalized-alpha", 1e-4),
    ("--verify", "hht-si2", 1e-4),
    ("--tol", "ida", 1e-6),
    ("--tol", "hht-si2", 1e-6),
    ("--tol", "nstiff-si2", 1e-4),
    ("--tol", "scipy-lsoda", 1e-6),
    ("--tol", "hht-add", 1e-4),
    ("--tol", "radau5", None),
    ("--tol", "hht-i3", 1e-3),
    ("recommend", "", 1e-4),
    ("--tol", "scipy-radau", 1e-5),
    ("--tol", "nstiff", 1e-3),
    ("--tol", "radau5", 1e-3),
    ("--accuracy", "", 1e-6),
    ("--tol", "generalized-alpha-i3", 1e-3),
    ("--tol", "newmark", 1e-2),
    ("--tol", "dop853", 1e-6),
    ("--tol", "radau9", 1e-4),
    ("--tol", "radau13", 1e-5),
]
TURNS = 5
#: further ways, in which all calibration runs miss a contact by less than their error
FURTHER = {"GrazeFaint": [("--tol", "radau5", 1e-3), ("--tol", "radau5", 1e-4), ("--tol", "hht-si2", 1e-3)]}
#: of all contacts: methods of high order pass them in few steps
CONTACTS = [("--tol", "dop853", 1e-6), ("--tol", "radau9", 1e-4), ("--tol", "radau13", 1e-5)]


def ways(name: str, every: bool = False) -> list[tuple]:
    """The ways of claiming an accuracy by which a model is tested."""
    first = TURNS * list(CLAIMS).index(name)
    turns = IN_TURN if every else [IN_TURN[(first + k) % len(IN_TURN)] for k in range(TURNS)]
    contacts = CONTACTS if CLAIMS[name].family in ("bouncing", "grazing") or "Floor" in name else []
    return list(dict.fromkeys([*ALWAYS, *turns, *FURTHER.get(name, []), *contacts]))


class TooSlow(KeyboardInterrupt):
    """The cell has used its time."""


def watch(limit: float):
    """A progress callback that ends a run after ``limit`` seconds of computing."""
    begun: list[float] = []

    def check_time(p) -> None:
        begun.append(time.process_time())
        if begun[-1] - begun[0] > limit:
            raise TooSlow

    return check_time


def cell(name: str, way: str, method: str, asked: float | None, limit: float = 30.0, general: bool | None = None):
    """The verdict on one model and one way to claim an accuracy."""
    import mbdsl
    from mbdsl.errors import IntegrationError, MbdslError

    claim = CLAIMS[name]
    if general is None:
        general = claim.name in mechanisms.CLAIMS  # one code, compiled once, for all of them
    common = {"interval": claim.stop / OUTPUTS, "progress": watch(limit), "general": general}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = mbdsl.parse(claim.text)
            if way == "--tol":
                run = mbdsl.simulate(scene, method=method, tol=asked, **common)
                said = run.stats["error"]
            elif way == "--accuracy":
                run = mbdsl.simulate(scene, accuracy=asked, **common)
                said = run.stats["accuracy"]["estimated"]
            elif way == "--verify":
                run, said = verified(claim, scene, method, asked, common)
            else:
                run, said = recommended(scene, asked, common)
    except KeyboardInterrupt:
        return judge.Verdict(judge.LATE, asked)
    except MbdslError as problem:
        reason = f"{type(problem).__name__}: {problem.message}"[:200]
        if not isinstance(problem, IntegrationError):  # a model of this folder has to be accepted
            return judge.Verdict(judge.LIE, asked, reason=reason)
        return judge.stopped(claim, getattr(problem, "trajectory", None), asked, reason)
    except Exception as problem:
        return judge.Verdict(judge.LIE, asked, reason=f"{type(problem).__name__}: {problem}"[:200])
    if run.stats.get("horizon") is not None:  # the default tolerance: a warning, not an error
        return judge.stopped(claim, run, run.stats["tol"], run.message)
    return judge.judge(claim, run, asked, said if said is None or math.isfinite(said) else None)


def verified(claim, scene, method, asked, common):
    """The difference of two runs in the norm of the rule: the largest of positions and velocities."""
    import mbdsl
    from mbdsl.errors import IntegrationError
    from mbdsl.studies.verify import verify

    run = mbdsl.simulate(scene, method=method, tol=asked, **common)
    found = verify(run, run.motion_names, progress=common["progress"])
    if found.problem:
        raise IntegrationError(f"not verified: {found.problem}")
    if found.doubtful:
        raise IntegrationError(f"doubtful: {found.doubtful[0].signal} agrees to {found.doubtful[0].digits:.1f} digits")
    size, speed = run.system.tables.size, 1.0 / claim.stop
    for key in run.motion_names:
        quantity = key.rsplit(".", 1)[1]
        if quantity in ("vx", "vy", "w"):
            speed = max(speed, abs(run[key]).max() / (1.0 if quantity == "w" else size))
    said = 0.0
    for a in found.agreements:
        quantity = a.signal.rsplit(".", 1)[1]
        scale = (1.0 if quantity in ("phi", "w") else size) * (speed if quantity in ("vx", "vy", "w") else 1.0)
        said = max(said, a.difference / scale if a.difference == a.difference else 0.0)
    return run, said


def recommended(scene, asked, common):
    """The recommended run, and its stated error."""
    import mbdsl
    from mbdsl.studies.recommendation import recommend

    with tempfile.TemporaryDirectory() as store:
        best = recommend(scene, asked, store=store, budget=15.0, repeats=1).best
    common = common | {"general": False}  # as the runs of the search: newmark differs, where drivers are not eliminated
    return mbdsl.simulate(scene, method=best.case.method, step=best.case.step, tol=best.case.tol, **common), best.error


def worker(conn, limit: float) -> None:
    while True:
        what = conn.recv()
        if what is None:
            return
        begun = time.process_time()
        found = asdict(cell(*what, limit=limit))
        conn.send({**found, "seconds": round(time.process_time() - begun, 3)})


def compute(jobs: list[tuple], limit: float, keep) -> None:
    """Run ``jobs``, (name, way, method, asked), in a process of its own that is killed if it hangs."""
    context = multiprocessing.get_context("spawn")
    process = conn = None
    while True:
        try:
            job = jobs.pop(0)
        except IndexError:
            break
        if process is None:
            conn, other = context.Pipe()
            process = context.Process(target=worker, args=(other, limit), daemon=True)
            process.start()
            other.close()
        conn.send(job)
        try:
            found = conn.recv() if conn.poll(600 + 20 * limit) else None
        except EOFError:
            found = asdict(judge.Verdict(judge.LIE, job[3], reason="the process died"))
            process = None
        if found is None:
            process.terminate()
            process, found = None, asdict(judge.Verdict(judge.LATE, job[3], reason="ended from outside"))
        keep(job, found)
    if process is not None:
        conn.send(None)
        process.join()


def number(x: float | None) -> str:
    return "-" if x is None else f"{x:.1e}"


def page(results: dict[tuple, dict], limit: float) -> str:
    """docs/claims.md."""
    names = {name for name, *_ in results}
    kinds = [judge.TRUE, judge.PESSIMISTIC, judge.STOPPED, judge.UNKNOWN, judge.LATE, judge.LIE]

    def counts(title: str, key) -> list[str]:
        rows: dict[str, Counter] = {}
        for job, found in results.items():
            rows.setdefault(key(job), Counter())[found["verdict"]] += 1
        lines = [f"| {title} | " + " | ".join(kinds) + " |", "|---|" + "---|" * len(kinds)]
        lines += [f"| {name} | " + " | ".join(str(row[k]) for k in kinds) + " |" for name, row in rows.items()]
        total = sum(rows.values(), Counter())
        return [*lines, "| all | " + " | ".join(str(total[k]) for k in kinds) + " |", ""]

    def way(job) -> str:
        _, way, method, _ = job
        return f"`{way}`" if not method or way == "--verify" else f"`{way}`, {method}"

    lines = [INTRODUCTION.format(models=len(names), cells=len(results), limit=limit, turns=TURNS)]
    cells = sum(len(ways(name)) for name in CLAIMS)
    missing = cells - sum(job[1:] in ways(job[0]) for job in results)
    if missing:
        lines += [f"This page is incomplete: {missing} of {cells} runs have not been made yet.", ""]
    lines += ["## By option", "", *counts("option", way)]
    lines += ["## By family", "", *counts("family", lambda job: CLAIMS[job[0]].family)]
    lines += [
        "## Models",
        "",
        "`truth/asked` is the true error over the requested error, `truth/said` the true error over the stated error;",
        "each is the largest value over all runs of the model.",
        "",
    ]
    lines += ["| model | family | answer | truth/asked | truth/said | lies |", "|---|---|---|---|---|---|"]
    for name in (x for x in CLAIMS if x in names):
        found = [(job, x) for job, x in results.items() if job[0] == name and x["truth"] is not None]
        asked = max((x["truth"] / x["asked"] for _, x in found if x["asked"]), default=None)
        floor = max(judge.FLOOR, CLAIMS[name].stored["agrees"])
        said = max((x["truth"] / max(x["said"], floor) for _, x in found if x["said"] is not None), default=None)
        lies = [job for job, x in results.items() if job[0] == name and x["verdict"] == judge.LIE]
        lie_text = ", ".join(f"{m or w} {a:g}" if a else m for _, w, m, a in lies) or "none"
        agrees = CLAIMS[name].stored["agrees"]
        source = f"closed form, {agrees:.0e}" if CLAIMS[name].exact else f"{agrees:.0e}"
        lines.append(f"| {name} | {CLAIMS[name].family} | {source} | {number(asked)} | {number(said)} | {lie_text} |")
    return "\n".join(lines) + "\n"


INTRODUCTION = """# Claims

<!-- made by `python tests/verification/claims/table.py --output docs/claims.md` -->

{models} models built to mislead an error estimate, run with every option that states an accuracy: {cells} runs. The
models are in `tests/verification/claims/`; each has an independent answer: a closed form, or a solution by SciPy's
DOP853 in minimal coordinates at a tolerance of 1e-13, restarted at every event. The column `answer` shows the
difference from a second solver.

The rule: the true error is at most 3 times the requested error, and at most 10 times the stated error
(`stats["error"]`, `stats["accuracy"]["estimated"]`, the difference that `--verify` shows, the error that `recommend`
shows). Errors are the largest over all outputs: positions relative to the mechanism's size, angles in radians,
velocities also relative to the largest of the run. Statements below the digits to which the answer is known (the
column `answer`; at least 1e-13) are raised to these: below, an error
cannot be judged.

- *true*: the rule holds, and the stated error is at most 10 times the true error.
- *pessimistic*: the rule holds, and the stated error is more than 10 times the true error.
- *stopped*: the run ends with a reason and exit code 4 instead of a result.
- *not known*: the run states that its error is not known; the true error is at most 3 times the requested one.
- *too slow*: the run was ended after {limit:g} s of computing.
- *LIE*: all other runs.

Every model is run with `--tol` by hht-si2 and radau5, with `--accuracy`, and with {turns} of the other options in
turn; `--all` runs all options. Contacts are also run by dop853, radau9 and radau13. `GrazeFaint` is run with three
further options: a mass touches a stiff stop by 1e-6 of its path, and all of the first runs, from which the error is
estimated, miss the stop. Mechanisms run with the code for every kind of element (`--general`).
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, help="the page to write")
    parser.add_argument("--results", type=Path, default=Path(tempfile.gettempdir()) / "mbdsl-claims.jsonl")
    parser.add_argument("--limit", type=float, default=30.0, help="seconds of computing that a cell may take")
    parser.add_argument("--models", nargs="*", help="names or families; default all")
    parser.add_argument("--ways", nargs="*", help="such as --ways=tol radau5 accuracy; default all")
    parser.add_argument("--all", action="store_true", help="every model by every way; three times as long")
    parser.add_argument("--fresh", action="store_true", help="forget what was found before")
    parser.add_argument("--page", action="store_true", help="run nothing, write the page of what was found")
    parser.add_argument("--processes", type=int, default=2)
    args = parser.parse_args()
    results: dict[tuple, dict] = {}
    if args.results.exists() and not args.fresh:
        for line in args.results.read_text(encoding="utf-8").splitlines():
            job, found = json.loads(line)
            results[tuple(job)] = found
    elif args.results.exists():
        args.results.unlink()
    order = list(dict.fromkeys([*ALWAYS, *IN_TURN, *(way for ways_ in FURTHER.values() for way in ways_)]))
    jobs = [
        (name, *way)
        for way in order
        for name, claim in CLAIMS.items()
        if way in ways(name, args.all)
        and (name, *way) not in results
        and "z" in claim.stored
        and (not args.models or name in args.models or claim.family in args.models)
        and (not args.ways or any(w in (way[0].strip("-"), way[1]) for w in args.ways))
    ]
    jobs = [] if args.page else jobs
    lock = threading.Lock()

    def keep(job: tuple, found: dict) -> None:
        with lock:
            results[job] = found
            with args.results.open("a", encoding="utf-8") as file:
                file.write(json.dumps([job, found]) + "\n")
            if found["verdict"] in (judge.LIE, judge.LATE):
                print(*job, *(found[key] for key in ("verdict", "said", "truth", "reason")), flush=True)

    threads = [threading.Thread(target=compute, args=(jobs, args.limit, keep)) for _ in range(args.processes)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print(dict(Counter(x["verdict"] for x in results.values())))
    if args.output:
        args.output.write_text(page(results, args.limit), encoding="utf-8")


if __name__ == "__main__":
    main()
