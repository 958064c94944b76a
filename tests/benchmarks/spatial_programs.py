"""The models of the comparison in space, and the same mechanisms in Exudyn and MuJoCo, built from mbdsl's scenes.

Exudyn gets the consistent start of mbdsl: masses, inertias, poses, velocities, and joints at their points and axes.
MuJoCo gets chains of ball joints as trees of bodies, whose coordinates are quaternions of the joints.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from doc_parts import ROOT
from numpy.typing import NDArray

import mbdsl
from mbdsl.expressions.spatial_coordinates import AXES
from mbdsl.expressions.symbolic import coordinate
from mbdsl.initial.consistent import InitialState, initial_state
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import System, build
from mbdsl.system.signals import values

Array = NDArray[np.float64]
SPACE = ROOT / "models" / "space"
#: options of Exudyn's solver: sparse or dense matrices, full or modified Newton
WAYS = {
    "dense": (False, False),
    "dense, modified": (False, True),
    "sparse": (True, False),
    "sparse, modified": (True, True),
}
LENGTH = 0.2  #: of the links of a chain [m]

TOP = """spatial model Top
  Ground ground(n = {0, 0, -1});
  Body last(m = 15 kg, I = {0.234375, 0.46875, 0.234375} kg.m2, frames(foot = {0, -1, 0} m, tip = {0, 0, 0}));
  Spherical ball(ground, last.foot);
initial equation
  last.y = 1; last.wy = 150; last.wz = -4.61538;
end Top;"""


def bend(k: int) -> float:
    return 0.5 * (-1.0) ** k


def chain(n: int, joint: str = "Spherical", axes: str = "") -> str:
    """A zigzag of rods of 0.2 m in a horizontal plane, connected by ball or universal joints, which falls."""
    rods = "".join(
        f"  Body link{k}(m = 1 kg, I = {{0.001, 0.004, 0.004}} kg.m2, frames(a = {{-0.1, 0, 0}}, b = {{0.1, 0, 0}}));\n"
        f"  {joint} J{k}({'ground' if k == 0 else f'link{k - 1}.b'}, link{k}.a{axes});\n"
        for k in range(n)
    )
    start = "".join(f"  link{k}.phi = {bend(k)!r};\n" for k in range(n))
    return f"spatial model Chain\n  Ground ground(n = {{0, 0, -1}});\n{rods}initial equation\n{start}end Chain;"


def released(name: str, start: str) -> str:
    """A model of Haug's without its motor, with the speed that the motor would have at the start."""
    text = re.sub(r"  RotationalDriver.*\n", "", (SPACE / f"{name}.mbd").read_text(encoding="utf-8"))
    return text.replace("initial equation", f"initial equation\n  {start}")


@dataclass
class Case:
    """A model, its duration [s], the numbers of steps, the point whose error counts, and the size [m]."""

    name: str
    text: str
    stop: float
    steps: tuple[int, ...]
    point: str
    size: float
    links: int = 0  #: of a chain of ball joints, which MuJoCo simulates, too
    #: axes that Exudyn's joints leave out, because others imply them: Exudyn has no redundant constraints
    left_out: dict[str, list[int]] = field(default_factory=dict)

    @cached_property
    def scene(self) -> Any:
        return mbdsl.parse(self.text)

    @property
    def frame(self) -> str:
        return self.point if "." in self.point else f"{self.point}.c"

    @cached_property
    def prepared(self) -> tuple[System, InitialState]:
        """The equations, and the consistent start."""
        mechanism = graph.build(self.scene)
        system = build(self.scene, mechanism)
        return system, initial_state(system, mechanism, 0.0)

    def first(self, name: str, keys: tuple[str, ...]) -> Array:
        """Coordinates of a frame at the start."""
        system, s = self.prepared
        nodes = [coordinate(name, key) for key in keys]
        return np.array([x[0] for x in values(system, nodes, np.zeros(1), s.q[None], s.v[None])])

    def ours(self, steps: int, method: str, options: dict[str, float]) -> tuple[Array, float]:
        """The point at the end, and seconds from the second step on."""
        system, s = self.prepared
        times = np.array([self.stop])
        run = MethodRun(system, method, self.stop / steps, 0.0, self.stop, times, options)
        run.begin(s.q, s.v, s.a, s.lam, s.redundant)
        run.advance(1)
        begun = time.process_time()
        status = run.advance()
        seconds = max(time.process_time() - begun, 1e-9)
        if status != S.DONE:
            return np.full(3, np.inf), np.inf
        nodes, n = [coordinate(self.frame, key) for key in "xyz"], system.n
        found = values(system, nodes, times, run.out[:, :n], run.out[:, n : 2 * n])
        return np.array([x[0] for x in found]), seconds


