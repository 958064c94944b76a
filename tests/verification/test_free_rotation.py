"""A body that turns freely: Euler's equations in closed form, and what all methods conserve of it.

The matrix of inertia is full: the principal axes are turned. Source: L. D. Landau, E. M. Lifshitz, Mechanics, section
37.
"""

from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import mbdsl
from mbdsl.integrators import modules

METHODS = [name for name, module in modules().items() if module.METHOD.chosen and not hasattr(module, "take")]
ORDERS = {name: modules()[name].METHOD.order for name in METHODS}
MOMENTS = np.array([3.0, 2.0, 1.2])  #: of inertia about the principal axes [kg.m2]
START = np.array([1.5, 3.0, 0.0])  #: angular velocity about these [rad/s]
AXES = Rotation.from_rotvec([0.4, -0.9, 0.7]).as_matrix()  #: principal axes in body axes
END = 2.0  #: [s]
COUNTS = (200, 400)  #: numbers of steps: of up to 0.03 rad


def text(spin=START, moments=MOMENTS):
    inertia = AXES @ np.diag(moments) @ AXES.T
    rows = ", ".join("{" + ", ".join(f"{x!r}" for x in map(float, row)) + "}" for row in (inertia + inertia.T) / 2)
    w = [f"body.w{i} = {float(x)!r} rad/s;" for i, x in zip("xyz", AXES @ spin, strict=True)]
    return f"""spatial model Free
      Ground ground(g = 0);
      Body body(m = 2 kg, I = {{{rows}}} kg.m2);
      FreeMotion free(ground, body.c);
    initial equation
      body.vx = 1 m/s; {" ".join(w)}
    end Free;"""


def expected(t):
    """Angular velocities about the principal axes; the one about the middle axis is largest at the start."""
    high, middle, low = MOMENTS
    energy, square = MOMENTS @ START**2, (MOMENTS**2) @ START**2
    fast, slow = energy * high - square, square - energy * low
    rate, k2 = np.sqrt((high - middle) * slow / (low * middle * high)), (middle - low) * fast / ((high - middle) * slow)
    assert k2 < 1.0  # otherwise the first and the third axis exchange their roles
    sn, cn, dn, _ = ellipj(rate * t + ellipk(k2), k2)
    first = np.sqrt(slow / (high * (high - low))) * dn
    second = np.sqrt(fast / (middle * (high - middle))) * sn
    third = -np.sqrt(fast / (low * (high - low))) * cn
    return np.stack([first, second, third], axis=-1)


def run(method, steps):
    return mbdsl.simulate(mbdsl.parse(text()), method=method, step=END / steps, stop=END, interval=END / 10)


def momentum(t):
    """In world axes."""
    R = Rotation.from_quat(np.stack([t[f"body.p{k}"] for k in (1, 2, 3, 0)], axis=-1))
    return R.apply(t.v[:, 3:] @ (AXES @ np.diag(MOMENTS) @ AXES.T))


@pytest.mark.parametrize("method", METHODS)
def test_orders(method):
    """Angular velocities, and the moment of momentum, which depends on the attitude."""
    off = []
    for steps in COUNTS:
        t = run(method, steps)
        L = momentum(t)
        off.append([np.abs(t.v[:, 3:] @ AXES - expected(t.t)).max(), np.abs(L - L[0]).max()])
        assert t["body.x"] == pytest.approx(t.t, abs=1e-12)  # the centre of mass moves with 1 m/s
    assert np.log2(np.divide(*off)) == pytest.approx(ORDERS[method], abs=0.15)
    assert off[1][0] < (0.05 if ORDERS[method] == 1 else 2e-3)


def test_closed_form_to_rounding():
    """dop853 with a tolerance of 1e-11 over one flip; disturbances grow near the unstable axis."""
    t = mbdsl.simulate(mbdsl.parse(text()), method="dop853", tol=1e-11, stop=5.0, interval=0.1)
    np.testing.assert_allclose(t.v[:, 3:] @ AXES, expected(t.t), rtol=0, atol=1e-10)
    L, E = momentum(t), t["energy.total"]
    np.testing.assert_allclose(L, np.broadcast_to(L[0], L.shape), rtol=0, atol=1e-10)
    np.testing.assert_allclose(E, E[0], rtol=1e-11)


