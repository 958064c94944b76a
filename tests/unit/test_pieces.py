"""Emitted modules assembled from stored pieces: without numba, equal to modules that are compiled as a whole."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.compilation import code_cache, pieces
from mbdsl.storage import cache_folder
from mbdsl.system import build, emit

MODEL = Path(__file__).parents[2] / "models" / "pendulum.mbd"
EVALUATE = f"""
import sys, mbdsl
from mbdsl.system import build
f, _, _ = build(mbdsl.load({str(MODEL)!r})).evaluate(0.0, [1.0, 2.0], [3.0, 4.0], [5.0])
print(f.tobytes().hex(), "numba" in sys.modules)
"""
pytestmark = pytest.mark.skipif(not code_cache.enabled(), reason="nothing is compiled")
FUNCTION = pieces.Signature(("float", "vector", "matrix", "ints"))
TEXT = '''
"""A module."""
from mbdsl.compilation.buffer_layout import BLOCKS
from mbdsl.system import loops


def both(t, v, M, layout):
    loops.first(t, 3, BLOCKS, v)
    loops.second(layout[2], M, layout)
'''


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """An empty cache; returns the folder of the objects."""
    monkeypatch.setenv("MBDSL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(cache_folder, "_said", [])
    monkeypatch.setattr(code_cache, "_functions", {})
    return tmp_path / "cache" / code_cache.version()


def evaluated(monkeypatch):
    """Residuals and a matrix of the pendulum at a state that is not consistent, with code that is loaded or compiled
    now."""
    monkeypatch.setattr(code_cache, "_functions", {})
    system = build(mbdsl.load(MODEL))
    q, v, lam = (np.random.default_rng(seed).normal(size=n) for seed, n in enumerate((system.n, system.n, system.m)))
    return [*system.evaluate(0.3, q, v, lam), system.tangent(0.3, q, v, lam, cM=1.0, cK=2.0, cP=3.0, cN=4.0)]


def test_text_is_read_as_calls():
    (function,) = pieces.read(TEXT, {"both": FUNCTION}).values()
    first, second = function.calls
    assert function.names == ["t", "v", "M", "layout"]
    assert first.piece == pieces.Piece("mbdsl.system.loops", "first", ("float", "int", "int", "vector"))
    assert first.arguments[:2] == ("t", 3) and isinstance(first.arguments[2], int)
    assert second == (pieces.Piece("mbdsl.system.loops", "second", ("int", "matrix", "ints")), ((2,), "M", "layout"))


@pytest.mark.parametrize(
    "statement",
    [
        "for k in range(3): loops.first(t, k, 3, v)",
        "v[0] = t",
        "loops.first(t + 1.0, 3, 4, v)",
        "loops.first(v[0], 3, 4, v)",
        "unknown.first(t)",
        "loops.first(t, k=3)",
        "return loops.first(t)",
    ],
)
def test_other_texts_are_not_assembled(statement):
    with pytest.raises(pieces.NotStraight):
        pieces.read(f"{TEXT}    {statement}\n", {"both": FUNCTION})


def test_assembled_code_gives_the_bits_of_code_compiled_as_a_whole(fresh, monkeypatch):
    assembled = evaluated(monkeypatch)
    assert list(fresh.glob("mbdsl_piece_*.bc"))
    (path,) = fresh.glob("*.o")
    read = set(path.read_bytes().split(b"\n")[2].decode().split())
    path.unlink()
    monkeypatch.setattr(code_cache, "_assembled", lambda *arguments: None)
    for one, other in zip(assembled, evaluated(monkeypatch), strict=True):
        assert np.isfinite(one).any()
        assert one.tobytes() == other.tobytes()
    # an edit of any of these files must lead to a new compilation of both; expression_tape is called by no pendulum
    whole = set(path.read_bytes().split(b"\n")[2].decode().split())
    assert "mbdsl.elements.distance" in whole
    assert whole - read <= {"mbdsl.system.expression_tape"}


def test_pieces_depend_on_the_source_of_their_kind(fresh, monkeypatch):
    evaluated(monkeypatch)
    (path,) = fresh.glob("mbdsl_piece_mbdsl_kind_distance_fill_*.bc")
    sources = path.read_bytes().split(b"\n")[2].decode().split()
    assert {"mbdsl.elements.distance", "mbdsl.system.loops", "mbdsl.system.emit"} <= set(sources)


def run(cache):
    environment = {**os.environ, "MBDSL_CACHE_DIR": str(cache), "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", EVALUATE], capture_output=True, text=True, env=environment, check=True)
    return done.stdout.split()


def test_a_new_structure_of_known_kinds_needs_no_numba(tmp_path):
    cold, loaded = run(tmp_path)
    assert loaded == "True"
    emitted = list(tmp_path.glob("*/mbdsl_emitted_*.o"))
    assert emitted
    for path in emitted:
        path.unlink()
    assert run(tmp_path) == [cold, "False"]


def test_damaged_and_outdated_pieces_are_made_again(fresh, monkeypatch):
    expected = evaluated(monkeypatch)
    stored = sorted(fresh.glob("mbdsl_piece_*.bc"))
    whole = [path.read_bytes() for path in stored]
    stored[0].write_bytes(whole[0][: len(whole[0]) // 2])
    stored[1].write_bytes(whole[1][:-5] + bytes([whole[1][-5] ^ 1]) + whole[1][-4:])
    for path in fresh.glob("*.o"):
        path.unlink()
    found = evaluated(monkeypatch)
    assert [path.read_bytes().split(b"\n")[1:4] for path in stored] == [data.split(b"\n")[1:4] for data in whole]
    assert all(one.tobytes() == other.tobytes() for one, other in zip(expected, found, strict=True))


def test_a_piece_of_changed_sources_is_not_used(fresh, monkeypatch):
    evaluated(monkeypatch)
    name = build(mbdsl.load(MODEL)).module_name(1)
    signatures = {"evaluate": emit.EVALUATE, "tangent": emit.TANGENT, "inertia": emit.INERTIA}
    given = pieces.read((fresh / f"{name}.py").read_text(encoding="utf-8"), signatures)
    piece = given["evaluate"].calls[0].piece
    assert code_cache._kept_piece(piece) is not None
    monkeypatch.setattr(code_cache, "digest_of", lambda names: "another digest")
    assert code_cache._kept_piece(piece) is None


def test_where_llvmlite_has_changed_modules_are_compiled_as_a_whole(fresh, monkeypatch):
    expected = evaluated(monkeypatch)
    for path in fresh.glob("*.o"):
        path.unlink()

    def fail(*arguments):
        raise AttributeError("not what it was")

    monkeypatch.setattr(pieces, "link", fail)
    with pytest.warns(UserWarning, match="which is slower: AttributeError: not what it was"):
        found = evaluated(monkeypatch)
    assert all(one.tobytes() == other.tobytes() for one, other in zip(expected, found, strict=True))
    assert "numba" in sys.modules
