"""Selections, slices by time, and the other forms of a trajectory: arrays, pandas, xarray, result files."""

import json
from pathlib import Path

import numpy as np
import pandas
import pytest
import xarray

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import UsageError

MODEL = Path(__file__).parents[3] / "models" / "slider_crank.mbd"


@pytest.fixture(scope="module")
def run():
    return mbdsl.simulate(MODEL, stop=0.5, step=1e-3, interval=0.01)


# -- selections ----------------------------------------------------------------------------------------------------
def test_a_list_selects_signals(run):
    chosen = run[["O.fx", "crank.phi"]]
    assert isinstance(chosen, mbdsl.Trajectory)
    assert chosen.names == ["time", "O.fx", "crank.phi"]
    assert list(chosen) == chosen.default_names == ["O.fx", "crank.phi"]
    assert len(chosen) == len(run) == 51
    np.testing.assert_array_equal(np.asarray(chosen), np.column_stack([run["O.fx"], run["crank.phi"]]))
    np.testing.assert_array_equal(chosen.to_numpy(), np.asarray(chosen))
    assert [*chosen.signals] == chosen.names
    assert "O.fx" in chosen._repr_html_() and "rod.phi" not in chosen._repr_html_()


def test_a_pattern_selects_signals(run):
    """The same as a list, also if one signal matches; a name is an array."""
    assert run["A.f*"].names == run[["A.f*"]].names == ["time", *(n for n in run.names if n.startswith("A.f"))]
    assert run["crank.ph?"].names == ["time", "crank.phi"]
    assert run["crank.phi"].shape == (51,)
    np.testing.assert_array_equal(run["B.Phi[*]"].to_numpy()[:, 0], run["B.Phi[1]"])
    assert run["crank.phi", "rod.phi"].names == run[["crank.phi", "rod.phi"]].names


def test_a_selection_shares_the_states_and_still_has_all_signals(run):
    chosen = run[["crank.phi"]]
    assert chosen.q is run.q
    np.testing.assert_array_equal(chosen["rod.ax"], run["rod.ax"])
    assert chosen["rod.*"].names == run["rod.*"].names  # of the whole model, not of the selection
    assert chosen.scene is run.scene
    assert chosen[0.1:0.2].names == chosen.names


def test_plots_of_a_selection(run):
    names = [s.name for panel in run[["rod.phi", "O.fx"]].plot().panels for s in panel.series]
    assert sorted(names) == ["O.fx", "rod.phi"]
    assert run[["rod.phi"]].plot("crank.*", against="rod.phi").panels


def test_notebooks_complete_names(run):
    assert run["O.f?"]._ipython_key_completions_() == run.names


@pytest.mark.parametrize(
    ("key", "message", "hint"),
    [
        ("crank.ph", "there is no signal `crank.ph` in SliderCrank", "crank.phi"),
        (["crank.phi", "crank.ph"], "there is no signal `crank.ph` in SliderCrank", "crank.phi"),
        ("crunk.*", "there is no signal `crunk.*` in SliderCrank", "crank."),
        (3, "found [3], expected a name, a list of names or a slice of times", "trajectory.q[k]"),
        (["crank.phi", 3], "found [['crank.phi', 3]], expected a name", "trajectory.q[k]"),
    ],
)
def test_wrong_keys(run, key, message, hint):
    with pytest.raises(UsageError) as caught:
        run[key]
    assert message in caught.value.message
    assert hint in caught.value.hint


# -- slices --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("times", "first", "last"),
    [
        (slice(0.1, 0.2), 10, 20),  # both borders are output times, and included
        (slice(0.1 + 0.2, 0.4), 30, 40),  # 0.30000000000000004
        (slice(0.101, 0.199), 11, 19),
        (slice(None, 0.1), 0, 10),
        (slice(0.4, None), 40, 50),
        (slice(None, None), 0, 50),
        (slice(-1.0, 100), 0, 50),
        (slice("100 ms", "0.2s"), 10, 20),
        (slice("100 ms", 0.2), 10, 20),
        (slice(0.25, 0.25), 25, 25),
    ],
)
def test_slices_by_time(run, times, first, last):
    found = run[times]
    assert len(found) == last - first + 1
    np.testing.assert_allclose(found.t[[0, -1]], [first / 100, last / 100], rtol=1e-15)
    rows = slice(first, last + 1)
    for name in run.names:  # constraints, accelerations, reactions and energies included
        np.testing.assert_array_equal(found[name], run[name][rows])


def test_slices_agree_with_pandas_and_xarray(run):
    pandas.testing.assert_frame_equal(run[0.105:0.2].to_pandas(), run.to_pandas().loc[0.105:0.2])
    assert run[0.105:0.2].to_xarray().identical(run.to_xarray().sel(time=slice(0.105, 0.2)))


