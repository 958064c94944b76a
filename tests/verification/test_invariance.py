"""The motion of every shipped model does not depend on its position, orientation, reflection, order or start time.

If only rounding differs, Newton's method stops at 16 eps of the largest coordinate in every step; a difference in
positions causes 1/h of it in velocities and 1/h^2 in accelerations, and forces in proportion to the mass. Or it stops
below 1e-4 of the local error, an iteration earlier or later. Both differences grow like any disturbance of the start.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.elements.kind import JointKind
from mbdsl.expressions.symbolic import COORDINATES, TIME, Expr, coordinate, is_velocity_level, substitute
from mbdsl.lang.load import load
from mbdsl.mechanism.scene import InitialValue, Scene

MODELS = Path(__file__).parents[2] / "models"
EPS = np.finfo(float).eps
#: model -> (stop, step, parameters): the first hundred steps of the table of runs
RUNS = json.loads((Path(__file__).parents[1] / "data" / "runs.json").read_text(encoding="utf-8"))
RUNS = {name: (100 * step, step, given) for name, (_, step, given) in RUNS.items() if "/" not in name}
METHODS = ("hht-si2", "nstiff", "radau5")

#: scalars that change sign when a scene is mirrored; all others keep it
ODD = {
    "Fixed": ("phi0",),
    "Prismatic": ("phi0",),
    "RotationalSpringDamper": ("phi0", "torque"),
    "Torque": ("tau",),
    "RotationalDriver": ("phi",),
    "Rope": ("radius", "radii", "drum", "drums", "ends"),
}
#: kinds whose values have no sign
EVEN = {"Ground", "Rod", "Body", "PointMass", "FlexibleBeam", "Revolute", "PointOnLine", "Distance", "KnifeEdge"}
EVEN |= {"RollingDisc", "SpringDamper", "TranslationalDriver", "TranslationalSpringDamper"}


@dataclass(frozen=True)
class Change:
    """Another origin, direction and handedness of the world's axes, and another zero of time.

    r_new = A(turn) (x, hand y) + shift,  phi_new = hand phi + turn,  t_new = t + later
    """

    shift: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0
    hand: float = 1.0
    later: float = 0.0

    def pose(self, x: float, y: float, phi: float) -> tuple[float, float, float]:
        (fx, fy), c, s = self.shift, math.cos(self.turn), math.sin(self.turn)
        return c * x - s * self.hand * y + fx, s * x + c * self.hand * y + fy, self.hand * phi + self.turn

    def back(self, key: str, z: dict):
        """The value of the coordinate ``key`` before the change, of a frame with coordinates ``z`` after it."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        if key in ("x", "y"):
            x, y = z["x"] - self.shift[0], z["y"] - self.shift[1]
        elif key in ("vx", "vy"):
            x, y = z["vx"], z["vy"]
        else:
            return self.hand * (z["phi"] - self.turn) if key == "phi" else self.hand * z["w"]
        return c * x + s * y if key in ("x", "vx") else self.hand * (c * y - s * x)

    def law(self, root: Expr, turned: dict[str, float]) -> Expr:
        """The same number as ``root``, from the changed coordinates and time."""

        def of(leaf: Expr) -> Expr | None:
            if leaf is TIME:
                return TIME - self.later
            if leaf.op != "coordinate":
                return None
            frame, key = leaf.value
            z = {key: coordinate(frame, key) for key in COORDINATES}
            z["phi"] = z["phi"] - turned.get(frame, 0.0)
            return self.back(key, z)

        return substitute(root, of)

    def scene(self, scene: Scene, start: list[InitialValue]) -> Scene:
        """The scene in the other axes; ``start``: further initial values in these axes."""
        # A disc on the left of a line is on the right of its image: the line is followed the other way.
        discs = [c.ports["frame_a"] for c in scene.components.values() if c.kind.name == "RollingDisc"]
        turned = dict.fromkeys(discs, math.pi) if self.hand < 0.0 else {}
        assert all(scene.components[scene.frames[f].body].kind.name == "Ground" for f in turned)
        frames = {}
        for name, f in scene.frames.items():
            grounded = scene.components[f.body].kind.name == "Ground"
            x, y, phi = self.pose(f.x, f.y, f.phi) if grounded else (f.x, self.hand * f.y, self.hand * f.phi)
            frames[name] = replace(f, x=x, y=y, phi=phi + turned.get(name, 0.0))
        components = {}
        for name, c in scene.components.items():
            assert c.kind.name in EVEN or c.kind.name in ODD, f"say what mirroring {c.kind.name} means"
            values = dict(c.values)
            if c.kind.name == "Ground":
                values["n"] = replace(self, shift=(0.0, 0.0)).pose(*values["n"], 0.0)[:2]
            if values.get("com"):
                values["com"] = (values["com"][0], self.hand * values["com"][1])
            for key, value in c.values.items():
                if isinstance(value, Expr):
                    values[key] = self.law(value, turned)
                if key in ODD.get(c.kind.name, ()) and value is not None:
                    old = values[key]
                    values[key] = tuple(self.hand * x for x in old) if isinstance(old, tuple) else self.hand * old
            components[name] = replace(c, values=values)
        initial = (*(replace(x, target=self.law(x.target, turned)) for x in scene.initial), *start)
        variables = {name: self.law(x, turned) for name, x in scene.variables.items()}
        return replace(scene, components=components, frames=frames, initial=initial, variables=variables)


