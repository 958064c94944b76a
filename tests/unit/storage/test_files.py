"""Written files are whole, keep their modes, and never replace a device, a pipe, an input or another output."""

import os
import re
import signal
import stat
import subprocess
import sys
import threading
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from mbdsl import Interrupted, UsageError, results
from mbdsl.simulation.interrupts import deferred, terminated
from mbdsl.storage import cache_folder, output_files
from mbdsl.storage.output_files import write_text, writing

MODEL = """model M
  Ground g;
  PointMass ball(m = 1 kg);
  FreeMotion free(g, ball);
  annotation(experiment(StopTime = 0.1 s, Step = 1 ms));
end M;
"""
COLUMNS = {"time": np.linspace(0.0, 1.0, 7), "x": np.linspace(-1 / 3, 1 / 7, 7)}
posix = pytest.mark.skipif(os.name != "posix", reason="pipes, devices and modes of POSIX")


@pytest.fixture
def model(say, tmp_path):
    path = tmp_path / "m.mbd"
    path.write_text(MODEL, encoding="utf-8")
    return path


# -- existing files -----------------------------------------------------------------------------------------------
@posix
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666])
def test_modes_are_kept(tmp_path, mode):
    path = tmp_path / "r.csv"
    path.touch()
    path.chmod(mode)
    results.write(path, COLUMNS)
    assert stat.S_IMODE(path.stat().st_mode) == mode


@posix
def test_a_private_file_is_private_while_it_is_written(tmp_path):
    path = tmp_path / "r.csv"
    path.touch(0o600)
    with writing(path):
        modes = {p.name: stat.S_IMODE(p.stat().st_mode) for p in tmp_path.iterdir()}
    assert len(modes) == 2 and set(modes.values()) == {0o600}


@posix
@pytest.mark.skipif(os.name == "posix" and os.geteuid() != 0, reason="only root gives files to any group")
def test_groups_are_kept_or_have_no_rights(tmp_path, monkeypatch):
    path = tmp_path / "r.csv"
    for allowed, expected in ((True, (4242, 0o660)), (False, (tmp_path.stat().st_gid, 0o600))):
        path.touch()
        os.chown(path, -1, 4242)
        path.chmod(0o660)
        if not allowed:
            monkeypatch.setattr(os, "chown", lambda *given: (_ for _ in ()).throw(PermissionError()))
        write_text(path, "new")
        assert (path.stat().st_gid, stat.S_IMODE(path.stat().st_mode)) == expected


@posix
@pytest.mark.parametrize("suffix", results.formats())
def test_pipes_are_written_into(tmp_path, suffix):
    whole, pipe = tmp_path / f"r{suffix}", tmp_path / f"pipe{suffix}"
    results.write(whole, COLUMNS)
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    results.write(pipe, COLUMNS)
    reader.join(10.0)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    if suffix == ".csv":
        assert read == [whole.read_bytes()]
    else:
        copy = tmp_path / f"copy{suffix}"
        copy.write_bytes(read[0])
        assert results.read(copy)[0]["x"].tolist() == COLUMNS["x"].tolist()


@posix
def test_devices_are_written_into(tmp_path):
    link = tmp_path / "r.csv"
    link.symlink_to("/dev/null")
    results.write(link, COLUMNS, {}, {"complete": False})
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode) and link.is_symlink()
    assert os.listdir(tmp_path) == ["r.csv"] and not os.path.exists("/dev/null.incomplete")


@posix
def test_links_are_followed_and_kept(tmp_path):
    real, link, other = tmp_path / "real.csv", tmp_path / "link.csv", tmp_path / "other.csv"
    real.write_text("old", encoding="utf-8")
    link.symlink_to(real)
    os.link(real, other)
    results.write(link, COLUMNS)
    assert link.is_symlink() and real.samefile(other)
    assert results.read(other)[0]["time"].tolist() == COLUMNS["time"].tolist()
    assert sorted(os.listdir(tmp_path)) == ["link.csv", "other.csv", "real.csv"]


