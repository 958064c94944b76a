"""Run by test_newton_in_space.py in a process of its own, with NUMBA_DISABLE_JIT=1, for bodies that turn far in a step.

Prints a JSON object: for every method with the common step, model and step, how one correction compares with the
Jacobian of the residual by differences (see uncompiled.py), and the largest rotation in the step.
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from uncompiled import NAMES, Step

from mbdsl.compilation import buffer_layout
from mbdsl.integrators.loop import loop_state, split_correction

#: joints off the centres of mass, springs and dampers between the bodies and to the ground
SPRUNG = """
spatial model Sprung
  Ground ground;
  Body bus(m = 3 kg, I = {1, 1.5, 0.8} kg.m2, frames(seat = {0.3, 0.1, -0.2} m, p = {0.1, -0.3, 0.2} m));
  Body wheel(m = 2 kg, I = {0.2, 0.3, 0.25} kg.m2, frames(axle = {0.05, 0.1, 0.02} m));
  FreeMotion free(ground, bus.c);
  Revolute j(bus.seat, wheel.axle, n = {1, 0.3, 0});
  SpringDamper s(ground, bus.p, k = 20 N/m, c = 3 N.s/m, s0 = 0.5 m);
  RotationalSpringDamper d(bus.seat, wheel.axle, n = {1, 0.3, 0}, k = 0.5 N.m/rad, c = 0.4 N.m.s/rad);
initial equation
  bus.wx_local = 0.02 rad/s; bus.wy_local = -0.03 rad/s; bus.wz_local = 0.05 rad/s;
  bus.vx = 0 m/s; bus.vy = 0 m/s; bus.vz = 0 m/s;
  j.w = 1 rad/s;
end Sprung;
"""
#: forces by expressions of the motion, a driven joint, and friction that depends on a reaction
DRIVEN = """
spatial model Driven
  Ground ground;
  Body a(m = 3 kg, I = {1, 1.5, 0.8} kg.m2, frames(p = {0.3, 0.1, -0.2} m, q = {-0.1, 0.2, 0.3} m));
  Body b(m = 2 kg, I = {0.4, 0.3, 0.5} kg.m2, frames(p = {0.05, 0.1, 0.02} m, q = {0.2, -0.1, 0.3} m));
  Spherical hip(ground, a.p);
  Universal knee(a.q, b.p, n_a = {0, 0, 1}, n_b = {0, 1, 0});
  Force push(b.q, fx = -2 N.s/m*b.q.vx, fy = 1 N.s2/m2*b.q.vy*a.q.vz, fz = 3 N.s/rad*a.wx);
  Torque twist(a.c, b.c, tau = 0.2 N.m.s*b.wy - 0.3 N.m.s*a.wz);
initial equation
  a.wx_local = 0.2 rad/s; a.wy_local = -0.3 rad/s; a.wz_local = 0.5 rad/s;
end Driven;
"""
MODELS = {"sprung": SPRUNG, "driven": DRIVEN}
#: steps [s], in which bodies turn by about a fifth of a radian, and by more than one
STEPS = (0.1, 0.8)


def left_by(path, name, h):
    """The largest eigenvalue of the error that a correction leaves, the largest rotation, and whether the full system
    was solved."""
    step = Step(path, name, h, False)
    left = np.eye(step.rows * step.N) - step.corrections() @ step.jacobian()
    active = step.active.ravel()
    run = step.run
    turns = [np.linalg.norm(run.vectors[buffer_layout.POSITION, d : d + 3]) for d, _ in run.system.tables.rotations]
    radius = np.abs(np.linalg.eigvals(left[np.ix_(active, active)])).max()
    return float(radius), float(max(turns)), int(run.integers[loop_state.COUPLED])


if __name__ == "__main__":
    split_correction.EARLY = split_correction.LATE = 0.0  # no term is left to the next iteration on purpose
    found = {}
    with TemporaryDirectory() as folder:
        for model, text in MODELS.items():
            path = Path(folder) / f"{model}.mbd"
            path.write_text(text, encoding="utf-8")
            for name in NAMES:
                found[f"{model} {name}"] = [left_by(path, name, h) for h in STEPS]
    json.dump(found, sys.stdout)
