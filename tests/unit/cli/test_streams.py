"""Standard output or error that is closed or full: the work is done, and the exit code or the other stream reports the
lost output. Each test runs in a process of its own, started by a shell."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

MODEL = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
FULL = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
POSIX = pytest.mark.skipif(os.name != "posix", reason="redirections of a POSIX shell")
SIMULATE = f"simulate {MODEL} --stop 1ms --interval 1ms --output r.csv"


def shell(command, folder):
    """A command line with redirections, run by the shell."""
    line = f'"{sys.executable}" -m mbdsl {command}'
    return subprocess.run(line, shell=True, cwd=folder, capture_output=True, text=True, check=False, timeout=300)


@FULL
@pytest.mark.parametrize(
    ("command", "code"),
    [("check MODEL", 2), ("--help", 2), ("show --stage code MODEL", 2), ("check nothing.mbd", 2)],
)
def test_full_output(command, code, tmp_path):
    done = shell(f"{command.replace('MODEL', str(MODEL))} >/dev/full", tmp_path)
    assert done.returncode == code
    assert done.stderr.count("error: ") == 1
    if "nothing" not in command:
        assert done.stderr.startswith("error: cannot write to standard output: No space left on device\n")


@POSIX
@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        ("check MODEL >&-", 2, "cannot write to standard output"),
        ("--version >&-", 2, "cannot write to standard output"),
        ("check nothing.mbd >&-", 2, "there is no file `nothing.mbd`"),
        ("check nothing.mbd 2>&-", 2, ""),
        ("check MODEL 2>&-", 0, ""),
        ("check MODEL <&- >&- 2>&-", 2, ""),
    ],
)
def test_closed(command, code, said, tmp_path):
    done = shell(command.replace("MODEL", str(MODEL)), tmp_path)
    assert done.returncode == code
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert "internal" not in done.stderr
    assert "Exception ignored" not in done.stderr


@POSIX
@pytest.mark.parametrize(
    ("redirected", "code"),
    [(">&-", 2), pytest.param(">/dev/full", 2, marks=FULL), ("--quiet >&-", 0), ("<&- >&- 2>&-", 2), ("2>&-", 0)],
)
def test_a_run_writes_its_result_all_the_same(redirected, code, tmp_path):
    done = shell(f"{SIMULATE} {redirected}", tmp_path)
    assert done.returncode == code
    header, *rows = (tmp_path / "r.csv").read_text().splitlines()
    assert header.startswith("time,") and len(rows) == 2
    assert {len(row.split(",")) for row in rows} == {len(header.split(","))}


@POSIX
def test_a_reader_that_leaves_gets_no_message(tmp_path):
    done = shell(f"show --stage code {MODEL} | true", tmp_path)
    assert done.stderr == ""


@FULL
def test_progress_that_cannot_be_shown_ends_no_run(monkeypatch, tmp_path):
    """As for `2>/dev/full` on a long run."""
    from mbdsl.cli._progress import Display
    from mbdsl.cli._streams import OutputStream

    with open("/dev/full", "w", buffering=1) as full:
        stream = OutputStream(full)
        display = Display(stream)
        display.show(10.0, lambda: "half", lambda block: "half")
        display.show(20.0, lambda: "done", lambda block: "done")
        display.close()
        assert stream.problem is not None and stream.problem.errno == 28  # ENOSPC
