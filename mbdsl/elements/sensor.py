"""Sensor: an accelerometer, a gyroscope and a load cell at a frame, in the axes of the frame.

    accelerometer  R^T (a - g)         the acceleration a of the origin, and the field g of gravity
    gyroscope      w                   (in space R^T w)
    load cell      R^T f, tau          the wrench of all joints and forces at the frame, on the body of the frame

It acts on nothing. At rest an accelerometer shows g upwards; in free fall it shows nothing.
"""

from mbdsl.elements.kind import SensorKind, Signal, in_space

DOC = (
    "Measures at a frame, in the axes of this frame: an accelerometer, a gyroscope, and the load of all joints and "
    "forces that are attached to the frame, on its body. It acts on nothing."
)
FELT = "specific force along {}: acceleration minus gravity"


def load(key: str, unit: str, doc: str) -> Signal:
    return Signal(key, unit, "", doc)


KIND = SensorKind(
    "Sensor",
    doc=DOC,
    signals=(Signal("w", "rad/s", "frame.w", "angular velocity"),),
    measured=(
        *(Signal(f"a{i}", "m/s2", "", FELT.format(i)) for i in "xy"),
        *(load(f"f{i}", "N", f"force on the body along {i}") for i in "xy"),
        load("tau", "N.m", "torque on the body about the origin of the frame"),
    ),
    drawing="nothing",
)
#: ``w`` and ``tau`` are those about the z axis of the frame, as in the plane
IN_SPACE = in_space(
    KIND,
    signals=(
        *(Signal(f"w{i}", "rad/s", f"frame.w{i}_local", f"angular velocity about {i}") for i in "xyz"),
        Signal("w", "rad/s", "frame.wz_local", "angular velocity about z"),
    ),
    measured=(
        *(Signal(f"a{i}", "m/s2", "", FELT.format(i)) for i in "xyz"),
        *(load(f"f{i}", "N", f"force on the body along {i}") for i in "xyz"),
        *(load(f"t{i}", "N.m", f"torque on the body about {i}") for i in "xyz"),
        load("tau", "N.m", "torque on the body about z"),
    ),
)
