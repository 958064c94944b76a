"""The answers of the hard cases, from closed forms, SciPy in minimal coordinates, or published data; mbdsl is not used.

``python tests/verification/hard/answers.py`` writes ``models/hard/*.json``. Each function below gives the cases of the
model of its name; its docstring names the source of the answer. Lengths in m, angles in rad, times in s.
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipe, ellipj, ellipk

sys.path.insert(0, str(Path(__file__).parent))

import mechanics as m

ROOT = Path(__file__).parents[3]
G = 9.81


def solved(rhs, y0, stop, count=10, method="DOP853", **given):
    """Ten times up to ``stop`` and the solution there (count, n), to 1e-13 where rounding allows it."""
    t = np.linspace(0.0, stop, count + 1)[1:]
    tight = {"rtol": 1e-13, "atol": 1e-13, **given}
    found = solve_ivp(rhs, (0.0, stop), y0, method, t_eval=t, **tight)
    assert found.success, found.message
    return t, found.y.T


def at(times, **signals):
    """Checks of signals; names with two underscores for dots, values or (values, scale, within)."""
    checks = []
    for name, said in signals.items():
        values, *rest = said if isinstance(said, tuple) else (said,)
        check = {"signal": name.replace("__", "."), "times": list(times), "values": list(np.asarray(values, float))}
        checks.append(check | dict(zip(("scale", "within", "controlled"), rest, strict=False)))
    return checks


def energy(value, scale, grows=1e-3, within=1e-2, signal="energy.total"):
    """The total energy stays; within a hundredth it may get lost, by a thousandth it may grow."""
    return {"signal": signal, "values": value, "scale": scale, "within": within, "grows": grows,
            "controlled": False}  # fmt: skip


def case(name, stop, checks=None, step=1e-3, tol=1e-5, **said):
    found = {"name": name, "stop": stop, "step": step, "tol": tol, "checks": checks or [], **said}
    return {key: value for key, value in found.items() if value not in (None, [], {})}


# -- 1. stiffness --------------------------------------------------------------------------------------------------


def stiff_knee():
    """Two links in minimal coordinates, DOP853; with 1e10 N.m/rad one rigid link: the knee bends by 1e-9 rad."""
    phi = np.deg2rad(300)
    cases = []
    for k, step in ((1e4, 1e-3), (1e7, 1e-3), (1e10, 1e-3), (1e10, 1e-2)):
        if k < 1e10:
            t, y = solved(m.links([3.0, 0.3], [1.0, 1.5], knee=k), [phi, phi, 0, 0], 1.0)
        else:
            inertia, pull = 3 / 3 + 0.3 * (1.5**2 / 12 + 1.75**2), 3 * 0.5 + 0.3 * 1.75
            t, y = solved(lambda t, y: [y[1], -pull * G * np.cos(y[0]) / inertia], [phi, 0.0], 1.0)  # noqa: B023
            y = y[:, [0, 0, 1, 1]]
        start = G * (3 * 0.5 + 0.3 * 1.75) * np.sin(phi)
        checks = [*at(t, upper__phi=y[:, 0], lower__phi=y[:, 1], upper__w=(y[:, 2], 5.0)), energy(start, 2.7)]
        more = (", long steps", None) if step == 1e-2 else ("", 1e-5)
        cases.append(case(f"k = {k:.0e} N.m/rad{more[0]}", 1.0, checks, step, more[1], parameters={"k": k}))
    return "1. Stiffness", cases


def stiff_mass():
    """Closed form: x = 0.3 m k/(k - m w^2) sin(w t)."""
    cases = []
    t = np.linspace(0, 3, 11)[1:]
    for name, k in (("1", 1e4), ("1e2", 1e8), ("1e4", 1e12), ("1e6", 1e16)):
        size = 0.3 * k / (k - 4.0)
        checks = at(t, mass__x=(size * np.sin(2 * t), 0.3), mass__vx=(2 * size * np.cos(2 * t), 0.6))
        cases.append(case(f"h omega = {name}", 3.0, checks, 1e-2, 1e-5 if k < 1e9 else 1e-4, parameters={"k": k}))
    return "1. Stiffness", cases


def two_time_scales():
    """Closed form: the two normal modes. A method may damp the fast one, of 1e-6 m."""
    cases = []
    t = np.linspace(0, 5, 11)[1:]
    for stiff in (1e4, 1e8):
        K = np.array([[10 + stiff, -stiff], [-stiff, stiff]])
        root = np.diag([1.0, np.sqrt(0.5)])
        w2, X = np.linalg.eigh(root @ K @ root)
        # the slow frequency without cancellation: the determinant over the fast one
        w = np.sqrt([10 * stiff / 2 / w2[1], w2[1]])
        part = X.T @ np.linalg.solve(root, [1.0, 1.000001])
        x = (root @ X @ (part * np.cos(np.outer(t, w))).T).T
        checks = at(t, first__x=x[:, 0], second__x=x[:, 1])
        cases.append(case(f"{stiff:.0e} N/m by 10 N/m", 5.0, checks, 1e-2, 1e-4, parameters={"stiff": stiff}))
    return "1. Stiffness", cases


def bushing_joint():
    """Three coordinates, DOP853 (1e6 N/m); stiffer bushings deflect by 1e-8 m or less: a pendulum on a pin."""
    phi = np.deg2rad(300)
    cases = []
    for k in (1e6, 1e9, 1e12):
        if k == 1e6:
            t, y = solved(m.bushed(k), [0.5 * np.cos(phi), 0.5 * np.sin(phi), phi, 0, 0, 0], 1.0)
            y = y[:, [2, 5]]
        else:
            t, y = solved(lambda t, y: [y[1], -1.5 * G * np.cos(y[0])], [phi, 0.0], 1.0)
        # with 1e6 N/m the bushing vibrates by m g/k, 1e-5 m and 0.01 rad/s, which methods with damping lose
        rings = 3e-3 if k == 1e6 else 1e-3
        checks = [*at(t, rod__phi=y[:, 0], rod__w=(y[:, 1], 3.0, rings)), energy(0.5 * G * np.sin(phi), 1.0)]
        cases.append(case(f"k = {k:.0e} N/m", 1.0, checks, parameters={"k": k}))
    return "1. Stiffness", cases


# -- 2. steps ------------------------------------------------------------------------------------------------------


def step_sizes():
    """One coordinate, DOP853; the reaction in the slot from the moments about the rod's other end."""
    cases = []
    for step, stop in ((1e-9, 1e-6), (1e-7, 1e-4), (1e-5, 1e-2), (5e-2, 1.0), (0.5, 1.0)):
        t, y = solved(m.slider_crank, [np.deg2rad(40), 6.0], stop, min(10, round(stop / step)), atol=1e-15)
        slot = [m.slot(t_, y_) for t_, y_ in zip(t, y, strict=True)]
        checks = at(t, crank__phi=y[:, 0], crank__w=(y[:, 1], 10.0), B__fy=(slot, 30.0, 1e-2, False))
        # long steps have correspondingly large errors; a step of half a turn may also stop
        cases.append(case(f"{stop / step:g} steps of {step:g} s", stop, checks, step, None))
    return "2. Steps from 1 ns to half a turn", cases


