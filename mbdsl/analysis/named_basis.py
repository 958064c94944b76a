"""Bases of the directions that the constraints allow, in coordinates with names and SI units.

:class:`mbdsl.analysis.tangent_bases.Moving` chooses the coordinates: signals of joints first, then coordinates of
bodies; always the first in the model that is at least half as independent as the most independent one. The speeds are
rates of these coordinates, chosen in the same way among those that nonholonomic constraints leave independent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbdsl.analysis.tangent_bases import LEAST, NOTHING, Moving, Released, named_coordinates
from mbdsl.elements.kind import JointKind
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import RATE, Expr, coordinate
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.numerics.saddle_point import RANK, Array, dense, null_space, row_size
from mbdsl.system import System
from mbdsl.system.signals import gradients

_RATES = {**RATE, "z": "vz"}


class BasisQuantity(NamedTuple):
    """A coordinate or a speed: its name and its SI unit ("" for a pure number)."""

    name: str
    unit: str


class Named(Moving):
    """The bases along a motion, with names: of the coordinates y (r,), and of the speeds u (d,).

    Attributes
    ----------
    coordinates : list of Quantity
        Signals, or coordinates of beams: ``beam.q[4]``, or in the axes of its frame c ``beam.c:x``, ``beam.c:q[4]``.
    speeds : list of Quantity
        Signals, or ``der(name)``.
    """

    def __init__(self, system: System, t: float, q: Array, v: Array, a: Array, released: Released = NOTHING) -> None:
        super().__init__(system, t, q, v, a, released)
        self._name()

    def _coordinates(self, t: float, q: Array, v: Array) -> tuple[list[Expr], list[int]]:
        """The targets in the order of the model."""
        targets, turned = super()._coordinates(t, q, v)
        order = {expression: k for k, expression in enumerate(self._known())}
        return sorted(targets, key=order.__getitem__), sorted(turned)

    @staticmethod
    def _independent(rows: Array, free: Array) -> tuple[list[int], Array]:
        """As in ``Moving``, but the first row that is at least half as independent as the most independent one."""
        found: list[int] = []
        while free.shape[1] and len(rows):
            size = np.linalg.norm(rows @ free, axis=1)
            largest = float(size.max())
            if largest < LEAST:
                break
            k = int(np.argmax(size >= 0.5 * largest))
            found.append(k)
            free = free @ null_space((rows[k] @ free)[None])
        return found, free

    def _speeds(self, B: Array) -> Array:
        """The most independent of the rates y' themselves, with lengths relative to the mechanism's size."""
        size = np.array([self.system.tables.size if x.unit == "m" else 1.0 for x in self._quantities()[0]])
        rows = np.eye(B.shape[1])
        chosen, _ = self._independent(rows, null_space(B * size))
        return rows[sorted(chosen)]

    def _name(self) -> None:
        """Set the names, and convert the bases from scaled coordinates of beams to SI units."""
        self.coordinates, rates, factors = self._quantities()
        chosen = range(len(rates)) if self.H is None else [int(np.argmax(row)) for row in self.H]
        self.speeds = [rates[k] for k in chosen]
        f = np.append(factors, np.ones(len(self.released.positions)))
        g = np.append(factors[list(chosen)], np.ones(self.given))
        self.Z, self.Z1, self.W, self.W1 = (X / f for X in (self.Z, self.Z1, self.W, self.W1))
        self.T, self.T1 = f[:, None] * self.T / g, f[:, None] * self.T1 / g
        self.S, self.S1 = f[:, None] * self.S / f, f[:, None] * self.S1 / f

    def _quantities(self) -> tuple[list[BasisQuantity], list[BasisQuantity], Array]:
        """Coordinates, their rates, and the SI value of a unit of each coordinate."""
        known = self._known()
        found, rates = [], []
        for target in self.targets:
            found.append(known[target])
            rates.append(known.get(der(target), BasisQuantity(f"der({known[target].name})", f"{known[target].unit}/s")))
        beams = self._beams()
        chosen = [beams[k] for k in self.turned]
        found += [x for x, _ in chosen]
        rates += [BasisQuantity(f"der({x.name})", f"{x.unit or '1'}/s") for x, _ in chosen]
        return found, rates, np.array([1.0] * len(self.targets) + [f for _, f in chosen])

    def _known(self) -> dict[Expr, BasisQuantity]:
        """Signals of joints, then of bodies, by their expressions."""
        scene = self.system.scene
        names, found = SignalNames(scene), dict[Expr, BasisQuantity]()
        for c in scene.components.values():
            if isinstance(c.kind, JointKind):
                signals = scene.signals_of(c)
                for key, expression in signals.items():
                    name, rate = f"{c.name}.{key}", key.replace("phi", "w", 1)
                    found.setdefault(expression, BasisQuantity(name, names.unit(name)))
                    if expression.op == "angle" and rate in signals:  # in space: equal by constraints
                        found.setdefault(
                            der(expression), BasisQuantity(f"{c.name}.{rate}", names.unit(f"{c.name}.{rate}"))
                        )
        for body in scene.bodies():
            own = named_coordinates(body)
            for key in (*own, *(_RATES[key] for key in own)):
                name = f"{body.name}.{key}"
                found.setdefault(coordinate(f"{body.name}.c", key), BasisQuantity(name, names.unit(name)))
        for state in scene.states():
            found[coordinate(f"{state.name}.c", "x")] = BasisQuantity(f"integral of {state.name}", "")
            found[coordinate(f"{state.name}.c", "vx")] = BasisQuantity(state.name, names.unit(state.name))
        return found

    def _beams(self) -> list[tuple[BasisQuantity, float]]:
        """Rows of :meth:`_of_beams`, or in space of :meth:`_of_rotations`, and the SI value of a unit of each."""
        if self.system.scene.spatial:
            first = {d + 3: name for name, d in self.system.tables.coordinates.items()}
            spun = [first[int(d)] for d in self.system.tables.rotations[:, 0]]
            return [(BasisQuantity(f"{name}.c:r{i}", "rad"), 1.0) for name in spun for i in "xyz"]
        elastic, pose = [], []
        for name in self.bends:
            body, d = self.system.tables.models[name], self.system.tables.coordinates[name]
            floating = not body.rigid(np.zeros(body.n))[3:].any()
            for k in range(3 if floating else 0, body.n):
                text = f"{name}.q[{k + 1}]" if floating else f"{name}.c:q[{k + 1}]"
                elastic.append((BasisQuantity(text, ""), 1.0 / float(self.scale[d + k])))
            length = 1.0 / float(self.scale[d])
            pose += [(BasisQuantity(f"{name}.c:x", "m"), length), (BasisQuantity(f"{name}.c:y", "m"), length)]
            pose.append((BasisQuantity(f"{name}.phi", "rad"), 1.0))
        return elastic + pose


class AtRest(Named):
    """The bases at rest: Z' = 0, and Z'' from the accelerations, without differences.

    Variations satisfy Phi_q da + (Phi_q a)_q dq = 0, and y'' = g_q da + (g_q a)_q dq for coordinates y = g(q).
    """

    def __init__(self, system: System, t: float, q: Array, a: Array, released: Released = NOTHING) -> None:
        rest = np.zeros(system.n)
        self.system, self.scale, self.released = system, system.tables.scale, released
        self.given = sum(map(len, released))
        self.path = lambda s: (t, q, rest)
        self.bends = [name for name, body in system.tables.models.items() if body.deforms]
        self.targets, self.turned = self._coordinates(t, q, rest)
        bodies = system.n - system.tables.states
        self.rate, self.e = max(float(np.sqrt(np.abs(a * self.scale)[:bodies].max(initial=0.0))), 1e-6), 1.0
        self.H: Array | None = None
        self.Z, self.W, self.T, self.S = self._at(0.0)
        self.Z1, self.T1, self.S1 = self.W, np.zeros_like(self.T), np.zeros_like(self.S)
        self.W1 = self._second(t, q, a) if a.any() else self.W
        self._name()

    @staticmethod
    def suits(system: System, v: Array, a: Array) -> bool:
        """Whether a state is at rest, and its accelerations change neither axes of beams nor nonholonomic bases."""
        simple = not system.p and not any(body.deforms for body in system.tables.models.values())
        bodies, pace = system.n - system.tables.states, np.abs(a * system.tables.scale)
        return not v[:bodies].any() and (simple or float(pace[:bodies].max(initial=0.0)) <= 1e-9)

    def _second(self, t: float, q: Array, a: Array) -> Array:
        system, rest = self.system, np.zeros(self.system.n)
        J, G = dense(system.Phi_q(t, q)) / self.scale, self._gradient(t, q, rest)
        curved = np.zeros((len(G), system.n))
        if self.targets:
            curved[: len(self.targets)] = dense(gradients(system, [der(x) for x in self.targets], t, q, a)[1])
        right = -np.vstack([dense(system.Phi_v_q(t, q, a)), curved]) @ self.Z
        whole = np.vstack([J, G])
        size = row_size(whole)[:, None]
        return np.asarray(np.linalg.lstsq(whole / size, right / size, rcond=RANK)[0]) / self.scale[:, None]
