"""`mbdsl info` and `mbdsl convert`, and the thinning of long results."""

import numpy as np
import pytest

from mbdsl import results
from mbdsl.plotting.decimation import ThinnedRows, thinned
from mbdsl.results.stored import Result, open_result
from mbdsl.viewing.stored_result import stored_trajectory

SUFFIXES = sorted(results.formats())
UNITS = {"time": "s", "a.x": "m", "a.w": "rad/s", "n": "1"}
META = {"complete": True, "model": "A", "method": "hht-si2", "step": 0.01, "options": "alpha = -0.1", "version": "0.1"}


def columns(n=1001):
    t = np.arange(n) / 100.0
    return {"time": t, "a.x": np.sin(t), "a.w": np.where(t < 5.0, t**2, np.nan), "n": -t}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("other", SUFFIXES)
def test_every_format_is_converted_to_every_other(say, suffix, other):
    results.write(f"a{suffix}", columns(), UNITS, META)
    assert say("convert", f"a{suffix}", "--out", f"b{other}", "--units") == (
        (0, f"b{other}: 1001 rows, time and 3 signals\n", "")
    )
    found, meta = results.read(f"b{other}")
    assert list(found) == list(columns())
    assert all(np.array_equal(found[name], x, equal_nan=True) for name, x in columns().items())
    assert open_result(f"b{other}").unit("a.x") == "m"  # in a file without units, that of the usual signals
    if ".csv" not in (suffix, other):
        assert meta == META


def test_units_of_unusual_signals_are_kept(say):
    results.write("a.nc", {"time": np.arange(3.0), "spring.force": np.ones(3)}, {"spring.force": "N"}, META)
    say("convert", "a.nc", "--out", "b.csv", "--units")
    say("convert", "b.csv", "--out", "c.mat")
    assert open_result("c.mat").unit("spring.force") == "N"


@pytest.mark.parametrize(
    ("options", "rows"),
    [
        (("--start", "2s", "--stop", "3s"), np.arange(200, 301)),
        (("--every", "7"), np.arange(0, 1001, 7)),
        (("--start", "15ms", "--every", "300"), [2, 302, 602, 902]),
        (("--stop", "-1s"), []),
    ],
)
def test_parts_of_a_result(say, monkeypatch, options, rows):
    monkeypatch.setattr(Result.chunks, "__defaults__", (64,))
    results.write("a.npz", columns(), UNITS, META)
    assert say("convert", "a.npz", "--out", "b.npz", "--signals", "n", *options)[0] == 0
    found = results.read("b.npz")[0]
    assert list(found) == ["time", "n"]
    assert found["n"].tolist() == columns()["n"][list(rows)].tolist()


def test_few_rows_keep_the_extremes(say):
    data = columns()
    data["a.x"][[123, 777]] = 9.0, -9.0
    results.write("a.npz", data, UNITS, META)
    assert say("convert", "a.npz", "--out", "b.npz", "--most", "60")[0] == 0
    found = results.read("b.npz")[0]
    assert len(found["time"]) <= 60
    assert (found["a.x"].max(), found["a.x"].min()) == (9.0, -9.0)
    assert found["time"][found["a.x"].argmax()] == 1.23
    assert (found["time"][0], found["time"][-1]) == (0.0, 10.0)
    assert np.nanmax(found["a.w"]) == np.nanmax(data["a.w"])