# -- 3. singular poses ---------------------------------------------------------------------------------------------


def flat_four_bar():
    """IFToMM A02: the equation of motion in one coordinate, 18 digits (tests/data/reference/four_bar_N2.json)."""
    rows = json.loads((ROOT / "tests/data/reference/four_bar_N2.json").read_text())["reference_N2"][1:]
    t = [float(r["t"]) for r in rows]
    checks = at(t, **{"R[1].b.x": [float(r["B0x"]) for r in rows], "R[1].b.y": [float(r["B0y"]) for r in rows]})
    # a kinetic energy of some 80 J at the bottom
    total = G * (3 * 0.5 + 2 * 1.0) + 0.5 * (3 / 3 + 2)
    return "3. Singular poses", [case("14 flat poses", t[-1], [*checks, energy(total, 80.0)], tol=1e-4)]


def folding_crank():
    """Conservation of energy in one coordinate along the smooth branch, DOP853."""
    t, y = solved(m.folding, [0.3, 5.0], 2.0)
    smooth = at(t, crank__phi=y[:, 0], rod__phi=-y[:, 0], crank__w=(y[:, 1], 8.0))
    total = m.folding_energy(0.3, 5.0)
    return "3. Singular poses", [case("8 folds", 2.0, [*smooth, energy(total, total)])]


