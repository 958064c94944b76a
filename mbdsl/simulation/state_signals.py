"""Signals from stored states: each signal of the model by name, computed on first access."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from mbdsl.elements.kind import JointKind, SensorKind
from mbdsl.errors import MbdslError
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.initial import shared_loads
from mbdsl.initial.consistent import Moved
from mbdsl.integrators.event_list import EventGroup
from mbdsl.kernels.arrays import Array
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.mechanism.scene import ENERGIES, Scene
from mbdsl.mechanism.signal_names import ACCELERATIONS, QUATERNION
from mbdsl.messages import UnitsOfSignals
from mbdsl.numerics.blas_threads import with_one_thread
from mbdsl.results.selection import matching
from mbdsl.simulation import derived_signals, section_forces
from mbdsl.simulation.frame_accelerations import acceleration, accelerometer
from mbdsl.system.signals import values
from mbdsl.system.system import System


class StateSignals:
    """The states of ``mbdsl.Trajectory``, and the signals that follow from them."""

    def __init__(
        self,
        system: System,
        t: Array,
        q: Array,
        v: Array,
        lam: Array | None,
        stats: dict,
        moved: tuple[Moved, ...] = (),
        left_out: tuple[int, ...] = (),
        inputs: Mapping[str, Array] | None = None,
    ) -> None:
        self.system, self.t, self.q, self.v, self.stats, self.moved = system, t, q, v, stats, moved
        self.left_out = left_out
        self.inputs = dict(inputs or {})
        self._lam = lam
        self.message = ""
        self.undetermined: list[float] = []
        self._known: dict[str, Array] = {}
        self._chosen: tuple[str, ...] | None = None  #: the signals of a selection
        #: of a part between two times, if angles depend on earlier states: the whole trajectory and the rows
        self._whole: tuple[StateSignals, slice] | None = None
        #: returns the motion between outputs, :class:`mbdsl.simulation.steps.Steps`, if it is known
        self.find_steps: Callable[[], Any] | None = None
        self.find_events: Callable[[], list[EventGroup]] = list  #: the events; see ``Trajectory.events``
        #: ranges over earlier steps, which a long run has forgotten: :class:`mbdsl.simulation.extremes.Gathered`
        self.gathered: Any = None
        self._display: UnitsOfSignals | None = None  #: None: those of the model
        self._extremes: dict[str, Any] = {}  #: those that were found
        self._since: float | None = (
            None  #: start of the run, if earlier rows than those of ``t`` were written to a file
        )
        self._from_start = True  #: whether the first state is that of the run
        self._together: int | None = None  #: least number of states whose equations of motion are solved together

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.system.scene

    @property
    def display(self) -> UnitsOfSignals:
        """The units in which values are displayed; arrays are in SI units."""
        return self.scene.display if self._display is None else self._display

    @property
    def descriptions(self) -> dict[str, str]:
        """Variable of the model -> its description, if it has one."""
        return {name: found.doc for name, found in self.scene.descriptions.items() if found.doc}

    @property
    def status(self) -> str:
        """One of "done", "interrupted", "failed", or "inaccurate" if the tolerance was not reached."""
        return self.stats["status"]

    def __getstate__(self) -> dict:
        """The state without signals, which are computed again on access.

        Reference angles remain: those of a part between two times depend on the states before it.
        """
        computed = {k for k in vars(self) if isinstance(getattr(type(self), k, None), cached_property)} - {"turns"}
        return {
            **{k: x for k, x in vars(self).items() if k not in computed},
            "_known": {},
            "find_steps": None,
            "find_events": partial(list, self.find_events()),
            "gathered": None,
        }

    @cached_property
    def steps(self) -> Any:
        """The motion at and between the ends of steps, a ``Steps``; None if it is not known."""
        if self.find_steps is None:
            return None
        found = self.find_steps()
        found.ends._names = self._names
        return found

    # -- names -------------------------------------------------------------------------------------------------
    @cached_property
    def _names(self) -> AskedSignals:
        return AskedSignals(self.scene)

    def select(self, patterns: str | Iterable[str]) -> list[str]:
        """List the names of signals that match patterns.

        Parameters
        ----------
        patterns : str or iterable of str
            Names and glob patterns such as "crank.*"; in ``q[1]`` the brackets are an index.

        Returns
        -------
        list of str
            Names of the model's signals that match at least one pattern, and expressions such as
            ``hypot(A.fx, A.fy)``, without duplicates.

        Raises
        ------
        UsageError
            If a pattern matches no name.
        """
        return self._names.select(patterns)

    def asked(self, text: str) -> list[str]:
        """List what a text stands for beyond the names of the model.

        Parameters
        ----------
        text : str
            A name or pattern of signals of ports and of sections, or an expression of signals.

        Returns
        -------
        list of str
            Signals and expressions; none if it is invalid, or matches names of the model.
        """
        if matching(text, self._names.names):
            return []
        try:
            return self._names.asked(text)
        except MbdslError:
            return []

    def unit(self, name: str) -> str:
        """Return the SI unit of a signal.

        Parameters
        ----------
        name : str
            Name of a signal.

        Returns
        -------
        str
            "" if the signal is a pure number or its unit is unknown.
        """
        return self._names.unit(name)

    # -- values ------------------------------------------------------------------------------------------------
    def __contains__(self, name: str) -> bool:
        return name in self._names

    def _signal(self, name: str) -> Array:
        if name == "time":
            return self.t
        if name not in self._known:
            if self._whole is not None:
                whole, rows = self._whole
                self._known[name] = whole._signal(name)[rows]
            elif (entry := self._names.entry(name)) is not None:
                self._known[name] = np.array(self.evaluate([entry[0]])[0])
                self._known[name].flags.writeable = False
            elif self._names.is_computed(name):
                self._compute(name)
            else:
                raise self._names.unknown(name)
        return self._known[name]

    def evaluate(self, roots: Sequence[Expr]) -> list[Array]:
        """Return the values of expressions of frames and multipliers.

        Parameters
        ----------
        roots : sequence of Expr
            Expressions.

        Returns
        -------
        list of (N,)
            In SI units.
        """
        lam = self._multipliers([leaf.value for leaf in leaves(*roots) if leaf.op == "multiplier"])
        inputs = self.inputs | {x: self._signal(x) for root in roots for x in self._names.computed_in(root)}
        return values(self.system, roots, self.t, self.q, self.v, lam, inputs)

    def is_at_hand(self, name: str) -> bool:
        """Whether a signal is known without solving the equations of motion for accelerations and multipliers.

        Parameters
        ----------
        name : str
            Name of a signal.

        Returns
        -------
        bool
            False also if there is no such signal.
        """
        if name in self._known or name == "time":
            return True
        if name not in self or self._names.is_computed(name):
            key = name.rpartition(".")[2]
            known = name in self and name not in self._names.sections
            return known and key != "a" and not key.startswith(("ax", "ay", "az", "alpha"))
        root = self._names.entry(name)[0]  # type: ignore[index]
        if not all(self.is_at_hand(x) for x in self._names.computed_in(root)):
            return False
        needed: list = [leaf.value for leaf in leaves(root) if leaf.op == "multiplier"]
        if not needed or "lam" in vars(self):
            return True
        columns = [self.system.tables.multipliers[key] - self.system.n for key in needed]
        return self._lam is not None and not np.isnan(self._lam[:, columns]).any()

    def needs_reactions(self, names: Iterable[str]) -> bool:
        """Whether one of these signals follows from multipliers.

        Parameters
        ----------
        names : iterable of str
            Names of signals.

        Returns
        -------
        bool
        """
        entries = [self._names.entry(name) for name in names if name != "time"]
        roots = [entry[0] for entry in entries if entry is not None]
        inner = [
            str(leaf.value) for leaf in leaves(*roots) if leaf.op == "input" and leaf.value in self._names.computed
        ]
        return any(leaf.op == "multiplier" for leaf in leaves(*roots)) or (bool(inner) and self.needs_reactions(inner))

    def signal_rows(self, names: Sequence[str]) -> Array:
        """Values (k, N) of signals, which are computed together.

        Parameters
        ----------
        names : sequence of str
            Names of k signals.

        Returns
        -------
        (k, N) array
        """
        entries = {name: self._names.entry(name) for name in names if name not in self._known and name != "time"}
        roots = {name: entry[0] for name, entry in entries.items() if entry is not None}
        roots = {name: root for name, root in roots.items() if not self._names.computed_in(root)}
        found: dict[str, Array] = {}
        if roots and self._whole is None:
            lam = self._multipliers([leaf.value for leaf in leaves(*roots.values()) if leaf.op == "multiplier"])
            computed = values(self.system, list(roots.values()), self.t, self.q, self.v, lam, self.inputs)
            found = dict(zip(roots, computed, strict=True))
        return np.array([found[name] if name in found else self._signal(name) for name in names])

    def supply(self, values: Mapping[str, Array]) -> None:
        """Set signals whose values are stored elsewhere, so that they are not computed again.

        Parameters
        ----------
        values : mapping of str to (N,)
            Name -> values; names that are not signals are ignored.
        """
        self._known.update(
            {name: np.asarray(x, float) for name, x in values.items() if name != "time" and name in self}
        )

    def _compute(self, name: str) -> None:
        owner, key = name.rsplit(".", 1)
        if key == "a":
            parts = [self._signal(f"{name}{i}") for i in "xyz" if f"{name}{i}" in self._names.computed]
            self._known[name] = np.linalg.norm(parts, axis=0)
            return
        if name in self._names.sections:
            self._known.update(section_forces.of_frame(self, owner))
            return
        if isinstance((sensor := self.scene.components.get(owner)) and sensor.kind, SensorKind):
            self._known.update(accelerometer(self, sensor))  # type: ignore[arg-type]
            return
        if name in ENERGIES:
            found = derived_signals.flexible_energies(self.system, self.t, self.q, self.v, self.inputs)
            self._known.update(zip(ENERGIES, found, strict=True))
            return
        if self.scene.spatial and key in QUATERNION:
            self._known.update(derived_signals.quaternion(self.system, owner, self.q))
            return
        if self.scene.spatial and owner in self.system.tables.models:
            self._known.update(derived_signals.accelerations_in_space(self.system, owner, self.q, lambda: self.a))
            return
        if key in ACCELERATIONS:
            d, body = self.system.tables.coordinates[owner], self.system.tables.models[owner]
            if body.deforms:
                a = acceleration(self, owner, (0.0, 0.0, 0.0))
            else:
                a = self.a[:, d : d + body.n]
            self._known.update({f"{owner}.{which}": a[:, k] for k, which in enumerate(ACCELERATIONS) if k < a.shape[1]})
            return
        if owner in self._names.flexible:
            k = self.system.tables.coordinates[owner] + int(key[key.index("[") + 1 : -1]) - 1
            self._known[name] = (self.v if key.startswith("dq") else self.q)[:, k]
            return
        Phi, dPhi, Gam = self._constraints
        tables, component = self.system.tables, self.scene.components[owner]
        assert isinstance(component.kind, JointKind)
        for k in range(component.kind.rows):
            row = tables.rows[owner] + k
            self._known[f"{owner}.Phi[{k + 1}]"] = Phi[:, row]
            self._known[f"{owner}.dPhi[{k + 1}]"] = dPhi[:, row]
        for k in range(len(component.velocity_constraints)):
            self._known[f"{owner}.Gam[{k + 1}]"] = Gam[:, tables.velocity_rows[owner] - self.system.m + k]

    @cached_property
    @with_one_thread
    def _motion(self) -> tuple[Array, Array]:
        """Accelerations (N, n) and multipliers (N, m + p) that satisfy the equations of motion at each (t, q, v)."""
        a, lam, undetermined = derived_signals.motion(
            self.system, self.t, self.q, self.v, self.left_out, self._numbers, self._together
        )
        self.undetermined += undetermined
        return a, lam

    @cached_property
    def _numbers(self) -> dict[int, Array]:
        """Inputs and reference angles (N,) that the equations depend on, by their index in the table F."""
        if self._whole is not None:
            whole, rows = self._whole
            return {at: x[rows] for at, x in whole._numbers.items()}
        tables = self.system.tables
        found = {tables.inputs[name]: value for name, value in self.inputs.items() if name in tables.inputs}
        found |= derived_signals.angles(self.system, self.t, self.q, self.v, self.inputs)
        return found | {tables.models[body].counter: angle for body, angle in self.turns.items()}

    @cached_property
    def turns(self) -> dict[str, Array]:
        """Reference angles (N,) for counting turns, by body, for bodies whose coordinates do not contain the turns."""
        return derived_signals.turns(self.system, self.t, self.q, self.v)

    @property
    def a(self) -> Array:
        """Generalised accelerations (N, n) [m/s2, rad/s2], from the equations of motion at each (t, q, v)."""
        return self._motion[0]

    @cached_property
    @with_one_thread
    def lam(self) -> Array:
        """Multipliers (N, m + p), in the order of ``system.constraint_names()``.

        The constraint force is -Phi_q^T lam - Gam_v^T nu, where lam and nu are the first m and the last p columns.
        Multipliers that the method does not compute (those of welds), or computes at a lower order than q and v, are
        found from the equations of motion at (t, q, v) on first access. In space, over-constrained mechanisms have
        those of least norm.
        """
        found = self._lam
        if found is None:
            found = self._motion[1]
        elif (missing := np.isnan(found).all(axis=0)).any():
            found = np.where(missing, self._motion[1], found)
        if shared_loads.shares(self.system, self.left_out):
            return shared_loads.least(self.system, self.t, self.q, found, self.left_out)
        return found

    def _multipliers(self, needed: list) -> Array | None:
        """``lam``, or the method's own multipliers if these contain all that are ``needed``; None if none is needed."""
        if not needed or self._lam is None or not len(self.t) or shared_loads.shares(self.system, self.left_out):
            return self.lam if needed else None
        own = self._lam[0, [self.system.tables.multipliers[key] - self.system.n for key in needed]]
        return self.lam if np.isnan(own).any() else self._lam

    @cached_property
    def _constraints(self) -> tuple[Array, Array, Array]:
        """Phi (N, m), Phi_q v + Phi_t (N, m), Gam (N, p)."""
        return derived_signals.residuals(self.system, self.t, self.q, self.v, self._numbers)
