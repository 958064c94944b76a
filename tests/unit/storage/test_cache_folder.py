"""The folder of machine code and of runs: files that others can have written are not used; a failure to store stops no
run.

Other users are real if the tests run as root, who can change the owner of files; elsewhere the status of a file is
changed.
"""

import errno
import io
import os
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from mbdsl.compilation import code_cache, kernel_sources
from mbdsl.storage import cache_folder, folder_rights
from mbdsl.studies.cases import Case
from mbdsl.studies.store import Computed, Store

OTHER = 12345  #: another user
VERSION = "0.1.0-py311-0123456789abcdef"
OBJECT = f"{VERSION}/mbdsl_some.o"
needs_owners = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows: files have no owners")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The folder that the environment names; it does not exist yet."""
    for name in ("XDG_CACHE_HOME", cache_folder.HANDED):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(cache_folder, "_said", [])
    monkeypatch.setenv("MBDSL_CACHE_DIR", str(tmp_path / "home" / "cache"))
    forget()
    yield tmp_path / "home" / "cache"
    forget()


def forget():
    """The module as in a new process."""
    cache_folder._chosen.cache_clear()
    cache_folder._own.cache_clear()
    cache_folder._said.clear()


@pytest.fixture
def give_away(monkeypatch):
    """Change the owner of a file or folder to another user."""

    def give(path):
        if os.geteuid() == 0:
            os.chown(path, OTHER, -1, follow_symlinks=False)
            return
        given = os.lstat(path)
        for name in ("stat", "lstat", "fstat"):
            monkeypatch.setattr(os, name, _lying(getattr(os, name), _which(given)))

    return give


def _which(status):
    return status.st_dev, status.st_ino, status.st_mtime_ns  # inode numbers are used again


def _lying(real, which):
    def look(*arguments, **named):
        found = real(*arguments, **named)
        if _which(found) != which:
            return found
        return os.stat_result((*found[:4], OTHER, *found[5:]))

    return look


def planted(folder, name=OBJECT, data=b"machine code"):
    path = folder / name
    path.parent.mkdir(0o700, parents=True, exist_ok=True)
    path.write_bytes(data)
    path.chmod(0o644)
    return path


def replaced(folder, capsys):
    """Another folder is used, and one line states the reason; returns this line."""
    own = cache_folder.own()
    assert own is not None and own != folder
    assert stat.S_IMODE(own.stat().st_mode) == 0o700 or not hasattr(os, "geteuid")
    assert cache_folder.keep("a", b"a") == own / "a" and cache_folder.read("a") == b"a"
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("note: nothing is stored for later runs: ") and line.endswith("; see `mbdsl cache`")
    assert cache_folder.compiling() == "compiling for the first time; the code cannot be stored ..."
    return line


# -- the owner of the folder -----------------------------------------------------------------------------------------


def test_it_is_made_for_the_user_alone(folder):
    """With any umask."""
    former = os.umask(0)
    try:
        path = cache_folder.keep(OBJECT, b"code")
    finally:
        os.umask(former)
    assert path == folder / OBJECT and cache_folder.read(OBJECT) == b"code"
    assert "is stored" in cache_folder.compiling() and "cannot" not in cache_folder.compiling()
    if hasattr(os, "geteuid"):
        assert [stat.S_IMODE(p.stat().st_mode) for p in (folder, path.parent, path)] == [0o700, 0o700, 0o644]


@needs_owners
def test_of_another_user(folder, capsys, give_away):
    """No file in it is read, and none is written."""
    path = planted(folder)
    assert cache_folder.read(OBJECT) == b"machine code"
    forget()
    give_away(folder)
    assert cache_folder.read(OBJECT) is None
    assert "belongs to user 12345" in replaced(folder, capsys)
    assert path.read_bytes() == b"machine code" and os.listdir(folder) == [VERSION]


@needs_owners
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702, 0o1777])
def test_others_can_write_into_it(folder, capsys, mode):
    planted(folder)
    folder.chmod(mode)
    assert cache_folder.read(OBJECT) is None
    message = f"others can write into `{folder}` (mode {mode:04o}; try: chmod go-w {folder})"
    assert message in replaced(folder, capsys)