@posix
def test_read_only_files_and_loops_are_refused(tmp_path):
    path, loop = tmp_path / "r.csv", tmp_path / "loop.csv"
    path.write_text("old", encoding="utf-8")
    path.chmod(0o444)
    loop.symlink_to(loop)
    for wrong, why in ((path, "read-only"), (loop, "symbolic links"), (tmp_path, "folder|directory")):
        with pytest.raises(UsageError, match=why):
            output_files.check([wrong])
        with pytest.raises(UsageError, match=why):
            write_text(wrong, "new")
    assert path.read_text(encoding="utf-8") == "old"


def test_what_fails_half_way_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old", encoding="utf-8")

    def fail():
        with writing(path) as stream:
            stream.write(b"new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert path.read_text(encoding="utf-8") == "old" and os.listdir(tmp_path) == ["a.txt"]


def test_all_files_are_written_whole():
    """By this module alone; caches and stores, whose files may be lost, write on their own."""
    package = Path(output_files.__file__).parents[1]
    own = {f"storage/{name}.py" for name in ("output_files", "cache_folder")}
    own |= {"compilation/code_cache.py", "studies/store.py", "lang/kind_reference.py"}
    own |= {"editor/textmate.py"}
    ways = [r"\.write_text\(", r"\.write_bytes\(", r'(?<!archive\.)\bopen\([^)]*, "[wax]b?"', r"savefig\((?!stream)"]
    opens = re.compile("|".join(ways))
    found = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if opens.search(path.read_text(encoding="utf-8"))
    }
    assert "storage/output_files.py" in found and found <= own


# -- many writers -------------------------------------------------------------------------------------------------
LONG = "slider_crank_with_friction_and_clearance_L1_0.1234_run_{}{}"


