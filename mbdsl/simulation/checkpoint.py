"""Checkpoints: the state of an unfinished run in a file, from which the run continues bit for bit.

The state of a run is in flat buffers (:mod:`mbdsl.integrators.run`); a checkpoint is a copy of them. A run with a
tolerance consists of several calibration runs (:mod:`mbdsl.simulation.tolerance_calibration`); the checkpoint contains
the final states of the complete ones, so that they are not repeated.

The file is an archive of plain NumPy arrays and JSON: reading it executes no code. It is written to a temporary file
that is then renamed, so that a checkpoint is always complete.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.integrators import backend, method_files, own
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.integrators.saved_runs import checked, checked_events
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.given_values import seconds
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.extremes import Gathered
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.storage.output_files import check, writing

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder
    from mbdsl.simulation.streaming import Stream

    Model: TypeAlias = Scene | Builder | str | os.PathLike

FORMAT = 1
EVERY = 60.0  #: default time between two checkpoints [s]
Snapshot = dict[str, Any]


@dataclass
class Checkpoint:
    """The file of a run's checkpoints.

    Parameters
    ----------
    path : path
        Name of the file.
    every : float or str, optional [s]
        Wall-clock time between two checkpoints.
    about : mapping, optional
        Further data to store in the file, serialisable as JSON.
    resumed : bool, optional
        Whether to continue from the state in the file.
    """

    path: str | os.PathLike
    every: float = EVERY
    about: Mapping[str, Any] = field(default_factory=dict)
    resumed: bool = False

    def __post_init__(self) -> None:
        self.every = seconds(self.every, "every")


def of_run(given: Checkpoint | str | os.PathLike, model: object, asked: dict[str, Any]) -> Checkpoint:
    """The checkpoint of a run, with the arguments that ``mbdsl.resume`` needs to repeat the call."""
    found = given if isinstance(given, Checkpoint) else Checkpoint(given)
    path = os.path.abspath(model) if isinstance(model, str | os.PathLike) else None
    said = {"given": asked, "model": path, "every": found.every}
    return replace(found, about={**said, **found.about})


class Keeper:
    """Stores the state of a motion: that of its complete calibration runs, and that of the present one.

    Raises
    ------
    UsageError
        If the method has no checkpoints, or the file cannot be written; or, for a ``resumed`` run, if the file is
        damaged or belongs to another model.
    """

    def __init__(self, checkpoint: Checkpoint, motion: MechanismRun, stream: Stream | None = None) -> None:
        if backend(motion.plan.method) is not None:
            why = "" if motion.plan.method in own() else ": its state is inside another package"
            raise UsageError(
                f"there are no checkpoints of {motion.plan.method}{why}",
                hint="take a compiled method, such as hht-si2",
            )
        self.checkpoint, self._stream = checkpoint, stream
        self.identity = {**_versions(), "model": digest(motion.system.scene), "plan": _plan(motion)}
        self.identity["method"] = method_files.digest(motion.plan.method)
        self.done: list[Snapshot] = []
        self._ahead: list[Snapshot] = []  # from the file, in the order of the runs
        self._written = perf_counter()
        self.problem = ""  #: reason why the last checkpoint could not be written
        check([checkpoint.path])
        if checkpoint.resumed:
            self._ahead = self._read()
        elif os.path.exists(checkpoint.path) and os.path.getsize(checkpoint.path):
            _load(checkpoint.path)  # raises an error, so that a file that is not a checkpoint is not overwritten

    def begin(self, motion: MechanismRun) -> int | None:
        """At the start of a run, restore its state from the file, if any; return the status of a complete run."""
        if not self._ahead:
            return None
        known = self._ahead.pop(0)
        try:
            _restore(motion, known)
            if self._stream is not None and known.get("stream") is not None:
                self._stream.restore(motion, known["stream"])
        except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as problem:
            raise damaged(self.checkpoint.path, str(problem)) from problem
        if known["status"] is None:
            return None
        self.done.append(known)
        return int(known["status"])

    def pause(self, motion: MechanismRun) -> None:
        """Between steps: write a checkpoint if it is due."""
        if perf_counter() - self._written >= self.checkpoint.every:
            self.write(motion)

    def end(self, motion: MechanismRun, status: int) -> None:
        """At the end of a run, add it to the complete runs."""
        self.done.append(_snapshot(motion, status))

    def write(self, motion: MechanismRun) -> None:
        """Write the complete runs and the state of the present one.

        If that fails, as on a full disk, the run continues, and ``problem`` is the reason.
        """
        try:
            self._write(motion)
        except UsageError as problem:
            self.problem = problem.message
        else:
            self.problem = ""
        self._written = perf_counter()

    def _write(self, motion: MechanismRun) -> None:
        from zipfile import ZIP_STORED, ZipFile

        runs = [*self.done, _snapshot(motion, None)]
        if self._stream is not None and motion.plan.streamed:
            runs[-1]["stream"] = self._stream.state(motion)
        arrays: dict[str, np.ndarray] = {}
        about = {"format": FORMAT, **self.identity, "about": dict(self.checkpoint.about)}
        about["runs"] = [_plain(x, f"{k}", arrays) for k, x in enumerate(runs)]
        arrays["about"] = np.array(json.dumps(about))
        with writing(self.checkpoint.path) as stream, ZipFile(stream, "w", ZIP_STORED) as archive:
            for name, values in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, values, allow_pickle=False)

    def _read(self) -> list[Snapshot]:
        path = self.checkpoint.path
        about, arrays = _load(path)
        for what, reason in (
            ("model", "the model is a different one, or has changed"),
            ("plan", "it was made with different settings"),
            ("method", "the file of its method has changed, or a file that it imports"),
            ("versions", "it was made with different versions of mbdsl or its dependencies"),
            ("code", "mbdsl's source code has changed since"),
            ("machine", "it was made on a different kind of machine"),
        ):
            if about.get(what) != self.identity[what]:
                raise UsageError(f"cannot resume from `{path!s}`: {reason}", hint="repeat the whole run")
        try:
            return [_arrays(x, arrays) for x in about["runs"]]
        except (KeyError, TypeError) as problem:
            raise damaged(path, str(problem)) from problem


def about(path: str | os.PathLike) -> dict[str, Any]:
    """The ``Checkpoint.about`` that was stored in a checkpoint.

    Raises
    ------
    UsageError
        If the file cannot be read, is not a checkpoint, or is damaged.
    """
    found = _load(path)[0]["about"]
    if not isinstance(found, dict):
        raise damaged(path, "it does not describe its run")
    return found


def digest(scene: Scene) -> str:
    """A digest of a scene's complete content."""
    return hashlib.sha256(scene.fingerprint.encode()).hexdigest()


