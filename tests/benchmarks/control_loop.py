"""Times of a control loop: signals, steps, inputs, states of a Simulation, in microseconds a call.

python tests/benchmarks/control_loop.py [--repeats 5]

"step, computed" is a hundredth of ``step(100)``; the difference to "step()" is the overhead of a call. Nothing is
asserted, because times depend on the machine and its load. Operations that an earlier version lacks are left out.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from timeit import repeat

import mbdsl

PENDULUM = """model Pendulum input Torque u; Ground ground; Rod rod(m = 1 kg, length = 1 m);
Revolute pin(ground, rod.a); Torque motor(ground, rod.a, tau = u); end Pendulum;"""
CRANK = """model Crank input Torque u; Ground ground; Rod crank(m = 1 kg, length = 0.3 m);
Rod rod(m = 2 kg, length = 0.7 m); Body slider(m = 0.5 kg, I = 0.01 kg.m2); Revolute pin(ground, crank.a);
Revolute A(crank.b, rod.a); Revolute B(rod.b, slider.c); Prismatic guide(ground, slider.c);
Torque motor(ground, crank.a, tau = u); initial equation guess crank.phi = 60 deg; guess rod.phi = -20 deg;
end Crank;"""
MODELS = {"pendulum": PENDULUM, "slider crank": CRANK}


def operations(sim: mbdsl.Simulation) -> dict[str, tuple[Callable[[], object], float]]:
    """Name -> operation, and the number of units that it contains."""
    values = [0.1, 0.2]

    def changed() -> None:
        values.reverse()
        sim.inputs["u"] = values[0]
        sim.step()

    found: dict[str, tuple[Callable[[], object], float]] = {
        'sim["pin.phi"]': (lambda: sim["pin.phi"], 1.0),
        'sim["pin.fx"]': (lambda: sim["pin.fx"], 1.0),
        "step()": (sim.step, 1.0),
        "step, computed": (lambda: sim.step(100), 100.0),
        "input and step()": (changed, 1.0),
    }
    if hasattr(sim, "reader"):
        read, write = sim.reader("pin.phi", "pin.w", "pin.fx", "pin.fy"), sim.writer("u")
        found["four signals"] = read, 1.0
        found["writer"] = (lambda: write(values[:1])), 1.0
    if hasattr(sim, "state"):
        kept = sim.state
        found["sim.state"] = (lambda: sim.state), 1.0
        found["sim.state = state"] = (lambda: setattr(sim, "state", kept)), 1.0
        found["reset()"], found["copy()"] = (sim.reset, 1.0), (sim.copy, 1.0)
    return found


def table(repeats: int = 5, number: int = 200) -> str:
    columns = []
    for text in MODELS.values():
        sim = mbdsl.Simulation(mbdsl.parse(text), step=1e-3, record=False)
        sim.step(10)
        times = {}
        for name, (operation, units) in operations(sim).items():
            operation()
            times[name] = min(repeat(operation, number=number, repeat=repeats)) / number / units * 1e6
        columns.append(times)
    lines = [f"{'microseconds':20}" + "".join(f"{name:>14}" for name in MODELS)]
    lines += [f"{name:20}" + "".join(f"{times[name]:14.2f}" for times in columns) for name in columns[0]]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    print(table(parser.parse_args().repeats))
