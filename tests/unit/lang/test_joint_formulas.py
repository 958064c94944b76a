"""The formulas of joints against mechanics: reactions, friction, constraints of velocities."""

import math

import numpy as np
import pytest

from mbdsl.elements import loaded, modules
from mbdsl.elements.declaration import REQUIRED
from mbdsl.elements.kind import JointKind
from mbdsl.expressions import derivatives
from mbdsl.expressions import symbolic as ex
from mbdsl.expressions.symbolic import COORDINATES
from mbdsl.kernels.columns import PLANE as C
from mbdsl.lang.load import parse_text
from mbdsl.system import row_kernels

BEFORE = "model M Ground ground; Rod a(m = 1, length = 1); Rod b(m = 1, length = 1); "
JOINTS = {name: m for name, m in modules().items() if isinstance(m.KIND, JointKind)}
MOVING = [name for name, m in JOINTS.items() if m.KIND.velocity_rows and m.KIND.ports]
#: rounding of a few dozen operations on numbers of order 1
ROUNDING = 1e-13
SLOPE = 0.3


def scene(text):
    return parse_text(f"{BEFORE}{text} end M;")


def with_joint(name):
    """A scene with a component of the kind between two rods, with all required parameters set to 1, the radius of a
    second circle to 2, and functions of a coordinate to ``SLOPE`` times this coordinate."""
    kind = JOINTS[name].KIND
    chosen = {"r_b": "2"} | ({kind.coupling[0]: f"{SLOPE}*{kind.coupling[1]}"} if kind.coupling else {})
    needed = [p.name for p in kind.parameters if p.default is REQUIRED or p.name in ("length", "radius") or p.law]
    given = ", ".join(f"{name} = {chosen.get(name, '1')}" for name in needed)
    return scene(f"{name} j(a.b, b.a, {given});" if given else f"{name} j(a.b, b.a);")


def joint(name):
    return with_joint(name).components["j"]


def frames(rng):
    """Rows x, y, phi, vx, vy, w of frames a.b and b.a."""
    return rng.uniform(-1.5, 1.5, (2, 6))


def value(expression, Z, lam=()):
    def leaf(node):
        if node.op == "multiplier":
            return lam[node.value[1]]
        frame, key = node.value
        return Z[["a.b", "b.a"].index(frame), COORDINATES.index(key)]

    return ex.evaluate([expression], leaf)[0]


@pytest.mark.parametrize("name", [n for n in JOINTS if JOINTS[n].KIND.ports])
def test_reactions_are_the_constraint_force_on_frame_b(name, plain):
    """-G^T lam of the kernel, and of the velocity rows with their derivative by the velocity of frame_b."""
    module, component, rng = JOINTS[name], joint(name), np.random.default_rng(1)
    kind = module.KIND
    Z, lam = frames(rng), rng.uniform(-1, 1, kind.rows + len(kind.velocity_rows))
    G = np.zeros((3, C.VALUE + 1))
    if kind.rows:
        p = (0.0, SLOPE, 0.0) if kind.coupling else kind.table(component.values)
        plain(row_kernels.module(module).gradient)(Z, 0, 1, p, G)
    force = -G[: kind.rows, 3:6].T @ lam[: kind.rows]
    velocities = [ex.coordinate("b.a", key) for key in ("vx", "vy", "w")]
    for row, multiplier in zip(component.velocity_constraints, lam[kind.rows :], strict=True):
        force -= multiplier * np.array([value(d, Z) for d in derivatives.diff(row, *velocities)])
    by_name = {x.name: value(with_joint(name).signal(f"j.{x.name}"), Z, lam) for x in kind.reactions}
    assert [by_name.get(key, 0.0) for key in ("fx", "fy", "tau")] == pytest.approx(force, abs=ROUNDING)
    assert all(by_name.values()), "a reaction that is always zero is none"


@pytest.mark.parametrize(("name", "at"), [("Distance", 0.6 + 0.8j), ("RollingDisc", 5 + 1j)])
def test_what_is_given_as_1_is_kept(name, at, plain):
    """A link of length 1, and a disc whose centre is by 1 above its line."""
    Z, G, component = frames(np.random.default_rng(1)), np.zeros((3, C.VALUE + 1)), joint(name)
    place = complex(*Z[0, :2]) + np.exp(1j * Z[0, 2]) * at
    Z[1, :2] = place.real, place.imag
    plain(row_kernels.module(JOINTS[name]).gradient)(Z, 0, 1, component.kind.table(component.values), G)
    assert G[0, C.VALUE] == pytest.approx(0.0, abs=ROUNDING)


