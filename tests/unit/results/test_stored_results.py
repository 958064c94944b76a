"""Results that are read in parts: the same values as those of whole files, bounded memory, errors, units."""

import os
import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
import scipy.io

from mbdsl import results
from mbdsl.elements import kinds
from mbdsl.errors import UsageError
from mbdsl.results import csv_file, rows_file
from mbdsl.results.stored import USUAL_UNITS, open_result

SUFFIXES = sorted(results.formats())
UNITS = {"time": "s", "a.x": "m", "link[1,2].w": "rad/s", "O.fx": "N"}


def columns(n=1000):
    t = np.linspace(0.0, 1.0, n)
    return {"time": t, "a.x": np.sin(t), "link[1,2].w": np.where(t < 0.5, t, np.nan), "O.fx": -t / 3.0}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("rows", [7, 1000, 4096])
def test_parts_are_the_whole(tmp_path, suffix, rows):
    path = tmp_path / f"r{suffix}"
    results.write(path, columns(), UNITS, {"complete": True})
    result = open_result(path)
    assert result.names == list(columns())[1:]
    parts = list(result.chunks(["O.fx", "link[1,2].w"], rows))
    assert all(len(t) == rows for t, _ in parts[:-1])
    whole = results.read(path)[0]
    assert np.array_equal(np.concatenate([t for t, _ in parts]), whole["time"])
    for name in ("O.fx", "link[1,2].w"):
        assert np.array_equal(np.concatenate([c[name] for _, c in parts]), whole[name], equal_nan=True)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_units(tmp_path, suffix):
    path = tmp_path / f"r{suffix}"
    results.write(path, columns(), UNITS, {"complete": True})
    result = open_result(path)
    assert [result.unit(name) for name in ("time", "a.x", "link[1,2].w")] == ["s", "m", "rad/s"]
    assert result.unit("O.fx") == ("" if suffix == ".csv" else "N")


def test_assumed_units_are_those_of_all_kinds():
    """Units by names, for CSV files, contradict no kind of element."""
    found = 0
    for kind in kinds().values():
        for key, unit in USUAL_UNITS.items():
            if unit != "J" and (declared := kind.unit_of(key)) is not None:
                assert declared == unit, (kind, key)
                found += 1
    assert found > 5


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_empty_results(tmp_path, suffix):
    path = tmp_path / f"r{suffix}"
    results.write(path, {name: x[:0] for name, x in columns().items()}, UNITS, {"complete": True})
    assert list(open_result(path).chunks(["a.x"])) == []


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".nc"])
def test_memory_does_not_grow_with_the_result(tmp_path, suffix):
    """NumPy's arrays, which tracemalloc counts, have the size of the parts: 5 columns of 8 kB instead of 1.6 MB."""
    path = tmp_path / f"r{suffix}"
    results.write(path, columns(200_000), UNITS, {"complete": True})
    result = open_result(path)
    next(result.chunks(["a.x"], 1024))  # imports
    tracemalloc.start()
    for _ in result.chunks(["a.x", "O.fx"], 1024):
        pass
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 500_000


def test_csv_by_both_readers(tmp_path, monkeypatch):
    """Numbers of all sizes are read to the same bits by the fast and by the strict reader."""
    path, random = tmp_path / "r.csv", np.random.default_rng(1)
    bits = random.integers(0, 2**63, 3000).view(float)
    results.write(path, {"time": np.arange(3000) / 7.0, "a.x": bits, "b.x": -bits[::-1]})
    known = [c for _, c in open_result(path).chunks(["b.x", "a.x"], 800)]
    used = []
    fast = csv_file._fast
    monkeypatch.setattr(csv_file, "_fast", lambda *given: used.append(fast(*given)) or used[-1])
    monkeypatch.setattr(csv_file, "MANY", 0)
    found = [c for _, c in open_result(path).chunks(["b.x", "a.x"], 800)]
    assert all(x is not None for x in used)
    for a, b in zip(known, found, strict=True):
        assert list(a) == list(b)
        assert all(np.array_equal(a[name], b[name], equal_nan=True) for name in a)


def test_rows_that_only_the_strict_reader_can_judge(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_file, "MANY", 0)
    for text in ("1,2x", "1", "1,", "1,--2 "):
        (tmp_path / "r.csv").write_text(f"time,a.x\n0,1\n{text}\n2,3\n")
        with pytest.raises(UsageError, match=r"is not a \.csv result file"):
            list(open_result(tmp_path / "r.csv").chunks(["a.x"]))


