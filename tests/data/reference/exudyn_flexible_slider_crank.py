"""Slider crank with a rod of ANCF cable elements in Exudyn: writes exudyn_flexible_slider_crank.json.

`simulate` builds and runs the mechanism of flexible_slider_crank.json; a benchmark can run it beside another tool.
"""

import json
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

TIMES = [0.1, 0.25, 0.5, 1.0, 1.5, 2.0]
M1, L1, M2, L2, G = 3.0, 0.3, 0.9, 0.6, 9.81
EA, EI = 200e9 * 5.74e-6, 200e9 * 2.765e-8


HEAD = dict(
    problem="The mechanism of flexible_slider_crank.json with a rod of ANCF cable elements, in Exudyn 1.13.6",
    model=(
        "ObjectANCFCable2D (strain |r'| - 1, material curvature, no rotary inertia), NodeRigidBody2D for the crank, "
        "two JointRevolute2D, y coordinate of the last node held at 0; generalised alpha, spectral radius 0.9, "
        "index 3, full Newton, relative tolerance 1e-8; start undeformed, along +x, velocities of the rigid mechanism"
    ),
    columns=["t", "phi1", "phi1'", "deflection of the rod's middle from the chord AB", "x of B"],
    difference_in_theory=(
        "The floating frame of flexible_slider_crank.json has 3 bending modes, 1 axial mode and linear strain. Here "
        "the axial force also stiffens bending and bending shortens the chord: with von Karman's strain in the "
        "floating frame the deflection changes by 1e-8 m up to 0.3 s, for axial forces of some 30 N are far from the "
        "buckling load 1.5e5 N. What differs more is the number of axial modes, which the sudden weight excites all: "
        "deflection at 0.25 s -8.99e-6 m with 1 axial mode, -8.60e-6 with 3, -8.51e-6 with 6, and here -8.35e-6, "
        "-8.39e-6, -8.40e-6 m with 8 elements and steps of 2e-5, 1e-5, 5e-6 s."
    ),
    trusted_digits=(
        "phi1 5e-6 at 0.5 s, 1e-5 at 2 s; phi1' 1e-3; deflection 1e-7 at 0.1 s, 5e-7 (of 8e-6) at 2 s: the rod's "
        "vibrations, from 1664 rad/s on, lose phase and amplitude with the step, and Exudyn's Newton tolerance, "
        "which cannot be met below some 1e-9, moves phi1 by 1e-6"
    ),
)


def build(elements, initial_rate=1.0):
    """The system of Exudyn and its sensors: crank angle and rate, the rod's middle, A and B."""
    import exudyn as exu
    from exudyn import itemInterface as item

    system = exu.SystemContainer()
    mbs = system.AddSystem()
    ground = mbs.AddObject(item.ObjectGround())
    crank_node = mbs.AddNode(
        item.NodeRigidBody2D(
            referenceCoordinates=[L1 / 2, 0, 0], initialVelocities=[0, L1 / 2 * initial_rate, initial_rate]
        )
    )
    crank = mbs.AddObject(item.ObjectRigidBody2D(mass=M1, inertia=M1 * L1**2 / 12, nodeNumber=crank_node))
    centre = mbs.AddMarker(item.MarkerNodePosition(nodeNumber=crank_node))
    mbs.AddLoad(item.Force(markerNumber=centre, loadVector=[0, -M1 * G, 0]))

    rate = -L1 / L2 * initial_rate  # of the rod, that keeps B on the axis
    nodes = []
    for k in range(elements + 1):
        x = L2 * k / elements
        nodes.append(
            mbs.AddNode(
                item.NodePoint2DSlope1(
                    referenceCoordinates=[L1 + x, 0, 1, 0],
                    initialVelocities=[0, L1 * initial_rate + rate * x, 0, rate],
                )
            )
        )
    for a, b in pairwise(nodes):
        cable = mbs.AddObject(
            item.Cable2D(
                length=L2 / elements,
                massPerLength=M2 / L2,
                bendingStiffness=EI,
                axialStiffness=EA,
                nodeNumbers=[a, b],
            )
        )
        mass = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=cable))
        mbs.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=[0, -G, 0]))

    def on(body, x):
        return mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))

    at_A = mbs.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[0]))
    mbs.AddObject(item.RevoluteJoint2D(markerNumbers=[on(ground, 0), on(crank, -L1 / 2)]))
    mbs.AddObject(item.RevoluteJoint2D(markerNumbers=[on(crank, L1 / 2), at_A]))
    fixed = mbs.AddNode(item.NodePointGround())
    guide = [
        mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=n, coordinate=c)) for n, c in ((fixed, 0), (nodes[-1], 1))
    ]
    mbs.AddObject(item.CoordinateConstraint(markerNumbers=guide))

    output = exu.OutputVariableType
    sensors = {
        name: mbs.AddSensor(item.SensorNode(nodeNumber=n, outputVariableType=v, storeInternal=True))
        for name, n, v in (
            ("crank", crank_node, output.Coordinates),
            ("crank_rate", crank_node, output.Coordinates_t),
            ("A", nodes[0], output.Position),
            ("middle", nodes[elements // 2], output.Position),
            ("B", nodes[-1], output.Position),
        )
    }
    mbs.Assemble()
    return exu, mbs, sensors


def simulate(elements=8, step=1e-4, end=2.0, write_step=None, spectral_radius=0.9, tolerance=1e-8, full=True):
    """Columns t, phi1, phi1', deflection of the rod's middle across the chord AB, x of B; and the wall time in s."""
    exu, mbs, sensors = build(elements)
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps = end, round(end / step)
    integration.generalizedAlpha.spectralRadius = spectral_radius
    integration.newton.relativeTolerance = tolerance
    integration.newton.useModifiedNewton = not full
    integration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = write_step or step
    begin = time.perf_counter()
    mbs.SolveDynamic(settings)
    wall = time.perf_counter() - begin
    data = {name: mbs.GetSensorStoredData(sensor) for name, sensor in sensors.items()}
    A, middle, B = (data[name][:, 1:3] for name in ("A", "middle", "B"))
    chord, arm = B - A, middle - A
    across = (chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / np.hypot(chord[:, 0], chord[:, 1])
    columns = (data["crank"][:, 0], data["crank"][:, 3], data["crank_rate"][:, 3], across, B[:, 0])
    return np.column_stack(columns), wall


def main():
    here = Path(__file__)
    frame = json.loads((here.parent / "flexible_slider_crank.json").read_text())["data"]["flexible_3_bending_1_axial"]
    frame = np.array([[float(r[k]) for k in ("t", "phi1", "omega1", "v_mid", "xB")] for r in frame["rows"]])
    runs = []
    for elements, step in ((8, 1e-4), (8, 5e-5), (8, 2e-5), (16, 5e-5), (16, 2e-5)):
        rows, _ = simulate(elements, step, write_step=0.05)
        rows = rows[[2, 5, 10, 20, 30, 40]]
        assert np.max(np.abs(rows[:, 0] - TIMES)) < 1e-9
        minus = [[f"{e:.1e}" for e in row[1:]] for row in rows - frame]
        runs.append(dict(elements=elements, step=step, rows=rows.tolist(), minus_flexible_slider_crank=minus))
    data = HEAD | dict(runs=runs)
    here.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n")


if __name__ == "__main__":
    main()
