"""Result files return the written values, in every format, and other tools read them."""

import csv
import os

import numpy as np
import pandas
import pytest
import scipy.io
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.io import netcdf_file

from mbdsl import results
from mbdsl.cli import main
from mbdsl.errors import UsageError
from mbdsl.plotting import table_files
from mbdsl.results.stored import open_result

SUFFIXES = sorted(results.formats())
META = {"complete": True, "model": "SliderCrank", "method": "hht-si2", "step": 0.001, "version": "0.1.0"}
UNITS = {"time": "s", "link[1].b.x": "m", "O.Phi[1]": "m"}
HARD = np.array(
    [0.0, -0.0, 5e-324, 2.2250738585072014e-308, 0.1, -1 / 3, 1.7976931348623157e308, np.inf, -np.inf, np.nan]
)


def columns(n=HARD.size):
    time = np.linspace(0.0, 1.0, n)
    return {"time": time, "link[1].b.x": HARD[:n].copy(), "a[1,2].w": time**2, "file": -time, "O.Phi[1]": time - 1e-17}


def same(a, b):
    """Equal to the bit."""
    return np.array_equal(np.asarray(a).view(np.int64), np.asarray(b).view(np.int64))


def test_formats_are_found():
    assert SUFFIXES == [".csv", ".mat", ".nc", ".npz"]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("n", [HARD.size, 1, 0])
def test_what_is_written_is_read(tmp_path, suffix, n):
    path = tmp_path / f"r{suffix}"
    results.write(path, columns(n), UNITS, META)
    found, meta = results.read(path)
    assert list(found) == list(columns(n))
    assert all(same(found[name], values) for name, values in columns(n).items())
    assert meta == (META if suffix != ".csv" else {"complete": True})
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_incomplete_results_say_so_until_complete_ones_replace_them(tmp_path, suffix):
    path = tmp_path / f"r{suffix}"
    for complete in (False, True):
        results.write(path, columns(), UNITS, {**META, "complete": complete})
        assert results.read(path)[1]["complete"] is complete


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(derandomize=True, deadline=None)
@given(data=arrays(float, st.tuples(st.integers(0, 5), st.just(3)), elements=st.floats(width=64)))
def test_any_doubles_survive(tmp_path_factory, suffix, data):
    path = tmp_path_factory.mktemp("any") / f"r{suffix}"
    written = dict(zip(("time", "a.x", "a.y"), data.T, strict=True))
    results.write(path, written)
    for name, values in results.read(path)[0].items():
        np.testing.assert_array_equal(values, written[name])


# -- other readers -------------------------------------------------------------------------------------------------
def test_pandas_and_numpy_read_the_csv(tmp_path):
    path = tmp_path / "r.csv"
    results.write(path, columns(), UNITS, {**META, "complete": False})
    frame = pandas.read_csv(path, engine="python")
    assert list(frame.columns) == list(columns())
    np.testing.assert_array_equal(frame["link[1].b.x"], HARD)
    np.testing.assert_array_equal(np.loadtxt(path, delimiter=",", skiprows=1)[:, 1], HARD)


