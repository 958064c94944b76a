"""Damaged result files: an error of one line or the values as they were, never another exception."""

import random

import numpy as np
import pytest

from mbdsl import results
from mbdsl.cli import main
from mbdsl.errors import UsageError

COLUMNS = {"time": np.linspace(0.0, 1.0, 5), "a.x": np.arange(5.0), "b.y": np.ones(5)}
SUFFIXES = (".csv", ".mat", ".nc", ".npz")
META = {"complete": True, "model": "M", "step": 1e-3}


def written(path):
    results.write(path, COLUMNS, {"time": "s", "a.x": "m"}, META)
    return path.read_bytes()


def tell(path, data):
    """The message, or None if something was read."""
    path.write_bytes(data)
    problem_text = None
    try:
        results.read(path)
    except UsageError as problem:
        problem_text = problem.message
    assert problem_text is None or "\n" not in problem_text
    return problem_text


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("suffix", [".npz", ".nc", ".mat"])
def test_damaged_bytes(suffix, tmp_path):
    path = tmp_path / f"x{suffix}"
    good = written(path)
    draw = random.Random(14)
    for _ in range(400):
        data = bytearray(good)
        data[draw.randrange(len(data))] = draw.randrange(256)
        tell(path, bytes(data))
    for cut in range(0, len(good), 7):
        assert "is not a" in tell(path, good[:cut])
    for _ in range(50):
        assert "is not a" in tell(path, draw.randbytes(draw.randrange(1000)))


@pytest.mark.parametrize("field", [4, 6, 8], ids=["version needed", "flags", "compression"])
def test_fields_of_the_archive(field, tmp_path):
    """Of the last member, in its local header and in the directory (PKWARE's APPNOTE, 4.3.7 and 4.3.12)."""
    path = tmp_path / "x.npz"
    data = bytearray(written(path))
    data[data.rindex(b"PK\x03\x04") + field] = data[data.rindex(b"PK\x01\x02") + field + 2] = 99
    assert "damaged" in tell(path, bytes(data))


def test_pickles_are_never_opened(tmp_path):
    class Bomb:
        def __reduce__(self):
            return (tmp_path.joinpath("opened").touch, ())

    path = tmp_path / "x.npz"
    np.savez(path, time=np.array([Bomb()], dtype=object))
    (tmp_path / "opened").unlink(missing_ok=True)
    assert tell(path, path.read_bytes()) is not None
    assert not (tmp_path / "opened").exists()


@pytest.mark.parametrize("suffix", [".npz", ".nc"])
def test_a_study_is_given_a_damaged_reference(suffix, tmp_path, capsys):
    reference = tmp_path / f"r{suffix}"
    data = written(reference)
    reference.write_bytes(data[: len(data) // 2])
    model = tmp_path / "m.mbd"
    model.write_text(
        "model M Ground ground; Rod r(m = 1 kg, length = 1 m); Revolute p(ground, r.a);\n"
        "annotation(experiment(StopTime = 0.01 s)); end M;"
    )
    code = main(["study", "convergence", str(model), "--steps", "1ms,2ms", "--reference", str(reference)])
    problem_text = capsys.readouterr().err
    assert (code, problem_text.count("\n")) == (2, 1)
    assert problem_text.startswith(f"error: `{reference}` is not a {suffix} result file, or is damaged: ")


@pytest.mark.parametrize(
    "arrays",
    [
        {"time": np.array(["a"] * 3)},
        {"time": np.zeros(3, dtype=[("a", float)])},
        {"time": np.zeros((3, 2))},
        {"time": np.arange(3.0), "_mbdsl": np.array('{"names": ["time"], "meta": 3}')},
        {"time": np.arange(3.0), "_mbdsl": np.array("[]")},
        {"time": np.arange(3.0), "_mbdsl": np.array('{"names": [["time"]]}')},
    ],
    ids=range(6),
)
def test_archives_that_are_no_results(arrays, tmp_path, capsys):
    np.savez(tmp_path / "r.npz", **arrays)
    model = tmp_path / "m.mbd"
    model.write_text("model M Ground ground; Rod r(m = 1 kg, length = 1 m); Revolute p(ground, r.a); end M;")
    words = ["study", "convergence", str(model), "--steps", "1ms,2ms", "--stop", "2ms"]
    assert main([*words, "--output", str(tmp_path / "o"), "--reference", str(tmp_path / "r.npz")]) == 2
    assert capsys.readouterr().err.startswith("error: ")


@pytest.mark.parametrize(
    "about",
    [
        "[1, 2]",
        '"text"',
        '{"meta": [1, 2]}',
        '{"meta": "x"}',
        '{"meta": {"model": {"a": 1}, "step": [1]}}',
        '{"meta": {"model": null}}',
        '{"meta": {"steps": 1' + "0" * 400 + "}}",
        '{"meta": {"model": "\\ud800"}}',
        '{"units": ["s", "m"]}',
        '{"units": {"a": 3}}',
        '{"units": null}',
    ],
)
def test_what_an_archive_says_about_itself(about, tmp_path, capsys, monkeypatch):
    """Commands that read it in parts and as a whole: a line with the reason, and no file."""
    monkeypatch.chdir(tmp_path)
    np.savez("r.npz", time=np.arange(3.0), a=np.ones(3), _mbdsl=np.array(about))
    for words in (["info", "r.npz"], ["plot", "r.npz"], *(["convert", "r.npz", "--out", f"o{x}"] for x in SUFFIXES)):
        assert main(words) == 2, words
        error = capsys.readouterr().err
        assert error.startswith("error: `r.npz` is not a .npz result file, or is damaged: ") and error.count("\n") == 1
    if "units" not in about:
        assert "damaged" in tell(tmp_path / "r.npz", (tmp_path / "r.npz").read_bytes())
    assert [path.name for path in tmp_path.iterdir()] == ["r.npz"]