def _load(path: str | os.PathLike) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    from zipfile import is_zipfile

    try:
        with open(path, "rb") as stream:
            try:
                if not is_zipfile(stream):
                    raise ValueError("it is not an archive")
                stream.seek(0)
                with np.load(stream, allow_pickle=False) as archive:
                    if archive.zip.testzip() is not None:
                        raise ValueError("a checksum does not match")
                    arrays = {name: archive[name] for name in archive.files}
                about = json.loads(arrays.pop("about").item())
                if about["format"] != FORMAT or not isinstance(about["runs"], list):
                    raise ValueError(f"its format is {about['format']}, expected {FORMAT}")
                return about, arrays
            except OSError:
                raise
            except Exception as problem:  # zipfile, zlib, numpy and json each raise their own errors at damaged bytes
                raise damaged(path, str(problem)) from problem
    except OSError as problem:
        raise UsageError(f"cannot read `{path!s}`: {problem.strerror or problem}") from problem


def damaged(path: str | os.PathLike, why: str) -> UsageError:
    return UsageError(f"`{path!s}` is not a checkpoint of mbdsl, or is damaged: {' '.join(why.split())[:200]}")


def _versions() -> dict[str, Any]:
    from mbdsl.simulation.provenance import code, machine, versions

    there = [machine()[key] for key in ("processor", "system", "compiled")]
    return {"versions": versions(), "machine": there, "code": code()}


def _plan(motion: MechanismRun) -> str:
    """A digest of the settings of the run and of its initial state."""
    plan = motion.plan
    said = [plan.method, plan.h, plan.start, plan.stop, sorted(plan.options.items()), plan.general]
    said += [plan.tol, plan.every, plan.streamed]
    found = hashlib.sha256(json.dumps(said, default=float).encode() + plan.times.tobytes())
    if plan.rows is not None:
        found.update(repr(plan.rows).encode())
    for p in motion.parts:
        first = p.initial
        for x in (first.q, first.v, first.a, first.lam):
            found.update(np.asarray(x, float).tobytes())
    return found.hexdigest()


# -- a motion as plain values ------------------------------------------------------------------------------------


