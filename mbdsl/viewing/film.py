"""Films and pictures: GIF and PNG by Pillow, MP4 by ffmpeg, if they are installed."""

from __future__ import annotations

import io
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.messages import install
from mbdsl.plotting.series_styles import LIGHT_PAPER
from mbdsl.viewing.motion import nearest
from mbdsl.viewing.overlays import Overlays
from mbdsl.viewing.picture import NOTHING_ELSE, Picture
from mbdsl.viewing.projection import drawing
from mbdsl.viewing.shapes import Drawing
from mbdsl.viewing.tracks import Tracks

if TYPE_CHECKING:
    from PIL import Image

RATE = 25  #: pictures per second
SAMPLES = 4  #: number of frames that the colours of a GIF are taken from
SHORTEST, LONGEST = 2.0, 20.0  #: [s]; motions of another duration are played slower or faster


def film(
    motion: Tracks,
    suffix: str,
    width: int = 640,
    height: int = 400,
    overlays: Overlays = NOTHING_ELSE,
    drawn: Drawing | None = None,
) -> bytes:
    """A motion as a film, or a picture of its start.

    Parameters
    ----------
    motion : Tracks
        The motion.
    suffix : str
        ".gif", ".mp4", or ".png" for its first row.
    width, height : int, optional
        Size [px]; even numbers for ".mp4".
    overlays : Overlays, optional
        Paths, arrows and another motion.
    drawn : Drawing, optional
        Shapes and the extent of the picture. Default: those of the motion.

    Returns
    -------
    bytes
        The content of the file: 25 pictures per second in real time, slower or faster if it would last less than 2 s or
        more than 20 s.

    Raises
    ------
    UsageError
        If Pillow or ffmpeg is missing, or ffmpeg fails.
    """
    try:
        import PIL  # noqa: F401
    except ImportError:
        raise UsageError("films need Pillow", hint=f"{install('film')}; a page (.html) needs nothing") from None
    picture = Picture(motion, drawn or drawing(motion), width, height, overlays)
    rows = rows_of(motion).tolist()
    pictures = (picture.frame(row) for row in rows)
    if suffix == ".png":
        stream = io.BytesIO()
        next(pictures).save(stream, "PNG", optimize=True)
        return stream.getvalue()
    return _gif(pictures, _palette(picture, rows)) if suffix == ".gif" else _mp4(pictures, width, height)


def rows_of(motion: Tracks) -> np.ndarray:
    """The rows of the motion that the film shows, the nearest to evenly spaced times."""
    t = motion.t
    duration = float(t[-1] - t[0])
    count = max(1, round(RATE * min(LONGEST, max(SHORTEST, duration)))) if duration > 0.0 else 1
    even = t[0] + duration * np.arange(count) / count
    return nearest(t, even) if len(t) > 1 else np.zeros(1, int)


def _palette(picture: Picture, rows: Sequence[int]) -> Image.Image:
    """A picture with the colours of some frames, of which one is exactly that of the paper."""
    from PIL import Image

    width, height = picture.size
    sheet = Image.new("RGB", (width, SAMPLES * height))
    for k in range(SAMPLES):
        sheet.paste(picture.frame(rows[k * len(rows) // SAMPLES]), (0, k * height))
    found = sheet.quantize(128, dither=Image.Dither.NONE)
    colours = np.array(found.getpalette(), dtype=int).reshape(-1, 3)
    paper = [int(LIGHT_PAPER[k : k + 2], 16) for k in (1, 3, 5)]
    colours[np.abs(colours - paper).sum(axis=1).argmin()] = paper
    found.putpalette(colours.ravel().tolist())
    return found


def _gif(pictures: Iterator[Image.Image], palette: Image.Image) -> bytes:
    """All pictures have one palette, so that unchanged pixels are stored once."""
    from PIL import Image

    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in pictures]
    stream = io.BytesIO()
    more = frames[1:]
    frames[0].save(stream, "GIF", save_all=True, append_images=more, duration=1000 // RATE, loop=0, optimize=False)
    return stream.getvalue()


def _mp4(pictures: Iterator[Image.Image], width: int, height: int) -> bytes:
    program = _ffmpeg()
    raw = ("-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", f"{width}x{height}", "-framerate", str(RATE))
    coded = ("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart")
    with tempfile.TemporaryDirectory(prefix="mbdsl-") as folder:
        path = Path(folder, "film.mp4")
        command = [program, "-loglevel", "error", *raw, "-i", "-", *coded, str(path)]
        frames = b"".join(image.tobytes() for image in pictures)
        done = subprocess.run(command, input=frames, capture_output=True, check=False)
        if done.returncode or not path.exists():
            why = " ".join(done.stderr.decode(errors="replace").split())[-200:]
            raise UsageError(f"ffmpeg has failed: {why}", hint="write a .gif or a page (.html)")
        return path.read_bytes()


def _ffmpeg() -> str:
    if program := shutil.which("ffmpeg"):
        return program
    try:
        import imageio_ffmpeg
    except ImportError:
        hint = f"{install('film')}, or install ffmpeg; a .gif or a page (.html) needs neither"
        raise UsageError("MP4 needs the program ffmpeg", hint=hint) from None
    return imageio_ffmpeg.get_ffmpeg_exe()
