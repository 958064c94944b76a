"""Run by test_newton_in_space.py in a process of its own, with MBDSL_NO_COMPILE=1, for bodies that turn far in a step.

Prints a JSON object: for every method with the common step, model and step, how one correction compares with the
Jacobian of the residual by differences (see uncompiled.py), and the largest rotation in the step.
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import uncompiled
from uncompiled import NAMES, Step

from mbdsl.initial.consistent import state_at
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop import split_correction
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism.reduction import reduce
from mbdsl.simulation.gyrostat_states import GyrostatStates
from mbdsl.system import build

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
#: a body that hangs on a ball joint, with rotors that a law, a damper and a driver turn
ROTORS = """
spatial model Rotors
  Ground ground;
  Body bus(m = 3 kg, I = {1, 1.5, 0.8} kg.m2, frames(p = {0.3, 0.1, -0.2} m, q = {-0.1, 0.2, 0.3} m));
  Body a(m = 0.5 kg, I = {0.3, 0.2, 0.2} kg.m2);
  Body b(m = 0.4 kg, I = {0.1, 0.25, 0.1} kg.m2, frames(p = {0, 0.1, 0} m));
  Spherical hip(ground, bus.p);
  Revolute j(bus.q, a.c, n = {1, 0, 0});
  Revolute k(b.p, bus.c, n = {0, 1, 0});
  Torque t(bus.q, a.c, n = {1, 0, 0}, tau = -0.2 N.m.s*j.w + 0.3 N.m.s*bus.wy + 1 N.m*bus.y/(1 m));
  RotationalSpringDamper d(b.p, bus.c, n = {0, 1, 0}, c = 0.3 N.m.s/rad);
  SpringDamper s(ground, bus.q, k = 20 N/m, c = 3 N.s/m, s0 = 0.5 m);
initial equation
  bus.wx_local = 0.3 rad/s; bus.wy_local = -0.4 rad/s; bus.wz_local = 0.6 rad/s;
  j.w = 10 rad/s; k.w = 5 rad/s;
end Rotors;
"""
MODELS = {"sprung": SPRUNG, "driven": DRIVEN, "rotors": ROTORS}
#: steps [s], in which bodies turn by about a fifth of a radian, and by more than one
STEPS = (0.1, 0.8)


def solved(path):
    """As ``uncompiled.prepared``, of a model with gyrostats: the system that is solved."""
    scene, whole, first = in_full(path)
    reduction = reduce(whole.graph)
    if not reduction.flattened:
        return scene, whole, first
    part = reduction.parts[0]
    system = build(part.scene, part.graph, size=whole.tables.size)
    states = GyrostatStates(reduction.flattened[0], [system], whole.tables.size)
    return part.scene, system, state_at(system, 0.0, *states.of_part(system, *states.of(whole, first)))


in_full, uncompiled.prepared = uncompiled.prepared, solved


def left_by(path, name, h):
    """The largest eigenvalue of the error that a correction leaves, the largest rotation, and whether the full system
    was solved."""
    step = Step(path, name, h, False)
    left = np.eye(step.rows * step.N) - step.corrections() @ step.jacobian()
    active = step.active.ravel()
    run = step.run
    turns = [np.linalg.norm(run.vectors[L.POSITION, d : d + 3]) for d, _ in run.system.tables.rotations]
    radius = np.abs(np.linalg.eigvals(left[np.ix_(active, active)])).max()
    return float(radius), float(max(turns)), int(run.integers[S.COUPLED])


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
