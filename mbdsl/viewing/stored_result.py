"""From a result file to a trajectory: its columns as states of the model that it contains or that is given."""

from __future__ import annotations

import os
from functools import partial

import numpy as np

from mbdsl import results
from mbdsl.errors import UsageError
from mbdsl.lang.stored_model import from_text
from mbdsl.mechanism.scene import Scene, is_state
from mbdsl.messages import few
from mbdsl.plotting.decimation import thinned
from mbdsl.results.stored import open_result
from mbdsl.simulation.result_units import in_si
from mbdsl.simulation.stored_events import of_meta
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.system import System, build

RATES = {"x": "vx", "y": "vy", "phi": "w"}


def is_result(path: str | os.PathLike) -> bool:
    """Whether a file's suffix is that of a result."""
    return os.path.splitext(os.fspath(path))[1].lower() in results.formats()


def has_model(path: str | os.PathLike) -> bool:
    """Whether a result file contains its model."""
    return bool(open_result(path).layout.meta.get("source"))


def stored_trajectory(path: str | os.PathLike, scene: Scene | None = None) -> tuple[Trajectory, list[str] | None]:
    """The trajectory of a result file; of a long one, rows that keep the extremes of its signals.

    Parameters
    ----------
    path : path
        The file.
    scene : Scene, optional
        The model; required if the file contains none.

    Returns
    -------
    trajectory : Trajectory
        Its states; without the multipliers.
    names : list of str or None
        The signals of the file, if it lacks velocities, so that the trajectory knows no others; else None.

    Raises
    ------
    UsageError
        If the file cannot be read, contains no model or lacks coordinates; the message states the remedy.
    """
    result = in_si(open_result(path))
    meta = result.layout.meta
    if scene is None:
        if not (text := meta.get("source")):
            raise UsageError(
                f"`{path!s}` contains signals, but not the model that they belong to",
                hint=f"mbdsl animate MODEL.mbd --result {path!s}; or write `.npz`, which contains the model",
            )
        scene = from_text(str(text))
    rows = thinned(result)
    columns = rows.columns()
    columns["time"] = columns.pop(result.time)
    _check(columns, path)
    system = build(scene)
    q, _ = _states(system, columns, False, path)
    v, complete = _states(system, columns, True, path)
    time = np.asarray(columns["time"], float)
    inputs = {name: np.asarray(columns[name], float) for name in scene.inputs if name in columns}
    complete = complete and len(inputs) == len(scene.inputs)
    status = "done" if meta.get("complete", True) else "interrupted"
    stats = {"status": str(meta.get("status", status)), "method": meta.get("method"), "h": meta.get("step")}
    stats["rows"] = rows.count
    trajectory = Trajectory(system, time, q, v, None, stats | {"tol": meta.get("tolerance")}, inputs=inputs)
    trajectory.supply(columns)
    trajectory.find_events = partial(of_meta, meta)
    names = [name for name in columns if name in trajectory and name != "time"]
    return trajectory, None if complete else names


def _check(columns: dict, path: str | os.PathLike) -> None:
    """Refuse columns that are not signals over ascending times, as in files of other programs."""
    time = np.asarray(columns.get("time", ()), float)
    if "time" not in columns or time.ndim != 1:
        raise UsageError(f"`{path!s}` has no column `time`", hint="give a result of mbdsl simulate")
    if not np.isfinite(time).all() or (np.diff(time) < 0.0).any():
        raise UsageError(f"the times of `{path!s}` do not ascend")


def _states(system: System, columns: dict, rates: bool, path: str | os.PathLike) -> tuple[np.ndarray, bool]:
    """Coordinates or their rates (N, n), and whether all are known; missing rates are zero."""
    states = np.zeros((len(columns["time"]), system.n))
    missing = []
    for c in system.scene.with_coordinates():
        d = system.tables.coordinates[c.name]
        if is_state(c):
            if rates and c.name in columns:
                states[:, d] = columns[c.name]
            continue
        for k, key in enumerate(c.coordinates):
            flexible = key.startswith("q[")
            name = f"{c.name}.{(f'd{key}' if flexible else RATES[key]) if rates else key}"
            if name in columns:
                states[:, d + k] = columns[name]
            else:
                missing.append(name)
    if missing and not rates:
        raise UsageError(
            f"`{path!s}` lacks coordinates of bodies: {few(missing)}",
            hint="`mbdsl simulate MODEL --output NAME.npz` without --signals writes all of them",
        )
    return states, not missing
