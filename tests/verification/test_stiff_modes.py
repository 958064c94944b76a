"""Modes far too fast for the step (h w of 1e3 to 1e5): numerical damping removes them at its rate, without other
effects.

In the limit h w -> inf the amplification matrices have, by hand,

* HHT: a double eigenvalue -(1 + alpha)/(1 - alpha) and alpha/(1 + alpha), all 1/2 in size for alpha = -1/3;
* newmark with beta = (gamma + 1/2)^2/4: a double one (gamma - 3/2)/(gamma + 1/2);
* BDF2: zero, twice for each of its two formulas.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError

# -- one axial mode, pulled at from a time on --------------------------------------------------------------------------

H, N, JUMP = 1e-3, 60, 11  #: the force begins at step 11
#: h w. hht-add has M^{-1} Q in its equations: what rounding and Newton's method leave in q is multiplied by w^2 there;
#: at 1e4 its rates are disturbed by some percent now and then.
HW = {"hht-add": 100.0}


def pulled(method, hw=1e4, **options):
    """Rates of the axial mode of a pinned rod, as parts of static displacement over h, from the first step with the
    force on; and its displacement at the end, as part of the static one."""
    b = mbdsl.Builder("Pull")
    ground = b.Ground("ground", g=0.0)
    E = (hw / H / (np.pi / 2)) ** 2 * 2.0 / 1e-4
    rod = b.FlexibleBeam(
        "rod", mass=2.0, length=1.0, S=1e-4, I=1e-8, E=E, elements=64, modes=1, axial=1, stiffening=False
    )
    b.Revolute("A", ground, rod.a)
    b.Force("F", rod.b, rod.b, fx=f"if time < {(JUMP - 0.5) * H:g} then 0 else 1000")
    b.initial(rod.phi, 0.5)
    run = mbdsl.simulate(b, method=method, step=H, stop=N * H, interval=0.0, options=options)
    assert len(run) == N + 1
    static = 1000.0 * run.system.tables.models["rod"].beam.station(1.0)[0][0, 0] / (hw / H) ** 2
    assert np.abs(run["rod.q[4]"][:JUMP]).max() == 0.0
    return run["rod.dq[4]"][JUMP:] * H / static, run["rod.q[4]"][-1] / static


def by_hand(alpha, beta, gamma, hw=1e4):
    """The same of q'' + w^2 (q - 1) = 0: the method's formulas with h = 1 and w = h w, step by step."""
    q = v = a = 0.0
    rates = []
    for k in range(JUMP, N + 1):
        ahead = q + v + (0.5 - beta) * a
        before = q - (k > JUMP)  # the force at the end of the step before is zero
        new = -(hw**2 * (ahead - 1.0 - alpha / (1 + alpha) * before)) / (1 / (1 + alpha) + hw**2 * beta)
        q, v, a = ahead + beta * new, v + (1 - gamma) * a + gamma * new, new
        rates.append(v)
    return np.array(rates)


def disobedience(rates, eigenvalues):
    """Largest difference between the first rates and the recurrence whose solutions are powers of these eigenvalues."""
    recurrence = np.poly(eigenvalues)
    return max(abs(recurrence @ rates[k + len(eigenvalues) : k - 1 if k else None : -1]) for k in range(10))


@pytest.mark.parametrize("method", ["hht-i3", "hht-add", "hht-si2"])
@pytest.mark.parametrize("alpha", [-1 / 3, -0.3, -0.2, -0.1, -0.05])
def test_alpha_is_the_damping_of_an_unresolved_mode(method, alpha):
    """Against the recursion by hand, step by step, and against its limit, from which it is 30/(h w)^2 away at most."""
    hw = HW.get(method, 1e4)
    rates, end = pulled(method, hw, alpha=alpha)
    assert np.abs(rates - by_hand(alpha, (1 - alpha) ** 2 / 4, 0.5 - alpha, hw)).max() < 1e-6
    damped = -(1 + alpha) / (1 - alpha)
    assert disobedience(rates, [damped, damped, alpha / (1 + alpha)]) < 40 / hw**2
    # and the displacement is static, except for the remaining vibration, rho^49 times 49 of 1/(h w)^2 and more
    assert end == pytest.approx(1.0, abs=40 / hw**2)


@pytest.mark.parametrize("gamma", [0.6, 0.75, 0.9])
def test_gamma_of_newmark(gamma):
    rates, _ = pulled("newmark", gamma=gamma)
    assert np.abs(rates - by_hand(0.0, (gamma + 0.5) ** 2 / 4, gamma)).max() < 1e-6
    assert disobedience(rates, [(gamma - 1.5) / (gamma + 0.5)] * 2) < 1e-6


@pytest.mark.parametrize("method", ["nstiff", "nstiff-si2"])
def test_bdf_forgets_at_once(method):
    """q is static from the first step on: rates of BDF2 are 3/2, 3/2 - 4/2, and 3/2 - 4/2 + 1/2 = 0 of it over h."""
    rates, _ = pulled(method)
    assert rates[:2] == pytest.approx([1.5, -0.5], abs=1e-6)
    assert np.abs(rates[2:]).max() < 1e-6


# -- in a mechanism ----------------------------------------------------------------------------------------------------

