"""Draw the films of the gallery, docs/gallery/*.gif, and its index; measure its loops over 1,000 revolutions.

python docs/draw_gallery.py [NAME...]     # of these models, or of all
python docs/draw_gallery.py --space       # of the models in space, and their page, docs/space-gallery.md

The command of a page, `mbdsl animate models/gallery/NAME.mbd --trace ... --arrows ...`, names the traces and arrows of
its film.
"""

import io
import re
import shlex
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import mbdsl

HERE = Path(__file__).resolve().parent
GALLERY, MODELS = HERE / "gallery", HERE.parent / "models" / "gallery"
#: heading of the index -> models; a page of the same name belongs to each
GROUPS = {
    "Linkages": (
        "four_bar_curves",
        "jansen_leg",
        "klann_leg",
        "chebyshev_lambda",
        "watt_straight_line",
        "roberts",
        "peaucellier_lipkin",
        "whitworth_quick_return",
        "scotch_yoke",
        "elliptical_trammel",
        "pantograph",
        "toggle_press",
        "scissor_lift",
        "stephenson_six_bar",
        "watt_six_bar",
    ),
    "Vehicles": (
        "ackermann_steering",
        "double_wishbone",
        "mcpherson_strut",
        "quarter_car",
        "half_car",
        "anti_lock_brake",
    ),
    "Machines": (
        *("four_cylinder_engine", "excavator_arm", "windscreen_wiper", "sewing_machine", "pump_jack"),
        *("flyball_governor", "loading_crane", "robot_arm", "loom", "clock_escapement", "motor_crank"),
        *("hydraulic_boom", "verge_clock", "valve_train", "cart_pole", "anti_sway_crane"),
    ),
    "Pendulums and throws": ("double_pendulum", "triple_pendulum", "swing", "trebuchet", "bow", "slingshot"),
    "Gears, cams and contacts": (
        *("gear_pair", "planetary_gear", "hypocycloid", "rack_steering", "bicycle_chain", "cam_follower"),
        *("geneva_drive", "newtons_cradle", "woodpecker", "trip_hammer", "ratchet_hoist"),
        *("geneva_indexer", "dominoes"),
    ),
}
INTRODUCTION = (
    "Mechanisms whose models fit on one screen (`models/gallery/`). Each page compares the motion with a closed form",
    "or an independent computation, and has the command that plays it.",
)
OF_SPACE = (
    "Mechanisms in space (`models/space/`). Each motion is compared with a closed form, published values or an",
    "independent computation, in `tests/gallery/`. The command",
    "",
    "```bash",
    "mbdsl animate models/space/gyroscope.mbd --out gyroscope.gif",
    "```",
    "",
    "makes such a film. See [models in space](space.md).",
)
COLUMNS = 3  #: of the index
LARGEST = 100_000  #: size of a film [bytes]
SIZES = (360, 270), (240, 180)  #: of a film [px]; the second only if the first has too many bytes
#: size, number of pictures and number of colours that are tried
FILMS = (*((SIZES[0], count, 48) for count in (50, 40, 32, 25, 20)), *((SIZES[1], count, 16) for count in (20, 18, 16)))
SHORTEST, LONGEST = 2.0, 6.0  #: duration of a film [s]; motions of another duration are shown slower or faster
#: without degrees of freedom all methods find the same motion; this one compiles fastest
DRIVEN = "newmark"
TURNS, STEPS = 1000, 24  #: revolutions over which loops are measured, and steps of each
RESIDUAL = re.compile(r"(largest\s+residual\s+of\s+the\s+loops\s+over\s+1,000\s+revolutions\s+is\s+)\S+( m)")


def page(name: str) -> str:
    return (GALLERY / f"{name}.md").read_text(encoding="utf-8")


def option(name: str, flag: str) -> list[str]:
    """The names listed in an option of the command of a page."""
    (command,) = re.findall(rf"^mbdsl animate models/gallery/{name}\.mbd.*$", page(name), flags=re.MULTILINE)
    words = shlex.split(command)
    return words[words.index(flag) + 1].split(",") if flag in words else []