@pytest.mark.parametrize("name", MOVING)
def test_a_common_rigid_motion_violates_no_velocity_row(name):
    component, rng = joint(name), np.random.default_rng(2)
    Z = frames(rng)
    moved = Z.copy()
    v, w = rng.uniform(-1, 1, 2), 0.7
    moved[:, 3] += v[0] - w * Z[:, 1]
    moved[:, 4] += v[1] + w * Z[:, 0]
    moved[:, 5] += w
    (row,) = component.velocity_constraints
    assert abs(value(row, Z)) > 1e-3
    assert value(row, moved) == pytest.approx(value(row, Z), abs=ROUNDING)


def test_material_points_of_disc_and_line_meet_without_slip():
    """The disc's lowest point and the point of the (moving, turning) line below it have one velocity along the line."""
    component, rng = joint("RollingDisc"), np.random.default_rng(3)
    Z = frames(rng)
    t = np.array([math.cos(Z[0, 2]), math.sin(Z[0, 2])])
    n = np.array([-t[1], t[0]])
    contact = Z[0, :2] + 0.4 * t
    Z[1, :2] = contact + 1.0 * n  # radius 1

    def velocity(frame, point):
        x, y = point - Z[frame, :2]
        return Z[frame, 3:5] + Z[frame, 5] * np.array([-y, x])

    (row,) = component.velocity_constraints
    assert value(row, Z) == pytest.approx(t @ (velocity(1, contact) - velocity(0, contact)), abs=ROUNDING)
    # across the line, the contact point moves with the line, as the disc neither lifts off nor penetrates
    Z[1, 3:5] += velocity(0, contact) - velocity(1, contact)
    assert value(row, Z) == pytest.approx(0.0, abs=ROUNDING)


def test_knife_edge_slides_forwards_only():
    component = joint("KnifeEdge")
    (row,) = component.velocity_constraints
    Z = np.zeros((2, 6))
    Z[1] = 0.3, 0.2, 0.5, math.cos(0.5), math.sin(0.5), 3.0
    assert value(row, Z) == pytest.approx(0.0, abs=ROUNDING)
    assert value(with_joint("KnifeEdge").signal("j.v"), Z) == pytest.approx(1.0)
    Z[1, 3:5] = -math.sin(0.5), math.cos(0.5)
    assert value(row, Z) == pytest.approx(1.0)


# -- friction ------------------------------------------------------------------------------------------------------


def test_no_friction_leaves_no_trace():
    for component in scene("Revolute p(a.b, b.a, radius = 1 cm); Prismatic q(a.c, b.c);").components.values():
        assert component.friction is None
        assert "friction" not in component.signals