def test_row_of_units(tmp_path):
    path = tmp_path / "r.csv"
    results.write(path, columns(), UNITS, {"complete": True}, row_of_units=True)
    assert path.read_bytes().split(b"\n")[1] == b"s,m,rad/s,N"
    result = open_result(path)
    assert [result.unit(name) for name in result.names] == ["m", "rad/s", "N"]
    for name, x in results.read(path)[0].items():
        assert np.array_equal(x, columns()[name], equal_nan=True)
        assert np.array_equal(np.concatenate([c[name] for _, c in result.chunks([name], 300)]), x, equal_nan=True)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_written_in_parts_are_the_same(tmp_path, suffix, monkeypatch):
    """Rows from a scratch file of small blocks give the same bytes as arrays."""
    monkeypatch.setattr(rows_file, "ROWS", 16)
    whole = columns(203)
    results.write(tmp_path / f"a{suffix}", whole, UNITS, {"complete": True})
    with rows_file.RowsFile(list(whole), tmp_path / "b") as file:
        for first, end in pairwise([0, 1, 90, 96, 203]):
            file.append([x[first:end] for x in whole.values()])
        results.write(tmp_path / f"b{suffix}", file.columns(), UNITS, {"complete": True})
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize("count", [0, 16, 21])
def test_a_kept_file_of_rows_is_continued(tmp_path, monkeypatch, count):
    monkeypatch.setattr(rows_file, "ROWS", 16)
    data = np.random.default_rng(2).random((3, 50))
    file = rows_file.RowsFile("abc", tmp_path / "rows", kept=True)
    file.append(data[:, :count])
    file.flush()
    file.append(-data)  # lost in the power cut
    file.close()
    again = rows_file.RowsFile("abc", tmp_path / "rows", kept=True, count=count)
    again.append(data[:, count:])
    assert all(np.array_equal(x[:], data[k]) for k, x in enumerate(again.columns().values()))
    again.remove()
    assert os.listdir(tmp_path) == []
    with pytest.raises(UsageError, match="has fewer than 5 rows"):
        rows_file.RowsFile("abc", tmp_path / "short", kept=(tmp_path / "short").write_bytes(b"") == 0, count=5)


@pytest.mark.parametrize("transposed", [True, False])
def test_trajectories_of_other_programs(tmp_path, transposed):
    """As Dymola writes them: single precision, a negated alias, constants, units in brackets."""
    path = tmp_path / "r.mat"
    names = ["Time", "a.x", "b.x", "p"]
    texts = ["Time in [s]", "position [m|mm]", "position [m]", "parameter [kg]"]
    info = np.array([[0, 1, 0, -1], [2, 2, 0, -1], [2, -2, 0, -1], [1, 2, 0, 0]], dtype=np.int32)
    t = np.linspace(0.0, 1.0, 11)
    data = {
        "Aclass": np.array(["Atrajectory", "1.1", "", "binTrans" if transposed else "binNormal"]),
        "name": names,
        "description": texts,
        "dataInfo": info,
        "data_1": np.array([[0.0, 1.0], [5.0, 5.0]]).T,
        "data_2": np.column_stack([t, t**2]).astype(np.float32),
    }
    width = max(map(len, names)), max(map(len, texts))
    for key, size in (("name", width[0]), ("description", width[1])):
        table = np.array([list(x.ljust(size)) for x in data[key]])
        data[key] = np.array(["".join(row) for row in (table.T if transposed else table)])
    if transposed:
        data.update({key: data[key].T for key in ("dataInfo", "data_1", "data_2")})
    scipy.io.savemat(path, data, format="4")
    result = open_result(path)
    assert (result.time, result.names, result.unit("a.x")) == ("Time", ["a.x", "b.x"], "m")
    ((times, found),) = result.chunks(["a.x", "b.x"])
    assert times == pytest.approx(t, rel=1e-6)
    assert found["a.x"] == pytest.approx(t**2, rel=1e-6)
    assert found["b.x"] == pytest.approx(-(t**2), rel=1e-6)


def test_archives_of_other_programs(tmp_path):
    t = np.linspace(0.0, 1.0, 5)
    path = tmp_path / "r.npz"
    np.savez_compressed(path, **{"time": t, "a.x": np.arange(5), "table": np.ones((5, 2)), "few": t[:3], "text": "a"})
    result = open_result(path)
    assert result.names == ["a.x"]
    ((_, found),) = result.chunks(["a.x"])
    assert found["a.x"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("part", [0.0, 0.3, 0.95])
def test_damaged_files_are_errors(tmp_path, suffix, part):
    path = tmp_path / f"r{suffix}"
    results.write(path, columns(), UNITS, {"complete": True})
    os.truncate(path, int(part * path.stat().st_size))
    with pytest.raises(UsageError, match=r"is not a .* result file, or is damaged"):
        list(open_result(path).chunks(["a.x"]))


def test_other_errors(tmp_path):
    with pytest.raises(UsageError, match="cannot read"):
        open_result(tmp_path / "none.npz")
    with pytest.raises(UsageError, match="unknown suffix"):
        open_result(tmp_path / "r.xyz")
    np.savez(tmp_path / "r.npz", a=np.ones(3))
    with pytest.raises(UsageError, match="no column `time`"):
        open_result(tmp_path / "r.npz")
    (tmp_path / "r.csv").write_text("time,a.x\n1,2\n3,x\n")
    with pytest.raises(UsageError, match="damaged: could not convert"):
        list(open_result(tmp_path / "r.csv").chunks(["a.x"]))