def parallelogram():
    """The equation of motion in one coordinate on the parallelogram's branch, which the velocities show, DOP853."""

    def rhs(t, y):
        return [y[1], -(0.5 + 0.5 + 1.0) * G * np.cos(y[0]) / (2 / 3 + 1)]

    cases = []
    for name, phi, w in (("9 rad/s", np.pi / 2, 9.0), ("from the flat pose", 0.0, 9.0), ("back and forth", 0.5, 0.0)):
        t, y = solved(rhs, [phi, w], 3.0)
        checks = at(t, left__phi=y[:, 0], right__phi=y[:, 0], coupler__phi=0 * t, left__w=(y[:, 1], 9.0))
        total = 2 * G * np.sin(phi) + 0.5 * (2 / 3 + 1) * w**2
        cases.append(case(name, 3.0, [*checks, energy(total, 40.0)], parameters={"phi0": phi, "w0": w}))
    return "3. Singular poses", cases


def beyond_reach():
    """Geometry: the distance 1.2 m + 0.5 m/s t reaches the length of the arm at 1 s."""
    stops = {"code": 4, "says": ["actuator"], "after": 0.9, "before": 1.001}
    return "3. Singular poses", [case("an actuator", 2.0, stops=stops)]


def locked_crank():
    """Geometry: the crank's tip is 2 m from D at cos(phi) = 0.375."""
    t = float(np.arccos(0.375)) - 0.5
    stops = {"code": 4, "after": t - 0.01, "before": t + 1e-3}
    return "3. Singular poses", [case("a driven crank", 1.0, stops=stops)]


# -- 4. redundant and contradictory constraints ---------------------------------------------------------------------


def spare_rocker():
    """The equation of motion in one coordinate, DOP853; with a misfit beyond rounding, no assembly exists."""

    def rhs(t, y):
        return [y[1], -3.5 / 3 * G * np.cos(y[0])]

    t, y = solved(rhs, [np.pi / 3, 0.0], 0.35)
    checks = at(t, **{"R[1].phi": y[:, 0], "R[3].phi": y[:, 0], "R[3].w": (y[:, 1], 3.0)})
    cases = [case(f"misfit {e:g} m", 0.35, checks, parameters={"misfit": e}) for e in (0, 1e-15, 1e-12, 1e-10)]
    # on the way down all bars lie in one line: more rows depend on each other there
    t, y = solved(rhs, [np.pi / 3, 0.0], 1.0)
    checks = at(t, **{"R[1].phi": y[:, 0], "R[3].phi": y[:, 0], "R[3].w": (y[:, 1], 6.0)})
    cases.append(case("through the flat pose", 1.0, checks))
    stops = {"code": 3, "says": ["Revolute O", "spare_rocker.mbd:"]}
    cases += [case(f"misfit {e:g} m", 0.35, stops=stops, parameters={"misfit": e}) for e in (1e-8, 1e-6, 1e-3)]
    return "4. Redundant and contradictory constraints", cases


def two_lengths():
    """A pendulum, DOP853; a point cannot have two distances from another point."""
    t, y = solved(lambda t, y: [y[1], -G * np.cos(y[0])], [np.arctan2(-0.8, 0.6), 0.0], 1.0)
    checks = at(t, mass__x=np.cos(y[:, 0]), mass__y=np.sin(y[:, 0]))
    cases = [case(f"misfit {e:g} m", 1.0, checks, parameters={"misfit": e}) for e in (0, 1e-14)]
    stops = {"code": 3, "says": ["Distance one", "Distance other", "two_lengths.mbd:"]}
    cases += [case(f"misfit {e:g} m", 1.0, stops=stops, parameters={"misfit": e}) for e in (1e-8, 1e-3)]
    return "4. Redundant and contradictory constraints", cases


# -- 5. inconsistent starts -----------------------------------------------------------------------------------------


def far_guesses():
    """Trigonometry; the motion of the slider crank in one coordinate, DOP853."""
    cases = []
    for name, angle, away in (("right", 20, 0), ("left", 170, 0), ("a kilometre away", 20, 1e3),
                              ("100 turns away", 36020, 1)):  # fmt: skip
        side = -1 if name == "left" else 1
        t, y = solved(m.free_crank(side), [np.deg2rad(40), 0.0], 0.5)
        x = 0.3 * np.cos(y[:, 0]) + side * np.sqrt(0.36 - 0.09 * np.sin(y[:, 0]) ** 2)
        checks = at(t, crank__phi=y[:, 0], B__s=x)
        cases.append(case(name, 0.5, checks, parameters={"rod_phi": np.deg2rad(angle), "away": away}))
    return "5. Inconsistent starts", cases