@pytest.mark.parametrize("suffix", results.formats())
def test_threads_write_files_of_their_own(tmp_path, suffix):
    def write(thread):
        for k in range(thread, 40, 4):
            x = np.full(2000, float(k))
            for name in (k, "all"):
                results.write(tmp_path / LONG.format(name, suffix), {"time": np.arange(2000.0), "x": x})

    threads = [threading.Thread(target=write, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(os.listdir(tmp_path)) == 41
    for k in range(40):
        columns, _ = results.read(tmp_path / LONG.format(k, suffix))
        assert np.array_equal(columns["time"], np.arange(2000.0)) and np.array_equal(columns["x"], np.full(2000, k))
    last = results.read(tmp_path / LONG.format("all", suffix))[0]["x"]
    assert len(last) == 2000 and len(set(last)) == 1


def test_processes_of_one_number_write_files_of_their_own(tmp_path, monkeypatch):
    """As in two containers that share a folder: the same process id and the same thread id."""
    monkeypatch.setattr(os, "getpid", lambda: 7)
    monkeypatch.setattr(threading, "get_ident", lambda: 1)
    outer, inner = (tmp_path / LONG.format(k, ".csv") for k in "ab")
    with writing(outer) as first, writing(inner) as second, writing(inner) as third:
        for stream, text in ((first, b"outer"), (second, b"second"), (third, b"third")):
            stream.write(text)
    assert (outer.read_bytes(), inner.read_bytes()) == (b"outer", b"second")
    cached = tmp_path / "code.o"
    with cache_folder.writing(cached) as first:
        with cache_folder.writing(cached) as second:
            second.write(b"second")
        first.write(b"the first")
    assert cached.read_bytes() == b"the first"
    assert len(os.listdir(tmp_path)) == 3


@posix
def test_leftovers_of_killed_writers_are_removed_and_no_others(tmp_path):
    path, foreign = tmp_path / LONG.format(1, ".csv"), tmp_path / "notes.part"
    foreign.touch()
    (tmp_path / f".{path.name[:50]}.{os.getpid()}.part").touch()  # by a former version
    code = """if True:
        import os, sys
        from mbdsl.storage.output_files import writing
        with writing(sys.argv[1]) as stream:
            stream.write(b"half")
            stream.flush()
            os.kill(os.getpid(), 9)"""
    assert subprocess.run([sys.executable, "-c", code, str(path)]).returncode == -signal.SIGKILL
    assert len(os.listdir(tmp_path)) == 2  # that of the former version is gone
    with writing(path) as mine:
        assert len(os.listdir(tmp_path)) == 2
        write_text(path, "meanwhile")  # does not remove what is being written
        mine.write(b"whole")
    assert sorted(os.listdir(tmp_path)) == ["notes.part", path.name] and path.read_bytes() == b"whole"


def test_what_could_not_be_copied_is_kept(tmp_path, monkeypatch):
    path = tmp_path / "r.txt"
    path.write_text("old", encoding="utf-8")
    os.link(path, tmp_path / "same.txt")

    def full(*streams):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("shutil.copyfileobj", full)
        with pytest.raises(UsageError, match="No space left") as caught:
            write_text(path, "new")
    kept = Path(re.search("the new content is in `(.*)`", str(caught.value))[1])
    write_text(path, "newer")
    assert kept.read_text(encoding="utf-8") == "new" and path.read_text(encoding="utf-8") == "newer"


# -- inputs and other outputs -------------------------------------------------------------------------------------
def test_the_model_is_not_overwritten(say, model, tmp_path):
    same = tmp_path / "pend.csv"
    same.write_text(MODEL, encoding="utf-8")
    (tmp_path / "sub").mkdir()
    for asked in (
        ["pend.csv"],
        ["m.mbd", "--stats", "m.mbd"],
        ["m.mbd", "--stats", "sub/../m.mbd"],
        ["m.mbd", "--checkpoint", str(model)],
    ):
        code, _, err = say("simulate", *asked)
        assert code == 2 and "it is an input of this command" in err
    assert same.read_text(encoding="utf-8") == model.read_text(encoding="utf-8") == MODEL


def test_imported_files_are_inputs_too(say, tmp_path):
    (tmp_path / "part.mbd").write_text("model Part\n  PointMass ball(m = 1 kg);\nend Part;\n", encoding="utf-8")
    text = 'import "part.mbd";\nmodel M\n  Ground g; Part p;\n  annotation(experiment(StopTime = 0.1 s));\nend M;\n'
    (tmp_path / "m.mbd").write_text(text, encoding="utf-8")
    code, _, err = say("simulate", "m.mbd", "--stats", "part.mbd")
    assert code == 2 and err.startswith("error: cannot write `part.mbd`: it is an input of this command\n")


@posix
def test_of_a_link_the_missing_folder_is_named(say, model, tmp_path):
    (tmp_path / "r.csv").symlink_to("missing/r.csv")
    _, _, err = say("simulate", "m.mbd", "--output", "r.csv")
    assert f"there is no folder `{tmp_path.resolve() / 'missing'}`" in err


def test_two_outputs_are_two_files(say, model):
    code, _, err = say("simulate", "m.mbd", "--output", "r.csv", "--stats", "./r.csv")
    assert code == 2 and "cannot write `./r.csv`: `r.csv` is given for two outputs" in err
    assert os.listdir() == ["m.mbd"]


# -- finished runs are not lost -----------------------------------------------------------------------------------
def test_results_go_elsewhere_where_their_file_cannot_be_written(say, model, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    write = results.write

    def full(path, *rest):
        if str(path) == "r.csv":
            raise UsageError("cannot write `r.csv`: No space left on device")
        write(path, *rest)

    monkeypatch.setattr(results, "write", full)
    code, _, err = say("simulate", "m.mbd", "--output", "r.csv", "--quiet")
    assert code == 2 and err.startswith("error: cannot write `r.csv`: No space left on device\n")
    where = err.split("the results are in ")[1].strip()
    assert len(results.read(where)[0]["time"]) == 501 and str(tmp_path / "temporary") in where


def test_unknown_signals_are_found_before_the_run(say, model, monkeypatch):
    monkeypatch.setattr("mbdsl.api.simulated", None)
    code, _, err = say("simulate", "m.mbd", "--signals", "ball.y,ball.z", "--quiet")
    assert code == 2
    assert err.startswith("error: there is no signal `ball.z` in ")
    assert "\n  = did you mean `ball." in err and "?;" not in err
    assert not Path("m.csv").exists()


@posix
def test_one_interruption_while_results_are_written(say, model, monkeypatch, default_signals):
    write = results.write

    def interrupted(*given):
        os.kill(os.getpid(), signal.SIGINT)
        write(*given)

    monkeypatch.setattr(results, "write", interrupted)
    code, _, err = say("simulate", "m.mbd", "--quiet")
    assert (code, err) == (130, "writing m.csv; Ctrl-C again to end without it\ninterrupted\n")
    assert len(results.read("m.csv")[0]["time"]) == 501


@posix
@pytest.mark.parametrize("where", ["simulate._collect", "diagnostics.warnings"])
def test_one_interruption_after_the_last_step(say, model, monkeypatch, where, default_signals):
    """Between the step loop and the writing of results."""
    from mbdsl.simulation import simulate

    module, name = where.split(".")
    place = import_module(f"mbdsl.simulation.{module}")
    known = getattr(place, name)

    def interrupted(*given, **named):
        if not named:  # not before the first step
            os.kill(os.getpid(), signal.SIGINT)
        return known(*given, **named)

    monkeypatch.setattr(place, name, interrupted)
    code, _, err = say("simulate", "m.mbd", "--quiet")
    with pytest.raises(Interrupted) as caught:
        simulate.simulate("m.mbd")
    columns, about = results.read("m.csv")
    assert (code, err, about["complete"], len(columns["time"])) == (130, "interrupted\n", True, 501)
    assert caught.value.trajectory.status == "done" and len(caught.value.trajectory.t) == 501


def test_a_mark_that_cannot_be_removed_is_told(tmp_path):
    path = tmp_path / "r.csv"
    (tmp_path / "r.csv.incomplete").mkdir()
    with pytest.raises(UsageError, match=r"cannot remove `.*r\.csv\.incomplete`, which marks"):
        results.write(path, COLUMNS)


@posix
def test_long_names(tmp_path):
    for name in ("a" * 251 + ".csv", "\u6f22" * 83 + ".csv"):  # 255 and 253 bytes
        results.write(tmp_path / name, COLUMNS)
        assert results.read(tmp_path / name)[1] == {"complete": True}


@posix
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_sigterm_and_sighup_are_as_ctrl_c(name, default_signals):
    number = getattr(signal, name)
    with terminated():
        with deferred() as heard:
            os.kill(os.getpid(), number)
        assert heard == [number]

        def twice():
            with deferred(1):
                for _ in range(2):
                    os.kill(os.getpid(), number)

        with pytest.raises(KeyboardInterrupt):
            twice()
    assert signal.getsignal(number) == signal.SIG_DFL


# -- a CSV that was cut -------------------------------------------------------------------------------------------
@pytest.mark.parametrize("rows", [0, 1, 2, 7])
def test_a_cut_csv_is_recognised(tmp_path, rows):
    path = tmp_path / "r.csv"
    results.write(path, {name: x[:rows] for name, x in COLUMNS.items()})
    whole = path.read_bytes()
    assert len(results.read(path)[0]["x"]) == rows
    for k in range(len(whole)):
        path.write_bytes(whole[:k])
        with pytest.raises(UsageError, match=r"is not a \.csv result file"):
            results.read(path)


@pytest.mark.parametrize(
    "text", ["time,x\n0,1\n1,2\n", "time,x\r\n0,1\r\n1,2\r\n", "time,x\n0,1\n1,2", "time,x\n0,1\n"]
)
def test_csv_files_by_others_are_read(tmp_path, text):
    path = tmp_path / "r.csv"
    path.write_bytes(text.encode())
    assert results.read(path)[0]["x"].tolist() == [1.0, 2.0][: text.count(",") - 1]


def test_readers_of_csv_take_all_line_ends_alike(tmp_path):
    import csv

    import pandas

    path = tmp_path / "r.csv"
    results.write(path, COLUMNS)
    assert np.array_equal(pandas.read_csv(path)["x"], COLUMNS["x"])
    assert np.array_equal(np.loadtxt(path, delimiter=",", skiprows=1)[:, 1], COLUMNS["x"])
    with open(path, newline="", encoding="utf-8") as stream:
        assert [float(row["x"]) for row in csv.DictReader(stream)] == COLUMNS["x"].tolist()
