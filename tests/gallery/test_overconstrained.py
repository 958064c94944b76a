"""Mechanisms in space with more constraints than their motion needs: they move, and the redundant rows are named.

The number of redundant rows of a linkage with mobility f is rows - coordinates + f: three for each planar loop of
hinges with parallel axes, three for Bennett's linkage (20 rows on 18 coordinates, f = 1).
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.compilation import code_cache
from mbdsl.initial.consistent import initial_state
from mbdsl.mechanism import graph
from mbdsl.system import build
from mbdsl.system.signals import values

SPACE = Path(__file__).parents[2] / "models" / "space"


def test_bennetts_linkage():
    """Its hinges obey Bennett's equation over 3.9 turns, opposite ones turn alike, and its energy is conserved.

    The constraints hold to 1e-12 with a stabilised method; the equation multiplies errors by less than 10. The error of
    the energy is of order 2: 4e-4 J at this step, of 17 J of kinetic energy."""
    t = mbdsl.simulate(SPACE / "bennett.mbd", step=1e-3)
    theta, phi = t["J1.phi"], t["J2.phi"]
    assert theta[-1] - theta[0] > 7 * math.pi
    ratio = math.sin(math.radians(60)) / math.sin(math.radians(30))
    misfit = np.sin(theta / 2) * np.sin(phi / 2) - ratio * np.cos(theta / 2) * np.cos(phi / 2)
    assert np.abs(misfit).max() < 1e-11
    np.testing.assert_allclose(t["J3.phi"], -theta, rtol=0, atol=1e-11)
    np.testing.assert_allclose(t["J4.phi"], -phi, rtol=0, atol=1e-11)
    assert np.ptp(t["energy.total"]) < 2e-3
    assert len(t.stats["redundant"]) == 3


@pytest.mark.parametrize("method", ["hht-si2", "nstiff-si2", "newmark"])
@pytest.mark.parametrize("step", [1e-3, 2e-3])
def test_rows_stay_independent_along_the_motion(method, step):
    """Rows that are independent at the start only would stop some of these runs, in poses that differ with the step."""
    t = mbdsl.simulate(SPACE / "bennett.mbd", method=method, step=step, interval=0.05)
    kept = [k for k in range(20) if k not in t.left_out]
    for row in zip(t.t, t.q, t.v, strict=True):
        J = t.system.velocity_jacobian(*row)[kept]
        assert np.linalg.svd(J / np.abs(J).max(axis=1, keepdims=True), compute_uv=False)[-1] > 0.02


def test_explain_names_redundant_rows():
    text = str(mbdsl.explain(SPACE / "bennett.mbd", measured=False))
    assert re.search(r"(J\d.Phi\[\d\](, )?){3} left out; true mobility 1", text)
    assert "reactions of J1, J2, J3, J4 are not unique" in text


LOOPS = {
    "four-bar": (
        3,
        """Rod r1(m = 1 kg, length = 0.4*L); Rod r2(m = 1 kg, length = 1.1*L); Rod r3(m = 1 kg, length = 0.8*L);
        Frame d(ground, r = {L, 0, 0});
        Revolute A(ground, r1.a); Revolute B(r1.b, r2.a); Revolute C(r2.b, r3.b); Revolute D(d, r3.a);
        initial equation r1.phi = 60 deg; guess r3.phi = 80 deg; guess r2.phi = 20 deg;""",
    ),
    "parallelogram": (
        3,
        """Rod r1(m = 1 kg, length = 0.4*L); Rod r2(m = 1 kg, length = L); Rod r3(m = 1 kg, length = 0.4*L);
        Frame d(ground, r = {L, 0, 0});
        Revolute A(ground, r1.a); Revolute B(r1.b, r2.a); Revolute C(r2.b, r3.b); Revolute D(d, r3.a);
        initial equation r1.phi = 60 deg; guess r3.phi = 60 deg;""",
    ),
    "flat parallelogram": (  # all bars on a line: one more row is dependent, but only there
        3,
        """Rod r1(m = 1 kg, length = 0.4*L); Rod r2(m = 1 kg, length = L); Rod r3(m = 1 kg, length = 0.4*L);
        Frame d(ground, r = {L, 0, 0});
        Revolute A(ground, r1.a); Revolute B(r1.b, r2.a); Revolute C(r2.b, r3.b); Revolute D(d, r3.a);
        initial equation r1.phi = 0;""",
    ),
    "slider crank": (
        3,
        """Rod r1(m = 1 kg, length = 0.4*L); Rod r2(m = 1 kg, length = L); Body s(m = 1 kg, I = {1, 1, 1} kg.m2);
        Revolute A(ground, r1.a); Revolute B(r1.b, r2.a); Revolute C(r2.b, s.c); Prismatic D(ground, s.c);
        initial equation r1.phi = 60 deg; guess r2.phi = -20 deg;""",
    ),
    "scissor lift": (  # three loops: 11 joints, 8 bodies
        9,
        """Rod r1(m = 1 kg, length = L); Rod r2(m = 1 kg, length = L); Rod r3(m = 1 kg, length = L);
        Rod r4(m = 1 kg, length = L); Body p(m = 1 kg, I = {1, 1, 1} kg.m2);
        Body q(m = 1 kg, I = {1, 1, 1} kg.m2); Body s(m = 1 kg, I = {1, 1, 1} kg.m2);
        Revolute A(ground, r1.a); Prismatic S(ground, s.c); Revolute A2(s.c, r2.a); Revolute M1(r1.c, r2.c);
        Revolute B(r1.b, r3.a); Revolute B2(r2.b, r4.a); Revolute M2(r3.c, r4.c); Revolute P(r4.b, p.c);
        Prismatic Q(p.c, q.c); Revolute R(r3.b, q.c);
        initial equation r1.phi = 50 deg; guess r2.phi = 130 deg; guess r3.phi = 130 deg; guess r4.phi = 50 deg;""",
    ),
}


def assembled(text):
    """The system and the initial state of a model."""
    mechanism = graph.build(mbdsl.parse(text))
    with code_cache.uncompiled():
        system = build(mechanism.scene, mechanism)
        return system, initial_state(system, mechanism, 0.0)


def model(parts, length="1 m"):
    return f"spatial model M parameter Length L = {length}; Ground ground; {parts} end M;"


@pytest.mark.parametrize("name", LOOPS)
def test_planar_loops_in_space(name):
    """Only rows out of the plane are redundant: forces along z and torques about x and y."""
    number, parts = LOOPS[name]
    system, state = assembled(model(parts))
    names = [system.constraint_names()[k] for k in state.redundant]
    assert len(names) == number
    assert {name.partition(".")[2] for name in names} <= {"Phi[3]", "Phi[4]", "Phi[5]"}


@pytest.mark.parametrize("length", ["2e-6 m", "1 mm", "3 km"])
def test_redundancy_does_not_depend_on_size(length):
    expected = assembled(model(LOOPS["four-bar"][1]))[1].redundant
    assert assembled(model(LOOPS["four-bar"][1], length))[1].redundant == expected


TILTED = """
  Frame base(ground, r = {0.3, -0.2, 0.7} m, n = {1, 2, -0.4}, phi = 1 rad);
  Frame d(ground, r = {0.3 + XX, -0.2 + XY, 0.7 + XZ} m, n = {1, 2, -0.4}, phi = 1 rad);
  Rod r1(m = 1 kg, length = 0.4 m); Rod r2(m = 1 kg, length = 1.1 m); Rod r3(m = 1 kg, length = 0.8 m);
  Revolute A(base, r1.a); Revolute B(r1.b, r2.a); Revolute C(r2.b, r3.b); Revolute D(d, r3.a);
  initial equation A.phi = 60 deg; guess B.phi = -40 deg; guess C.phi = 60 deg;"""


def test_redundancy_does_not_depend_on_the_axes_of_the_world():
    """The four-bar of LOOPS, turned about a skew axis: every entry of the Jacobian has rounding errors."""
    n, e = np.array([1.0, 2.0, -0.4]) / np.linalg.norm([1.0, 2.0, -0.4]), np.array([1.0, 0.0, 0.0])
    x = np.cos(1.0) * e + np.sin(1.0) * np.cross(n, e) + (1 - np.cos(1.0)) * n * n[0]  # Rodrigues' formula
    text = TILTED
    for key, value in zip("XYZ", x, strict=True):
        text = text.replace(f"X{key}", f"({float(value)!r})")
    _, state = assembled(model(text))
    assert len(state.redundant) == 3


def test_bricards_linkage_has_one_redundant_row():
    _, state = assembled((SPACE / "bricard.mbd").read_text(encoding="utf-8"))
    assert len(state.redundant) == 1


DOOR = """spatial model Door
  Ground ground(n = {0, 0, -1});
  Body door(m = 20 kg, I = {3, 2, 1} kg.m2, frames(low = {-0.5, 0, -1} m, high = {-0.5, 0, 1} m));
  Frame low(ground, r = {0, 0, -1} m);
  Frame high(ground, r = {0, 0, 1} m);
  Revolute LOW(low, door.low);
  Revolute HIGH(high, door.high);