@needs_owners
def test_a_link_is_followed(folder, tmp_path, capsys, give_away):
    """The folder that it leads to counts."""
    planted(tmp_path / "elsewhere")
    folder.parent.mkdir()
    folder.symlink_to("../elsewhere")
    assert cache_folder.read(OBJECT) == b"machine code"
    forget()
    give_away(tmp_path / "elsewhere")
    assert cache_folder.read(OBJECT) is None
    assert f"`{folder}` belongs to user" in replaced(folder, capsys)


@needs_owners
def test_a_process_looks_at_the_folder_once(folder, monkeypatch):
    planted(folder)
    looked = []
    monkeypatch.setattr(cache_folder, "fault_of", lambda path: looked.append(path) or "")
    for _ in range(3):
        assert cache_folder.read(OBJECT) == b"machine code"
    assert looked == [folder]


@needs_owners
def test_a_circle_of_links(folder, capsys):
    folder.parent.mkdir()
    folder.symlink_to(folder)
    assert "cannot be reached" in replaced(folder, capsys)


def test_a_file_in_its_place(folder, capsys):
    folder.parent.mkdir(mode=0o700)
    folder.write_text("mine")
    replaced(folder, capsys)
    assert folder.read_text() == "mine"


@pytest.mark.parametrize("home", ["~", "", "some/where"])
def test_no_home_makes_no_relative_folder(folder, tmp_path, monkeypatch, capsys, home):
    """Python returns ``~`` if HOME is not set and the user is not known."""
    monkeypatch.delenv("MBDSL_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "also/relative")  # the specification requires that it is ignored then
    monkeypatch.setattr(os.path, "expanduser", lambda path: home)
    monkeypatch.chdir(tmp_path)
    assert "there is no home folder" in replaced(folder, capsys)
    assert os.listdir(tmp_path) == []


def test_a_relative_folder_is_refused(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("MBDSL_CACHE_DIR", "cache")
    monkeypatch.chdir(tmp_path)
    assert "MBDSL_CACHE_DIR is `cache`, expected an absolute path" in replaced(folder, capsys)
    assert os.listdir(tmp_path) == []


def test_without_owners_all_is_trusted(folder, monkeypatch):
    """As on Windows."""
    planted(folder).chmod(0o666)
    folder.chmod(0o777)
    monkeypatch.delattr(os, "geteuid", raising=False)
    assert cache_folder.read(OBJECT) == b"machine code" and cache_folder.own() == folder


# -- files in the folder ---------------------------------------------------------------------------------------------


@needs_owners
@pytest.mark.parametrize("kind", ["another's", "writable", "by the group", "link", "pipe", "folder"])
def test_files_that_others_can_have_written(folder, tmp_path, give_away, kind):
    """Files of others are not read, not waited for, and replaced by our own."""
    path = planted(folder)
    if kind == "another's":
        give_away(path)
    elif kind in ("writable", "by the group"):
        path.chmod(0o666 if kind == "writable" else 0o664)
    else:
        path.unlink()
        if kind == "link":
            path.symlink_to(planted(tmp_path, "target"))
        elif kind == "pipe":
            os.mkfifo(path)
        else:
            path.mkdir()
    assert cache_folder.read(OBJECT) is None
    cache_folder.keep(OBJECT, b"own")
    assert cache_folder.read(OBJECT) == (None if kind == "folder" else b"own")
    assert kind != "link" or (tmp_path / "target").read_bytes() == b"machine code"


@needs_owners
def test_machine_code_of_others_is_not_run(folder, give_away, monkeypatch):
    """A complete file with the right sources and the right text, but written by another user."""
    body = "\n".join(
        [
            kernel_sources.digest_of(["mbdsl.kernels.marks"]),
            "mbdsl.kernels.marks",
            code_cache._asked("text", {}),
            "",
            "",
        ]
    ).encode()
    said = code_cache.hashlib.sha256(body).hexdigest().encode()
    path = planted(folder, f"{code_cache.version()}/planted.o", said + b"\n" + body)
    monkeypatch.setattr(code_cache, "_linked", lambda name, body, signatures: ["what the object does"])
    assert code_cache._kept("planted", "text", {}) == ["what the object does"]
    give_away(path)
    assert code_cache._kept("planted", "text", {}) is None
    assert code_cache._body("planted") is None


# -- nothing can be written ------------------------------------------------------------------------------------------


@pytest.fixture
def read_only(folder, monkeypatch):
    """A read-only folder, as in an image or at a site; root could write all the same."""
    real = cache_folder._created

    def created(path):
        if folder in path.parents:
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        return real(path)

    monkeypatch.setattr(cache_folder, "_created", created)


def test_a_read_only_folder_is_read(folder, read_only, capsys):
    """It is used silently if it has all that is needed; missing files are written elsewhere."""
    planted(folder)
    assert cache_folder.read(OBJECT) == b"machine code"
    assert capsys.readouterr().err == ""
    assert f"cannot write into `{folder}` (Read-only file system)" in replaced(folder, capsys)
    assert cache_folder.read(OBJECT) == b"machine code"


@needs_owners
def test_a_folder_of_root_is_read(folder, monkeypatch, capsys):
    """Any user may use it: a folder of root is trusted like one's own. Another user who runs the tests stands for
    root."""
    monkeypatch.setattr(os, "geteuid", lambda: OTHER)
    if os.getuid() != 0:
        monkeypatch.setattr(folder_rights, "_belongs_to_us", lambda status: status.st_uid in (0, os.getuid()))
    planted(folder)
    assert cache_folder.read(OBJECT) == b"machine code"
    assert capsys.readouterr().err == ""


FULL = """
import os, resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))  # not a byte can be written into any file
import numpy as np
from mbdsl.compilation import code_cache, kernel_sources
from mbdsl.storage import cache_folder
signatures = {"f": code_cache.Signature(("float", "vector"))}
(f,) = code_cache.functions("full", "def f(x, v):\\n    v[0] = 2.0 * x\\n", signatures, list)
v = np.zeros(1)
f(1.5, v)
print(v[0], code_cache.beside("sys") is None or cache_folder.own() is not None, cache_folder.compiling())
"""


def run(code, tmp_path, *arguments, **environment):
    """Run a process whose temporary folders are in ``tmp_path / "tmp"``."""
    (tmp_path / "tmp").mkdir(exist_ok=True)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(sys.path),
        "TMPDIR": str(tmp_path / "tmp"),
        **environment,
    }
    command = [sys.executable, "-B", "-c", code, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=True, cwd=tmp_path)


@needs_owners
@pytest.mark.skipif(not code_cache.enabled(), reason="MBDSL_NO_COMPILE=1: nothing is compiled")
def test_a_full_disk_stops_nothing(tmp_path):
    """A limit of 0 bytes a file: the code is compiled and runs, one line says that it is not stored, no file is
    left."""
    done = run(FULL, tmp_path, MBDSL_CACHE_DIR=str(tmp_path / "cache"))
    assert done.stdout == "3.0 True compiling for the first time; the code cannot be stored ...\n"
    (line,) = done.stderr.splitlines()
    assert f"cannot write into `{tmp_path / 'cache'}`" in line
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []
    assert os.listdir(tmp_path / "tmp") == []


def test_a_disk_that_fills_up_later(folder, monkeypatch, capsys):
    assert cache_folder.own() == folder

    class Full(io.FileIO):
        def write(self, data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(cache_folder, "_created", lambda path: Full(path, "w"))
        assert cache_folder.keep(OBJECT, b"code") is None and cache_folder.keep(OBJECT, b"code") is None
        (line,) = capsys.readouterr().err.splitlines()
        assert os.strerror(errno.ENOSPC) in line
        assert list(folder.rglob("*.*part")) == []
    assert "cannot be stored" in cache_folder.compiling()


def test_no_place_at_all(folder, monkeypatch, capsys):
    def nowhere(*arguments, **named):
        raise FileNotFoundError(errno.ENOENT, "no usable temporary folder")

    monkeypatch.setenv("MBDSL_CACHE_DIR", "relative")
    monkeypatch.setattr(tempfile, "mkdtemp", nowhere)
    assert cache_folder.own() is None
    assert cache_folder.keep(OBJECT, b"code") is None and cache_folder.read(OBJECT) is None
    assert cache_folder.environment() == {}
    assert code_cache.beside("sys") is None
    assert len(capsys.readouterr().err.splitlines()) == 1


# -- temporary folders -----------------------------------------------------------------------------------------------

HAND = """
import subprocess, sys
from mbdsl.storage import cache_folder
own = cache_folder.own()
cache_folder.keep("a", b"of the parent")
code = "from mbdsl.storage import cache_folder as c; print(c.read('a'), c.own(), c.keep('b', b'of the child'))"
import os
subprocess.run([sys.executable, "-c", code], env={**os.environ, **cache_folder.environment()}, check=True)
print(cache_folder.read("b"), own, own.exists())
"""


def test_a_temporary_folder_is_handed_on_and_ends_with_its_process(tmp_path):
    done = run(HAND, tmp_path, MBDSL_CACHE_DIR="relative")
    child, parent = done.stdout.splitlines()
    own = parent.split()[-2]
    assert child == f"b'of the parent' {own} {Path(own, 'b')}" and parent == f"b'of the child' {own} True"
    assert len(done.stderr.splitlines()) == 1  # the child prints nothing
    assert Path(own).parent == tmp_path / "tmp" and os.listdir(tmp_path / "tmp") == []


@needs_owners
def test_temporary_folders_of_killed_processes_go(tmp_path, monkeypatch):
    """After a day without use."""
    killed, recent, others = (tmp_path / f"mbdsl-{name}" for name in ("cache-killed", "cache-recent", "clone"))
    for path in (killed, recent, others):
        planted(path)
        if path != recent:
            os.utime(path, (1e9, 1e9))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    new = cache_folder._temporary()
    assert {path for path in tmp_path.iterdir() if path.is_dir()} == {recent, others, new}


# -- the size of the cache -------------------------------------------------------------------------------------------


def test_what_was_not_used_for_longest_goes(folder, monkeypatch):
    monkeypatch.setattr(cache_folder, "LARGEST", 3500)
    long_ago = time.time() - 1e6
    for k in range(4):
        for suffix in ("o", "py"):
            path = planted(folder, f"{VERSION}/mbdsl_{k}.{suffix}", bytes(500))
            os.utime(path, (long_ago + k, long_ago + k))
    foreign = planted(folder, f"{VERSION}/thesis.tex", bytes(5000))
    older = planted(folder, "0.0.9-py310-0123456789abcdef/mbdsl_a.o", bytes(10))
    os.utime(older, (1e9, 1e9))
    assert cache_folder.read(f"{VERSION}/mbdsl_0.o") is not None  # so that its last use is today
    cache_folder.keep(f"{VERSION}/mbdsl_new.o", bytes(1000))
    left = {path.name.split(".")[0] for path in (folder / VERSION).iterdir()}
    assert left == {"mbdsl_0", "mbdsl_3", "mbdsl_new", "thesis"}
    assert foreign.exists() and not older.parent.exists()
    assert sum(entry.size for entry in cache_folder.code(folder)) == 3000


def test_a_process_looks_at_all_files_once_and_after_much_writing(folder, monkeypatch):
    looked = []
    monkeypatch.setattr(cache_folder, "LARGEST", 100_000)
    monkeypatch.setattr(cache_folder, "prune", looked.append)
    for k in range(10):
        cache_folder.keep(f"{VERSION}/mbdsl_{k}.o", bytes(400))
    assert looked == [folder] * 4  # at 400, 1600, 2800 and 4000 bytes: more than 1000 since the last


BUSY = """
import sys
from pathlib import Path
from mbdsl.storage import cache_folder

cache_folder.LARGEST = 20_000
seed = int(sys.argv[1])
for k in range(80):
    at = (7 * k + seed) % 11
    cache_folder.keep(f"{sys.argv[2]}/mbdsl_{at}.o", bytes([at]) * (1000 + at))
    found = cache_folder.read(f"{sys.argv[2]}/mbdsl_{(at + seed) % 11}.o")
    assert found is None or found == found[:1] * (1000 + found[0]), len(found)
    if k % 20 == seed:
        cache_folder.clear(cache_folder.chosen().path)
    if k % 10 == seed:
        cache_folder.prune(cache_folder.chosen().path)
"""


def test_processes_that_write_read_and_remove_at_the_same_time(folder):
    """No failure, no message, and no file that is not whole."""
    command = [sys.executable, "-c", BUSY]
    running = [
        subprocess.Popen([*command, str(k), VERSION], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for k in range(4)
    ]
    assert [(process.communicate()[0], process.returncode) for process in running] == [("", 0)] * 4


def test_a_folder_that_another_process_has_just_removed(folder, monkeypatch):
    """The folder is as it was when it was empty."""
    real = cache_folder.writing

    def writing(path):
        if path.parent != folder and not cache_folder.runs(folder):  # the first object
            planted(folder, f"{'0' * 32}.npz")
            path.parent.rmdir()
        return real(path)

    monkeypatch.setattr(cache_folder, "writing", writing)
    assert cache_folder.keep(OBJECT, b"code") == folder / OBJECT and cache_folder.read(OBJECT) == b"code"


def test_files_that_were_not_finished_go(folder):
    old, now = (planted(folder, f"{VERSION}/mbdsl_a.o.{k}.{k}.part") for k in (1, 2))
    top = planted(folder, "probe.3.3.part")
    foreign = planted(folder, f"{VERSION}/a novel.part")
    for path in (old, top, foreign):
        os.utime(path, (1e9, 1e9))
    cache_folder.keep(OBJECT, b"code")
    assert not old.exists() and not top.exists() and now.exists() and foreign.exists()


# -- the command -----------------------------------------------------------------------------------------------------


def filled(folder):
    """A folder with all files that mbdsl writes."""
    planted(folder, OBJECT, bytes(400_000))
    for name in ("mbdsl_a.py", "mbdsl_b.o", "mbdsl_a.o.1.1.part"):
        planted(folder, f"{VERSION}/{name}", bytes(25_000))
    for name in (f"{'0' * 32}.npz", f"{'0' * 32}-{'1' * 12}.npz", f".{'0' * 32}.npz.1.1.part"):
        planted(folder, f"studies/{name}", bytes(100_000))


def test_the_command_shows_what_there_is(folder, say):
    filled(folder)
    assert say("cache") == (
        0,
        f"folder: {folder}\nmachine code: 3 entries, 0.5 MB (limit: 500 MB)\n"
        "  of other versions and settings: 3 entries, 0.5 MB, in 1 folder\n"
        "runs of studies: 2 entries, 0.2 MB (limit: 1000 MB)\n",
        "",
    )


def test_the_command_shows_the_kinds_of_code(folder, say):
    version = code_cache.version()
    planted(folder, f"{version}/mbdsl_method_newmark.o", bytes(200_000))
    planted(folder, f"{version}/mbdsl_method_newmark.py", bytes(100_000))
    for name in "ab":
        planted(folder, f"{version}/mbdsl_emitted_{name}.o", bytes(100_000))
    planted(folder, f"{version}/mbdsl_kind_rod.py", bytes(100_000))
    planted(folder, OBJECT, bytes(400_000))
    assert say("cache")[1] == (
        f"folder: {folder}\nmachine code: 5 entries, 1.0 MB (limit: 500 MB)\n"
        "  step loops: 1 entry, 0.3 MB\n  equations: 2 entries, 0.2 MB\n  other files: 1 entry, 0.1 MB\n"
        "  of other versions and settings: 1 entry, 0.4 MB, in 1 folder\n"
        "runs of studies: 0 entries, 0.0 MB (limit: 1000 MB)\n"
    )


def test_the_command_empties_the_folder(folder, say):
    filled(folder)
    code, out, _ = say("cache", "--clear")
    assert (code, out) == (0, f"removed 7 entries, 0.8 MB, from {folder}\n")
    assert os.listdir(folder) == []
    assert say("cache", "--clear")[1] == f"removed 0 entries, 0.0 MB, from {folder}\n"


def test_the_command_leaves_what_mbdsl_did_not_write(folder, say, tmp_path):
    """MBDSL_CACHE_DIR may be a folder with other files; links are not followed."""
    names = ("letter.o", f"{VERSION}/notes.txt", "studies/mine.npz", "src-py311-0123456789abcdef/a.o", "a.part")
    foreign = [planted(folder, name) for name in names]
    target = planted(tmp_path / "target", "mbdsl_a.o")
    (folder / VERSION.replace("311", "312")).symlink_to(target.parent)
    filled(folder)
    code, out, _ = say("cache", "--clear")
    assert code == 0 and all(path.exists() for path in [*foreign, target])
    assert out.startswith("removed 7 entries, 0.8 MB") and "left unchanged" in out and "letter.o" in out


@needs_owners
def test_the_command_says_why_a_folder_is_not_used(folder, say):
    filled(folder)
    folder.chmod(0o777)
    code, out, err = say("cache")
    assert (code, err) == (0, "")
    assert (
        out == f"folder: {folder}\nnot used: others can write into `{folder}` (mode 0777; try: chmod go-w {folder})\n"
    )
    code, out, err = say("cache", "--clear")
    assert (code, out) == (2, "") and "not emptied: others can write into" in err
    assert (folder / OBJECT).exists()


def test_the_command_says_that_it_cannot_be_written(folder, read_only, say):
    planted(folder)
    code, out, err = say("cache")
    assert (code, err) == (0, "")
    assert out.endswith(f"nothing can be stored: cannot write into `{folder}` (Read-only file system)\n")


def test_the_help_fits_a_terminal(say, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, _ = say("cache", "--help")
    assert code == 0 and "--clear" in out and "MBDSL_CACHE_DIR" in out and max(map(len, out.splitlines())) <= 80


# -- runs of studies -------------------------------------------------------------------------------------------------

CASE = Case("hht-si2", step=1e-3)
KEY = "0" * 32


def computed():
    t = np.linspace(0.0, 1.0, 3)
    return Computed(CASE, t, t[:, None], t[:, None], t[:, None])


@needs_owners
def test_runs_that_others_can_have_written_are_not_read(folder, give_away):
    """For any place of the store."""
    for store in (Store(), Store(folder / "named")):
        assert store.put(KEY, computed()) and store.get(KEY, CASE) is not None
        path = store.folder / f"{KEY}.npz"
        path.chmod(0o666)
        assert store.get(KEY, CASE) is None
        path.chmod(0o644)
        give_away(path)
        assert store.get(KEY, CASE) is None
        assert store.put(KEY, computed()) and store.get(KEY, CASE) is not None


def test_a_run_under_the_name_of_another_is_not_read(folder):
    store = Store()
    assert store.folder == folder / "studies"
    store.put(KEY, computed())
    (store.folder / f"{KEY}.npz").rename(store.folder / f"{'1' * 32}.npz")
    assert store.get("1" * 32, CASE) is None


def test_a_run_that_cannot_be_kept(folder, monkeypatch, capsys):
    from mbdsl.studies.cases import setting
    from mbdsl.studies.runner import Runner

    def full(path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    store = Store()
    runner = Runner(setting(Path(__file__).parents[3] / "models" / "pendulum.mbd", 0.1), store)
    monkeypatch.setattr(cache_folder, "_created", full)
    monkeypatch.setattr("mbdsl.studies.runner.compute", lambda *arguments: computed())
    assert runner.compute([CASE])[CASE].done and not runner.kept
    store.put_times(KEY, "session", [1.0])
    assert store.times(KEY) == ("", [])
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_store_does_not_remove_other_files(tmp_path):
    store = Store(tmp_path)
    mine = planted(tmp_path, "measurement.npz", bytes(1000))
    store.put(KEY, computed())
    store.prune(largest=0)
    assert mine.exists() and store.get(KEY, CASE) is None


def test_a_store_without_a_place(folder, monkeypatch):
    from mbdsl.errors import UsageError

    monkeypatch.setattr(cache_folder, "own", lambda: None)
    with pytest.raises(UsageError, match="no folder that the runs of a study can be written into"):
        Store()
    folder.parent.mkdir()
    folder.write_text("a file")
    with pytest.raises(UsageError, match="cannot make the folder"):
        Store(folder)
