"""The models of the gallery, and runs of 1,000 revolutions of those that are driven."""

import runpy
from functools import cache
from pathlib import Path

import pytest

import mbdsl
from mbdsl.system.peaks_along_motion import OnTheWay

ROOT = Path(__file__).parents[2]
DRAW = runpy.run_path(str(ROOT / "docs" / "draw_gallery.py"))


@pytest.fixture(scope="session")
def draw():
    """The names that docs/draw_gallery.py defines."""
    return DRAW


@pytest.fixture(scope="session")
def gallery():
    """``gallery(name)``: the model; ``gallery(name, parameters)``: with other values."""
    return lambda name, parameters=None: mbdsl.load(ROOT / "models" / "gallery" / f"{name}.mbd", parameters)


@pytest.fixture(scope="session")
def turned(gallery):
    """``turned(name)``: 1,000 revolutions of a driven model, 24 states in each, the same run for all tests.

    They are not searched for peaks of laws, which does not change a motion: with the laws of geneva_drive, the search
    takes a hundred times as long as the run. test_geneva_drive has the search.
    """
    known = {}

    def find(name):
        if name not in known:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(OnTheWay, "first", lambda self, *motion: [])
                known[name] = DRAW["turned"](gallery(name))
        return known[name]

    return find


@pytest.fixture(scope="session")
def whole(gallery):
    """``whole(name)``: the run of a model to its end, the same for all tests."""
    return cache(lambda name: mbdsl.simulate(gallery(name)))


@pytest.fixture(scope="session")
def one_cycle(gallery):
    """``one_cycle(name)``: one revolution of a driven model, for accelerations and reactions."""

    def find(name):
        scene = gallery(name)
        step = scene.experiment.stop / DRAW["STEPS"]
        return mbdsl.simulate(scene, method="newmark", step=step, interval=step)

    return find
