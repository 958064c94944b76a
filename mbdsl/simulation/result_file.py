"""The result file of a trajectory: its signals, their units, and the data that describe the run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING

from mbdsl import results
from mbdsl.errors import MbdslError
from mbdsl.lang.display_units import asked, declared_text
from mbdsl.simulation.result_units import KEY as SHOWN
from mbdsl.simulation.result_units import check, converted
from mbdsl.version import __version__

if TYPE_CHECKING:
    from mbdsl.mechanism.scene import Scene
    from mbdsl.simulation.trajectory import Trajectory


def names(trajectory: Trajectory, path: str | PathLike, patterns: str | Iterable[str] | None = None) -> list[str]:
    """The signals that a file contains, without the time; by default, coordinates and velocities of all bodies,
    states and discrete variables.

    A format that keeps the model also contains the coordinates of bodies that deform.
    """
    if patterns is not None:
        chosen = trajectory.select(patterns)
    else:
        chosen = [*trajectory.default_names]
        if keeps_model(path):
            chosen += trajectory.elastic_names
    return [name for name in chosen if name != "time"]


def keeps_model(path: str | PathLike) -> bool:
    """Whether the format of a file has a place for the text of the model."""
    return getattr(results.format_of(path), "KEEPS_MODEL", False)


def units(trajectory: Trajectory, names: Iterable[str]) -> dict[str, str]:
    """The units of the time and of signals."""
    return {"time": "s", **{name: trajectory.unit(name) for name in names}}


def keeps_extremes(path: str | PathLike) -> bool:
    """Whether the format of a file has a place for data about the run."""
    return not hasattr(results.format_of(path), "mark")


def about(
    trajectory: Trajectory, path: str | PathLike | None = None, names: Iterable[str] = ()
) -> dict[str, str | float | bool]:
    """The meta data of a result file, with the extremes of the signals ``names`` if it has a place for them."""
    stats = trajectory.stats
    said = {"model": trajectory.scene.name, "method": stats.get("method"), "step": stats.get("h")}
    said |= {"tolerance": stats.get("tol"), "error": stats.get("error"), "horizon": stats.get("horizon")}
    said |= {"steps": stats.get("steps"), "iterations": stats.get("iterations")}
    options = [f"{name} = {value:g}" for name, value in stats.get("options", {}).items() if value is not None]
    said["options"] = ", ".join(options) or None
    if path is not None:
        from mbdsl.simulation import stored_events  # which needs numpy

        if events := stored_events.text_of(trajectory.find_events()):
            said[stored_events.EVENTS] = events
    if path is not None and keeps_extremes(path):
        from mbdsl.simulation.stored_extremes import KEY, text_of

        said[KEY] = text_of(trajectory.extremes(names).values())
        said[SHOWN] = declared_text(trajectory.scene.display, names) or None
    return {
        "complete": trajectory.status == "done",
        **{key: value for key, value in said.items() if value is not None},
        "status": trajectory.status,
        "version": __version__,
    }


def save(
    trajectory: Trajectory,
    path: str | PathLike,
    patterns: str | Iterable[str] | None,
    row_of_units: bool,
    given: str | Iterable[str] | None = None,
) -> None:
    """Write a trajectory to a file; see ``Trajectory.save``."""
    check(path, given)
    chosen = names(trajectory, path, patterns)
    said = about(trajectory, path, chosen)
    if keeps_model(path) and (source := _source(trajectory.scene)):
        said["source"] = source
    columns = {"time": trajectory.t, **{name: trajectory[name] for name in chosen}}
    written, own = converted(path, columns, units(trajectory, chosen), asked(given))
    results.write(path, written, own, said, row_of_units or bool(given))


def _source(scene: Scene) -> str:
    """The text of a model, with the values of its parameters; "" if no model of equal components is read from it."""
    from mbdsl.lang.stored_model import from_text, to_text

    numbers = {name: p.value for name, p in scene.parameters.items() if isinstance(p.value, (int, float))}
    overrides: Mapping[str, str | float]
    for overrides in ({}, numbers):
        try:
            text = to_text(scene, overrides)
            if text and _plain(from_text(text)) == _plain(scene):
                return text
        except MbdslError:  # such as that of a parameter that is final
            continue
    return ""


def _plain(scene: Scene) -> Scene:
    """A scene without initial values and times, which the results replace."""
    return replace(scene, initial=(), experiment=type(scene.experiment)())
