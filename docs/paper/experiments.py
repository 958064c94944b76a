"""The experiments of Negrut, Jay and Khude (2009), figures 3 to 15, run with mbdsl: errors, energies, violations.

Each function returns what it found as numbers by name, which go into numbers.json, and as figures. ``quick`` leaves out
the shortest steps; what is left is the same. The runs of figure 16, which are timed, are in costs.py.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import mbdsl
from mbdsl.plotting.figures import Figure, Series

ROOT = Path(__file__).resolve().parents[2]
#: method -> its order
SIX = {"newmark": 1, "nstiff": 2, "hht-i3": 2, "nstiff-si2": 2, "hht-add": 2, "hht-si2": 2}
INDEX3, STABILISED = ("newmark", "nstiff", "hht-i3"), ("nstiff-si2", "hht-add", "hht-si2")
HHT = ("hht-i3", "hht-add", "hht-si2")
ALPHAS = (-0.3, -0.05)  #: of figures 7 and 8
L1, L2, M1, M2, G = 0.3, 0.6, 3.0, 0.9, 9.81  #: of the slider crank
Found = tuple[dict, list[Figure]]


def model(name: str, **parameters: float):
    return mbdsl.load(ROOT / "models" / f"{name}.mbd", parameters)


def reference(name: str) -> dict:
    return json.loads((ROOT / "tests" / "data" / "reference" / f"{name}.json").read_text(encoding="utf-8"))


def rounded(x: float) -> float:
    """To the digits that are kept in numbers.json."""
    return float(f"{x:.3e}")


def powers(first: int, last: int, unit: float = 1.0) -> dict[str, float]:
    """Label -> step; ``unit`` [s] stands before the power of two."""
    return {("" if unit == 1.0 else f"{unit:g}*") + f"2^-{k}": unit * 2.0**-k for k in range(first, last + 1)}


def sweep(steps: dict[str, float], errors: Callable[[str, float], dict[str, float]]) -> dict:
    """quantity -> method -> step -> error; ``errors(method, h)`` finds those of one run by quantity."""
    found: dict = {}
    for method in SIX:
        for label, h in steps.items():
            for quantity, error in errors(method, h).items():
                found.setdefault(quantity, {}).setdefault(method, {})[label] = rounded(error)
    return found


def against_step(key: str, title: str, y_label: str, errors: dict, steps: dict[str, float], anchor: str) -> Figure:
    """Errors over steps; lines of slope 1 and 2 begin at the step ``anchor``, a third of errors of those orders."""
    series = [Series(name, [steps[k] for k in row], list(row.values())) for name, row in errors.items()]
    at = anchor if anchor in steps else list(steps)[-1]
    h = np.array([steps[at], min(16.0 * steps[at], max(steps.values()))])
    for slope, name in ((1, "newmark"), (2, "hht-add")):
        series.append(Series(f"slope {slope}", h, errors[name][at] / 3 * (h / h[0]) ** slope, style="guide"))
    return Figure(key, title, "step h [s]", y_label, series)


# -- figures 3 to 6: errors at the end against the step ----------------------------------------------------------------


def figure_3(quick: bool) -> Found:
    """The crank's angular velocity at 2 s, against the ODE of one degree of freedom."""
    row = reference("slider_crank")["reference"]["A1_crank_along_plus_x_undeformed c=5.0 T=2"]
    scene, exact, steps = model("slider_crank"), float(row["omega1"]), powers(6, 10 if quick else 14)

    def errors(method: str, h: float) -> dict[str, float]:
        end = mbdsl.simulate(scene, method=method, step=h, stop=2.0, interval=2.0)
        return {"errors": abs(end["crank.w"][-1] - exact)}

    found = sweep(steps, errors)
    label = "error of the crank's angular velocity at 2 s [rad/s]"
    return found, [against_step("figure03", "Figure 3: rigid slider crank", label, found["errors"], steps, "2^-14")]


