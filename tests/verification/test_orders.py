"""The slider crank of Negrut, Jay and Khude: errors fall with each method's order, in q, v and reactions.

Reference: angle and angular velocity at T = 2 s in 18 digits from the one-degree-of-freedom ODE; the reactions follow
from them by Newton's and Euler's equations of crank and rod, written here by hand.
"""

import numpy as np
import pytest

import mbdsl

HHT = ["hht-i3", "hht-add", "hht-si2"]
#: Five halvings; the smallest errors are 1e-7, far above rounding. The BDF methods, which err four times as much as
#: HHT, need shorter steps to be asymptotic; newmark's error in A.fx changes its sign at 2^-6 s; and below 2^-12 s what
#: Newton's iteration leaves, over h^2, shows in the multipliers of hht-i3.
LONGEST = 2.0**-6
NEWMARK = [2.0**-k for k in range(9, 15)]
LOW, HIGH = 1.85, 2.15


def reactions(theta, omega, m1=3.0, L1=0.3, m2=0.9, L2=0.6, k=100.0, c=5.0, g=9.81):
    """Forces of the joints on the crank (O) and the rod (A, B) in a state of the mechanism.

    Unknowns: both angular accelerations, O, A, and N in B. Equations: the loop L1 sin(theta) + L2 sin(phi) = 0
    differentiated twice; crank: centre of mass, moments about O; rod: centre of mass, moments about it.
    """

    def along(x):
        return np.array([np.cos(x), np.sin(x)])

    def across(x):
        return np.array([-np.sin(x), np.cos(x)])

    phi = -np.arcsin(L1 / L2 * np.sin(theta))
    rate = -L1 * np.cos(theta) * omega / (L2 * np.cos(phi))
    e1, n1, e2, n2 = along(theta), across(theta), along(phi), across(phi)
    x, v = (L1 * e1 + L2 * e2)[0], (L1 * n1 * omega + L2 * n2 * rate)[0]
    spring = -k * (x - (L1 + L2)) - c * v
    A, b = np.zeros((7, 7)), np.zeros(7)
    A[0, :2] = L1 * np.cos(theta), L2 * np.cos(phi)
    b[0] = L1 * np.sin(theta) * omega**2 + L2 * np.sin(phi) * rate**2
    A[1:3, 0], A[1:3, 2:4], A[1:3, 4:6] = m1 * L1 / 2 * n1, -np.eye(2), np.eye(2)
    b[1:3] = m1 * L1 / 2 * e1 * omega**2 + (0.0, -m1 * g)
    A[3, 0], A[3, 4:6] = m1 * L1**2 / 3, L1 * n1
    b[3] = -m1 * g * L1 / 2 * np.cos(theta)
    A[4:6, 0], A[4:6, 1], A[4:6, 4:6], A[5, 6] = m2 * L1 * n1, m2 * L2 / 2 * n2, -np.eye(2), -1.0
    b[4:6] = m2 * (L1 * e1 * omega**2 + L2 / 2 * e2 * rate**2) + (spring, -m2 * g)
    A[6, 1], A[6, 4:6], A[6, 6] = m2 * L2**2 / 12, L2 / 2 * n2, -L2 / 2 * np.cos(phi)
    b[6] = -L2 / 2 * np.sin(phi) * spring
    return dict(zip(("O.fx", "O.fy", "A.fx", "A.fy", "B.fy"), np.linalg.solve(A, b)[2:], strict=True))


@pytest.fixture(scope="module")
def exact(reference):
    row = reference("slider_crank")["reference"]["A1_crank_along_plus_x_undeformed c=5.0 T=2"]
    theta, omega = float(row["theta1"]), float(row["omega1"])
    return {"crank.phi": theta, "crank.w": omega, "rod.w": float(row["omega2"]), **reactions(theta, omega)}


@pytest.fixture(scope="module")
def steps(halved):
    """``steps(method)``."""
    return lambda method: NEWMARK if method == "newmark" else halved(method, LONGEST)


@pytest.fixture(scope="module")
def errors(model, exact, steps):
    """``errors(method, **options)``: name -> its error at T = 2 s for each of the steps."""
    scene, known = mbdsl.load(model("slider_crank")), {}

    def find(method, **options):
        key = (method, *options.items())
        if key not in known:
            ends = []
            for h in steps(method):
                end = mbdsl.simulate(scene, method=method, step=h, interval=2.0, options=options)
                ends.append({name: abs(end[name][-1] - value) for name, value in exact.items()})
            known[key] = {name: [end[name] for end in ends] for name in exact}
        return known[key]

    return find


def test_order_of_positions_velocities_and_reactions(errors, steps, any_order, wrong_orders):
    assert not wrong_orders(any_order, steps(any_order), errors(any_order))