def signals(trajectory, change: Change = Change()) -> dict[str, np.ndarray]:
    """Coordinates of all frames on bodies, reactions and friction, as before ``change``; {name: (N,)}."""
    scene, found = trajectory.scene, {}
    for frame, f in scene.frames.items():
        if scene.components[f.body].kind.name != "Ground":
            turns = "phi" in (scene.components[f.body].kind.coordinates)
            z = {key: trajectory[f"{frame}.{key}"] for key in COORDINATES if turns or key not in ("phi", "w")}
            found |= {f"{frame}.{key}": change.back(key, z) for key in z}
    for name, c in scene.components.items():
        if isinstance(c.kind, JointKind):
            force = {
                key: trajectory[f"{name}.f{key[-1]}"] for key in ("vx", "vy") if f"{name}.f{key[-1]}" in trajectory
            }
            found |= {f"{name}.f{key[-1]}": change.back(key, force) for key in force}
            if f"{name}.tau" in trajectory:
                found[f"{name}.tau"] = change.back("w", {"w": trajectory[f"{name}.tau"]})
    return found


CHANGES = {
    "moved": Change(shift=(0.7, -1.1)),
    "turned": Change(turn=0.6),
    "mirrored": Change(hand=-1.0),
    "later": Change(later=1.0),
    "all of it": Change((-1.3, 0.4), 2.0, -1.0, 0.5),
}


def reordered(scene: Scene) -> Scene:
    """All components in the reverse order."""
    components, frames = dict(reversed(scene.components.items())), dict(reversed(scene.frames.items()))
    return replace(scene, components=components, frames=frames, initial=scene.initial[::-1])


def disturbed(scene: Scene, by: float, size: float) -> Scene:
    """Positions at the start are changed by a part ``by`` of the mechanism's size, and of a radian."""

    def moved(x: InitialValue) -> InitialValue:
        if is_velocity_level(x.target):
            return x
        angle = x.name.endswith("phi")
        return replace(x, value=x.value + by * (1.0 if angle else size))

    return replace(scene, initial=tuple(moved(x) for x in scene.initial))


def run(scene: Scene, method: str, step: float, stop: float, later: float = 0.0):
    scene = replace(scene, experiment=replace(scene.experiment, tolerance=None))
    found = mbdsl.simulate(scene, method=method, step=step, start=later, stop=later + stop, interval=stop / 10)
    assert found.status == "done"
    return found


def differences(one: dict, other: dict) -> dict[str, float]:
    assert one.keys() == other.keys()
    return {name: float(np.abs(one[name] - other[name]).max()) for name in one}


@cache
def base(name: str, method: str):
    """The scene, its run, its signals, those of a run with half the step, and the growth of a disturbance."""
    stop, step, parameters = RUNS[name]
    scene = load(MODELS / f"{name}.mbd", parameters)
    found = run(scene, method, step, stop)
    size, of = found.system.tables.size, signals(found)
    error = differences(of, signals(run(scene, method, step / 2, stop)))
    other = signals(run(disturbed(scene, 1e-10, size), method, step, stop))
    growth = max(
        d / (1e-10 * (size if n.endswith((".x", ".y")) else 1.0))
        for n, d in differences(of, other).items()
        if n.endswith((".x", ".y", ".phi"))
    )
    return scene, found, of, error, max(1.0, growth)


def allowed(name: str, method: str, trajectory) -> dict[str, float]:
    """Bounds of the differences between signals of an equivalent run and those of the original model."""
    stop, step, _ = RUNS[name]
    scene, _, of, error, growth = base(name, method)
    size, bodies = trajectory.system.tables.size, scene.bodies()
    reach = max(size, *(float(np.abs(trajectory[k]).max()) for k in of if k.endswith((".x", ".y"))))
    mass = sum(c.kind.table(dict(c.values))[0] for c in bodies)
    # the shortest length over which positions make an angle: of an element of a cable, of a link
    lengths = [c.values["length"] / (c.values.get("elements") or 1.0) for c in bodies if c.values.get("length")]
    short = min([size, *lengths])
    speed, force = 1.0 / step, mass / step**2
    units = {"x": 1.0, "y": 1.0, "phi": 1.0 / short, "vx": speed, "vy": speed, "w": speed / short}
    units |= {"fx": force, "fy": force, "tau": force * size}
    rounding = 16.0 * EPS * reach * stop / step * growth
    return {k: rounding * units[k.rsplit(".", 1)[1]] + 1e-4 * error[k] for k in of}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("change", CHANGES)
def test_other_axes(name, method, change):
    """The start is given in the new axes: assembly places undetermined coordinates along the axes."""
    stop, step, _ = RUNS[name]
    change = CHANGES[change]
    scene, before, of, *_ = base(name, method)
    start = []
    for body in scene.bodies():
        z = {key: float(before[f"{body.name}.{key}"][0]) for key in COORDINATES}
        z["x"], z["y"], z["phi"] = change.pose(z["x"], z["y"], z["phi"])
        z["vx"], z["vy"], _ = replace(change, shift=(0.0, 0.0)).pose(z["vx"], z["vy"], 0.0)
        z["w"] *= change.hand
        turns = "phi" in body.kind.coordinates
        start += [
            InitialValue(f"{body.name}.{key}", coordinate(f"{body.name}.c", key), z[key], False)
            for key in COORDINATES
            if turns or key not in ("phi", "w")
        ]
    found = run(change.scene(scene, start), method, step, stop, change.later)
    most = allowed(name, method, found)
    wrong = {k: (d, most[k]) for k, d in differences(signals(found, change), of).items() if not d <= most[k]}
    assert not wrong


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", RUNS)
def test_other_order(name, method):
    stop, step, _ = RUNS[name]
    scene, _, of, *_ = base(name, method)
    found = run(reordered(scene), method, step, stop)
    most = allowed(name, method, found)
    wrong = {k: (d, most[k]) for k, d in differences(signals(found), of).items() if not d <= most[k]}
    assert not wrong