def over_fixed():
    """Trigonometry: rod.phi = -asin(sin(crank.phi)/2), and its rate; the motion in one coordinate, DOP853."""
    t, y = solved(m.free_crank(1), [np.deg2rad(30), 2.0], 0.3)
    checks = at(t, crank__phi=y[:, 0], rod__phi=-np.arcsin(np.sin(y[:, 0]) / 2), crank__w=(y[:, 1], 5.0))
    cases = [case("all fits", 0.3, checks)]
    for off in (1e-6, 1e-3, 1.0):
        stops = {"code": 3, "says": ["over_fixed.mbd:", "is fixed, but comes out as"]}
        cases.append(case(f"angle off by {off:g}", 0.3, stops=stops, parameters={"off": off}))
    for off in (1e-6, 1.0):
        stops = {"code": 3, "says": ["velocities", "over_fixed.mbd:"]}
        cases.append(case(f"rate off by {off:g}", 0.3, stops=stops, parameters={"w_off": off}))
    return "5. Inconsistent starts", cases


# -- 6. ratios and sizes --------------------------------------------------------------------------------------------


def mass_ratio():
    """Two links in minimal coordinates, DOP853."""
    cases = []
    start = np.deg2rad([-30, -80])
    for m1, m2 in ((1, 1e-9), (1, 1e-3), (1e-3, 1), (1e-9, 1), (1e9, 1), (1, 1e9)):
        t, y = solved(m.links([m1, m2], [1.0, 0.5]), [*start, 0, 0], 1.0)
        checks = at(t, upper__phi=y[:, 0], lower__phi=y[:, 1], upper__w=(y[:, 2], 10.0), lower__w=(y[:, 3], 10.0))
        total = G * (m1 * 0.5 * np.sin(start[0]) + m2 * (np.sin(start[0]) + 0.25 * np.sin(start[1])))
        cases.append(case(f"{m1:g} kg, {m2:g} kg", 1.0, [*checks, energy(total, G * (m1 + m2))],
                          parameters={"m1": m1, "m2": m2}))  # fmt: skip
    return "6. Ratios and sizes", cases


def massless_rod():
    """One coordinate, DOP853."""
    t, y = solved(m.massless, [np.deg2rad(40), 6.0], 1.0)
    checks = at(t, crank__phi=y[:, 0], crank__w=(y[:, 1], 10.0))
    return "6. Ratios and sizes", [case("", 1.0, checks)]


def no_inertia():
    """Jacobi's elliptic functions."""
    t = np.linspace(0, 2, 11)[1:]
    sn, cn, _, _ = ellipj(ellipk(0.5) + np.sqrt(G) * t, 0.5)
    phi, w = -2 * np.arcsin(np.sqrt(0.5) * sn), -2 * np.sqrt(0.5 * G) * cn
    return "6. Ratios and sizes", [case("", 2.0, at(t, bob__phi=phi, bob__w=(w, 5.0)))]


def any_size():
    """One coordinate, DOP853, in dimensionless time."""
    cases = []
    for L in (1e-9, 1e-4, 1.0, 1e6):
        T = float(np.sqrt(L))
        t, y = solved(lambda t, y: [y[1], -1.5 * G * np.cos(y[0])], [-np.pi / 6, 0.0], 3.0)
        checks = at(t * T, rod__phi=y[:, 0], rod__w=(y[:, 1] / T, 5.0 / T), rod__b__x=(L * np.cos(y[:, 0]), L))
        cases.append(case(f"{L:g} m", 3.0 * T, checks, 1e-3 * T, parameters={"L": L}))
    return "6. Ratios and sizes", cases


# -- 7. discontinuity -----------------------------------------------------------------------------------------------


def stick_slip():
    """One coordinate with the same continuous friction, Radau, 1e-11."""
    t, y = solved(m.on_a_belt, [0.0, 0.1], 2.0, method="Radau", rtol=1e-11, atol=1e-13, max_step=1e-2)
    checks = at(t, block__x=(y[:, 0], 0.05), block__vx=(y[:, 1], 0.2, 2e-2))
    return "7. Discontinuity", [case("1 mm/s", 2.0, checks, 1e-4, 1e-4)]


def stiff_stop():
    """Closed form: parabolas, and arcs of a sine on the spring."""
    cases = []
    for k, step in ((1e4, 1e-3), (1e6, 1e-4), (1e8, 1e-4)):
        # away from the contacts, where positions depend little on the times of contact
        t = np.linspace(0.2, 4.1, 14)
        checks = [*at(t, ball__y=m.bounced(t, k)), energy(10.0, 10.0, signal="kept")]
        cases.append(case(f"k = {k:.0e} N/m", 4.1, checks, step, parameters={"k": k}))
    return "7. Discontinuity", cases