def test_csv_spans_chunks(tmp_path):
    n = 20_000
    results.write(tmp_path / "r.csv", {"time": np.arange(n) / 7.0, "x": np.sqrt(np.arange(n))})
    with open(tmp_path / "r.csv", newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows[0] == ["time", "x"]
    assert len(rows) == n + 1
    assert [float(row[1]) for row in rows[1:]] == np.sqrt(np.arange(n)).tolist()


def test_numpy_reads_the_archive_by_name(tmp_path):
    results.write(tmp_path / "r.npz", columns(), UNITS, META)
    with np.load(tmp_path / "r.npz") as archive:
        np.testing.assert_array_equal(archive["link[1].b.x"], HARD)


def test_a_text_is_no_archive(tmp_path):
    """NumPy takes any content for pickled objects; the message must not recommend to load them."""
    (tmp_path / "r.npz").write_text("time,x", encoding="utf-8")
    with pytest.raises(UsageError, match=r"is not a \.npz result file, or is damaged: File is not a zip file"):
        results.read(tmp_path / "r.npz")


def test_mat_is_laid_out_as_trajectory_readers_expect(tmp_path):
    results.write(tmp_path / "r.mat", columns(), UNITS, META)
    mat = scipy.io.loadmat(tmp_path / "r.mat", chars_as_strings=False)
    assert ["".join(row).strip() for row in mat["Aclass"]] == ["Atrajectory", "1.1", "", "binTrans"]
    names = ["".join(column).strip() for column in mat["name"].T]
    notes = ["".join(column).strip() for column in mat["description"].T]
    assert names[:2] == ["time", "link[1].b.x"]
    assert notes[:2] == ["[s]", "[m]"]
    assert mat["dataInfo"].dtype == np.int32
    assert mat["dataInfo"][:, :2].T.tolist() == [[0, 1, 0, -1], [2, 2, 0, -1]]
    assert mat["data_1"].shape[1] == 2
    assert mat["data_1"][0].tolist() == [0.0, 1.0]
    step = names.index("mbdsl.step")
    assert mat["data_1"][mat["dataInfo"][1, step] - 1].tolist() == [0.001, 0.001]
    np.testing.assert_array_equal(mat["data_2"][mat["dataInfo"][1, 1] - 1], HARD)


def test_negated_aliases_of_other_tools_are_read(tmp_path):
    results.write(tmp_path / "r.mat", {"time": np.arange(3.0), "x": np.ones(3)})
    raw = (tmp_path / "r.mat").read_bytes()
    info = np.array([[0, 1, 0, -1], [2, 2, 0, -1]], dtype="<i4").tobytes()
    assert info in raw
    (tmp_path / "r.mat").write_bytes(raw.replace(info, np.array([[0, 1, 0, -1], [2, -2, 0, -1]], "<i4").tobytes()))
    assert results.read(tmp_path / "r.mat")[0]["x"].tolist() == [-1.0, -1.0, -1.0]


def test_xarray_reads_the_netcdf(tmp_path):
    results.write(tmp_path / "r.nc", columns(), UNITS, META)
    with xarray.open_dataset(tmp_path / "r.nc", engine="scipy") as data:
        np.testing.assert_array_equal(data["link[1].b.x"], HARD)
        assert data["link[1].b.x"].dims == ("time",)
        assert data["link[1].b.x"].attrs["units"] == "m"
        assert data.attrs["mbdsl_method"] == "hht-si2"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_names_of_all_alphabets(suffix, tmp_path, monkeypatch):
    """Read back as a whole and in parts, from a .csv file of another program. The NetCDF format has names in UTF-8."""
    names = ["größe", "Ω.x", "日本", "a\N{COMBINING RING ABOVE}"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "u.csv").write_text(f"time,{','.join(names)}\n0,1,2,3,4\n1,5,6,7,8\n", encoding="utf-8")
    assert main(["convert", "u.csv", "--out", f"o{suffix}"]) == 0
    found, _ = results.read(f"o{suffix}")
    if suffix == ".nc":
        names[-1] = "\u00e5"  # composed (NFC), as the format demands
        with netcdf_file("o.nc", mmap=False) as file:
            assert [name.encode("latin-1").decode("utf-8") for name in file.variables] == ["time", *names]
    assert list(found) == ["time", *names] == ["time", *open_result(f"o{suffix}").names]
    assert found["日本"].tolist() == [3.0, 7.0]
    assert main(["info", f"o{suffix}"]) == 0


def test_names_in_latin_1_are_read(tmp_path):
    """As other programs write them, which take the bytes of a name for characters."""
    with netcdf_file(tmp_path / "r.nc", "w") as file:
        file.createDimension("time", 2)
        for name, values in (("time", [0.0, 1.0]), ("größe", [3.0, 4.0])):
            file.createVariable(name, "f8", ("time",))[:] = values
    assert results.read(tmp_path / "r.nc")[0]["größe"].tolist() == [3.0, 4.0]
    assert open_result(tmp_path / "r.nc").names == ["größe"]


def test_names_that_are_formulas_of_spreadsheets(tmp_path, monkeypatch):
    """Files of other authors are converted to cells with text, by an apostrophe (OWASP, CSV injection)."""
    monkeypatch.chdir(tmp_path)
    names = ["=cmd|' /C calc'!A0", "+1", "-x", "@SUM(1)", "\tq", " =1", "pin.f", "1-x"]
    units = dict.fromkeys(names, "m") | {"pin.f": "=1+1"}
    results.write("r.npz", {"time": np.zeros(2), **{name: -np.ones(2) for name in names}}, units)
    assert main(["convert", "r.npz", "--out", "r.csv", "--units"]) == 0
    with open("r.csv", encoding="utf-8", newline="") as stream:
        head, row_of_units, *rows = csv.reader(stream)
    assert head == ["time", *(f"'{name}" for name in names[:6]), "pin.f", "1-x"]
    assert row_of_units[-2:] == ["'=1+1", "m"] and rows[0][1:] == ["-1.0"] * 8
    written = table_files.as_csv([{"=1": "@x", "ok": "-y", "b": -1.0}])
    assert written == "'=1,ok,b\n'@x,'-y,-1.0\n"


# -- errors -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "expected"), [("r.xls", "unknown suffix `.xls`"), ("r", "no suffix on result file `r`")]
)
def test_unknown_suffix_lists_the_known_ones(name, expected):
    with pytest.raises(UsageError) as caught:
        results.write(name, {"time": np.zeros(1)})
    assert expected in caught.value.message
    assert caught.value.hint == "known suffixes are .csv, .mat, .nc, .npz"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, suffix):
    path = tmp_path / f"r{suffix}"
    results.write(path, columns(), UNITS, META)
    before = path.read_bytes()
    with pytest.raises(ValueError, match=r"."):
        results.write(path, {"time": np.zeros(2), "x": np.array(["no", "number"])}, UNITS, META)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [path.name]


def test_folder_that_is_not_there(tmp_path):
    with pytest.raises(UsageError, match=r"cannot write .*No such file"):
        results.write(tmp_path / "none" / "r.csv", columns())


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 nothing", b"time,b\n1,2\n3\n", bytes(64)])
def test_files_of_another_kind_are_refused(tmp_path, suffix, content):
    path = tmp_path / f"r{suffix}"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=f"is not a {suffix} result file"):
        results.read(path)
