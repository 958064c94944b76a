"""Attitudes in space: as initial values, as signals and in laws, compared with SciPy's rotations and differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.errors import ModelError, UsageError
from mbdsl.mechanism.given_attitudes import given_attitudes
from mbdsl.numerics.rotation_arrays import turned
from mbdsl.system.signals import gradients

FREE = """spatial model Free
  Ground ground(g = 0 m/s2);
  Body b(m = 1 kg, I = {{1, 2, 2.5}} kg.m2, frames(tip(r = {{1, 0, 0}} m, angles = {{10, 20, 30}} deg)));
  Force free(b.c);
  {more}
initial equation
  {initial}
end Free;
"""
JOINT = """spatial model Held
  Ground ground(frames(f(r = {{1, 2, 3}} m, angles = {{20, -30, 40}} deg)));
  Body b(m = 1 kg, I = {{1, 2, 2.5}} kg.m2, frames(tip(r = {{1, 0.3, 0}} m, angles = {{10, 20, 30}} deg)));
  {joint}(ground.f, b.tip);
initial equation
  {initial}
end Held;
"""
#: of a rotation that the assembly finds by Newton's iteration, which ends below 1e-13 for models of this size
EXACT = 1e-12


def start(text, **values):
    return mbdsl.simulate(mbdsl.parse(text.format(more="", **values)), stop=1e-3, interval=1e-3)


def attitude(t, frame, k=0):
    return Rotation.from_quat([t[f"{frame}.p{i}"][k] for i in (1, 2, 3, 0)])


def apart(found, expected):
    """Angle between two attitudes [rad]."""
    return (found.inv() * expected).magnitude()


CARDAN = "b.phi_x = {} deg; b.phi_y = {} deg; b.phi_z = {} deg;"
OF_QUATERNION = "b.p0 = {}; b.p1 = {}; b.p2 = {}; b.p3 = {};"


@pytest.mark.parametrize("frame", ["b", "b.tip"])
@pytest.mark.parametrize("mode", ["", "guess "])
@pytest.mark.parametrize("angles", [(100, -70, 170), (-179, 89.9, 5), (10, 90, 20), (10, 110, 20), (0, -90, 0)])
def test_cardan_angles_at_the_start(frame, mode, angles):
    found = start(FREE, initial=CARDAN.format(*angles).replace("b.", f"{mode}{frame}."))
    assert apart(attitude(found, frame), Rotation.from_euler("XYZ", angles, degrees=True)) < EXACT


@pytest.mark.parametrize("frame", ["b", "b.tip"])
@pytest.mark.parametrize("mode", ["", "guess "])
@pytest.mark.parametrize(
    "p", [(0.5, 0.5, -0.5, 0.5), (0, 1, 0, 0), (0, 0, 0, -1), (-0.8, 0, 0.6, 0), (0.7071, 0, 0, -0.7071)]
)
def test_quaternions_at_the_start(frame, mode, p):
    found = start(FREE, initial=OF_QUATERNION.format(*p).replace("b.", f"{mode}{frame}."))
    assert apart(attitude(found, frame), Rotation.from_quat([*p[1:], p[0]])) < EXACT


def test_parts_of_an_attitude_are_kept_and_the_others_are_free():
    found = start(FREE, initial="b.phi_x = 100 deg; b.phi_z = 170 deg;")
    expected = Rotation.from_euler("XYZ", [100, 0, 170], degrees=True)
    assert apart(attitude(found, "b"), expected) < EXACT
    found = start(FREE, initial="b.p1 = -0.6; b.p2 = 0; b.p3 = 0.3;")
    assert found["b.p0"][0] == pytest.approx(np.sqrt(1 - 0.45), abs=EXACT)
    found = start(FREE, initial="b.p1 = 0.3; b.p2 = 0.4;")
    assert (found["b.p1"][0], found["b.p2"][0]) == pytest.approx((0.3, 0.4), abs=EXACT)


def test_angular_velocity_in_world_and_in_body_axes():
    angles = "b.phi_x = 100 deg; b.phi_y = -70 deg; b.phi_z = 170 deg;"
    found = start(FREE, initial=f"{angles} b.wx_local = 1; b.wy_local = 2; b.wz_local = 3;")
    R = attitude(found, "b")
    assert R.inv().apply([found[f"b.w{i}"][0] for i in "xyz"]) == pytest.approx([1, 2, 3], abs=1e-13)
    tip = attitude(found, "b.tip").inv().apply([found[f"b.w{i}"][0] for i in "xyz"])
    assert [found[f"b.tip.w{i}_local"][0] for i in "xyz"] == pytest.approx(tip, abs=1e-13)


def test_values_from_python_and_as_modifiers():
    scene = mbdsl.parse(FREE.format(more="", initial="b.x = 0;"))
    given = {"b.p0": 0.0, "b.p1": 0.6, "b.p2": 0.0, "b.p3": -0.8}
    found = mbdsl.simulate(scene, stop=1e-3, interval=1e-3, initial=given)
    assert apart(attitude(found, "b"), Rotation.from_quat([0.6, 0, -0.8, 0])) < EXACT
    with pytest.raises(UsageError, match="has the length 2, expected 1"):
        mbdsl.simulate(scene, stop=1e-3, initial={**given, "b.p0": np.sqrt(3)})
    more = "phi_x(start = 20 deg, fixed = true), phi_y(start = 0.3), phi_z(start = 1), m = 1 kg"
    text = FREE.replace("m = 1 kg", more).format(more="", initial="b.x = 0;")
    found = mbdsl.simulate(mbdsl.parse(text), stop=1e-3, interval=1e-3)
    assert apart(attitude(found, "b"), Rotation.from_euler("XYZ", [np.deg2rad(20), 0.3, 1])) < EXACT


def test_a_quaternion_of_another_length_is_refused_with_the_one_of_length_1():
    with pytest.raises(ModelError, match=r"of `b` has the length 1.41421, expected 1") as found:
        mbdsl.parse(FREE.format(more="", initial=OF_QUATERNION.format(1, 1, 0, 0)))
    assert found.value.hint == "a quaternion of length 1 is {0.707107, 0.707107, 0, 0}"
    assert found.value.span.line == 7


def test_the_rotation_from_a_given_attitude_is_what_assembly_closes():
    t = start(FREE, initial=CARDAN.format(20, 30, 40))
    given = given_attitudes(t.scene.initial)[0]
    names = [x.name for x in given.rotation()]
    assert names == [f"the rotation of b from its given attitude about its {i} axis" for i in "xyz"]
    R = Rotation.from_euler("XYZ", [20, 30, 40], degrees=True)
    for k, angle in enumerate((0.3, -0.01, 1.2)):
        turn = np.eye(3)[k] * angle
        q = np.append(np.zeros(3), (R * Rotation.from_rotvec(turn)).as_rotvec())
        found, _, _ = gradients(t.system, [x.target for x in given.rotation()], 0.0, q, np.zeros(6))
        assert found == pytest.approx(np.sin(turn), abs=1e-14)


SPUN = FREE.format(more="", initial=CARDAN.format(20, 30, 40) + "b.wx = 3; b.wy = -2; b.wz = 5;")


def test_signals_of_attitude_along_a_motion():
    t = mbdsl.simulate(mbdsl.parse(SPUN), stop=2, interval=1e-2, step=1e-3)
    for frame in ("b", "b.tip"):
        R = Rotation.from_quat(np.column_stack([t[f"{frame}.p{i}"] for i in (1, 2, 3, 0)]))
        angles = R.as_euler("XYZ")
        w = np.column_stack([t[f"{frame}.w{i}"] for i in "xyz"])
        local = R.inv().apply(w)
        for k, i in enumerate("xyz"):
            away = t[f"{frame}.phi_{i}"] - angles[:, k]
            # rounding, divided by the cosine of phi_y, which is above 1e-3 at these times
            assert np.abs(away - 2 * np.pi * np.round(away / (2 * np.pi))).max() < 1e-12
            assert t[f"{frame}.w{i}_local"] == pytest.approx(local[:, k], abs=1e-13)
        p = np.column_stack([t[f"{frame}.p{i}"] for i in range(4)])
        assert np.abs(np.diff(p, axis=0)).max() < 0.05  # |w| dt / 2 is at most 0.04: no change of sign
    turned = attitude(t, "b", -1) * Rotation.from_euler("XYZ", [10, 20, 30], degrees=True)
    assert apart(attitude(t, "b.tip", -1), turned) < 1e-14


def test_at_gimbal_lock_the_signals_are_finite():
    t = start(FREE, initial=CARDAN.format(10, 90, 20))
    for name in t.select("b.phi_*"):
        assert np.isfinite(t[name]).all()
    assert t["b.phi_y"][0] == pytest.approx(np.pi / 2, abs=1e-13)
    assert t["b.phi_x"][0] + t["b.phi_z"][0] == pytest.approx(np.deg2rad(30), abs=1e-13)


LAWS = {
    "cardan": "1 N.m*sin(b.phi_x) + 2 N.m*b.phi_y - 1 N.m*b.phi_z",
    "local": "1 N.m.s*b.wx_local - 2 N.m.s*b.tip.wz_local",
    "quaternion": "3 N.m*b.p1 - 1 N.m*b.tip.p2*b.p0 + 1 N.m*b.p3",
    "rates": "1 N.m.s*der(b.phi_x) + 1 N.m.s*der(b.p2)",
}


@pytest.mark.parametrize("law", LAWS)
def test_derivatives_of_laws_of_attitude_are_exact(law):
    """A law as a variable: its gradients at an attitude against differences of its values."""
    text = SPUN.replace("initial equation", f"Real u = {LAWS[law]};\ninitial equation")
    t = mbdsl.simulate(mbdsl.parse(text), stop=0.1)
    root, q, v = t.scene.variables["u"], t.q[-1], t.v[-1]
    _, (by_q,), (by_v,) = gradients(t.system, [root], 0.0, q, v)
    h = 1e-6

    def value(q, v):
        return gradients(t.system, [root], 0.0, q, v)[0][0]

    for k in range(6):
        e = np.eye(6)[k] * h
        moved = [np.append(q[:3] + s * e[:3], turned(q[None, 3:], s * e[None, 3:])) for s in (1, -1)]
        # second-order differences: an error of h^2 times third derivatives, and rounding over h
        assert (value(moved[0], v) - value(moved[1], v)) / (2 * h) == pytest.approx(by_q[k], abs=1e-8)
        assert (value(q, v + e) - value(q, v - e)) / (2 * h) == pytest.approx(by_v[k], abs=1e-8)


def test_laws_use_attitudes():
    """A torque along the body's x axis, from its own Cardan angle, against the same body on a hinge."""
    law = "Torque drive(b.c, n = {1, 0, 0}, tau = -5 N.m*b.phi_x - 0.3 N.m.s*b.wx_local);"
    free = FREE.format(more=law, initial="b.phi_x = 1; b.wx_local = 2;")
    held = """spatial model Hinge
  Ground ground(g = 0 m/s2);
  Body b(m = 1 kg, I = {1, 2, 2.5} kg.m2);
  Revolute j(ground, b.c, n = {1, 0, 0});
  Torque drive(b.c, n = {1, 0, 0}, tau = -5 N.m*j.phi - 0.3 N.m.s*j.w);
initial equation
  j.phi = 1; j.w = 2;
end Hinge;
"""
    a, b = (mbdsl.simulate(mbdsl.parse(text), stop=1, interval=0.1, step=1e-3) for text in (free, held))
    assert a["b.phi_x"] == pytest.approx(b["j.phi"], abs=1e-9)  # tolerance of Newton's iteration, over 1000 steps