@pytest.mark.parametrize("method", [m for m in METHODS if ORDERS[m] == 2])
def test_energy_stays_bounded(method):
    """Over 100 s, or 300 rad: dissipation is of order h^3, and far below one part in a thousand of the energy."""
    t = mbdsl.simulate(mbdsl.parse(text()), method=method, step=5e-3, stop=100.0, interval=1.0)
    E = t["energy.total"]
    assert np.abs(E / E[0] - 1.0).max() < 1e-3
    assert np.linalg.norm(momentum(t), axis=1) == pytest.approx(np.linalg.norm(momentum(t)[0]), rel=1e-3)


def test_steady_spin_is_exact():
    """About a principal axis the attitude is exact in any step: exponentials about one axis add."""
    for h in (0.01, 0.1, 0.5):
        t = mbdsl.simulate(mbdsl.parse(text(np.array([3.0, 0, 0]))), step=h, stop=5.0, interval=0.5)
        R = Rotation.from_quat([t[f"body.p{k}"][-1] for k in (1, 2, 3, 0)])
        away = R.inv() * Rotation.from_rotvec(15.0 * AXES[:, 0])
        assert away.magnitude() < 1e-12
        assert not t.stats["warnings"]  # outputs show the turns: 1.5 rad apart


@pytest.mark.parametrize(("angle", "warned"), [(3.0, False), (3.3, True)])
def test_half_a_turn_in_a_step_is_reported(angle, warned):
    t = mbdsl.simulate(mbdsl.parse(text(np.array([0.01, angle / 1e-3, 0.01]))), step=1e-3, stop=0.05, interval=0.01)
    found = [warning for warning in t.stats["warnings"] if "half a turn" in warning]
    assert bool(found) == warned
    if warned:
        assert found[0].startswith(
            "body turns by 3.3 rad in a step of 0.001 s, first by more than half a turn at t = 0 s:"
        )
        step = float(found[0].partition("try a step of ")[2].split()[0])
        assert step * angle / 1e-3 < 0.5


# -- a body that flips over and over: the smallest tolerances -----------------------------------------------------


def flips(moments, start, times):
    """Euler's equations by Taylor series of degree 24 with 30 digits, in steps of at most 1/4 of a radian."""
    with localcontext() as digits:
        digits.prec = 30
        a, b, c = map(Decimal, moments)
        factors = (b - c) / a, (c - a) / b, (a - b) / c
        w, found = [Decimal(x) for x in start], [start]
        for before, after in pairwise(times):
            count = int(np.ceil((after - before) * max(map(abs, start)) / 0.25))
            h = (Decimal(after) - Decimal(before)) / count
            for _ in range(count):
                x = [[value] for value in w]
                for n in range(24):
                    rates = [
                        k * sum(p * q for p, q in zip(x[i - 2], reversed(x[i - 1]), strict=True)) / (n + 1)
                        for i, k in enumerate(factors)
                    ]
                    for series, rate in zip(x, rates, strict=True):
                        series.append(rate)
                w = [sum(value * h**n for n, value in enumerate(series)) for series in x]
            found.append([float(value) for value in w])
    return np.array(found)


@pytest.mark.parametrize("start", [(0.01, 5.0, 0.0), (0.1, 10.0, 0.1)])
def test_a_flipping_body_is_not_refused(start):
    """Its axis stays near the unstable one, where rounding of the other two velocities is as small as they are: the
    error that is stated covers the true one, and is within a tolerance that the run keeps."""
    values = " ".join(f"body.w{i} = {x} rad/s;" for i, x in zip("xyz", start, strict=True))
    t = mbdsl.simulate(
        mbdsl.parse(f"""spatial model Flips
          Ground ground(g = 0); Body body(m = 1 kg, I = {{2, 3, 4}} kg.m2); FreeMotion free(ground, body.c);
        initial equation {values}
        end Flips;"""),
        method="dop853",
        tol=1e-10,
        stop=10.0 if start[0] < 0.1 else 5.0,
        interval=0.5,
    )
    error = np.abs(t.v[:, 3:] - flips((2, 3, 4), start, list(t.t))).max() / max(start)
    assert error < t.stats["error"] < 1e-10
