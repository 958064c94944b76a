"""Simulations that start at a static equilibrium: of models with ``initial(state = steady)``, or on request."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbdsl.compilation import code_cache
from mbdsl.initial.consistent import initial_position
from mbdsl.mechanism.scene import Scene
from mbdsl.numerics.saddle_point import Array
from mbdsl.simulation.given_initial_values import with_initial
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.statics.equilibrium_search import prepared, searched

UNSTABLE = "the run begins at an equilibrium that is unstable"


class PointsAtRest(Trajectory):
    """A trajectory of points at rest, with zero accelerations."""

    @property
    def _motion(self) -> tuple[Array, Array]:
        return np.zeros_like(self.q), self._lam  # type: ignore[return-value]


def equilibrium(scene: Scene, start: float | None, announce: Callable[[str], None] | None) -> PointsAtRest:
    """The equilibrium of a model at the time ``start`` [s], by default that of its settings.

    Raises
    ------
    InitialisationError, EquilibriumError
        If the model cannot be assembled, or no equilibrium is found.
    """
    t = float(scene.experiment.start) if start is None else start
    system, mechanism = prepared(scene, announce)
    found = searched(system, t, initial_position(system, mechanism, t))
    stats = {"method": "static", "h": None, "tol": None, "status": "done", "stability": found.stability}
    q, v, lam = found.q[None], found.v[None], found.lam[None]
    return PointsAtRest(system, np.array([t]), q, v, lam, stats, (), found.left_out)


def found_at_start(scene: Scene) -> str:
    """The stability of the equilibrium of a model at its start, found without compilation.

    Raises
    ------
    InitialisationError, EquilibriumError
        As :func:`equilibrium`.
    """
    with code_cache.uncompiled(), np.errstate(all="ignore"):  # as compiled code, which gives nan
        return str(equilibrium(scene, None, None).stats["stability"])


def settled(
    scene: Scene, start: float | None = None, announce: Callable[[str], None] | None = None
) -> tuple[Scene, PointsAtRest | None]:
    """A model that starts at its equilibrium with the equilibrium as its initial values; other models as they are.

    Raises
    ------
    InitialisationError, EquilibriumError
        As :func:`equilibrium`.
    """
    if not scene.steady:
        return scene, None
    rest = equilibrium(scene, start, announce)
    return with_initial(scene, rest), rest


def warnings(rest: PointsAtRest | None) -> list[str]:
    """Warnings about the equilibrium at which a run starts."""
    return [UNSTABLE] if rest is not None and rest.stats["stability"] == "unstable" else []