@pytest.mark.parametrize("method", HHT)
@pytest.mark.parametrize("alpha", [-1 / 3, -0.2, -0.05, 0.0])
def test_order_with_other_damping(errors, steps, order, method, alpha):
    # alpha = 0 is the trapezoidal rule, which lets any disturbance of the multipliers ring on: q and v only
    for name in ("crank.phi", "crank.w") + (() if alpha == 0.0 else ("O.fx", "A.fy", "B.fy")):
        assert LOW < order(steps(method), errors(method, alpha=alpha)[name]) < HIGH, name


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_order_with_other_radii(errors, steps, order, rho):
    # the damping of rho = 0 goes with h^3, and is visible in the angle in comparison with h^2
    for name in ("crank.phi", "crank.w", "O.fx", "A.fy", "B.fy"):
        found = errors("generalized-alpha", rho=rho)[name]
        assert LOW < order(steps("generalized-alpha")[-3:], found[-3:]) < HIGH, name


@pytest.mark.parametrize(("gamma", "expected"), [(0.5, 2), (0.6, 1), (0.9, 1)])
def test_gamma_of_newmark(order, gamma, expected):
    """Only gamma = 1/2, which constraints do not bear, is of second order: a body without joints, on a spring."""
    errors = []
    for h in NEWMARK:
        b = mbdsl.Builder("Oscillator")
        body = b.Body("body", m=2.0, I=0.1)
        b.Bushing("spring", b.Ground("ground", g=0.0), body.c, k=(200.0, 200.0), k_phi=1.0)
        b.initial(body.x, 0.1)
        end = mbdsl.simulate(b, method="newmark", step=h, stop=1.0, interval=1.0, options={"gamma": gamma})
        errors.append(abs(end["body.x"][-1] - 0.1 * np.cos(10.0)))
    assert expected - 0.1 < order(NEWMARK, errors) < expected + 0.1


def test_error_grows_with_damping(errors):
    """The parameter has an effect: alpha = -1/3 is less accurate than alpha = 0, by about a third."""
    for method in HHT:
        least, most = (errors(method, alpha=alpha)["crank.w"][-1] for alpha in (0.0, -1 / 3))
        assert 1.2 * least < most < 3.0 * least


def test_constraints_on_positions(model, method):
    """Newton's method stops where a position is right to 1e-4 of the local error h^4 |a|: 1e-4 * 1.5e-11 * 1e3."""
    found = mbdsl.simulate(model("slider_crank"), method=method, step=2.0**-9, interval=0.0)
    assert max(np.abs(found[name]).max() for name in found.select(["*.Phi[*]"])) < 2e-12


def test_undamped_end_state(model, reference, steps, order):
    row = reference("slider_crank")["reference"]["A1_crank_along_plus_x_undeformed c=0.0 T=2"]
    found = []
    for h in steps("hht-si2"):
        end = mbdsl.simulate(model("slider_crank"), method="hht-si2", step=h, interval=2.0, parameters={"c": 0.0})
        found.append(abs(end["crank.phi"][-1] - float(row["theta1"])))
    assert LOW < order(steps("hht-si2")[1:], found[1:]) < HIGH


def test_reactions_by_hand_agree_with_accelerations(model, exact, reference):
    """The hand-written equations against the system's own, at the reference state: no integration involved."""
    from mbdsl.mechanism import graph
    from mbdsl.system import build
    from mbdsl.system.accelerations import accelerations

    scene = mbdsl.load(model("slider_crank"))
    system = build(scene, graph.build(scene))
    row = reference("slider_crank")["reference"]["A1_crank_along_plus_x_undeformed c=5.0 T=2"]
    th, om, w2 = (float(row[k]) for k in ("theta1", "omega1", "omega2"))
    ph = -np.arcsin(np.sin(th) / 2)
    c, s, cp, sp = np.cos(th), np.sin(th), np.cos(ph), np.sin(ph)
    q = np.array([0.15 * c, 0.15 * s, th, 0.3 * c + 0.3 * cp, 0.3 * s + 0.3 * sp, ph])
    v = np.array([-0.15 * s * om, 0.15 * c * om, om, -0.3 * s * om - 0.3 * sp * w2, 0.3 * c * om + 0.3 * cp * w2, w2])
    _, lam = accelerations(system, 2.0, q, v)
    system.evaluate(2.0, q, v, lam)
    force = -system.gradient_table()[:5, 3:5] * lam[:, None]
    first = system.tables.rows
    found = {j: force[first[j] : first[j] + (1 if j == "B" else 2)].sum(axis=0) for j in "OAB"}
    for name, value in exact.items():
        if "." in name and name[0] in "OAB":
            # reference states are right to rounding; the solve's condition number is some 1e3
            assert found[name[0]]["xy".index(name[-1])] == pytest.approx(value, abs=1e-11)
