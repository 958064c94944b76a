"""The garbage collector is paused while a model is set up, and works as before afterwards."""

import gc
import weakref

import pytest

from mbdsl.storage.garbage_collection import paused


class Node:
    """An object that can refer to itself."""


@pytest.fixture
def enabled():
    """An enabled collector without frozen objects; the test session freezes its own (conftest.py)."""
    was, frozen = gc.isenabled(), gc.get_freeze_count()
    gc.enable()
    gc.unfreeze()
    yield
    if frozen:
        gc.freeze()
    (gc.enable if was else gc.disable)()


def test_no_collection_inside(enabled):
    with paused():
        assert not gc.isenabled()
    assert gc.isenabled()


def test_stays_disabled():
    was = gc.isenabled()
    gc.disable()
    try:
        with paused():
            pass
        assert not gc.isenabled()
    finally:
        if was:
            gc.enable()


def test_cycles_made_inside_are_collected_later(enabled):
    """They are old, but not exempt from collection."""
    with paused():
        node = Node()
        node.itself = node
        seen = weakref.ref(node)
        del node
    assert gc.get_freeze_count() == 0
    gc.collect()
    assert seen() is None


def test_the_next_collection_does_not_visit_them(enabled):
    with paused():
        made = [[] for _ in range(10_000)]
    assert gc.get_count()[0] < 1_000  # the young ones, of which a collection visits all
    assert len(made) == 10_000


def test_frozen_objects_of_others_stay_frozen(enabled):
    gc.collect()
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        with paused():
            pass
        assert gc.get_freeze_count() == frozen > 0
    finally:
        gc.unfreeze()