def flexible(bending: int, axial: int):
    """The flexible slider crank with given numbers of modes, on so many elements that these are as good as sines."""
    text = (ROOT / "models" / "flexible_slider_crank.mbd").read_text(encoding="utf-8")
    assert "modes = modes," in text
    text = text.replace("modes = modes,", f"modes = {bending + axial}, axial = {axial}, elements = 256,")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flexible_slider_crank.mbd"
        path.write_text(text, encoding="utf-8")
        return mbdsl.load(path)


def figure_4(quick: bool) -> Found:
    """The same of the flexible one, at 2 s and as root mean squares over ten times up to 50 ms; and M of (8c)."""
    row = reference("flexible_slider_crank")["data"]["flexible_3_bending_1_axial"]["rows"][-1]
    assert float(row["t"]) == 2.0
    scene, steps = flexible(3, 1), powers(6, 11 if quick else 20)

    def at_end(method: str, h: float) -> dict[str, float]:
        end = mbdsl.simulate(scene, method=method, step=h, stop=2.0, interval=2.0)
        return {
            "errors": abs(end["crank.w"][-1] - float(row["omega1"])),
            "angle": abs(end["crank.phi"][-1] - float(row["phi1"])),
        }

    found = sweep(steps, at_end)
    rows = reference("flexible_slider_crank_short")["data"]["rows"]
    exact, few = np.array([float(x["omega1"]) for x in rows]), flexible(1, 1)
    short = powers(9, 12 if quick else 17, 0.05)

    def up_to_50_ms(method: str, h: float) -> dict[str, float]:
        run = mbdsl.simulate(few, method=method, step=h, stop=0.05, interval=0.005)
        return {"resolved": np.sqrt(np.mean((run["crank.w"][1:] - exact) ** 2))}

    found |= sweep(short, up_to_50_ms)
    found["mass matrix"] = mass_matrix(9 if quick else 12)
    if not quick:
        found["ringing"] = ringing(scene)
    title, what = "Figure 4: flexible slider crank", "error of the crank's angular velocity"
    return found, [
        against_step("figure04", title, f"{what} at 2 s [rad/s]", found["errors"], steps, "2^-20"),
        against_step(
            "figure04_resolved",
            f"{title}, resolved",
            f"{what}, root mean square up to 50 ms [rad/s]",
            found["resolved"],
            short,
            "0.05*2^-17",
        ),
    ]


def ringing(scene) -> float:
    """By how much the crank's angular velocity [rad/s] swings about its course in the last 20 ms, modes resolved."""
    run = mbdsl.simulate(scene, method="hht-si2", step=2.0**-18, stop=2.0, interval=2.0**-15)
    late = run.t > 1.98
    t, w = run.t[late] - 2.0, run["crank.w"][late]
    return rounded(np.abs(w - np.polyval(np.polyfit(t, w, 4), t)).max())


