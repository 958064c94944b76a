"""Redraws the comparison of Fang, Kissel, Zhang and Negrut (2023) from runs of mbdsl:  python docs/draw_paper_space.py

Writes pictures and numbers.json into docs/paper-space/, and the tables of docs/paper-space.md, which are made of these
numbers. With --folder they go there, and the page stays; with --quick the shortest steps and the times are left out.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from paper.page import MARKED, short, table

import mbdsl
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.plotting.figures import Figure, Series
from mbdsl.plotting.pictures import draw
from mbdsl.plotting.sheets import sheet
from mbdsl.system import build

HERE = Path(__file__).resolve().parent
SPACE = HERE.parent / "models" / "space"
MODELS = {"slider crank": "haug_slider_crank", "four-link": "haug_four_link", "double pendulum": "bar_pendulum"}
STEPS = (1e-4, 1e-3, 1e-2)  #: of the published times [s]
STOP = 8.0  #: [s]
#: published processor times [s], half-implicit and fully implicit: data/timing.csv of the paper's repository
PUBLISHED = {
    "slider crank": ((99.347, 143.141), (12.5147, 25.142), (1.81937, 3.8223)),
    "four-link": ((93.3165, 128.456), (13.5558, 21.7), (2.13917, 3.90227)),
    "double pendulum": ((47.6116, 105.476), (6.50978, 14.3156), (0.926551, 2.18519)),
}
TIMED = ("hht-i3", "hht-si2")
METHODS = ("newmark", "nstiff", "hht-i3", "nstiff-si2", "hht-add", "hht-si2")
LADDER = (1e-4, 2e-4, 4e-4, 1e-3, 2e-3, 4e-3, 1e-2)  #: steps of the convergence plots [s]
QUICK = (2e-3, 4e-3, 1e-2)
END = 1.0  #: of the convergence plots [s]
REPEATS = 3


def seconds(name: str, method: str, h: float) -> tuple[float, float]:
    """Processor time of the steps of 8 s, the least of three runs, and iterations a step."""
    scene = mbdsl.load(SPACE / f"{MODELS[name]}.mbd")
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    s, least = initial_state(system, mechanism, 0.0), np.inf
    for _ in range(REPEATS):
        run = MethodRun(system, method, h, 0.0, STOP, np.array([STOP]), {})
        run.begin(s.q, s.v, s.a, s.lam, s.redundant)
        begun = time.process_time()
        status = run.advance()
        least = min(least, time.process_time() - begun)
        assert status == loop_state.DONE
    return least, run.integers[loop_state.ITERATIONS] / round(STOP / h)


def times(quick: bool) -> dict:
    return {
        name: {method: {f"{h:g}": seconds(name, method, h) for h in STEPS} for method in TIMED}
        for name in MODELS
        if not quick
    }


def lower_bar(t: mbdsl.Trajectory) -> np.ndarray:
    """The height of the centre of the lower bar."""
    return t["lower.y"][-1]


def pendulum() -> float:
    """The same of Lagrange's equations in both angles, by SciPy."""
    from scipy.integrate import solve_ivp

    w, rho, g = 0.05, 7800.0, 9.81
    L, l = 4.0, 2.0
    M, m = rho * w * w * L, rho * w * w * l
    I, i = (mass * (w * w + length * length) / 12 for mass, length in ((M, L), (m, l)))

    def rates(_, y):
        a, b, p, q = y
        A = np.array([[I + M * L * L / 4 + m * L * L, m * L * l / 2 * np.cos(a - b)], [0, i + m * l * l / 4]])
        A[1, 0], s = A[0, 1], m * L * l / 2 * np.sin(a - b)
        f = [-s * q * q - (M / 2 + m) * g * L * np.cos(a), s * p * p - m * g * l / 2 * np.cos(b)]
        return [p, q, *np.linalg.solve(A, f)]

    found = solve_ivp(rates, (0.0, END), [0.0, -np.pi / 2, 0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-13)
    a, b = found.y[:2, -1]
    return float(L * np.sin(a) + l / 2 * np.sin(b))


def slider() -> float:
    """The velocity of the slider at the end, from the length of the rod."""
    psi = np.pi / 2 - 2 * np.pi * END
    y, z = 0.1 + 0.08 * np.cos(psi), 0.12 + 0.08 * np.sin(psi)
    return float(0.16 * np.pi * (z * np.cos(psi) - y * np.sin(psi)) / np.sqrt(0.09 - y**2 - z**2))


def link() -> float:
    """The vertical velocity of the link at the end, by the kinematics of mbdsl, which have no discretisation error."""
    return float(mbdsl.simulate(SPACE / "haug_four_link.mbd", stop=END, step=1e-3, interval=END)["link.vz"][-1])


#: model -> the quantity of its convergence plot, its value, and its name
QUANTITIES: dict[str, tuple[Callable, Callable, str]] = {
    "double pendulum": (lower_bar, pendulum, "height of the lower bar [m]"),
    "slider crank": (lambda t: t["slider.vx"][-1], slider, "velocity of the slider [m/s]"),
    "four-link": (lambda t: t["link.vz"][-1], link, "vertical velocity of the link [m/s]"),
}


def errors(quick: bool) -> dict:
    """model -> method -> step -> error at 1 s; of driven mechanisms for the methods that do not enforce velocities."""
    found: dict = {}
    for name, (of, true, _) in QUANTITIES.items():
        expected, driven = true(), name != "double pendulum"
        for method in ("newmark", "nstiff", "hht-i3") if driven else METHODS:
            runs = {}
            for h in QUICK if quick else LADDER:
                given = {"method": method, "step": h, "stop": END, "interval": END, "general": True}
                runs[f"{h:g}"] = abs(float(of(mbdsl.simulate(SPACE / f"{MODELS[name]}.mbd", **given))) - expected)
            found.setdefault(name, {})[method] = {h: float(f"{e:.4g}") for h, e in runs.items()}
    return found


def figures(numbers: dict) -> list[Figure]:
    found = []
    for name, rows in numbers["errors"].items():
        series = [Series(m, [float(h) for h in row], list(row.values())) for m, row in rows.items()]
        key, y = name.replace(" ", "_").replace("-", "_"), QUANTITIES[name][2]
        found.append(Figure(f"errors_{key}", f"Error at {END:g} s, {name}", "step h [s]", y, series))
    if numbers["times"]:
        for name, rows in numbers["times"].items():
            series = [Series(f"mbdsl, {m}", list(STEPS), [row[f"{h:g}"][0] for h in STEPS]) for m, row in rows.items()]
            for k, kind in enumerate(("half-implicit", "fully implicit")):
                series.append(Series(f"Python, {kind}", list(STEPS), [PUBLISHED[name][n][k] for n in range(3)]))
            key = name.replace(" ", "_").replace("-", "_")
            found.append(Figure(f"times_{key}", f"Time of 8 s, {name}", "step h [s]", "processor time [s]", series))
    return found


def times_table(numbers: dict) -> str:
    head = ["model", "h", "half-implicit", "fully implicit", *(f"`{m}`" for m in TIMED), "times as fast"]
    rows = []
    for name, methods in numbers["times"].items():
        for n, h in enumerate(STEPS):
            own = [methods[m][f"{h:g}"][0] for m in TIMED]
            half, full = PUBLISHED[name][n]
            ratios = sorted((half / own[1], full / own[0]))
            parts = [f"{1e3 * s:.3g} ms" for s in own]
            factor = " to ".join(f"{float(f'{x:.2g}'):,.4g}" for x in ratios)
            rows.append([name, f"{1e3 * h:g} ms", f"{half:.3g} s", f"{full:.3g} s", *parts, factor])
    return table(head, rows)


def errors_table(numbers: dict) -> str:
    rows = []
    for name, methods in numbers["errors"].items():
        for method, row in methods.items():
            h, e = np.log([float(x) for x in row]), np.log(list(row.values()))
            slope = np.polyfit(h[1:4], e[1:4], 1)[0]
            rows.append([name, f"`{method}`", *(short(row[f"{x:g}"]) for x in STEPS), f"{slope:.2f}"])
    return table(["model", "method", *(f"h = {1e3 * h:g} ms" for h in STEPS), "slope"], rows)


BLOCKS = {"times": times_table, "errors": errors_table}


def filled(text: str, numbers: dict) -> str:
    """The page with its tables made anew."""
    return MARKED.sub(lambda m: f"{m[1]}\n{BLOCKS[m[2]](numbers)}\n\n{m[3]}", text)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="without the shortest steps and the times")
    parser.add_argument("--folder", type=Path, default=None, help="where numbers and pictures go; the page stays")
    options = parser.parse_args(arguments)
    if options.quick and options.folder is None:
        parser.error("--quick needs a --folder: the page is of the whole runs")
    folder = options.folder or HERE / "paper-space"
    folder.mkdir(parents=True, exist_ok=True)
    numbers = {"errors": errors(options.quick), "times": times(options.quick)}
    for figure in figures(numbers):
        draw(sheet(figure.title, [figure]), folder / f"{figure.key}.png", dpi=100)
    (folder / "numbers.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    if options.folder is None:
        text = HERE / "paper-space.md"
        text.write_text(filled(text.read_text(encoding="utf-8"), numbers), encoding="utf-8")


if __name__ == "__main__":
    main()
