"""Films: pixels against the motion, times, and what is missing."""

import shutil
import subprocess

import numpy as np
import pytest

from mbdsl import load
from mbdsl.errors import UsageError
from mbdsl.plotting.series_styles import OTHERS
from mbdsl.viewing import film as films
from mbdsl.viewing.marks import THEME
from mbdsl.viewing.motion import motion
from mbdsl.viewing.overlays import Overlays
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.shapes import drawing
from mbdsl.viewing.vectors import Vector

Image = pytest.importorskip("PIL.Image", reason="films need Pillow")


@pytest.fixture(scope="module")
def pendulum(trajectory_of, model_file):
    """A mass on a circle of 1 m, in two seconds."""
    t = np.linspace(0.0, 2.0, 81)
    return trajectory_of(load(model_file("pendulum")), t, {"mass": np.column_stack([np.cos(3 * t), np.sin(3 * t)])})


def blue(image):
    """The centre [px] of the pixels of the mass's blue."""
    red, green, blue = np.moveaxis(np.asarray(image.convert("RGB"), int), -1, 0)
    y, x = np.nonzero((blue - red > 100) & (blue > green))
    assert len(x) > 50
    return x.mean() + 0.5, y.mean() + 0.5


def test_pixels_are_where_the_mass_is(pendulum):
    moving = motion(pendulum)
    picture = Picture(moving, drawing(moving), 400, 300)
    for row in (0, 17, 80):
        x, y = blue(picture.frame(row))
        assert x == pytest.approx(picture.left + picture.scale * pendulum["mass.x"][row], abs=1.0)
        assert y == pytest.approx(picture.top - picture.scale * pendulum["mass.y"][row], abs=1.0)


def test_a_film_lasts_as_long_as_the_motion(pendulum, tmp_path):
    """Fifty pictures of 40 ms, each of the state at its time."""
    pendulum.animate().save(tmp_path / "p.gif", (400, 300))
    moving = motion(pendulum)
    picture = Picture(moving, drawing(moving), 400, 300)
    with Image.open(tmp_path / "p.gif") as film:
        assert (film.size, film.n_frames, film.info["loop"]) == ((400, 300), 50, 0)
        total = 0
        for k in range(50):
            film.seek(k)
            total += film.info["duration"]
            if k in (10, 35):
                x, y = blue(film)
                angle = 3 * 0.04 * k
                # the nearest stored state is up to 12.5 ms away, in which the mass moves by 0.0375 m
                assert x == pytest.approx(picture.left + picture.scale * np.cos(angle), abs=0.04 * picture.scale)
                assert y == pytest.approx(picture.top - picture.scale * np.sin(angle), abs=0.04 * picture.scale)
    assert total == 2000


@pytest.mark.parametrize(("duration", "count"), [(0.01, 50), (5.0, 125), (1000.0, 500)])
def test_short_and_long_motions(trajectory_of, pendulum, duration, count):
    t = np.linspace(0.0, duration, 1001)
    moving = motion(trajectory_of(pendulum.scene, t, {"mass": np.column_stack([np.cos(t), np.sin(t)])}))
    rows = films.rows_of(moving)
    assert len(rows) == count and (np.diff(rows) > 0).all()
    assert np.diff(moving.t[rows]).max() <= 1.6 * duration / count


def test_a_motion_without_numbers_is_an_empty_picture(slider_crank, trajectory_of):
    moving = motion(trajectory_of(slider_crank.scene, [0.0, 1.0], {"crank": np.full((2, 3), np.nan)}))
    assert Picture(moving, drawing(moving), 100, 80).frame(1).size == (100, 80)


def test_without_ffmpeg(pendulum, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with pytest.raises(UsageError, match="MP4 needs the program ffmpeg") as caught:
        pendulum.animate(tmp_path / "p.mp4")
    assert "'.[film]'" in caught.value.hint and not list(tmp_path.iterdir())


def test_ffmpeg_gets_all_pictures(pendulum, tmp_path, monkeypatch):
    """A program in place of ffmpeg sees the bytes of 50 pictures, and its failure is a message."""
    seen = {}

    def run(command, input, **given):
        seen.update(command=command, size=len(input))
        return subprocess.CompletedProcess(command, 1, b"", b"no codec")

    monkeypatch.setattr(shutil, "which", lambda name: f"/bin/{name}")
    monkeypatch.setattr(subprocess, "run", run)
    with pytest.raises(UsageError, match="ffmpeg has failed: no codec"):
        pendulum.animate().save(tmp_path / "p.mp4", (64, 64))
    assert seen["size"] == 50 * 64 * 64 * 3
    assert seen["command"][0] == "/bin/ffmpeg" and "64x64" in seen["command"]
    assert not list(tmp_path.iterdir())


def pixels_of(image, colour):
    """Columns and rows of the pixels that have a colour up to 12 levels."""
    wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
    y, x = np.nonzero((np.abs(np.asarray(image.convert("RGB"), int) - wanted) <= 12).all(axis=-1))
    return x + 0.5, y + 0.5


def test_paths_arrows_and_a_ghost(pendulum, trajectory_of):
    """The path of the mass is the unit circle, an arrow ends where its force says, the ghost is pale."""
    moving = motion(pendulum)
    mass = moving.spots["mass.c"]
    force = Vector("f", "forces", "force", mass, np.tile([0.0, 2.0], (len(moving.t), 1)))
    other = motion(trajectory_of(pendulum.scene, [0.0], {"mass": np.array([[-0.5, 0.0]])}))
    picture = Picture(moving, drawing(moving), 400, 300, Overlays(["mass.c"], [force], other))
    image = picture.frame(80)
    x, y = pixels_of(image, OTHERS[0].light)
    radius = np.hypot(x - picture.left, y - picture.top) / picture.scale
    far = np.hypot(x - picture.left - picture.scale * np.cos(6), y - picture.top + picture.scale * np.sin(6)) > 30
    assert far.sum() > 200 and np.abs(radius[far] - 1.0).max() < 3 / picture.scale
    # the arrow begins at the mass and points up by 22 % of the height of 300 px
    x, y = pixels_of(image, THEME["load"])
    top = picture.top - picture.scale * np.sin(6.0) - 0.22 * 300
    assert y.min() == pytest.approx(top, abs=1.5)
    assert np.abs(x - picture.left - picture.scale * np.cos(6.0)).max() < 8
    # the ghost at (-0.5, 0): a pale ball
    place = image.getpixel((round(picture.left - picture.scale / 2), round(picture.top) - 6))
    assert min(place) > 150 and max(place) - min(place) > 10
