"""The store of runs, under a digest of everything that determines a run; for times also of the machine.

Each run is one file in the cache folder, written atomically; the oldest are removed when they become too many. Files
that others can have written are not read (:mod:`mbdsl.storage.cache_folder`). A run that cannot be stored remains
valid.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache, singledispatch
from pathlib import Path
from types import ModuleType
from typing import TypeVar

import numpy as np

from mbdsl.compilation.kernel_sources import digest_of, names_of
from mbdsl.errors import UsageError
from mbdsl.integrators import backend, modules
from mbdsl.kernels.arrays import Array
from mbdsl.simulation.provenance import code, machine
from mbdsl.storage import cache_folder
from mbdsl.studies.cases import Case, Setting

T = TypeVar("T")
LARGEST = 1_000_000_000  #: largest size in bytes
OUT_OF_TIME = "not run to its end: the budget of the study was spent"
OUT_OF_MEMORY = "not run to its end: there was not enough memory"
ENDED, LOST = "the process that ran it ended", "its result was not kept"
CHANGED = "the files of the model changed during the sweep"
PASSING = (OUT_OF_TIME, OUT_OF_MEMORY, ENDED, LOST, CHANGED)  #: problems of the present run, not of the case


@dataclass(frozen=True)
class Computed:
    """A run: t (N,), q, v (N, n), lam (N, m + p), and the ``numbers`` (N,) that events change, by name; or the
    ``problem`` that prevented its completion."""

    case: Case
    t: Array = field(default_factory=lambda: np.empty(0))
    q: Array = field(default_factory=lambda: np.empty((0, 0)))
    v: Array = field(default_factory=lambda: np.empty((0, 0)))
    lam: Array = field(default_factory=lambda: np.empty((0, 0)))
    stats: dict = field(default_factory=dict)
    problem: str = ""
    numbers: Mapping[str, Array] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        return not self.problem

    @property
    def late(self) -> bool:
        """Whether it is missing only for lack of time."""
        return self.problem == OUT_OF_TIME

    @property
    def lasting(self) -> bool:
        """Whether a repetition would give the same result, so that it is worth storing."""
        return self.problem not in PASSING

    @property
    def word(self) -> str:
        return "not run" if self.late else "failed" if self.problem else "done"


class Store:
    """A folder of runs. With ``fresh`` previous runs are not read.

    Raises
    ------
    UsageError
        If the folder cannot be made.
    """

    def __init__(self, folder: str | os.PathLike | None = None, fresh: bool = False) -> None:
        self.folder = Path(folder) if folder is not None else _default()
        try:
            self.folder.mkdir(0o700, parents=True, exist_ok=True)
        except OSError as problem:
            raise UsageError(f"cannot make the folder `{self.folder}`: {problem.strerror or problem}") from problem
        self.fresh = fresh
        self.own: set[str] = set()  #: files written in this session
        self._method_code = cache(method_code)

    def key(self, of: Setting, case: Case) -> str:
        """The key of a run: see :func:`key_of`. The files of a method are read once in a session: a sweep has 10,000
        runs, and reading them takes longer than a run."""
        return key_of(of, case, self._method_code)

    def get(self, key: str, case: Case) -> Computed | None:
        def run(found: Mapping[str, Array]) -> Computed:
            meta = json.loads(str(found["meta"]))
            t, q, v, lam = (found[name] for name in ("t", "q", "v", "lam"))
            numbers = dict(zip(meta["numbers"], found["numbers"], strict=True))
            return Computed(case, t, q, v, lam, meta["stats"], meta["problem"], numbers)

        return self._read(_run_file(key), run)

    def put(self, key: str, run: Computed) -> bool:
        """Store a run; whether this succeeded."""
        said = {"case": str(run.case), "stats": run.stats, "problem": run.problem, "numbers": list(run.numbers)}
        meta, numbers = np.array(json.dumps(said)), np.array(list(run.numbers.values()))
        kept = self._write(_run_file(key), t=run.t, q=run.q, v=run.v, lam=run.lam, numbers=numbers, meta=meta)
        if kept:
            self.claim(key)
        return kept

    def claim(self, key: str) -> None:
        """Accept a run that another process has stored as one of this session."""
        self.own.add(_run_file(key))

    def has_claimed(self, key: str) -> bool:
        return _run_file(key) in self.own

    def times(self, key: str) -> tuple[str, list[float]]:
        """Seconds of the runs that were timed on this machine, and their session ("" without any)."""

        def timed(found: Mapping[str, Array]) -> tuple[str, list[float]]:
            return str(found["session"]), [float(x) for x in found["seconds"]]

        return self._read(_times_file(key), timed) or ("", [])

    def put_times(self, key: str, session: str, seconds: list[float]) -> None:
        if self._write(_times_file(key), session=np.array(session), seconds=np.array(seconds)):
            self.own.add(_times_file(key))

    def spent(self, key: str) -> float:
        """The longest time [s] after which a run was ended on this machine before it was complete; 0 without any."""
        return max(self.times(_ended(key))[1], default=0.0)

    def put_spent(self, key: str, run: Computed) -> None:
        """Store the time of a step loop that was ended, so that it is not repeated with the same time limit."""
        seconds = run.stats.get("seconds", {}).get("integrate", 0.0) if run.late else 0.0
        if seconds > self.spent(key):
            self.put_times(_ended(key), "", [seconds])

    def _read(self, name: str, what: Callable[[Mapping[str, Array]], T]) -> T | None:
        """The content of a file; None if it is damaged, untrusted, or under the name of another run."""
        if self.fresh and name not in self.own:
            return None
        stream = cache_folder.opened(self.folder / name)
        if stream is None:
            return None
        try:
            with stream, np.load(stream) as found:
                return what(found) if found.zip.testzip() is None and str(found["name"]) == name else None
        except Exception:  # zipfile, zlib, numpy and json each raise their own errors at damaged bytes
            return None

    def _write(self, name: str, **arrays: Array) -> bool:
        path = self.folder / name
        try:
            with cache_folder.writing(path) as stream:
                np.savez(stream, name=np.array(name), **arrays)  # type: ignore[arg-type]
        except OSError as problem:
            cache_folder.say(f"cannot write `{path}` ({problem.strerror or problem})")
            return False
        return True

    def prune(self, largest: int = LARGEST) -> None:
        """Remove the oldest runs beyond ``largest`` bytes, and unfinished files of killed processes.

        Other files are not touched.
        """
        cache_folder.remove_oldest(cache_folder.runs(self.folder), largest)
        cache_folder.remove_oldest(cache_folder.parts(self.folder, cache_folder.ABANDONED), 0)


def _default() -> Path:
    folder = cache_folder.own()
    if folder is None:
        raise UsageError("there is no folder that the runs of a study can be written into", hint="see mbdsl cache")
    return folder / cache_folder.STUDIES


def _run_file(key: str) -> str:
    return f"{key}.npz"


def _times_file(key: str) -> str:
    return f"{key}-{_machine_digest()}.npz"


def _ended(key: str) -> str:
    """The key of the times of a run that was ended."""
    return hashlib.sha256(f"ended {key}".encode()).hexdigest()[:32]


def method_code(name: str) -> str:
    """Digest of the file of a method, which may be third-party code, and of the files that it imports."""
    owner = modules().get(name) or backend(name)
    module = owner if isinstance(owner, ModuleType) else sys.modules.get(type(owner).__module__)
    return (digest_of(names_of([module])) if module is not None else None) or name


@singledispatch
def key_of(of: Setting, case: Case, code_of: Callable[[str], str] = method_code) -> str:
    """The digest of everything that determines a run.

    These are the canonical text of the scene (:attr:`mbdsl.mechanism.scene.Scene.fingerprint`), the code of mbdsl and
    its libraries, the code of the method, the case and the times. A kind of setting can register a digest of its own.

    Parameters
    ----------
    of : Setting
        Scene and times.
    case : Case
        Method, and step or tolerance.
    code_of : callable
        Returns the digest of the code of a method.

    Returns
    -------
    str
        32 hexadecimal digits; the same in every process.
    """
    # as JSON, numbers read the same whichever type they have
    asked = json.dumps([asdict(case), of.start, of.stop, of.points], default=float)
    said = [of.scene.fingerprint, code(), code_of(case.method), asked]
    return hashlib.sha256("\0".join(said).encode()).hexdigest()[:32]


def _machine_digest() -> str:
    return hashlib.sha256(repr(sorted(machine().items())).encode()).hexdigest()[:12]
