"""Accelerations of frames, and what accelerometers show, at stored states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from mbdsl.bodies.contract import VELOCITIES, Body, Pose
from mbdsl.expressions.symbolic import Expr
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.numerics import rotation_arrays
from mbdsl.system.body_models import body_pose
from mbdsl.system.signals import frame_coordinate
from mbdsl.system.system import System

STEP = 1e-30  #: of complex steps, which are exact


class MotionStates(Protocol):
    """What is needed of N states: those of a Trajectory."""

    system: System
    t: Array
    q: Array
    v: Array

    @property
    def scene(self) -> Scene:
        """The model."""

    @property
    def a(self) -> Array:
        """Generalised accelerations (N, n)."""

    def evaluate(self, roots: Sequence[Expr]) -> list[Array]:
        """Values (N,) of expressions."""


def acceleration(states: MotionStates, body: str, pose: Pose) -> Array:
    """The acceleration of a frame at ``pose`` on a body, in world axes.

    Parameters
    ----------
    states : States
        N states.
    body : str
        Name of the body; of the ground, which does not move, or of a body.
    pose : tuple of float
        Pose of the frame from the centre of mass: (x, y, phi), in space origin and axes (12 numbers).

    Returns
    -------
    (N, 3) array [m/s2, rad/s2]
        In the plane of x, y and phi; in space of x, y and z.
    """
    model = states.system.tables.models.get(body)
    if model is None:
        return np.zeros((len(states.t), 3))
    d = states.system.tables.coordinates[body]
    own = slice(d, d + model.n)
    q, v, a = states.q[:, own], states.v[:, own], states.a[:, own]
    if states.scene.spatial:
        return _in_space(pose, q, v, a)
    return _of_beam(model, pose, q, v, a) if model.deforms else _of_rigid_body(pose, q, v, a)


def _of_rigid_body(pose: Pose, q: Array, v: Array, a: Array) -> Array:
    if q.shape[1] < 3:
        return np.column_stack([a, np.zeros(len(a))])
    c, s = np.cos(q[:, 2]), np.sin(q[:, 2])
    x, y = c * pose[0] - s * pose[1], s * pose[0] + c * pose[1]
    w, alpha = v[:, 2], a[:, 2]
    return np.column_stack([a[:, 0] - alpha * y - w * w * x, a[:, 1] + alpha * x - w * w * y, alpha])


def _of_beam(model: Body, pose: Pose, q: Array, v: Array, a: Array) -> Array:
    """B a + (B v)_q v: the velocity B v of a frame is linear in v, and its derivative along v is a complex step."""
    found = []
    for key in VELOCITIES:
        turning = model.frame(pose, key, q + 1j * STEP * v, v).imag / STEP
        found.append(model.frame(pose, key, q, a) + turning)
    return np.column_stack(found)


def _in_space(pose: Pose, q: Array, v: Array, a: Array) -> Array:
    if q.shape[1] < 6:
        return a.copy()
    w, lever = v[:, 3:6], np.array(pose[:3], float)  # the angular velocity and its rate are in body axes
    turned = np.cross(a[:, 3:6], lever) + np.cross(w, np.cross(w, lever))
    return a[:, :3] + np.einsum("nij,nj->ni", rotation_arrays.matrices(q[:, 3:6]), turned)


def accelerometer(states: MotionStates, sensor: Component) -> dict[str, Array]:
    """The specific force (N,) [m/s2] at the frame of a sensor in its own axes, as signals: R^T (a - g)."""
    scene, name = states.scene, sensor.ports["frame"]
    frame = scene.frames[name]
    n = 3 if scene.spatial else 2
    owner = scene.components[frame.body]
    felt = acceleration(states, frame.body, body_pose(owner, frame))[:, :n] - np.array(gravity(scene))
    axes = axes_of(states, name)
    return {f"{sensor.name}.a{i}": (felt * axes[k]).sum(axis=1) for k, i in enumerate("xyz"[:n])}


def axes_of(states: MotionStates, frame: str) -> list[Array]:
    """The axes of a frame in world axes, each (N, 2) or (N, 3)."""

    def coordinate(key: str) -> Array:
        return frame_coordinate(states.system, frame, key, states.q, states.v, states.t)

    if states.scene.spatial:
        return [np.column_stack([coordinate(i + j) for j in "xyz"]) for i in "xyz"]
    phi = coordinate("phi")
    c, s = np.cos(phi), np.sin(phi)
    return [np.column_stack([c, s]), np.column_stack([-s, c])]