def mass_matrix(last: int, alpha: float = -0.1) -> dict:
    """HHT-I3 with M(q_{n+1}), as (8c) reads, and with M where its accelerations belong: errors of the velocity at 1 s.

    The rigid slider crank without spring and damper in its angle alone, M(phi) phi'' + M'(phi) phi'^2/2 + V'(phi) = 0:
    no constraints, and a mass matrix that depends on coordinates. Without mbdsl.
    """
    beta, gamma = (1 - alpha) ** 2 / 4, 1 / 2 - alpha

    def parts(phi: float) -> tuple[float, float, float]:
        """M, dM/dphi and dV/dphi; the rod's angle is psi, r = dpsi/dphi."""
        s, c = np.sin(phi), np.cos(phi)
        sp = -L1 / L2 * s
        cp = np.sqrt(1 - sp**2)
        r = -L1 * c / (L2 * cp)
        dr = (L1 * s / L2 + r**2 * sp) / cp
        mixed = c * cp + s * sp  # cos(phi - psi)
        turning = (M1 / 3 + M2) * L1**2
        mass = turning + M2 * (L2**2 / 3 * r**2 + L1 * L2 * mixed * r)
        change = M2 * (2 * L2**2 / 3 * r * dr + L1 * L2 * (mixed * dr - (s * cp - c * sp) * (1 - r) * r))
        return mass, change, G * (M1 + M2) * L1 / 2 * c

    def force(phi: float, w: float) -> float:
        _, change, weight = parts(phi)
        return -change * w**2 / 2 - weight

    def end(steps: int, at_end: bool) -> float:
        h, phi, w = 1.0 / steps, 0.0, 1.0
        a, f = force(phi, w) / parts(phi)[0], force(phi, w)
        for _ in range(steps):
            mass, new = parts(phi + (1 + alpha) * h * w)[0], a
            for _ in range(50):
                q = phi + h * w + h**2 * ((1 / 2 - beta) * a + beta * new)
                v = w + h * ((1 - gamma) * a + gamma * new)
                before, g = new, force(q, v)
                new = ((1 + alpha) * g - alpha * f) / (parts(q)[0] if at_end else mass)
                if abs(new - before) < 1e-13 * abs(new):
                    break
            phi, w, a, f = q, v, new, g
        return w

    rows = reference("flexible_slider_crank")["data"]["rigid"]["rows"]
    exact = float(next(row["omega1"] for row in rows if row["t"] == "1"))
    return {
        name: {f"2^-{k}": rounded(abs(end(2**k, at_end) - exact)) for k in range(7, last + 1)}
        for name, at_end in (("M(q_{n+1}), as in (8c)", True), ("M at q_n + (1 + alpha) h v_n", False))
    }


def figures_5_and_6(quick: bool) -> Found:
    """Body 5 of the seven bodies at 30 ms."""
    row = reference("seven_body")["samples"]["0.03"][4]
    scene, steps = model("seven_body"), powers(8, 11 if quick else 18, 0.03)

    def errors(method: str, h: float) -> dict[str, float]:
        end = mbdsl.simulate(scene, method=method, step=h, stop=0.03, interval=0.03)
        return {
            "errors": abs(end["K5.phi"][-1] - float(row["theta"])),
            "rates": abs(end["K5.w"][-1] - float(row["omega"])),
        }

    found, title = sweep(steps, errors), "seven bodies, body 5 at 30 ms"
    angle, rate = "error of the angle [rad]", "error of the angular velocity [rad/s]"
    return found, [
        against_step("figure05", f"Figure 5: {title}", angle, found["errors"], steps, "0.03*2^-15"),
        against_step("figure06", f"Figure 6: {title}", rate, found["rates"], steps, "0.03*2^-15"),
    ]


# -- figures 7 to 10: energy -------------------------------------------------------------------------------------------


def energy(scene, method: str, h: float, stop: float, **options: float) -> tuple[np.ndarray, np.ndarray]:
    """Time, and by how much the energy differs from that at the start, at every step."""
    run = mbdsl.simulate(scene, method=method, step=h, stop=stop, interval=0.0, options=options)
    return run.t, run["energy.total"] - run["energy.total"][0]


def figures_7_and_8(quick: bool) -> Found:
    """The energy of the slider crank without damper, over 20 s, and what is lost a second."""
    scene, steps = model("slider_crank", c=0.0), powers(7, 8 if quick else 10)
    lost: dict = {}
    for method in HHT:
        for alpha in ALPHAS:
            rates = {k: -np.polyfit(*energy(scene, method, h, 20.0, alpha=alpha), 1)[0] for k, h in steps.items()}
            lost.setdefault(method, {})[f"{alpha:g}"] = {k: rounded(x) for k, x in rates.items()}
    series = [
        Series(f"alpha = {alpha:g}", *energy(scene, "hht-i3", 2.0**-8, 20.0, alpha=alpha), style="line")
        for alpha in ALPHAS
    ]
    # what the energy goes to and fro by, apart from what is lost: in the last two seconds, more than a period
    wavers = {f"{a:g}": rounded(np.ptp(x.y[-512:])) for a, x in zip(ALPHAS, series, strict=True)}
    title = "Figures 7 and 8: hht-i3, h = 2^-8 s"
    figure = Figure("figure07_08", title, "time [s]", "total energy [J]", series, False, False)
    return {"lost": lost, "wavers": wavers}, [figure]