def rattle():
    """Closed form: straight lines, and arcs of a sine on the springs."""
    cases = []
    for k, stop in ((1e4, 0.5), (1e6, 0.5)):
        t = np.linspace(0, stop, 12)[1:]
        x = m.rattled(t, k, 1e-3)
        checks = [*at(t, mass__x=(x, 1e-3 + 1 / np.sqrt(k), 5e-2, False)), energy(0.5, 0.5, signal="kept")]
        cases.append(case(f"k = {k:.0e} N/m", stop, checks, 1e-5, 1e-5, parameters={"k": k}))
    return "7. Discontinuity", cases


def sign_friction():
    """Closed form: the mass stops at 1 m after 1 s. A run may also end there with a message that names the law."""
    checks = at([0.5, 0.9, 1.5], block__x=[0.75, 0.99, 1.0], block__vx=([1.0, 0.2, 0.0], 2.0, 2e-3))
    return "7. Discontinuity", [case("", 1.5, checks)]


def kinked_force():
    """Closed form: cubics from corner to corner."""
    t = np.linspace(0, 1.2, 13)[1:]
    x, v = m.pushed(t, [0, 0.13, 0.29, 0.47, 0.77, 1], [0, 5, -7, 3, 0, 2])
    return "7. Discontinuity", [case("", 1.2, at(t, mass__x=(x, 1.0), mass__vx=(v, 1.0)))]


def step_force():
    """Closed form: parabolas."""
    t = np.linspace(0, 1.1, 12)[1:]
    on, pulse, after = (np.maximum(t - x, 0) for x in (0.3333, 0.7, 0.707))
    x, v = on**2 + 50 * pulse**2 - 50 * after**2, 2 * on + 100 * pulse - 100 * after
    # with fixed steps, a jump inside a step causes an error of order h
    return "7. Discontinuity", [case("", 1.1, at(t, mass__x=(x, 1.0, 0.1), mass__vx=(v, 2.0, 0.1)))]


# -- 8. long runs ---------------------------------------------------------------------------------------------------


def million_steps():
    """The energy is constant; motion in one coordinate, DOP853: 420 swings."""
    t, y = solved(lambda t, y: [y[1], -1.5 * G * np.cos(y[0])], [-np.pi / 6, 0.0], 1000.0)
    checks = [*at(t, rod__phi=y[:, 0]), energy(-0.25 * G, 0.25 * G, grows=1e-5, within=1e-4)]
    return "8. Long runs", [case("", 1000.0, checks, 1e-3, 1e-4)]


def many_turns():
    """phi = w t: an angle of 1e5 rad is known to 1e-11, and every step of the run adds a rounding error."""
    t = np.linspace(0, 100, 11)[1:]
    checks = at(t, wheel__phi=(1000 * t, 1.0, 1e-7), wheel__w=(1000 + 0 * t, 1000.0, 1e-12))
    return "8. Long runs", [case("16,000 turns", 100.0, [*checks, energy(1e6 / 24, 1e6 / 24, 1e-12, 1e-12)])]


# -- 9. flexible ----------------------------------------------------------------------------------------------------


def post_buckling():
    """The elastica under its own load, elliptic integrals; the column stretches by 4e-6, 8 elements err by 1e-4."""
    cases = []
    for over in (0.9, 1.5, 2.5):
        x, y = 1.0, 0.0
        if over > 1:
            low, high = 0.0, 1.0 - 1e-12
            for _ in range(200):
                k2 = 0.5 * (low + high)
                low, high = (k2, high) if ellipk(k2) ** 2 < over * np.pi**2 / 4 else (low, k2)
            x, y = 2 * ellipe(k2) / ellipk(k2) - 1, 2 * np.sqrt(k2) / ellipk(k2)
        checks = at([60.0], column__b__x=([x], 1.0), column__b__y=([y], 1.0))
        cases.append(case(f"{over:g} of the load", 60.0, checks, 1e-2, 1e-3, parameters={"over": over}))
    return "9. Flexible bodies", cases