def test_what_cannot_be_converted(say):
    results.write("a.npz", columns(), UNITS, META)
    for given, expected in (
        (("a.npz", "--out", "a.npz"), "cannot write `a.npz`"),
        (("a.npz", "--out", "b.xls"), "unknown suffix `.xls`"),
        (("a.npz", "--out", "b.npz", "--signals", "crank.*"), "there is no signal that matches `crank.*`"),
        (("a.npz", "--out", "b.npz", "--every", "0"), "expected a whole number above 0, found `0`"),
        (("a.npz", "--out", "b.npz", "--start", "2s", "--stop", "1s"), "--stop 1 s is before --start 2 s"),
        (("c.npz", "--out", "b.npz"), "cannot read `c.npz`"),
    ):
        code, out, err = say("convert", *given)
        assert (code, out) == (2, "")
        assert expected in err


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_info(say, suffix, monkeypatch):
    monkeypatch.setattr(Result.chunks, "__defaults__", (64,))
    results.write(f"a{suffix}", columns(), UNITS, META | {"complete": False, "status": "failed"})
    code, out, err = say("info", f"a{suffix}")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    lines = {line.split(maxsplit=1)[0]: line.split()[1:] for line in out.splitlines()}
    assert "incomplete" in out.splitlines()[0]
    assert " ".join(lines["time"]) == "0 ... 10 s, 1001 rows every 10 ms"
    assert lines["a.x"] == ["m", "0", f"{np.sin(10.0):.4g}", f"{np.sin(4.71):.4g}", f"{np.sin(1.57):.4g}"]
    assert lines["a.w"][-5:] == ["0", "nan", "0", f"{4.99**2:.4g}", "*"]
    if suffix != ".csv":
        assert " ".join(lines["options"]) == "alpha = -0.1"
        assert "failed" in out.splitlines()[0]


def test_info_of_many_signals_and_long_names(say):
    long = "assembly." * 9 + "x"
    results.write("a.npz", {"time": np.arange(3.0), long: np.ones(3), **{f"s{k}": np.ones(3) for k in range(40)}})
    _, out, _ = say("info", "a.npz")
    assert out.splitlines()[-1] == "... 11 more; --signals '*' lists all"
    assert say("info", "a.npz", "--signals", "*")[1].count("\ns") == 41  # with the line "signals"
    results.write("b.csv", {"time": np.zeros(0), "x": np.zeros(0)})
    assert "no rows" in say("info", "b.csv")[1]


# -- thinning ------------------------------------------------------------------------------------------------------
def test_thinned_rows_are_rows_with_all_extremes():
    """Rows that are added in parts of any length."""
    n, random = 20_000, np.random.default_rng(3)
    data = {"time": np.arange(n) * 1.0, "x": random.standard_normal(n), "y": np.cumsum(random.standard_normal(n))}
    rows = ThinnedRows(list(data), "time", 500)
    for k in range(0, n, 777):
        rows.add({name: x[k : k + 777] for name, x in data.items()})
    found = rows.columns()
    assert rows.count == n and 100 < len(rows.index) <= 500
    for name, x in data.items():
        assert np.array_equal(found[name], x[rows.index])
    assert rows.width < n / 10
    width = int(rows.width)
    for name in ("x", "y"):
        for first in range(0, n, width):
            part = data[name][first : first + width]
            own = found[name][(rows.index >= first) & (rows.index < first + width)]
            assert (own.min(), own.max()) == (part.min(), part.max())


def test_animations_read_long_results_in_parts(say, monkeypatch):
    monkeypatch.setattr("mbdsl.plotting.decimation.FEWEST", 100)
    monkeypatch.setattr("mbdsl.plotting.decimation.ROWS", 400)
    with open("fall.mbd", "w") as file:
        file.write(
            "model Fall\n  Ground g0;\n  PointMass a(m = 1 kg);\n  FreeMotion free(g0, a);\n"
            "initial equation\n  a.x = 0 m; a.y = 1 m; a.vx = 1 m/s; a.vy = 0 m/s;\nend Fall;\n"
        )
    from mbdsl.lang.load import load

    t = np.linspace(0.0, 1.0, 5001)
    y = 1.0 + np.sin(40.0 * t) / (1.0 + t)
    data = {"time": t, "a.x": t, "a.y": y, "a.vx": np.ones(5001), "a.vy": np.zeros(5001)}
    results.write("r.csv", data)
    trajectory, _ = stored_trajectory("r.csv", load("fall.mbd"))
    assert trajectory.stats["rows"] == 5001 and len(trajectory.t) <= 400
    assert (trajectory["a.y"].max(), trajectory["a.y"].min()) == (y.max(), y.min())
    assert len(thinned(open_result("r.csv"), 10_000).index) == 5001