def figure_9(quick: bool) -> Found:
    return mean_energy_error("figure09", "Figure 9: rigid slider crank", model("slider_crank", c=0.0), 6, quick)


def figure_10(quick: bool) -> Found:
    return mean_energy_error("figure10", "Figure 10: flexible slider crank", model("flexible_slider_crank"), 8, quick)


def mean_energy_error(key: str, title: str, scene, first: int, quick: bool, stop: float = 2.0) -> Found:
    """eps(T) = 1/T int_0^T |E(t) - E(0)| dt, (14), over 2 s."""
    steps = powers(first, 10 if quick else 14)

    def errors(method: str, h: float) -> dict[str, float]:
        t, E = energy(scene, method, h, stop)
        size = np.abs(E)
        return {"errors": ((size[1:] + size[:-1]) / 2 * np.diff(t)).sum() / stop}

    found = sweep(steps, errors)
    label = "mean energy error over 2 s [J]"
    return found, [against_step(key, title, label, found["errors"], steps, "2^-14")]


# -- figures 11 to 15: the constraints on velocities -------------------------------------------------------------------

#: dPhi is c h^2 Phi_q q''' to leading order; gamma = 0.6 and beta = 0.3025 with newmark and hht-i3
LEADING = {"newmark": 0.6 / 2 - 0.3025 - 1 / 12, "hht-i3": 0.6 / 2 - 0.3025 - 1 / 12, "nstiff": -1 / 3}


def figures_11_to_15(quick: bool) -> Found:
    """x and y of the violation at the pin between crank and ground, 10 s without damper, at every step."""
    scene, steps = model("slider_crank", c=0.0), powers(8, 10)
    found: dict = {"largest": {}, "predicted": {}}
    figures = []
    for method in SIX:
        for label, h in steps.items():
            run = mbdsl.simulate(scene, method=method, step=h, stop=10.0, interval=0.0)
            x, y = run["O.dPhi[1]"], run["O.dPhi[2]"]
            found["largest"].setdefault(method, {})[label] = rounded(np.hypot(x, y).max())
            if method in LEADING:
                expected = LEADING[method] * h**2 * third(run)
                found["predicted"].setdefault(method, {})[label] = rounded(np.hypot(*expected).max())
        number = {"hht-add": 11, "hht-si2": 12, "newmark": 13, "nstiff": 14, "hht-i3": 15}.get(method)
        if number is None:
            continue
        series = [Series(method, x, y, style="line" if method in LEADING else "marks")]
        if method in LEADING:
            once = run.t < 2.0  # more than a period
            series.append(Series("c h² Φq q‴", expected[0][once], expected[1][once], style="front"))
        title = f"Figure {number}: {method}, h = 2^-10 s"
        labels = ("violation along x [m/s]", "violation along y [m/s]")
        figures.append(Figure(f"figure{number}", title, *labels, series, False, False, equal=True))
    return found, figures


def third(run) -> np.ndarray:
    """Phi_q q''' of the pin, (2, N) [m/s3]: with the crank's centre on its circle, what no phi''' is in."""
    phi, w = run["crank.phi"], run["crank.w"]
    acceleration = np.gradient(w, run.t)
    s, c = np.sin(phi), np.cos(phi)
    return L1 / 2 * np.array([s * w**3 - 3 * c * w * acceleration, -c * w**3 - 3 * s * w * acceleration])
