"""Results that are read in parts: the same values as those of whole files, bounded memory, errors, units."""

import os
import tracemalloc

import numpy as np
import pytest
import scipy.io

from mbdsl import results
from mbdsl.elements import kinds
from mbdsl.errors import UsageError
from mbdsl.results import csv_file
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


def test_csv_with_and_without_pandas(tmp_path, monkeypatch):
    path = tmp_path / "r.csv"
    results.write(path, columns(), UNITS, {"complete": True})
    known = [c for _, c in open_result(path).chunks(["O.fx", "a.x", "link[1,2].w"], 300)]
    used = []
    by_pandas = csv_file._by_pandas
    monkeypatch.setattr(csv_file, "_by_pandas", lambda *given: used.append(given) or by_pandas(*given))
    monkeypatch.setattr(csv_file, "LARGE", 0)
    found = [c for _, c in open_result(path).chunks(["O.fx", "a.x", "link[1,2].w"], 300)]
    assert used
    for a, b in zip(known, found, strict=True):
        assert list(a) == list(b)
        assert all(np.array_equal(a[name], b[name], equal_nan=True) for name in a)


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