def _snapshot(motion: MechanismRun, status: int | None) -> Snapshot:
    """A copy of the complete state of a run; ``status`` is None for the present run."""
    parts = []
    for p in motion.parts:
        run = p.integration
        assert isinstance(run, MethodRun)
        kept, there = run.saved("out"), run.written - run.released
        kept["out"] = run.out[:there].copy()
        if run.every:
            kept["times"] = kept["times"][:there]
        events = run.events.saved() if hasattr(run, "events") else None
        parts.append({"run": kept, "events": events, "ends": run.kept})
    tables = [p.system.tables.numbers.copy() for p in motion.parts]
    gathered = None if motion.gathered is None else motion.gathered.state()
    return {"status": status, "parts": parts, "tables": tables, "taken": motion._taken, "gathered": gathered}


def _restore(motion: MechanismRun, known: Snapshot) -> None:
    motion._taken = int(known["taken"])
    if not 0 <= motion._taken <= sys.maxsize or len(known["parts"]) != len(motion.parts):
        raise ValueError("it has a different number of steps or parts")
    if known["status"] is not None and known["status"] != S.DONE:
        raise ValueError("it has a run that is not complete")
    motion.gathered = Gathered.of_state(AskedSignals(motion.system.scene), known["gathered"])
    for p, kept, numbers in zip(motion.parts, known["parts"], known["tables"], strict=True):
        run = p.integration
        assert isinstance(run, MethodRun)
        _restore_run(run, kept["run"])
        ends = kept["ends"]
        if not isinstance(ends, np.ndarray) or (ends.dtype, ends.shape[1:]) != (np.float64, run.kept.shape[1:]):
            raise ValueError("its steps do not have the size or type that this model needs")
        run.ends = [ends]
        run.keeps = run.keeps and len(ends) > 0
        own = p.system.tables.numbers
        if not isinstance(numbers, np.ndarray) or (numbers.shape, numbers.dtype) != (own.shape, own.dtype):
            raise ValueError("its tables do not have the size or type that this model needs")
        own[:] = numbers
        if hasattr(run, "events"):
            vars(run.events).update(checked_events(run.events, kept["events"]))
            if run.events.set is not None:
                run.events.set.restore(run, kept["events"]["set"])
            run.events.rejoin()
            run.landings.rejoin()
        if hasattr(run, "jumps"):
            run.jumps.rejoin(run.reals[S.NEXT_EVENT])
    motion.failed = None


def _restore_run(run: MethodRun, kept: Mapping[str, Any]) -> None:
    out, times = kept["out"], kept["times"]
    fits = all(isinstance(x, np.ndarray) and x.dtype == np.float64 for x in (out, times))
    if not fits or out.ndim != 2 or out.shape[1] != run.out.shape[1]:
        raise ValueError("its outputs do not have the size or type that this model needs")
    if times.shape != (out.shape[:1] if run.every else run.times.shape) or (not run.every and len(out) > len(run.out)):
        raise ValueError("its output times are not those of this run")
    vars(run).update(checked(run, kept, len(out)))
    if run.every:
        run.out, run.times = out.copy(), times.copy()
    else:
        run.out[: len(out)] = out
        if run.rows is not None:
            run.times = run.rows.visible(run.released)


def _plain(x: Any, name: str, arrays: dict[str, np.ndarray]) -> Any:
    """A value as a JSON document; arrays are moved to ``arrays``."""
    if isinstance(x, np.ndarray):
        arrays[name] = x
        return {"array": name}
    if isinstance(x, dict):
        return {"values": {key: _plain(value, f"{name}.{key}", arrays) for key, value in x.items()}}
    if isinstance(x, list | tuple):
        return {type(x).__name__: [_plain(value, f"{name}.{k}", arrays) for k, value in enumerate(x)]}
    if x is None or isinstance(x, bool | int | float | str):
        return x
    if isinstance(x, np.generic):
        return x.item()
    raise TypeError(f"a checkpoint cannot hold {name}, which is a {type(x).__name__}")


def _arrays(x: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """The inverse of ``_plain``."""
    if not isinstance(x, dict):
        return x
    ((kind, inner),) = x.items()
    if kind == "array":
        return arrays[inner]
    if kind == "values":
        return {key: _arrays(value, arrays) for key, value in inner.items()}
    found = [_arrays(value, arrays) for value in inner]
    return tuple(found) if kind == "tuple" else found