#: the axial mode's frequency [rad/s] for each method. hht-add has M^{-1} Q in its equations: what rounding and Newton's
#: method leave in q is multiplied by w^2 there; from h w = 300 on it refuses (see below).
FREQUENCY = {"newmark": 1e9, "hht-i3": 1e9, "nstiff": 1e9, "nstiff-si2": 1e9, "hht-si2": 1e9, "hht-add": 1e7}
#: iterations against those without the mode; new matrices a step. hht-add: measured 1.2 to 1.5, and 0.06
MORE = dict.fromkeys(FREQUENCY, 1.05) | {"hht-add": 1.6}
MATRICES = dict.fromkeys(FREQUENCY, 0.03) | {"hht-add": 0.1}
STEPS = [5e-6, 2.5e-6, 1.25e-6]


def crank(model, where, frequency):
    """The flexible slider crank with two modes of bending, and an axial one of this frequency, if any."""
    text = model("flexible_slider_crank").read_text(encoding="utf-8")
    assert "S = 5.74e-6 m2" in text
    assert "modes = modes," in text
    modes = 3 if frequency else 2
    area = 5.74e-6 * ((frequency or 2290.0) / 2290.0) ** 2
    text = text.replace("S = 5.74e-6 m2", f"S = {area:.17g} m2")
    path = where / "crank.mbd"
    path.write_text(
        text.replace("modes = modes,", f"modes = {modes}, axial = {modes - 2}, elements = 128,"), encoding="utf-8"
    )
    return mbdsl.load(path)


@pytest.fixture(scope="module")
def exact(reference):
    """At 0.1 and 0.25 s, of the mechanism whose rod does not stretch."""
    rows = reference("flexible_slider_crank")["data"]["flexible_2_bending"]["rows"][:2]
    assert [row["t"] for row in rows] == ["0.1", "0.25"]
    return {
        "crank.w": np.array([float(row["omega1"]) for row in rows]),
        "bending": np.array([[float(q) for q in row["q"]] for row in rows]),
        "rates": np.array([[float(q) for q in row["qd"]] for row in rows]),
    }


def errors(run, exact):
    """Root mean square over both times; of w of the crank, and both modes of bending in the rod, and their rates."""
    beam, at = run.system.tables.models["rod"].beam, [2, 5]
    assert run.t[at] == pytest.approx([0.1, 0.25])
    crest = [beam.station(x)[0][1, i] for i, x in enumerate((0.3, 0.15))]
    found = {"crank.w": run["crank.w"][at] - exact["crank.w"]}
    for i in (0, 1):
        found[f"q{i + 1}"] = run[f"rod.q[{4 + i}]"][at] * crest[i] - exact["bending"][:, i]
        found[f"dq{i + 1}"] = run[f"rod.dq[{4 + i}]"][at] * crest[i] - exact["rates"][:, i]
    return {name: float(np.sqrt(np.mean(values**2))) for name, values in found.items()}


def test_slow_motion_does_not_notice(model, method, exact, tmp_path, order):
    """h w = 5000 to 1250 (hht-add: 50 to 12): errors are those without axial modes, and as such of second order.

    To first order errors of two runs add up, so that 5 % more is allowed for Newton's method and rounding. Orders are
    those of quantities that do not have an extremum at one of the two times; newmark's second mode would need shorter
    steps.
    """
    stiff, none = crank(model, tmp_path, FREQUENCY[method]), crank(model, tmp_path, None)
    found = []
    for h in STEPS:
        one, other = (mbdsl.simulate(s, method=method, step=h, stop=0.25, interval=0.05) for s in (stiff, none))
        found.append(errors(one, exact))
        plain = errors(other, exact)
        assert all(found[-1][name] == pytest.approx(plain[name], rel=0.05) for name in plain), (h, found[-1], plain)
        assert one.stats["iterations"] < MORE[method] * other.stats["iterations"]
        assert one.stats["matrix_evaluations"] < MATRICES[method] * one.stats["steps"]
    if method != "newmark":
        for name in ("crank.w", "q1", "dq1", "dq2"):
            assert 1.85 < order(STEPS, [f[name] for f in found]) < 2.15, name


def test_newton_with_a_mode_that_is_very_stiff(model, method, tmp_path):
    """h w = 1e5 (hht-add: 200), at a step that resolves bending: iterations and matrices as without the mode.

    Measured: 0.99 to 1.003 times as many iterations; with hht-add 1.1 times, and three times the matrices.
    """
    stiff, none = crank(model, tmp_path, 2e6 if method == "hht-add" else 1e9), crank(model, tmp_path, None)
    one, other = (mbdsl.simulate(s, method=method, step=1e-4, stop=0.5, interval=0.05).stats for s in (stiff, none))
    assert one["iterations"] < MORE[method] * other["iterations"]
    few = MATRICES[method] * one["steps"] if method == "hht-add" else 1.25 * other["matrix_evaluations"] + 2
    assert one["matrix_evaluations"] < few


def test_hht_add_refuses_what_it_cannot_bear(model, tmp_path):
    """Its reactions, of 60 N at most, would silently be wrong by 1 N with h w = 500, and by 200 N with 1e4."""
    fast = crank(model, tmp_path, 1e7)
    with pytest.raises(InitialisationError, match=r"magnifies rounding: rod\.q\[6\] has 1\.0e\+07 rad/s, 500 times"):
        mbdsl.simulate(fast, method="hht-add", step=5e-5, stop=0.1)
