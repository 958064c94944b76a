"""The figures of a report: main signals, energies and their drift, and the residuals of constraints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.contacts import is_contact
from mbdsl.mechanism.scene import ENERGIES, Component, is_rate
from mbdsl.mechanism.scene_tables import displayed
from mbdsl.messages import few
from mbdsl.plotting.curves import over_time
from mbdsl.plotting.figures import Figure
from mbdsl.plotting.series_styles import OTHERS, Look
from mbdsl.plotting.signal_panels import Horizontal, labelled, panels
from mbdsl.results.stored import of_columns
from mbdsl.simulation.trajectory import Trajectory

LEAST = 1e-18  #: residuals below it are drawn there: zero has no place on a logarithmic axis
MOST_COMPONENTS = 1000  #: number of components up to which energies and residuals are computed
FLAT = 0.3  #: height over width
POSITIONS, RATES, SPEEDS = "positions: largest |Φ|", "velocities: largest |dΦ/dt|", "nonholonomic rows: largest |Γ|"
CHANGE = "change of the total energy"


def energy_figures(trajectory: Trajectory) -> list[Figure]:
    """The energies, and the change of their sum since the start."""
    if not len(trajectory) or len(trajectory.scene.components) > MOST_COMPONENTS:
        return []
    energies = {name: np.asarray(trajectory[name], float) for name in ENERGIES}
    total = energies[ENERGIES[2]]
    return [
        _figure(trajectory, "energy", "Energy", "energy", "J", energies, balance(trajectory)),
        _figure(trajectory, "drift", "", CHANGE, "J", {CHANGE: total - total[0]}, ""),
    ]


def balance(trajectory: Trajectory) -> str:
    """What changes the total energy, and its largest change."""
    energies = [np.asarray(trajectory[name], float) for name in ENERGIES]
    drift, joule = _largest(energies[2] - energies[2][0]), trajectory.display.of("J")
    scene = trajectory.scene
    by = [c.name for c in scene.components.values() if _exchanges(c)]
    by += [f"reinit({a.target})" for b in scene.events.branches for a in b.actions if a.what == "reinit"]
    if by:
        return f"The total energy changes by up to {joule.text(drift, 3)}. Energy is added or removed by {few(by)}."
    size = max(_largest(energies[0]), _largest(energies[1] - energies[1][:1]))
    relative = f", {drift / size:.2g} of the largest energy that is exchanged" if size > 0.0 else ""
    most = joule.text(drift, 3)
    return f"No component adds or removes energy: the change of the total is an error, at most {most}{relative}."


def _exchanges(c: Component) -> bool:
    """Whether a component adds energy to the mechanism or removes it."""
    if is_rate(c):
        return False
    if isinstance(c.kind, JointKind):
        loses = is_contact(c) and c.values["e"] != 1.0
        return loses or c.moves_in_time or c.friction is not None
    damping = c.kind.effects.get("damping")
    damped = damping is not None and bool(damping(dict(c.values)))
    return damped or (isinstance(c.kind, ForceKind) and c.energy is None)


def constraint_figure(trajectory: Trajectory) -> Figure | None:
    """The largest residuals of the constraints over time; None without constraints."""
    scene = trajectory.scene
    joints = [c for c in scene.components.values() if isinstance(c.kind, JointKind) and not is_contact(c)]
    if not len(trajectory) or not joints or len(scene.components) > MOST_COMPONENTS:
        return None
    kinds: dict[str, list[str]] = {POSITIONS: [], RATES: [], SPEEDS: []}
    for c in joints:
        rows = range(1, c.kind.rows + 1)
        kinds[POSITIONS] += [f"{c.name}.Phi[{k}]" for k in rows]
        kinds[RATES] += [f"{c.name}.dPhi[{k}]" for k in rows]
        kinds[SPEEDS] += [f"{c.name}.Gam[{k + 1}]" for k in range(len(c.velocity_constraints))]
    found: dict[str, Array] = {}
    for label, names in kinds.items():
        if names:
            found[label] = np.zeros(len(trajectory))
            for name in names:
                found[label] = np.fmax(found[label], np.abs(trajectory[name]))
    if not found:
        return None
    sizes = ", ".join(f"{label.partition(':')[0]} {_largest(worst):.2g}" for label, worst in found.items())
    shown = {label: np.maximum(worst, LEAST) for label, worst in found.items()}
    note = f"The largest residuals over the run: {sizes} (SI units)."
    figure = _figure(trajectory, "constraints", "Constraints", "largest residual [SI]", "", shown, note)
    return replace(figure, y_log=True)


def looks(figures: Sequence[Figure | None]) -> dict[str, Look]:
    """The looks of the series of these figures: colours in order in each of them."""
    return {s.name: OTHERS[k % len(OTHERS)] for f in figures if f is not None for k, s in enumerate(f.series)}


def _figure(
    trajectory: Trajectory, key: str, title: str, label: str, unit: str, values: dict[str, Array], note: str
) -> Figure:
    """Values (T,) in SI units over the time."""
    columns = {"time": trajectory.t, **values}
    curves = over_time(of_columns("", list(columns), lambda name: unit, columns.__getitem__), list(values))
    units = dict.fromkeys(values, unit)
    (figure,), _ = panels(curves, units, Horizontal("time", "s"), False, trajectory.display)
    label = labelled(label, trajectory.display.of(unit).symbol) if unit else label
    return replace(figure, key=key, title=title, y_label=label, note=note, aspect=FLAT)


def _largest(values: Array) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max(initial=0.0))


def signal_figures(
    trajectory: Trajectory, patterns: Sequence[str] | None
) -> tuple[list[Figure], Mapping[str, Look], list[str]]:
    """Figures of signals, one for each unit, with their looks and notes."""
    plot = trajectory.plot(patterns)
    return list(plot.panels), plot.looks, [note for note in plot.notes if "--list" not in note]


def rows_of_parameters(trajectory: Trajectory) -> Iterator[tuple[str, str, str, str]]:
    """(Name, value, unit, description) of the parameters of the model that are numbers."""
    for p in trajectory.scene.parameters.values():
        if isinstance(p.value, bool | int | float | str):
            number, unit = displayed(p.value, p.unit, p.name, trajectory.display)
            value = f"{number:.9g}" if isinstance(number, float) else str(number)
            yield p.name, value, unit, p.doc
