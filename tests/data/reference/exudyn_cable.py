"""Tip of a straight beam of ANCF cable elements in Exudyn: for spin_up_beam.py and flexible_pendulum.py."""

from itertools import pairwise


def exudyn_cable(n, L, EA, EI, rhoA, step, end, gravity=0.0, spin=None, write=0.1):
    """Columns t, x + i y of the tip, its slope: n elements clamped to a hub turned by spin(t), or pinned at (0, 0)."""
    import exudyn as exu
    from exudyn import itemInterface as item

    system = exu.SystemContainer()
    mbs = system.AddSystem()
    nodes = [mbs.AddNode(item.NodePoint2DSlope1(referenceCoordinates=[L * k / n, 0, 1, 0])) for k in range(n + 1)]
    for a, b in pairwise(nodes):
        data = dict(massPerLength=rhoA, bendingStiffness=EI, axialStiffness=EA, nodeNumbers=[a, b])
        cable = mbs.AddObject(item.Cable2D(length=L / n, **data))
        if gravity:
            mass = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=cable))
            mbs.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=[0, -gravity, 0]))
    fixed = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(item.NodePointGround()), coordinate=0))

    def hold(node, coordinate, **offset):
        marker = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, marker], **offset))

    if spin:
        hub = mbs.AddNode(item.NodeRigidBody2D())
        body = mbs.AddObject(item.ObjectRigidBody2D(mass=1, inertia=1, nodeNumber=hub))
        hold(hub, 0)
        hold(hub, 1)
        hold(
            hub,
            2,
            offsetUserFunction=lambda mbs, t, index, offset: spin(t)[0],
            offsetUserFunction_t=lambda mbs, t, index, offset: spin(t)[1],
        )
        root = mbs.AddMarker(item.MarkerNodeRigid(nodeNumber=nodes[0]))
        ends = [mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=body)), root]
        mbs.AddObject(item.GenericJoint(markerNumbers=ends, constrainedAxes=[1, 1, 0, 0, 0, 1]))
    else:
        hold(nodes[0], 0)
        hold(nodes[0], 1)
    output = exu.OutputVariableType.Coordinates
    tip = mbs.AddSensor(item.SensorNode(nodeNumber=nodes[-1], outputVariableType=output, storeInternal=True))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    t = settings.timeIntegration
    t.endTime, t.numberOfSteps = end, round(end / step)
    t.newton.absoluteTolerance = 1e-6  # Exudyn's default lies below the rounding of the residual: steps would fail
    t.newton.useModifiedNewton = False
    t.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = write
    mbs.SolveDynamic(settings)
    d = mbs.GetSensorStoredData(tip)
    return d[:, 0], d[:, 1] + L + 1j * d[:, 2], d[:, 3] + 1 + 1j * d[:, 4]