def test_a_slice_computes_what_the_whole_has_not():
    """Accelerations of a slice do not need those of the whole, and are the same."""
    one, other = (mbdsl.simulate(MODEL, stop=0.1, step=1e-3, interval=0.01) for _ in range(2))
    np.testing.assert_array_equal(one[0.05:]["rod.ay"], other["rod.ay"][5:])
    assert "_motion" not in vars(one)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (slice(0.1, 0.2, 0.01), "found a slice with the step 0.01, expected two times"),
        (slice(0.2, 0.1), "there is no output time from 0.2 to 0.1 s"),
        (slice(0.101, 0.102), "there is no output time from 0.101 to 0.102 s"),
        (slice(7, None), "there is no output time from 7 to 0.5 s"),
        (slice("1 m", None), "the start of the slice: `1 m` has the wrong unit: expected s, found m"),
        (slice(None, "soon"), "the end of the slice: `soon` is not a number"),
        (slice(None, [1]), "the end of the slice: found [1], expected a number in s"),
        (slice(np.nan, None), "found a slice from nan to 0.5 s, expected finite times"),
    ],
)
def test_wrong_slices(run, times, message):
    with pytest.raises(UsageError) as caught:
        run[times]
    assert message in caught.value.message


def test_state_at_a_time_with_a_unit(run):
    for one, other in zip(run.state("102 ms"), (run.q[10], run.v[10]), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_part_of_a_run_cannot_be_verified(run):
    with pytest.raises(UsageError, match="a part of a run cannot be repeated"):
        mbdsl.study.verify(run[0.1:], ["crank.phi"])


@pytest.mark.parametrize("names", [3, ["crank.phi", 3]])
def test_names_that_are_not_texts(run, names):
    for call in (run.select, run.to_pandas, lambda names: mbdsl.simulate(MODEL, signals=names)):
        with pytest.raises(UsageError, match="found 3"):
            call(names)


# -- files ---------------------------------------------------------------------------------------------------------
def test_files_are_those_of_the_command_line(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = ["--stop", "0.5s", "--step", "1ms", "--interval", "10ms", "--quiet"]
    for suffix, patterns in ((".csv", None), (".csv", ["crank.*", "O.f?"]), (".mat", ["rod.phi"])):
        asked = [] if patterns is None else ["--signals", ",".join(patterns)]
        assert main(["simulate", str(MODEL), *given, *asked, "--output", f"theirs{suffix}"]) == 0
        run.save(f"ours{suffix}", patterns)
        if suffix == ".csv":
            assert Path("ours.csv").read_bytes() == Path("theirs.csv").read_bytes()
        ours, theirs = mbdsl.results.read(f"ours{suffix}"), mbdsl.results.read(f"theirs{suffix}")
        assert ours[1] == theirs[1]
        assert [*ours[0]] == [*theirs[0]]
        for name, x in ours[0].items():
            np.testing.assert_array_equal(x, theirs[0][name])


def test_other_programs_read_the_files(run, tmp_path):
    part = run[["crank.phi", "O.fx"]][0.1:0.2]
    part.to_csv(tmp_path / "a.csv")
    np.testing.assert_array_equal(pandas.read_csv(tmp_path / "a.csv", index_col="time"), part.to_pandas())
    part.to_csv(tmp_path / "u.csv", row_of_units=True)
    assert (tmp_path / "u.csv").read_text().splitlines()[:2] == ["time,crank.phi,O.fx", "s,rad,N"]
    part.save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as file:
        np.testing.assert_array_equal(file["O.fx"], run["O.fx"][10:21])
    part.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc", engine="scipy") as file:
        np.testing.assert_array_equal(file["crank.phi"], run["crank.phi"][10:21])


def test_a_file_contains_the_model_with_its_parameters(tmp_path):
    run = mbdsl.simulate(MODEL, parameters={"m1": "4 kg"}, stop=0.01, step=1e-3)
    run.save(tmp_path / "a.npz")
    said = json.loads(mbdsl.results.read(tmp_path / "a.npz")[1]["source"])
    assert said["set"]["m1"] == 4.0
    assert said["files"][str(MODEL)] == MODEL.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("path", "message"), [("a.txt", "suffix .csv"), ("a", "suffix .csv"), ("no/a.csv", "cannot write")]
)
def test_wrong_paths(run, tmp_path, path, message):
    with pytest.raises(UsageError, match=message):
        run.to_csv(tmp_path / path)


def test_an_unknown_suffix(run, tmp_path):
    with pytest.raises(UsageError, match=r"unknown suffix `.xls`") as caught:
        run.save(tmp_path / "a.xls")
    assert ".csv" in caught.value.hint
    assert list(tmp_path.iterdir()) == []


def test_the_last_of_given_times_is_the_stop_time():
    model = Path(__file__).parents[3] / "models" / "pendulum.mbd"
    assert mbdsl.simulate(model, times=[0.1, 0.25, 0.3], step=1e-3).t.tolist() == [0.0, 0.1, 0.25, 0.3]
    with pytest.raises(mbdsl.UsageError, match="must ascend"):
        mbdsl.simulate(model, times=[0.1, 0.3], stop=0.5)
