"""Attitudes among the initial values of a model in space: all Cardan angles of a frame, or its quaternion.

Such a group of values becomes three: the rotation vector from the given attitude, to first order, which is zero. Unlike
Cardan angles they are regular everywhere, and unlike parts of a quaternion they do not depend on its sign.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot, pi, sqrt

from mbdsl.errors import ModelError
from mbdsl.expressions.spatial_coordinates import CARDAN, QUATERNION, named
from mbdsl.expressions.symbolic import Expr, const, coordinate, leaves
from mbdsl.mechanism.poses import of_quaternion, turned_successively
from mbdsl.mechanism.scene import InitialValue, Scene
from mbdsl.messages import DisplayUnit

DEGREES = DisplayUnit("deg", pi / 180.0)
#: largest difference from 1 of the length of a quaternion: of parts with three digits
LENGTH = 2e-3


@dataclass(frozen=True)
class GivenAttitude:
    """The attitude of a frame that a group of initial values gives."""

    frame: str
    axes: tuple[float, ...]  #: of the frame, in world axes (9)
    values: tuple[InitialValue, ...]  #: the group, fixed or guesses

    def rotation(self) -> list[InitialValue]:
        """The rotation from this attitude to that of the frame, about the axes of this attitude: three zeros."""
        first, owner = self.values[0], self.values[0].name.rpartition(".")[0]
        x, y, z = (self.axes[3 * k : 3 * k + 3] for k in range(3))
        pairs = {"x": (z, "y", y, "z"), "y": (x, "z", z, "x"), "z": (y, "x", x, "y")}
        found = []
        for name, (a, b, c, d) in pairs.items():  # R* exp(theta~): theta_x = (z* . y - y* . z)/2
            target = 0.5 * (_along(a, self.frame, b) - _along(c, self.frame, d))
            label = f"the rotation of {owner} from its given attitude about its {name} axis"
            found.append(InitialValue(label, target, 0.0, first.fixed, first.span, DEGREES))
        return found


def _along(a: Iterable[float], frame: str, axis: str) -> Expr:
    """The component along ``a`` of an axis of a frame."""
    total = const(0.0)
    for x, i in zip(a, "xyz", strict=True):
        total = total + x * coordinate(frame, axis + i)
    return total


def given_attitudes(items: Iterable[InitialValue]) -> list[GivenAttitude]:
    """The attitudes that are given completely; fixed values first.

    Three parts of a quaternion are complete, with a scalar part that is not negative if it is missing.

    Raises
    ------
    ModelError
        If a quaternion does not have the length 1.
    """
    groups: dict[tuple[str, bool, tuple[str, ...]], dict[str, InitialValue]] = {}
    for item in items:
        if (found := _key(item.target)) is not None:
            frame, key = found
            names = CARDAN if key in CARDAN else QUATERNION
            groups.setdefault((frame, item.fixed, names), {})[key] = item
    result = []
    for (frame, _fixed, names), group in sorted(groups.items(), key=lambda x: not x[0][1]):
        if names is CARDAN and len(group) == 3:
            axes = turned_successively([group[key].value for key in CARDAN])
        elif names is QUATERNION and {"p1", "p2", "p3"} <= set(group):
            axes = of_quaternion(_completed(group))
        else:
            continue
        result.append(GivenAttitude(frame, axes, tuple(group.values())))
    return result


def _key(target: Expr) -> tuple[str, str] | None:
    """Frame and name of a Cardan angle or a part of a quaternion; None of other expressions."""
    if target.op not in ("atan2", "select"):
        return None
    first = next((leaf for leaf in leaves(target) if leaf.op == "coordinate"), None)
    if first is None:
        return None
    frame = first.value[0]
    names = CARDAN if target.op == "atan2" else QUATERNION
    return next(((frame, key) for key in names if named(frame, key) is target), None)


def _completed(group: dict[str, InitialValue]) -> list[float]:
    """The four parts of a quaternion, checked."""
    vector = [group[key].value for key in ("p1", "p2", "p3")]
    square = sum(x * x for x in vector)
    if "p0" not in group and square <= 1.0:
        return [sqrt(1.0 - square), *vector]
    p = [group["p0"].value if "p0" in group else 0.0, *vector]
    size = hypot(*p)
    if abs(size - 1.0) > LENGTH:
        first = next(iter(group.values()))
        owner = first.name.rpartition(".")[0]
        right = ", ".join(f"{x / size:.6g}" for x in p) if size > 0.0 else "1, 0, 0, 0"
        raise ModelError(
            f"the quaternion p0 ... p3 of `{owner}` has the length {size:.6g}, expected 1",
            first.span,
            f"a quaternion of length 1 is {{{right}}}",
        )
    return p


def for_assembly(scene: Scene, items: list[InitialValue]) -> list[InitialValue]:
    """Initial values for the assembly: rotations in place of complete attitudes.

    Guesses of angles that count turns are left out if all frames in them belong to bodies with a given attitude: they
    say which turn it is.
    """
    if not scene.spatial:
        return items
    found = given_attitudes(items)
    replaced = {x.target for attitude in found for x in attitude.values}
    known = {scene.frames[attitude.frame].body for attitude in found} | {
        c.name for c in scene.components.values() if not c.coordinates
    }
    kept = [x for x in items if x.target not in replaced and (x.fixed or not _turns_only(scene, x.target, known))]
    return kept + [rotation for attitude in found for rotation in attitude.rotation()]


def _turns_only(scene: Scene, target: Expr, known: set[str]) -> bool:
    frames = {leaf.value[0] for leaf in leaves(target) if leaf.op == "coordinate"} if target.op == "angle" else ()
    return bool(frames) and all(scene.frames[name].body in known for name in frames)
