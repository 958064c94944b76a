"""Sensors, wrenches on ports and sections in models: declarations, the Builder, errors."""

import pickle

import pytest

import mbdsl
from mbdsl import ModelError

HEAD = "model M Ground ground; Rod rod(m = 1, length = 1); Revolute pin(ground, rod.a); "


def parse(text, spatial=False):
    return mbdsl.parse(("spatial " if spatial else "") + HEAD + text + " end M;")


@pytest.mark.parametrize("spatial", [False, True])
def test_a_sensor_is_declared_as_text_and_by_the_builder(spatial):
    text = parse("Sensor imu(rod.b); Sensor other(frame = pin.frame_b);", spatial)
    b = (mbdsl.SpatialBuilder if spatial else mbdsl.Builder)("M")
    b.Ground("ground")
    rod = b.Rod("rod", m=1, length=1)
    pin = b.Revolute("pin", "ground.c", rod.a)
    b.Sensor("imu", rod.b)
    b.Sensor("other", frame=pin.frame_b)
    assert b.scene() == text
    assert "2 sensors" in repr(text) and text.components["other"].ports == {"frame": "rod.a"}
    assert pickle.loads(pickle.dumps(text)).components["imu"].kind is text.components["imu"].kind


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("Sensor imu(pin);", "`pin` is a Revolute, expected a frame for `frame` of `imu`", "its ports are pin.frame_a"),
        ("Sensor imu(rod.a, rod.b);", "Sensor `imu` takes 1 frame, found 2", "write a Sensor for each frame"),
        ("Sensor imu();", "`frame` of Sensor `imu` is not connected", "name a frame, `Sensor imu(a)`"),
        ("Sensor imu(rod.b, k = 1);", "Sensor `imu` has no parameter `k`", "Sensor takes: frame"),
        ("Sensor imu(rod.b); Real x = imu.ax;", "`imu.ax` is a result of the simulation", "accelerations"),
        ("Sensor imu(rod.b); Real x = imu.fx;", "`imu.fx` is a result of the simulation", "reactions"),
        ("Real x = rod.a.N;", "`rod.a.N` is a result of the simulation", "reactions"),
        ("Real x = pin.frame_a.f;", "`pin.frame_a.f` is a result", "write `hypot(pin.frame_a.fx, pin.frame_a.fy)`"),
        ("Real x = pin.frame_a.fq;", "the frame `pin.frame_a` has no `fq`", "w, fx, fy, tau"),
        ("Real x = rod.a.fx;", "the frame `rod.a` has no `fx`", "did you mean `x`"),
        ("Torque t(rod.b, tau = pin.frame_a.fx);", "`tau` of `t`", "N.m"),
    ],
)
def test_errors(text, message, hint):
    with pytest.raises(ModelError) as problem:
        parse(text)
    assert message in problem.value.message and hint in f"{problem.value.hint} {problem.value.message}"
    assert problem.value.span is not None