initial equation
  LOW.w = 2 rad/s;
annotation(experiment(StopTime = 0.5 s));
end Door;"""


def test_hinges_of_a_door_share_the_load():
    """Two hinges on one axis, 5 redundant rows. The reactions of least norm do not depend on which hinge comes first.

    Half of the weight W and of the centripetal force F on each hinge. The moment W c about the middle is balanced by
    forces f at +-d and torques u on both: 2 d f + 2 u = W c, and L^2 f^2 + u^2 is smallest for f/u = d/L^2.
    The error of hht-si2 is 4e-6 N at this step (and 4e-4 N at the tenfold)."""
    weight, c, d, centripetal = 20 * 9.81, 0.5, 1.0, 20 * 0.5 * 2.0**2
    first = mbdsl.simulate(mbdsl.parse(DOOR), step=1e-3, interval=0.1)
    lines = DOOR.splitlines()
    lines[5], lines[6] = lines[6], lines[5]
    second = mbdsl.simulate(mbdsl.parse("\n".join(lines)), step=1e-3, interval=0.1)
    assert {name.split(".")[0] for name in first.stats["redundant"]} == {"HIGH"}
    assert {name.split(".")[0] for name in second.stats["redundant"]} == {"LOW"}
    for t in first, second:
        assert set(t.stats["not unique"]) == {
            f"{j}.{key}" for j in ("LOW", "HIGH") for key in ("fx", "fy", "fz", "tx", "ty", "f", "t")
        }
        u = weight * c / 2 / (1 + (d / t.system.tables.size) ** 2)
        f = u * d / t.system.tables.size**2
        along, across = np.cos(t["LOW.phi"]), np.sin(t["LOW.phi"])
        for j, side in (("LOW", 1), ("HIGH", -1)):
            pull = side * f - centripetal / 2
            expected = {"fx": pull * along, "fy": pull * across, "fz": weight / 2, "tx": u * across, "ty": -u * along}
            for key, value in expected.items():
                np.testing.assert_allclose(t[f"{j}.{key}"], value, rtol=0, atol=1e-6 * weight)


@pytest.mark.parametrize(
    ("frame", "gap"),
    [("r = {L, 0, 0.02*L}", "0.02 m"), ("r = {L, 0, 0}, n = {0, 1, 0}, phi = 2 deg", "2 deg")],
)
def test_loops_that_do_not_close_name_the_gap(frame, gap, tmp_path, capsys):
    """A four-bar whose last hinge is beside the plane, or tilted: open by just that if the other hinges are closed."""
    path = tmp_path / "m.mbd"
    path.write_text(model(LOOPS["four-bar"][1].replace("r = {L, 0, 0}", frame)), encoding="utf-8")
    assert main(["simulate", str(path), "--stop", "0.1"]) == 3
    assert f"Revolute D is open by {gap} if all others are closed" in capsys.readouterr().err


HELD = """spatial model Held
  Ground ground;
  Frame tilted(ground, n = {1, 0, 0}, phi = 170 deg);
  Body body(m = 1 kg, I = {1, 1, 1} kg.m2);
  JOINTS