@pytest.mark.parametrize(
    ("joint", "exact"),
    [
        ("Revolute j(a.b, b.a, mu = 0.3, radius = 0.1)", lambda v: 0.1 * 5.0 * 0.3 * math.tanh(v / 0.01)),
        ("Revolute j(a.b, b.a, mu = 0.3, mu_s = 0.3, radius = 0.1, w_s = 2)", lambda v: 0.15 * math.tanh(v / 2)),
        (
            "Revolute j(a.b, b.a, mu = 0.3, mu_s = 0.5, radius = 0.1, w_s = 0.2)",
            lambda v: 0.5 * (0.3 + 0.2 * math.exp(-((v / 8.0) ** 2))) * math.tanh(v / 0.2),
        ),
        (
            "Revolute j(a.b, b.a, mu_s = 0.5, radius = 0.1, w_st = 1)",
            lambda v: 0.5 * (0.5 * math.exp(-(v**2))) * math.tanh(v / 0.01),
        ),
    ],
)
def test_friction_of_a_pin(joint, exact):
    found = scene(f"{joint};")
    component = found.components["j"]
    assert component.friction is found.signal("j.friction")
    assert component.kind.unit_of("friction") == "N.m"
    for v in (0.0, 0.004, 0.6, -0.6):
        Z = np.zeros((2, 6))
        Z[0, 5], Z[1, 5] = 1.0, 1.0 + v
        assert value(component.friction, Z, (3.0, 4.0)) == pytest.approx(exact(v), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("kind", ["Prismatic", "PointOnLine"])
def test_friction_of_a_slide(kind):
    component = scene(f"{kind} j(a.b, b.a, mu = 0.2, v_s = 0.1);").components["j"]
    assert component.kind.unit_of("friction") == "N"
    Z = np.zeros((2, 6))
    Z[0, 2] = Z[1, 2] = math.pi / 2
    Z[1, 4] = 0.05  # along x of frame_a
    for lam in (-7.0, 7.0):
        assert value(component.friction, Z, (lam, 1.0)) == pytest.approx(7.0 * 0.2 * math.tanh(0.5))


def test_speeds_from_which_friction_slides():
    """The defaults named by docs/language.md: 0.01 rad/s and 1 mm/s."""
    found = scene(
        "Revolute r(a.b, b.a, mu = 1, radius = 1); Prismatic p(a.b, b.a, mu = 1); PointOnLine l(a.b, b.a, mu = 1);"
    ).components
    assert (found["r"].values["w_s"], found["p"].values["v_s"], found["l"].values["v_s"]) == (0.01, 0.001, 0.001)


def test_equal_coefficients_need_no_exponential():
    equal, falling = (
        scene(f"PointOnLine j(a.b, b.a, mu = 0.2{more});").components["j"].friction for more in ("", ", mu_s = 0.3")
    )
    assert "exp" not in {n.op for n in ex.walk(equal)}
    assert "exp" in {n.op for n in ex.walk(falling)}


@pytest.mark.parametrize("name", [n for n in JOINTS if JOINTS[n].KIND.friction_along])
def test_friction_acts_along_the_coordinate_whose_rate_it_resists(name, plain):
    kind, Z, G = JOINTS[name].KIND, frames(np.random.default_rng(4)), np.zeros((1, C.VALUE + 1))
    plain(row_kernels.module(loaded(f"mbdsl.elements.{kind.friction_along}")).gradient)(Z, 0, 1, (), G)
    rate = G[0, :3] @ Z[0, 3:] + G[0, 3:6] @ Z[1, 3:]
    signal = "j.w" if kind.resistance[0].unit == "N.m" else "j.v"
    assert value(with_joint(name).signal(signal), Z) == pytest.approx(rate)


# -- in laws -------------------------------------------------------------------------------------------------------


def test_reactions_in_laws_and_variables():
    found = scene("Revolute p(a.b, b.a); Torque t(p, tau = 0.1 m*p.fx); Real load = hypot(p.fx, p.fy);")
    fx, fy = -ex.multiplier("p", 0), -ex.multiplier("p", 1)
    assert found.components["t"].values["tau"] is 0.1 * fx
    assert found.variables["load"] is ex.call("hypot", fx, fy)
    assert found.signal("p.fx") is fx
    (partial,) = derivatives.diff(found.components["t"].values["tau"], ex.multiplier("p", 0))
    assert ex.is_const(partial, -0.1)


def test_velocity_drivers_demand_their_law_and_measure_what_is():
    found = scene("RotationalVelocityDriver d(a.b, b.a, w = 3 rad/s + a.w); Real measured = d.w;")
    measured = ex.coordinate("b.a", "w") - ex.coordinate("a.b", "w")
    d = found.components["d"]
    assert d.velocity_constraints == (measured - d.values["w"],)
    assert {leaf.value for leaf in ex.leaves(found.variables["measured"])} == {("b.a", "w"), ("a.b", "w")}
    assert d.kind.driver is None


@pytest.mark.parametrize("gamma", ["a.w + 2*b.w", "hypot(a.vx, a.vy) - 2 m/s", "der(a.phi)*a.vx", "a.vx*1 kg + time*2"])
def test_velocity_constraint_of_any_unit(gamma):
    found = scene(f"VelocityConstraint c(gamma = {gamma});")
    component = found.components["c"]
    assert component.velocity_constraints == (component.values["gamma"],) == (found.signal("c.gamma"),)
    assert not component.ports and component.kind.rows == 0
