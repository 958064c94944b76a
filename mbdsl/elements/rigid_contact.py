"""Contacts and stops without stiffness: their components consist of rigid contacts (:mod:`mbdsl.elements.contact`).

Each point that may touch, and each limit, is a ``Contact`` with the gap and the slips of its geometry. The component
itself has neither rows nor forces; its signals are those of the geometry, and sums over its contacts.
"""

from dataclasses import replace

from mbdsl.elements.declaration import RIGID
from mbdsl.elements.kind import ForceKind, JointKind, Kind, Signal, Touch

FORCES = ("force", "torque", "friction_force", "active")


def specialised(variant: str, otherwise: str = ""):
    """A ``specialised``: components without `k` are of the rigid kind for a variant."""
    return lambda values: RIGID + variant if values["k"] is None else otherwise


def rigid(kind: Kind, variant: str) -> JointKind:
    """The kind of the components without stiffness of a kind with ``touching``."""
    assert isinstance(kind, ForceKind)
    force = next(x for x in kind.signals if x.name in FORCES)
    return JointKind(
        kind.name,
        doc=kind.doc,
        ports=kind.ports,
        parameters=kind.parameters,
        signals=tuple(x for x in kind.signals if x.name not in FORCES and not x.name.startswith("force_")),
        results=(*_forces(kind.touching, force), *_counts(kind.touching, force.unit)),
        terms=kind.terms,
        contacts=kind.touching,
        spatial=kind.spatial,
        axes=kind.axes,
        follows=kind.follows,
        counted=kind.counted,
        drawing=kind.drawing,
        variant=variant,
    )


def _forces(touching: tuple[Touch, ...], force: Signal) -> list[Signal]:
    total = " + ".join(f"({x.sense})*force[{i}]" for i, x in enumerate(touching, 1))
    found = [replace(force, formula=total)]
    if len(touching) > 1:
        found += _of_each(touching, force)
    elif touching[0].slips:
        found.append(Signal("friction_force", "N", "friction[1]", "friction, against the slip"))
    return found


def _counts(touching: tuple[Touch, ...], unit: str) -> list[Signal]:
    count = range(1, len(touching) + 1)
    impulse = Signal("impulse", f"{unit}.s", "", "impulse of the last impact")
    found = [
        Signal("active", "1", _sum("active", count), "number of points that touch"),
        Signal("impacts", "1", _sum("impacts", count), "number of impacts so far"),
    ]
    if len(touching) > 1:
        return [*found, *_of_each(touching, impulse)]
    sliding = Signal("sliding", "1", "sliding[1]", "1 or -1 while it slides, by the sign of the slip; else 0")
    return [*found, replace(impulse, formula="impulse[1]"), *[sliding] * bool(touching[0].slips)]


def _of_each(touching: tuple[Touch, ...], signal: Signal) -> list[Signal]:
    own = "impulse" if signal.name == "impulse" else "force"
    named = enumerate(touching, 1)
    return [Signal(f"{signal.name}_{x.key}", signal.unit, f"{own}[{i}]", f"{signal.doc}, {x.key}") for i, x in named]


def _sum(signal: str, of: range) -> str:
    return " + ".join(f"{signal}[{i}]" for i in of)