end Held;"""


@pytest.mark.parametrize(
    "joints",
    [
        "Spherical ball(ground, body.c); Planar J(tilted, body.c);",
        "PointOnPlane plane(ground, body.c); Prismatic J(tilted, body.c);",
        "PointOnPlane plane(ground, body.c); Cylindrical J(tilted, body.c, n = {0, 0, 1});",
    ],
)
def test_mirrored_poses_are_left(joints):
    """The assembly starts 170 degrees beside the pose, and 10 degrees beside the mirrored one."""
    system, state = assembled(HELD.replace("JOINTS", joints))
    assert not state.mirrored
    rest = np.zeros((1, system.n))
    found = [
        values(system, [system.scene.signal(f"body.c.z{i}")], np.zeros(1), state.q[None], rest)[0][0] for i in "xyz"
    ]
    turn = math.radians(170)
    assert found == pytest.approx([0.0, -math.sin(turn), math.cos(turn)], abs=1e-12)


def test_mirrored_poses_that_cannot_be_left_are_reported():
    """The last hinge of a four-bar is upside down: its line is right, its sense is not."""
    parts = LOOPS["four-bar"][1].replace(
        "Revolute D(d, r3.a)", "Frame e(r3, r = {-0.4*L, 0, 0}, n = {1, 0, 0}, phi = pi); Revolute D(d, e)"
    )
    _, state = assembled(
        model(parts.replace("Revolute C(r2.b, r3.b); ", "").replace("initial", "Revolute C(r2.b, r3.b); initial"))
    )
    assert len(state.mirrored) == 1


def test_redundant_rows_are_watched():
    """Two drivers turn both rockers of a parallelogram alike until 0.05 s, then differently: a driver that was left out
    is violated by (t - 0.05 s)^2 rad/s2, above 1e-6 rad from 0.051 s on; output each 10 ms."""
    drivers = """RotationalDriver first(ground, r1.a, phi = 1 rad + 2 rad/s*time);
        RotationalDriver second(d, r3.a, phi = 1 rad + 2 rad/s*time + 1 rad/s2*max(time - 0.05 s, 0 s)^2); initial"""
    text = model(LOOPS["parallelogram"][1].replace("initial", drivers).replace("r1.phi = 60 deg; ", ""))
    violated = r"second.Phi\[1\] was redundant .* violated from t = "
    with pytest.raises(mbdsl.IntegrationError, match=violated + "0.06 s on") as bad:
        mbdsl.simulate(mbdsl.parse(text), step=1e-3, interval=0.01, stop=0.1, general=True)
    assert bad.value.trajectory.t[-1] == pytest.approx(0.06)
    # between outputs, the state of a long run is looked at after parts of a second: 1e6 steps take many seconds
    with pytest.raises(mbdsl.IntegrationError, match=violated) as bad:
        mbdsl.simulate(mbdsl.parse(text), step=1e-5, interval=10.0, stop=10.0, general=True)
    assert bad.value.trajectory.stats["steps"] < 500_000
    assert 0.051 < bad.value.trajectory.t[-1] < 5.0


def test_errors_of_all_constraints_are_no_violation_of_a_redundant_one():
    """dop853 satisfies constraints up to its tolerance: in Bennett's linkage by 1e-5 of its size, redundant or not."""
    model = Path(__file__).parents[2] / "models" / "space" / "bennett.mbd"
    t = mbdsl.simulate(model, method="dop853", tol=1e-3, stop=1.5, interval=0.01)
    assert t.stats["error"] < 1e-3
