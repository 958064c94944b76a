"""What has been computed is kept: by a digest of everything that determines a run, and of the machine for its time.

One file a run, written whole or not at all, in the folder of compiled code; the oldest go when they become too many.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sys
import threading
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import mbdsl
from mbdsl import jit
from mbdsl.integrators import backend, modules
from mbdsl.lang.expression_text import text
from mbdsl.lang.expressions import Expr
from mbdsl.scene import Scene
from mbdsl.studies.cases import Case, Setting

Array = NDArray[np.float64]
LARGEST = 1_000_000_000  #: bytes that are kept
OUT_OF_TIME = "not run to its end: the budget of the study was spent"


@dataclass(frozen=True)
class Computed:
    """A run: t (N,), q, v (N, n), lam (N, m + p), or the ``problem`` that kept it from its end."""

    case: Case
    t: Array = field(default_factory=lambda: np.empty(0))
    q: Array = field(default_factory=lambda: np.empty((0, 0)))
    v: Array = field(default_factory=lambda: np.empty((0, 0)))
    lam: Array = field(default_factory=lambda: np.empty((0, 0)))
    stats: dict = field(default_factory=dict)
    problem: str = ""

    @property
    def done(self) -> bool:
        return not self.problem

    @property
    def late(self) -> bool:
        """Whether nothing is known of it but that there was no time."""
        return self.problem == OUT_OF_TIME

    @property
    def word(self) -> str:
        return "not run" if self.late else "failed" if self.problem else "done"


class Store:
    """A folder of runs. With ``fresh`` nothing is read that was there before."""

    def __init__(self, folder: str | os.PathLike | None = None, fresh: bool = False) -> None:
        self.folder = Path(folder) if folder is not None else jit.cache_directory().parent / "studies"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.fresh = fresh
        self.own: set[str] = set()

    def get(self, key: str, case: Case) -> Computed | None:
        path = self.folder / f"{key}.npz"
        if self.fresh and key not in self.own:
            return None
        try:
            with np.load(path) as found:
                meta = json.loads(str(found["meta"]))
                t, q, v, lam = (found[name] for name in ("t", "q", "v", "lam"))
                return Computed(case, t, q, v, lam, meta["stats"], meta["problem"])
        except (OSError, ValueError, KeyError, EOFError):
            return None

    def put(self, key: str, run: Computed) -> None:
        meta = json.dumps({"case": str(run.case), "stats": run.stats, "problem": run.problem})
        self._write(f"{key}.npz", t=run.t, q=run.q, v=run.v, lam=run.lam, meta=np.array(meta))
        self.own.add(key)

    def times(self, key: str) -> list[float]:
        """Seconds of the runs that were timed on this machine."""
        name = f"{key}-{_machine_digest()}.npz"
        if self.fresh and name not in self.own:
            return []
        try:
            with np.load(self.folder / name) as found:
                return [float(x) for x in found["seconds"]]
        except (OSError, ValueError, KeyError, EOFError):
            return []

    def put_times(self, key: str, seconds: list[float]) -> None:
        name = f"{key}-{_machine_digest()}.npz"
        self._write(name, seconds=np.array(seconds))
        self.own.add(name)

    def _write(self, name: str, **arrays: Array) -> None:
        path = self.folder / name
        part = path.with_name(f".{name}.{os.getpid()}.{threading.get_ident()}.part")
        try:
            with open(part, "wb") as stream:
                np.savez(stream, **arrays)  # type: ignore[arg-type]
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)

    def prune(self, largest: int = LARGEST) -> None:
        """Remove the oldest where there is more than ``largest`` bytes."""
        files = sorted(((f.stat().st_mtime, f.stat().st_size, f) for f in self.folder.glob("*.npz")), reverse=True)
        total = 0
        for _, size, file in files:
            total += size
            if total > largest:
                file.unlink(missing_ok=True)


def key_of(of: Setting, case: Case) -> str:
    """The digest of everything that determines a run."""
    said = [fingerprint(of.scene), _code(), _method_code(case.method), repr(case), repr((of.start, of.stop, of.points))]
    return hashlib.sha256("\0".join(said).encode()).hexdigest()[:32]


def fingerprint(scene: Scene) -> str:
    """Everything that a scene says, as text."""

    def told(x) -> str:
        if isinstance(x, Expr):
            return text(x)
        return f"({', '.join(map(told, x))})" if isinstance(x, tuple) else repr(x)

    lines = [scene.name]
    for c in scene.components.values():
        lines.append(f"{c.kind.name} {c.name} {sorted(c.ports.items())}")
        lines += [f"  {name} = {told(x)}" for name, x in c.values.items()]
        lines += [f"  0 = {told(x)}" for x in c.velocity_constraints]
        lines += [f"  friction {told(c.friction)}"]
    lines += [f"frame {f.name} {f.body} {(f.x, f.y, f.phi)!r} {told(f.motion)}" for f in scene.frames.values()]
    lines += [f"initial {told(i.target)} {i.value!r} {i.fixed}" for i in scene.initial]
    lines += [f"input {x.name} {x.start!r}" for x in scene.inputs.values()]
    return "\n".join(lines)


@cache
def _code() -> str:
    """Digest of all of mbdsl that has to do with a result, and of what it computes with."""
    digest = hashlib.sha256(f"{mbdsl.__version__} {np.__version__} {sys.version}".encode())
    package = Path(mbdsl.__file__).parent
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] not in ("cli", "plotting", "results", "studies"):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _method_code(name: str) -> str:
    """Digest of the file of a method, which may come from elsewhere."""
    owner = modules().get(name) or backend(name)
    module = owner if hasattr(owner, "__file__") else sys.modules.get(type(owner).__module__)
    file = getattr(module, "__file__", None)
    return hashlib.sha256(Path(file).read_bytes()).hexdigest() if file and Path(file).exists() else name


@cache
def machine() -> dict[str, str]:
    """What times depend on."""
    from mbdsl import jit

    processor = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        processor = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "processor": processor,
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.machine()}",
        "compiled": "yes" if jit.enabled() else "no",
        "host": platform.node(),
    }


def _machine_digest() -> str:
    return hashlib.sha256(repr(sorted(machine().items())).encode()).hexdigest()[:12]
