"""The tests of a room are in the folder of its name."""

from pathlib import Path

import pytest

import mbdsl

UNIT = Path(__file__).parents[1]
ROOMS = sorted(path.parent.name for path in Path(mbdsl.__file__).parent.glob("*/__init__.py"))


@pytest.mark.parametrize("room", ROOMS)
def test_every_room_has_tests(room):
    assert list((UNIT / room).glob("test_*.py"))


def test_no_folder_is_without_a_room():
    """``house`` has the tests of the project as a whole: imports, names, words, pages."""
    folders = {path.name for path in UNIT.iterdir() if list(path.glob("*.py"))}
    assert folders == {*ROOMS, "house"}
    assert not list(UNIT.glob("test_*.py"))
