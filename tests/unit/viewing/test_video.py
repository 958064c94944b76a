"""A video that ffmpeg has encoded is decoded again, and compared with the pictures that it was made from."""

import shutil
import subprocess

import numpy as np
import pytest

from mbdsl.viewing.motion import motion
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.shapes import drawing

WIDTH, HEIGHT = 320, 240


def program():
    if found := shutil.which("ffmpeg"):
        return found
    return pytest.importorskip("imageio_ffmpeg", reason="needs ffmpeg").get_ffmpeg_exe()


def test_decoded_pictures_are_those_drawn(slider_crank, tmp_path):
    ffmpeg = program()
    slider_crank.animate().save(tmp_path / "crank.mp4", (WIDTH, HEIGHT))
    command = [ffmpeg, "-loglevel", "error", "-i", tmp_path / "crank.mp4", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    found = np.frombuffer(done.stdout, np.uint8).reshape(-1, HEIGHT, WIDTH, 3)
    assert len(found) == 25 * 3  # 25 pictures a second for 3 s
    moving = motion(slider_crank)
    picture = Picture(moving, drawing(moving), WIDTH, HEIGHT)
    for k in (0, 30, 74):
        row = int(np.abs(moving.t - k / 25).argmin())
        drawn = np.asarray(picture.frame(row).convert("RGB"), float)
        distance = [np.abs(found[j] - drawn).mean() for j in range(len(found))]
        # colours are stored at half the resolution: edges differ, areas do not
        assert np.argmin(distance) == k
        assert distance[k] < 1.0  # of 255
