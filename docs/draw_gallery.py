"""Draws the films of the gallery, docs/gallery/*.gif, and its index; measures its loops over 1,000 revolutions.

python docs/draw_gallery.py [NAME...]     # of these models, or of all

The command of a page, `mbdsl animate models/gallery/NAME.mbd --trace ...`, names the paths of its film.
"""

import io
import re
import shlex
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import mbdsl
from mbdsl.viewing.motion import motion
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.shapes import drawing

HERE = Path(__file__).resolve().parent
GALLERY, MODELS = HERE / "gallery", HERE.parent / "models" / "gallery"
#: heading of the index -> models; a page of the same name belongs to each
GROUPS = {
    "Linkages": ("four_bar_curves",),
}
INTRODUCTION = (
    "Mechanisms of one screen each (`models/gallery/`). Each page has a number that proves the motion right, from a",
    "closed form or an independent computation, and the command to try it.",
)
COLUMNS = 3  #: of the index
SIZE = 360, 270  #: of a film [px]
LARGEST = 100_000  #: size of a film [bytes]
PICTURES = (50, 40, 32, 25, 20)  #: numbers of pictures, of which the first that makes a small film is taken
COLOURS = 48
SHORTEST, LONGEST = 2.0, 6.0  #: duration of a film [s]; motions of another duration are shown slower or faster
TURNS, STEPS = 1000, 24  #: revolutions over which loops are measured, and steps of each
RESIDUAL = re.compile(r"(largest\s+residual\s+of\s+the\s+loops\s+over\s+1,000\s+revolutions\s+is\s+)\S+( m)")


def page(name: str) -> str:
    return (GALLERY / f"{name}.md").read_text(encoding="utf-8")


def traces(name: str) -> list[str]:
    """The paths that the command of a page shows."""
    (command,) = re.findall(rf"^mbdsl animate models/gallery/{name}\.mbd.*$", page(name), flags=re.MULTILINE)
    words = shlex.split(command)
    return words[words.index("--trace") + 1].split(",") if "--trace" in words else []


def film(trajectory: mbdsl.Trajectory, traced: list[str]) -> bytes:
    """A GIF of ``SIZE`` that repeats; all pictures have the palette of the first."""
    moving = motion(trajectory)
    picture = Picture(moving, drawing(moving), *SIZE, traced)
    t = moving.t
    duration = t[-1] - t[0]
    for count in PICTURES:
        rows = np.abs(t[:, None] - (t[0] + duration * np.arange(count) / count)).argmin(axis=0)
        images = [picture.frame(row) for row in rows.tolist()]
        palette = images[0].quantize(COLOURS, dither=Image.Dither.NONE)
        frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
        hundredths = 100 * min(LONGEST, max(SHORTEST, duration))  # the unit of time in a GIF
        lengths = 10 * np.diff(np.rint(hundredths * np.arange(count + 1) / count).astype(int))
        stream = io.BytesIO()
        frames[0].save(stream, "GIF", save_all=True, append_images=frames[1:], duration=lengths.tolist(), loop=0)
        if stream.tell() <= LARGEST:
            break
    return stream.getvalue()


def turned(scene: mbdsl.Scene) -> mbdsl.Trajectory:
    """A run of 1,000 revolutions of a driven mechanism, each of which lasts as long as its experiment."""
    stop = scene.experiment.stop
    # without degrees of freedom all methods find the same motion; the code of this one compiles in the least time
    return mbdsl.simulate(scene, method="newmark", step=stop / STEPS, stop=TURNS * stop, interval=stop / STEPS)


def residual(run: mbdsl.Trajectory) -> float:
    """Largest |Phi| of all joints [m, rad], without drivers: they count turns."""
    joints = [c.name for c in run.scene.components.values() if "Driver" not in c.kind.name]
    names = [name for name in run.select(["*.Phi[*]"]) if name.rpartition(".")[0] in joints]
    return float(max(np.abs(run[name]).max() for name in names))


def index() -> str:
    """The text of docs/gallery/index.md."""
    lines = ["# Gallery", "", *INTRODUCTION]
    for heading, names in GROUPS.items():
        lines += ["", f"## {heading}", "", "| " * COLUMNS + "|", "|---" * COLUMNS + "|"]
        for first in range(0, len(names), COLUMNS):
            cells = [cell(name) for name in names[first : first + COLUMNS]]
            lines.append(f"| {' | '.join([*cells, *[''] * (COLUMNS - len(cells))])} |")
    return "\n".join([*lines, ""])


def cell(name: str) -> str:
    title = page(name).splitlines()[0].removeprefix("# ")
    return f"[![{title}]({name}.gif)]({name}.md)<br>[{title}]({name}.md)"


def main(names: list[str]) -> None:
    for name in names or [name for group in GROUPS.values() for name in group]:
        scene = mbdsl.load(MODELS / f"{name}.mbd")
        content = film(mbdsl.simulate(scene), traces(name))
        (GALLERY / f"{name}.gif").write_bytes(content)
        text = page(name)
        if RESIDUAL.search(text):
            found = f"{residual(turned(scene)):.0e}"
            (GALLERY / f"{name}.md").write_text(RESIDUAL.sub(rf"\g<1>{found}\g<2>", text), encoding="utf-8")
        print(f"{name}: {len(content) / 1000:.0f} KB")
    (GALLERY / "index.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