def spin_up():
    """A beam in the rotating frame, DOP853 (tests/data/reference/spin_up_beam.json); six modes err by 6e-4 m."""
    rows = json.loads((ROOT / "tests/data/reference/spin_up_beam.json").read_text())["rows"]
    t, _u1, u2, _ = np.array([row for row in rows if row[0] in (2, 5, 7, 10, 13, 16, 20)]).T
    with_ = case("with stiffening", 20.0, at(t, u2=(u2, 10.0)), 2e-3, 1e-4)
    own = ["Newton's iteration does not converge", "hht-add finds reactions from M^-1 Q"]
    stops = {"code": 4, "says": ["beam bends by"], "after": 5.0, "before": 15.0, "own": own}
    without = case("without stiffening", 20.0, None, 2e-3, 1e-4, stops=stops, parameters={"stiffening": "false"})
    return "9. Flexible bodies", [with_, without]


def many_modes():
    """Closed form: the sum over the Euler-Bernoulli modes."""
    t = np.linspace(0, 3, 11)[1:]
    y = m.dropped_cantilever(t, 0.01)
    return "9. Flexible bodies", [case("", 3.0, at(t, beam__b__y=(y, 5e-3)), 1e-3, None)]


# -- 10. published traps --------------------------------------------------------------------------------------------


def squeezer():
    """Loop closure and quadrature of the energy in 50 digits (tests/data/reference/seven_body.json)."""
    samples = json.loads((ROOT / "tests/data/reference/seven_body.json").read_text())["samples"]
    t = sorted(samples, key=float)
    phi = [float(samples[x][0]["theta"]) for x in t]
    w = [float(samples[x][0]["omega"]) for x in t]
    checks = at([float(x) for x in t], K1__phi=phi, K1__w=(w, 1200.0))
    return "10. Published traps", [case("", 0.03, checks, 1e-5, 1e-4)]


def flexible_crank():
    """Minimal coordinates, the same eigenmodes, DOP853 (tests/data/reference/crank_ivp_eigenmodes.json)."""
    rows = json.loads((ROOT / "tests/data/reference/crank_ivp_eigenmodes.json").read_text())["rows"]
    rows = [row for row in rows if row["t"] <= 0.0201]
    t, y = [row["t"] for row in rows], np.array([row["y"] for row in rows])
    checks = at(t, **{"rod.q[3]": y[:, 0]}, slider__x=(y[:, 1], 0.45))
    return "10. Published traps", [case("", t[-1], checks, 2e-5, 1e-4)]


def light_link():
    """Three links in minimal coordinates, DOP853."""
    start = np.deg2rad([-60, -75, -90])
    cases = []
    for light in (1e-3, 1e-6, 1e-9):
        t, y = solved(m.links([1.0, light, 1.0], [1.0, 0.3, 0.6]), [*start, 0, 0, 0], 1.0)
        checks = at(t, one__phi=y[:, 0], two__phi=y[:, 1], three__phi=y[:, 2])
        cases.append(case(f"{light:g} kg", 1.0, checks, parameters={"light": light}))
    return "10. Published traps", cases


# -- 11. divergence -------------------------------------------------------------------------------------------------


def pole():
    """x = 1/(1 - t): there is no solution beyond 1 s."""
    stops = {"code": 4, "after": 0.9, "before": 1.02}
    return "11. Divergence", [case("", 2.0, None, 1e-3, 1e-4, stops=stops)]


def out_of_domain():
    """x'' = -sqrt(1 - x): x reaches 1 m at a time given by a quadrature, and the force has no value beyond."""
    w, dw = np.polynomial.legendre.leggauss(60)
    s = 0.5 * (w + 1)
    t = float(0.5 * dw @ (1 / np.sqrt(4 - 4 / 3 * (1 - (1 - s) ** 1.5))))
    stops = {"code": 4, "says": ["pull"], "after": t - 5e-3, "before": t + 1e-3}
    return "11. Divergence", [case("", 2.0, None, 1e-3, 1e-4, stops=stops)]


MODELS = (
    stiff_knee, stiff_mass, two_time_scales, bushing_joint, step_sizes, flat_four_bar, folding_crank, parallelogram,
    beyond_reach, locked_crank, spare_rocker, two_lengths, far_guesses, over_fixed, mass_ratio, massless_rod,
    no_inertia, any_size, stick_slip, stiff_stop, rattle, sign_friction, kinked_force, step_force, million_steps,
    many_turns, post_buckling, spin_up, many_modes, squeezer, flexible_crank, light_link, pole, out_of_domain,
)  # fmt: skip


def said(model):
    """The contents of the file of a model."""
    group, cases = model()
    return {"group": group, "answer": model.__doc__, "cases": cases}


def main(*names):
    for model in [x for x in MODELS if not names or x.__name__ in names]:
        text = json.dumps(said(model), indent=1, default=float)
        (ROOT / "models" / "hard" / f"{model.__name__}.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
