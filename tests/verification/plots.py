"""Draws the velocity-constraint violation of the slider crank's fixed pin:  python tests/verification/plots.py [folder]

As figures 11-15 of Negrut, Jay and Khude (2009): x against y, undamped, over 10 s. The index-3 methods run along closed
curves whose box shrinks with the order of the method; the stabilised ones leave some
1e-11.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import mbdsl

MODEL = Path(__file__).resolve().parents[2] / "models" / "slider_crank.mbd"
INDEX3, STABILISED = ("newmark", "nstiff", "hht-i3"), ("nstiff-si2", "hht-add", "hht-si2")
STEPS = (2.0**-8, 2.0**-9, 2.0**-10)
STOP = 10.0


def violation(method: str, h: float, stop: float = STOP):
    """x and y of O's dPhi [m/s] at every step."""
    scene = mbdsl.load(MODEL, {"c": 0.0})
    found = mbdsl.simulate(scene, method=method, step=h, stop=stop, interval=0.0)
    return found["O.dPhi[1]"], found["O.dPhi[2]"]


def limit_cycles(target: Path, steps=STEPS, stop: float = STOP) -> dict[str, list[float]]:
    """Write the picture; method -> largest violation for each of its steps."""
    figure, largest = Figure(figsize=(11, 7.2), layout="constrained"), {}
    axes = figure.subplots(2, 3)
    for row, names in zip(axes, (INDEX3, STABILISED), strict=True):
        for ax, name in zip(row, names, strict=True):
            ax.set_title(name)
            largest[name] = []
            for k, h in list(enumerate(steps))[0 if name in INDEX3 else -1 :]:
                x, y = violation(name, h, stop)
                largest[name].append(float(np.hypot(x, y).max()))
                shade = matplotlib.colormaps["viridis"](0.8 - 0.35 * k)
                style = dict(linewidth=0.7) if name in INDEX3 else dict(linestyle="", marker=".", markersize=2)
                ax.plot(x, y, color=shade, label=f"h = 2^{np.log2(h):.0f} s", **style)
            ax.ticklabel_format(style="sci", scilimits=(0, 0))
            ax.legend(loc="upper right", fontsize="small")
            ax.set(xlabel="O.dPhi[1] [m/s]", ylabel="O.dPhi[2] [m/s]")
    figure.savefig(target, dpi=100)
    return largest


def main(folder: str = ".") -> None:
    largest = limit_cycles(Path(folder) / "limit_cycles.png")
    for name, sizes in largest.items():
        print(f"{name:10}", *(f"{size:.2e} m/s" for size in sizes))


if __name__ == "__main__":
    main(*sys.argv[1:])
