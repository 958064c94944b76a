"""Sensor: an accelerometer, a gyroscope and a load cell at a frame, in the axes of the frame; see the one of the plane.

``w`` and ``tau`` are those about the z axis of the frame, as in the plane.
"""

from mbdsl.elements import sensor
from mbdsl.elements.kind import Signal, in_space
from mbdsl.elements.sensor import FELT, load

DRAWING = "nothing"

KIND = in_space(
    sensor.KIND,
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
