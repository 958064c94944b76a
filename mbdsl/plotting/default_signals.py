"""The signals that a plot shows by default: positions that change, each once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mbdsl.plotting.curves import SignalCurve
from mbdsl.results.stored import Result

BODIES = 3  #: number of bodies of which the default signals of a file are
FEW = 6  #: number of default signals if no name is that of a coordinate
MOST, READ = 9, 36  #: numbers of signals that are shown, and that are read to find those that change
COORDINATES, QUATERNION = ("x", "y", "z", "phi"), ("p0", "p1", "p2", "p3")
OF_JOINTS = ("s", "s_x", "s_y", "phi", "phi_a", "phi_b", "phi_x", "phi_y", "phi_z")
ROW = "Phi[1]"  #: a signal of joints only
CONSTANT = 1e-9  #: signals that vary by less than this part of the largest value of their unit are left out


def default_groups(results: Sequence[Result]) -> Iterator[list[str]]:
    """The signals of each group, of which a plot shows the first that moves.

    A trajectory knows its groups: the coordinates of joints, drivers and free bodies, and those of other bodies. Of a
    file they follow from the names.
    """
    own = [result.groups if result.groups is not None else [default_signals(result.names)] for result in results]
    for k in range(max(map(len, own), default=0)):
        found = dict.fromkeys(name for groups in own if k < len(groups) for name in groups[k])
        if found:
            yield list(found)[:READ]


def default_signals(names: Sequence[str]) -> list[str]:
    """The coordinates of joints and of the first bodies; if no name is that of a coordinate, the first few names."""
    known = dict.fromkeys(names)
    owners: dict[str, list[str]] = {}
    for name in known:
        owner, _, key = name.rpartition(".")
        if owner and "." not in owner:
            owners.setdefault(owner, []).append(key)
    joints = [f"{o}.{k}" for o, keys in owners.items() if ROW in keys for k in keys if k in OF_JOINTS]
    placed = {o: [f"{o}.{k}" for k in _coordinates(keys)] for o, keys in owners.items() if ROW not in keys}
    placed = {owner: own for owner, own in placed.items() if own}
    # Bodies have accelerations; frames have none, and joints only an angle.
    bodies = [own for owner, own in placed.items() if f"{owner}.ax" in known]
    bodies = bodies or [own for own in placed.values() if len(own) > 1] or list(placed.values())
    return joints + [name for own in bodies[:BODIES] for name in own] or list(known)[:FEW]


def _coordinates(keys: Sequence[str]) -> list[str]:
    """The coordinates of a body among its signals; in space, the quaternion in place of one angle."""
    if "z" not in keys:
        return [key for key in keys if key in COORDINATES]
    return [key for key in keys if key in ("x", "y", "z", *QUATERNION)]


def left_out(
    curves: Sequence[SignalCurve], units: Mapping[str, str], sizes: Mapping[str, float]
) -> tuple[list[str], list[str]]:
    """The constant signals, and those that equal an earlier one, in all results.

    ``sizes`` are usual sizes by unit; those of the curves count if they are larger.
    """
    size = {**sizes}
    for curve in curves:
        size[units[curve.name]] = max(size.get(units[curve.name], 0.0), curve.largest)
    of: dict[str, list[SignalCurve]] = {}
    for curve in curves:
        of.setdefault(curve.name, []).append(curve)
    limit = {name: CONSTANT * size[units[name]] for name in of}
    constant = [name for name, own in of.items() if not any(c.spread > limit[name] for c in own)]
    same: list[str] = []
    for name, own in of.items():
        if name in constant:
            continue
        earlier = (x for x in of if x not in (*constant, *same) and units[x] == units[name])
        for other in earlier:
            if other == name:
                break
            if len(of[other]) == len(own) and all(map(_equal, of[other], own, [limit[name]] * len(own))):
                same.append(name)
                break
    return constant, same


def _equal(a: SignalCurve, b: SignalCurve, limit: float) -> bool:
    """Whether two curves of the same result are the same."""
    if a.result != b.result or len(a.x) != len(b.x) or not np.array_equal(a.x, b.x, equal_nan=True):
        return False
    return bool(np.allclose(a.y, b.y, rtol=0.0, atol=limit, equal_nan=True))
