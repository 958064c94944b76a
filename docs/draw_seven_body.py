"""Draws docs/seven_body.png: positions of models/seven_body.mbd, and error against time from docs/work-precision.

python docs/draw_seven_body.py
"""

import json
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from mbdsl import simulate
from mbdsl.plotting.series_styles import MARKS, looks

HERE = Path(__file__).resolve().parent
TIMES = np.linspace(21.5e-3, 30e-3, 22)  #: one turn of the crank [s]
#: frames at the corners of each body; A, B and C are fixed to the ground
LINES = ("K1.O K1.F", "K2.F K2.E", "K3.B K3.D K3.E K3.B", "K4.E K4.G", "K5.A K5.c K5.G K5.A", "K6.E K6.H")
LINES = (*(line.split() for line in (*LINES, "K7.A K7.c K7.H K7.A")),)
BACKGROUND, INK, PALE = "#0d1b2a", "#e6edf3", "#5d7188"
#: series, its name, and the point that has the name
METHODS = (("radau5 --tol", "radau5, tolerance", -1), ("hht-si2", "HHT-SI2", -1), ("Exudyn", "Exudyn", 9))


def mechanism(axes: plt.Axes) -> None:
    """The bodies at ``TIMES``, from dark to bright, and the spring at the last of them."""
    run = simulate(HERE.parent / "models" / "seven_body.mbd", interval=0.0)

    def at(frames: list[str], t: float) -> list[np.ndarray]:
        return [np.array([1e3 * np.interp(t, run.t, run[f"{frame}.{axis}"]) for frame in frames]) for axis in "xy"]

    for k, t in enumerate(TIMES):
        last = k == len(TIMES) - 1
        colour = plt.get_cmap("plasma")(0.25 + 0.65 * k / (len(TIMES) - 1))
        for frames in LINES:
            x, y = at(frames, t)
            axes.plot(x, y, color=INK if last else colour, linewidth=2.4 if last else 1.2, zorder=3 if last else 2)
            if len(x) > 2:
                axes.fill(x, y, color=colour, alpha=0.55 if last else 0.05, linewidth=0, zorder=3 if last else 1)
            if last:
                axes.plot(x, y, "o", color=BACKGROUND, markeredgecolor=INK, markersize=4.5, zorder=4)
    (x, y), turns = at(["C", "K3.D"], TIMES[-1]), 24
    along, across = np.linspace(0.0, 1.0, turns + 1), np.zeros(turns + 1)
    across[3:-3] = 2.2 * (-1.0) ** np.arange(turns - 5)
    normal = np.array([y[0] - y[1], x[1] - x[0]]) / np.hypot(x[1] - x[0], y[1] - y[0])
    axes.plot(x[0] + along * (x[1] - x[0]) + across * normal[0], y[0] + along * (y[1] - y[0]) + across * normal[1],
              color=PALE, linewidth=1.4, zorder=1)  # fmt: skip
    axes.plot(*at(["A", "B", "C", "K1.O"], TIMES[-1]), "^", color=PALE, markersize=9, zorder=2)
    axes.set(aspect="equal", xlim=(-74.0, 24.0), ylim=(-26.0, 76.0))
    axes.set_title("seven bodies, one turn of the crank in 8.5 ms", color=INK, loc="left", fontsize=10)
    axes.axis("off")


def precision(axes: plt.Axes) -> None:
    """Error against time of two methods and Exudyn."""
    points = json.loads((HERE / "work-precision" / "seven_body.json").read_text(encoding="utf-8"))["points"]
    known = looks(series for series, _, _ in METHODS)  # as in all other pictures
    for series, name, k in METHODS:
        look = known[series]
        found = sorted((p["error"], p["seconds"]) for p in points if p["series"] == series)
        # only points that no other of the series beats in both error and time
        front = [(e, s) for k, (e, s) in enumerate(found) if all(s < t for _, t in found[:k])]
        error, seconds = np.array(front[::-1]).T
        mark: Any = [(a, -b) for a, b in (*MARKS[look.mark], MARKS[look.mark][0])] if MARKS[look.mark] else "o"
        axes.loglog(seconds, error, color=look.dark, linewidth=1.8, linestyle=(0, look.dash) if look.dash else "-",
                    marker=mark, markersize=8 if MARKS[look.mark] else 5.5,
                    markerfacecolor=look.dark if look.filled else BACKGROUND)  # fmt: skip
        axes.annotate(name, (seconds[k], error[k]), (9, 3), textcoords="offset points", color=look.dark, fontsize=11)
    axes.set_xlabel("run time [s]", color=INK, fontsize=10)
    axes.set_title("relative error of positions", color=INK, loc="left", fontsize=10)
    axes.set_facecolor(BACKGROUND)
    axes.grid(color=PALE, alpha=0.25, linewidth=0.6)
    axes.tick_params(which="both", colors=INK, labelsize=9)
    axes.spines[:].set_visible(False)


def main(target: Path = HERE / "seven_body.png") -> None:
    figure = plt.figure(figsize=(9.6, 4.7), facecolor=BACKGROUND, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.08, 1))
    mechanism(left)
    precision(right)
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main()
