"""Redraws figures 3 to 16 of Negrut, Jay and Khude (2009) from runs of mbdsl:  python docs/draw_paper.py [--quick]

Writes pictures and numbers.json into docs/paper/ and the tables of docs/paper.md, which are made of these numbers.
With --quick the shortest steps are left out, and nothing is written unless --folder says where to.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from paper import costs, experiments, page

from mbdsl.plotting.pictures import draw
from mbdsl.plotting.sheets import sheet

HERE = Path(__file__).resolve().parent
EXPERIMENTS = {
    "figure 3": experiments.figure_3,
    "figure 4": experiments.figure_4,
    "figures 5 and 6": experiments.figures_5_and_6,
    "figures 7 and 8": experiments.figures_7_and_8,
    "figure 9": experiments.figure_9,
    "figure 10": experiments.figure_10,
    "figures 11 to 15": experiments.figures_11_to_15,
    "figure 16": costs.figure_16,
}


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="without the shortest steps")
    parser.add_argument("--only", nargs="+", default=list(EXPERIMENTS), choices=list(EXPERIMENTS), metavar="FIGURE")
    parser.add_argument("--folder", type=Path, default=None, help="where numbers and pictures go; the page stays")
    options = parser.parse_args(arguments)
    if options.quick and options.folder is None:
        parser.error("--quick needs a --folder: the page is of the whole runs")
    folder = options.folder or HERE / "paper"
    folder.mkdir(parents=True, exist_ok=True)
    store = folder / "numbers.json"
    numbers = json.loads(store.read_text(encoding="utf-8")) if store.exists() else {}
    for name in options.only:
        begun = time.perf_counter()
        numbers[name], figures = EXPERIMENTS[name](options.quick)
        for figure in figures:
            draw(sheet(figure.title, [figure]), folder / f"{figure.key}.png", dpi=100)
        print(f"{name}: {time.perf_counter() - begun:.1f} s", flush=True)
    store.write_text(json.dumps({name: numbers[name] for name in EXPERIMENTS if name in numbers}, indent=1) + "\n")
    if options.folder is None:
        text = HERE / "paper.md"
        text.write_text(page.filled(text.read_text(encoding="utf-8"), numbers), encoding="utf-8")


if __name__ == "__main__":
    main()