#: the first cross axis of each joint is horizontal across the link, the second one vertical
CROSS = ", n_a = {0, 1, 0}, n_b = {0, 0, 1}"
CASES = (
    Case("heavy top", TOP, 0.1, (100, 200, 400, 800), "last", 1.0),
    Case(
        "Bricard's linkage",
        (SPACE / "bricard.mbd").read_text(encoding="utf-8"),
        1.0,
        (50, 100, 200, 400),
        "rod3.b",
        1.0,
        left_out={"J3": [4]},
    ),
    Case(
        "Haug's slider crank",
        released("haug_slider_crank", "A.phi = pi/2 rad; A.w = -2*pi*(1 rad/s);"),
        0.5,
        (125, 250, 500, 1000),
        "slider",
        0.3,
    ),
    Case(
        "Haug's four-link",
        released("haug_four_link", "A.phi = 0 rad; A.w = pi*(1 rad/s);"),
        1.0,
        (125, 250, 500, 1000),
        "link",
        12.2,
    ),
    Case("chain of 8 ball joints", chain(8), 0.5, (125, 250, 500, 1000), "link3.b", 1.6, 8),
    Case("chain of 64 ball joints", chain(64), 0.5, (125, 250, 500), "link3.b", 12.8, 64),
    Case("chain of 8 universal joints", chain(8, "Universal", CROSS), 0.5, (125, 250, 500, 1000), "link3.b", 1.6),
)


def build_exudyn(exu: Any, mbs: Any, node: Any, case: Case) -> dict[str, Any]:
    """The bodies of a case in Exudyn, by name."""
    import exudyn.utilities as eu

    scene, first = case.scene, case.first
    ground = next(c for c in scene.components.values() if c.kind.name == "Ground")
    gravity = (ground.values["g"] * np.array(ground.values["n"])).tolist()
    bodies: dict[str, Any] = {ground.name: mbs.CreateGround()}

    def attitude(body: str) -> Array:
        """With the axes of the body, in world axes, as columns."""
        return np.eye(3) if body == ground.name else np.reshape(case.first(f"{body}.c", AXES), (3, 3)).T

    for body in scene.bodies():
        m, *J = body.kind.table(dict(body.values))
        bodies[body.name] = mbs.CreateRigidBody(
            inertia=eu.RigidBodyInertia(mass=m, inertiaTensor=np.reshape(J, (3, 3))),
            nodeType=node,
            referencePosition=first(f"{body.name}.c", ("x", "y", "z")).tolist(),
            referenceRotationMatrix=attitude(body.name),
            initialVelocity=first(f"{body.name}.c", ("vx", "vy", "vz")).tolist(),
            initialAngularVelocity=first(f"{body.name}.c", ("wx", "wy", "wz")).tolist(),
            gravity=gravity,
        )
    for name, c in scene.components.items():
        if c.kind.name not in ("Spherical", "Revolute", "Prismatic", "Universal"):
            continue
        a, b = (scene.frames[c.ports[port]] for port in ("frame_a", "frame_b"))
        point = first(c.ports["frame_b"], ("x", "y", "z")).tolist()
        given = {"itemNumbers": [bodies[a.body], bodies[b.body]], "position": point, "show": False}
        axes = attitude(a.body) @ np.reshape(a.axes, (3, 3)).T
        if c.kind.name == "Spherical":
            mbs.CreateSphericalJoint(useGlobalFrame=True, **given)
            continue
        free = {"Revolute": [5], "Prismatic": [0], "Universal": [3, 4]}[c.kind.name]
        free = free + case.left_out.get(name, [])
        if c.kind.name == "Universal":  # Exudyn keeps x of the first at right angles to y of the second
            other = attitude(b.body) @ np.reshape(b.axes, (3, 3)).T
            axes = np.stack([axes[:, 2], other[:, 0], np.cross(axes[:, 2], other[:, 0])], axis=-1)
        kept = [int(k not in free) for k in range(6)]
        mbs.CreateGenericJoint(rotationMatrixAxes=axes, constrainedAxes=kept, useGlobalFrame=True, **given)
    return bodies