def film(trajectory: mbdsl.Trajectory, traced: list[str], arrows: list[str] | None = None) -> bytes:
    """A looping GIF, the first of ``FILMS`` that is small enough; ``arrows`` as for the command, by default forces."""
    shown = trajectory.animate(traces=traced, arrows=[x for x in arrows or ["forces"] if x != "none"])
    seconds = min(LONGEST, max(SHORTEST, float(trajectory.t[-1] - trajectory.t[0])))
    with tempfile.TemporaryDirectory() as folder:
        for size, count, colours in FILMS:
            path = Path(folder, "whole.gif")
            shown.save(path, size)
            content = shortened(path, count, colours, seconds)
            if len(content) <= LARGEST:
                return content
    raise SystemExit(f"{trajectory.scene.name}: the film is larger than {LARGEST} bytes")


def shortened(path: Path, count: int, colours: int, seconds: float) -> bytes:
    """A film with fewer pictures and colours; all pictures have the palette of the first."""
    with Image.open(path) as whole:
        rows = np.arange(count) * whole.n_frames // count
        images = []
        for row in rows.tolist():
            whole.seek(row)
            images.append(whole.convert("RGB"))
    palette = images[0].quantize(colours, dither=Image.Dither.NONE)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    ends = np.rint(100 * seconds * np.arange(count + 1) / count).astype(int)  # [0.01 s], as in a GIF
    stream = io.BytesIO()
    lengths = (10 * np.diff(ends)).tolist()
    frames[0].save(stream, "GIF", save_all=True, append_images=frames[1:], duration=lengths, loop=0)
    return stream.getvalue()


def turned(scene: mbdsl.Scene, turns: int = TURNS) -> mbdsl.Trajectory:
    """A run of many revolutions of a driven mechanism; a revolution is the duration of its experiment."""
    stop = scene.experiment.stop
    return mbdsl.simulate(scene, method=DRIVEN, step=stop / STEPS, stop=turns * stop, interval=stop / STEPS)


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


def in_space() -> None:
    """Films of the models in space, and the page of them."""
    folder, lines = GALLERY / "space", ["# Gallery of models in space", "", *OF_SPACE, ""]
    lines += ["| " * COLUMNS + "|", "|---" * COLUMNS + "|"]
    cells = []
    for path in sorted((HERE.parent / "models" / "space").glob("*.mbd")):
        scene = mbdsl.load(path)
        content = film(mbdsl.simulate(scene, method=None if scene.experiment.tolerance else "hht-si2"), [])
        (folder / f"{path.stem}.gif").write_bytes(content)
        name = f"models/space/{path.name}"
        cells.append(f"![{scene.doc}](gallery/space/{path.stem}.gif)<br>{scene.doc}: [`{path.stem}`](../{name})")
        print(f"{path.stem}: {len(content) / 1000:.0f} KB")
    for first in range(0, len(cells), COLUMNS):
        row = cells[first : first + COLUMNS]
        lines.append(f"| {' | '.join([*row, *[''] * (COLUMNS - len(row))])} |")
    (HERE / "space-gallery.md").write_text("\n".join([*lines, ""]), encoding="utf-8")


def main(names: list[str]) -> None:
    if names == ["--space"]:
        in_space()
        return
    for name in names or [name for group in GROUPS.values() for name in group]:
        scene = mbdsl.load(MODELS / f"{name}.mbd")
        text = page(name)
        driven = RESIDUAL.search(text)
        run = mbdsl.simulate(scene, method=DRIVEN if driven else None)
        content = film(run, option(name, "--trace"), option(name, "--arrows"))
        (GALLERY / f"{name}.gif").write_bytes(content)
        if driven:
            found = f"{residual(turned(scene)):.0e}"
            (GALLERY / f"{name}.md").write_text(RESIDUAL.sub(rf"\g<1>{found}\g<2>", text), encoding="utf-8")
        print(f"{name}: {len(content) / 1000:.0f} KB")
    (GALLERY / "index.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