class Exudyn:
    """A case in Exudyn with one kind of node."""

    def __init__(self, exu: Any, case: Case, node: Any) -> None:
        self.exu, self.case = exu, case
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.bodies = build_exudyn(exu, self.mbs, node, case)
        self.mbs.Assemble()

    def run(self, way: str, steps: int, taken: int | None = None) -> tuple[Array, float]:
        sparse, modified = WAYS[way]
        given = self.exu.SimulationSettings()
        t = given.timeIntegration
        t.numberOfSteps, t.endTime = taken or steps, self.case.stop * (taken or steps) / steps
        t.generalizedAlpha.spectralRadius = 0.9
        t.newton.useModifiedNewton = modified
        t.verboseMode = 0
        given.linearSolverType = self.exu.LinearSolverType.EigenSparse if sparse else self.exu.LinearSolverType.EXUdense
        given.solution.file.write = False
        given.solution.sensors.writePeriod = self.case.stop
        given.show.statistics = given.show.computationTime = False
        given.parallel.numberOfThreads = 1
        begin = time.process_time()
        try:
            self.mbs.SolveDynamic(given)
        except self.exu.SolverError:
            return np.full(3, np.inf), np.inf
        seconds = time.process_time() - begin
        frame = self.case.scene.frames[self.case.frame]
        place = [frame.x, frame.y, frame.z]
        found = self.mbs.GetObjectOutputBody(self.bodies[frame.body], self.exu.OutputVariableType.Position, place)
        return np.array(found, float), seconds

    def time(self, way: str, steps: int) -> tuple[Array, float]:
        """Without preparations and the first step."""
        found, whole = self.run(way, steps)
        return found, max(whole - self.run(way, steps, 1)[1], 1e-9) if whole < np.inf else np.inf


def mjcf(n: int, jacobian: str) -> str:
    """A chain of ball joints in MuJoCo's XML: every body has its origin at its joint."""
    inner = ""
    for k in reversed(range(n)):
        turn = bend(k) - (bend(k - 1) if k else 0.0)
        place = f'pos="{LENGTH if k else 0} 0 0" quat="{math.cos(turn / 2)!r} 0 0 {math.sin(turn / 2)!r}"'
        inertial = f'<inertial pos="{LENGTH / 2} 0 0" mass="1" diaginertia="0.001 0.004 0.004"/>'
        inner = f'<body name="link{k}" {place}><joint type="ball"/>{inertial}{inner}</body>'
    option = f'<option integrator="RK4" gravity="0 0 -9.81" jacobian="{jacobian}"/>'
    return f"<mujoco>{option}<worldbody>{inner}</worldbody></mujoco>"


def mujoco_runs(case: Case) -> dict[str, Callable[[int], tuple[Array, float]]]:
    """For dense and sparse matrices: the point at the end, and seconds, of a run with a number of steps."""
    import mujoco

    mujoco.set_mju_user_warning(lambda text: None)  # too long steps are unstable: no messages, and no file for them
    found = {}
    for jacobian in ("dense", "sparse"):
        model = mujoco.MjModel.from_xml_string(mjcf(case.links, jacobian))
        flags = mujoco.mjtDisableBit.__members__.items()
        used = ("mjDSBL_GRAVITY",)
        model.opt.disableflags = sum(
            bit.value for name, bit in flags if name.startswith("mjDSBL_") and name not in used
        )

        def run(steps: int, model: Any = model) -> tuple[Array, float]:
            model.opt.timestep = case.stop / steps
            data = mujoco.MjData(model)
            begun = time.process_time()
            mujoco.mj_step(model, data, nstep=steps)
            seconds = time.process_time() - begun
            mujoco.mj_kinematics(model, data)
            body = data.body(case.point.partition(".")[0])
            return np.array(body.xpos + LENGTH * body.xmat.reshape(3, 3)[:, 0]), seconds

        found[f"MuJoCo RK4, {jacobian}"] = run
    return found
