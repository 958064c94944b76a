"""Tables of files: values against NumPy's interpolation, formats, the folder that is not left, messages with lines."""

import os
import pickle

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import ModelError
from mbdsl.lang import limits
from mbdsl.lang.stored_model import from_text, to_text

MODEL = """
model Car
  parameter String road = "road.csv";
  Table profile(file = road, x = "s", y = "z"{more});
  Ground ground;
  PointMass wheel(m = 1 kg);
  Prismatic guide(ground, wheel);
  TranslationalDriver moved(ground, wheel, s = 1 m + profile(10 m/s*time));
  annotation(experiment(StopTime = 1 s));
end Car;
"""
POINTS = [(0.0, 0.0), (2.5, 30.0), (7.0, -12.5), (10.0, 4.0)]  #: in m and mm
CSV = "s [m], z [mm]\n" + "".join(f"{s},{z}\n" for s, z in POINTS)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "model").mkdir()
    return tmp_path / "model"


def model(folder, csv=CSV, text=MODEL, more="", name="road.csv"):
    if csv is not None:
        (folder / name).write_bytes(csv if isinstance(csv, bytes) else csv.encode())
    path = folder / "car.mbd"
    path.write_text(text.replace("{more}", more))
    return path


def heights(path, **given):
    return mbdsl.simulate(path, step=2e-3, **given)["wheel.x"]


def expected(points=POINTS):
    s, z = np.array(points).T
    return 1.0 + np.interp(10.0 * np.linspace(0.0, 1.0, 501), s, 1e-3 * z)


# -- values and formats ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "csv",
    [
        CSV,
        "\ufeff" + CSV,
        CSV.replace("\n", "\r\n"),
        CSV.replace(",", ";"),
        CSV.replace(", ", ",").replace(",", "\t"),
        '"s [m]","z [mm]"\n' + "\n\n".join(f'"{s}", {z}' for s, z in POINTS),
        "n, z [m], s [mm], note\n" + "".join(f"{k},{z * 1e-3!r},{s * 1e3},\n" for k, (s, z) in enumerate(POINTS)),
        "s,z\nm,mm\n" + "".join(f"{s},{z}\n" for s, z in POINTS),
        "s,z\n" + "".join(f"{s},{z * 1e-3!r}\n" for s, z in POINTS),  # SI units
    ],
    ids=["plain", "mark", "crlf", "semicolons", "tabs", "quotes", "more columns", "row of units", "no units"],
)
def test_forms_of_csv(csv, folder):
    np.testing.assert_allclose(heights(model(folder, csv)), expected(), atol=1e-12)


def test_two_columns_need_no_names(folder):
    path = model(folder, text=MODEL.replace(', x = "s", y = "z"', ""))
    np.testing.assert_allclose(heights(path), expected(), atol=1e-12)


def test_the_result_of_a_run_as_a_table(folder):
    """The motion of one run drives the other: as npz, and as CSV with and without a row of units."""
    first = model(folder)
    run = mbdsl.simulate(first, step=2e-3)
    text = MODEL.replace('x = "s", y = "z"', 'x = "time", y = "wheel.x"').replace(
        "1 m + profile(10 m/s*time)", "profile(time)"
    )
    for name in ("run.npz", "run.csv"):
        run[["wheel.x"]].save(folder / name)
        second = model(folder, None, text.replace("road.csv", name))
        np.testing.assert_allclose(mbdsl.simulate(second, step=2e-3)["wheel.x"], run["wheel.x"], atol=1e-12)


def test_many_rows_with_all_their_digits(folder):
    rng = np.random.default_rng(5)
    s, z = np.cumsum(rng.uniform(0.1, 1.0, 20_000)), rng.normal(size=20_000)
    path = model(
        folder, "s [m],z [m]\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(s.tolist(), z.tolist(), strict=True))
    )
    (table,) = _tables(mbdsl.load(path))
    assert table.u == tuple(s.tolist())
    assert table.y == tuple(z.tolist())


def _tables(scene):
    from mbdsl.expressions.symbolic import walk

    laws = (x for c in scene.components.values() for x in c.values.values() if hasattr(x, "op"))
    return list({node.value[0] for law in laws for node in walk(law) if node.op == "table"})


def test_other_settings_and_units(folder):
    path = model(folder, more=', smoothness = "cubic", extrapolation = "linear"')
    assert _tables(mbdsl.load(path))[0].smoothness == "cubic"
    with pytest.raises(ModelError, match=r"the argument of `profile`: found .* expected a length"):
        mbdsl.load(model(folder, text=MODEL.replace("10 m/s*time", "time")))


def test_a_file_below_and_another_file_by_a_parameter(folder):
    (folder / "roads").mkdir()
    other = "s [m], z [mm]\n0, 0\n10, 100\n"
    path = model(folder, other, name="roads/flat.csv")
    model(folder)
    found = heights(path, parameters={"road": '"roads/flat.csv"'})
    np.testing.assert_allclose(found, expected([(0.0, 0.0), (10.0, 100.0)]), atol=1e-12)


def test_a_table_of_an_imported_model_is_beside_it(folder):
    (folder / "parts").mkdir()
    model(folder, name="parts/road.csv")
    part = 'model Road\n  Table profile(file = "road.csv");\n  Real z = profile(10 m/s*time);\nend Road;'
    (folder / "parts" / "road.mbd").write_text(part)
    text = MODEL.replace('  Table profile(file = road, x = "s", y = "z"{more});', "  Road road_;")
    text = 'import "parts/road.mbd";\n' + text.replace("profile(10 m/s*time)", "road_.z").replace(
        '  parameter String road = "road.csv";\n', ""
    )
    np.testing.assert_allclose(heights(model(folder, None, text)), expected(), atol=1e-12)


# -- models that are read again ----------------------------------------------------------------------------------------


def test_changed_and_stored_models_do_not_read_the_disk(folder):
    path = model(folder)
    scene = mbdsl.load(path)
    for file in folder.iterdir():
        file.unlink()
    again = scene.changed({"road": '"road.csv"'})
    assert again == scene
    assert from_text(to_text(scene)) == scene  # as in the npz of a result
    assert pickle.loads(pickle.dumps(scene)).changed({}) == scene


def test_long_columns_are_a_digest_in_results(folder, monkeypatch):
    monkeypatch.setattr(limits, "ARRAY", 6)
    scene = mbdsl.load(model(folder))
    assert pickle.loads(pickle.dumps(scene)).changed({}) == scene
    assert "SHA-256" in scene.files[str(folder / "road.csv")]
    with pytest.raises(ModelError, match="too long to be stored with results"):
        from_text(to_text(scene))


@pytest.mark.parametrize("unit", ["mm", "inch", "ft"])
def test_stored_columns_have_the_same_numbers(unit, folder):
    rng = np.random.default_rng(1)
    rows = zip(range(2000), rng.normal(size=2000).tolist(), strict=True)
    scene = mbdsl.load(model(folder, f"s [m],z [{unit}]\n" + "".join(f"{s},{z!r}\n" for s, z in rows)))
    np.testing.assert_allclose(_tables(from_text(to_text(scene)))[0].y, _tables(scene)[0].y, rtol=3e-16)


def test_a_changed_file_is_another_model(folder):
    path = model(folder)
    first = mbdsl.load(path)
    assert mbdsl.load(path).fingerprint == first.fingerprint
    model(folder, CSV.replace("30.0", "31.0"))
    assert mbdsl.load(path).fingerprint != first.fingerprint
    assert dict(mbdsl.load(path).files) != dict(first.files)


# -- the folder of the model -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "../road.csv",
        "a/../../road.csv",
        "..\\\\road.csv",
        "/etc/road.csv",
        "~/road.csv",
        "C:/road.csv",
        "file:///road.csv",
    ],
)
@pytest.mark.parametrize("allow", [False, True])
def test_no_file_of_another_folder(name, allow, folder):
    model(folder.parent, name="road.csv")
    path = model(folder, text=MODEL.replace("road.csv", name))
    with pytest.raises(ModelError, match="leads out of the folder of the model") as problem:
        mbdsl.load(path, allow_imports=allow)
    assert problem.value.span.line == 4


def test_no_link_to_another_folder(folder):
    model(folder.parent, name="road.csv")
    (folder / "road.csv").symlink_to(folder.parent / "road.csv")
    (folder / "up").symlink_to(folder.parent)
    for name in ("road.csv", "up/road.csv"):
        with pytest.raises(ModelError, match="leads out of the folder of the model"):
            mbdsl.load(model(folder, None, MODEL.replace("road.csv", name)), allow_imports=True)


def test_a_link_within_the_folder(folder):
    path = model(folder, name="measured.csv")
    (folder / "road.csv").symlink_to("measured.csv")
    np.testing.assert_allclose(heights(path), expected(), atol=1e-12)


def test_pipes_and_folders_are_not_read(folder):
    os.mkfifo(folder / "road.csv")
    with pytest.raises(ModelError) as problem:
        mbdsl.load(model(folder, None))
    (folder / "road.csv").unlink()
    (folder / "road.csv").mkdir()
    with pytest.raises(ModelError) as other:
        mbdsl.load(model(folder, None))
    assert problem.value.message == other.value.message == "`road.csv`: it is not a regular file"


def test_bounds(folder, monkeypatch):
    path = model(folder)
    for name, value, message in (
        ("DATA_SIZE", 20, "a file of a table has at most 20"),
        ("DATA_ROWS", 3, "it has more than 3 rows"),
        ("DATA_NUMBERS", 7, "more than 7 numbers"),
    ):
        monkeypatch.setattr("mbdsl.lang.data_files._cache", {})
        monkeypatch.setattr(limits, name, value)
        with pytest.raises(ModelError, match=message):
            mbdsl.load(path)
        monkeypatch.undo()


# -- messages ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("csv", "message", "hint", "line"),
    [
        ("s [m], z [mm]\n0, 1\n2, abc\n", "line 3: found `abc` in column `z`", "expected a number", 3),
        ("s [m], z [mm]\n0, 1\n\n2, 5 mm\n", "line 4: found `5 mm` in column `z`", "units are in the first line", 4),
        ("s [m]; z [mm]\n0; 1\n2; 1,5\n", "line 3: found `1,5` in column `z`", "decimals with a point", 3),
        ("s [m], z [mm]\n0, 1\n2,\n", "line 3: it has no value in column `z`", "each row has a number", 3),
        (
            "s [m], z [mm]\n0, 1\n1,2,5\n",
            "line 3: it has 3 values, but the header names 2 columns",
            "decimals with a",
            3,
        ),
        ("s [m], z [mm]\n0, 1\n2\n", "line 3: it has no value in column `z`", "each row has a number", 3),
        ("s [m], z [mm]\n0, 1\n2, nan\n", "line 3: found `nan` in column `z`, expected a finite number", "", 3),
        (
            "s [m], z [mm]\n0, 1\n\n2, 1\n2, 3\n",
            "line 5: column `s` must increase strictly: 2",
            "sort the rows",
            5,
        ),
        ("s [m], z [furlong]\n0, 1\n2, 3\n", "line 1: unknown unit `furlong` of column `z`", "mm", 1),
        ("0, 1\n2, 3\n", "line 1: it has no names of columns", "s [m], z [mm]", 1),
        ("", "it has no names of columns", "s [m], z [mm]", 1),
        ("s [m], y [mm]\n0, 1\n2, 3\n", "it has no column `z`", "columns: s, y", None),
        ("s [m], z [m], z [mm]\n0, 1, 1\n2, 3, 3\n", "2 columns `z`", "a name of its own", 1),
        ("s [m], z [mm]\n0, 1\n", "it has 1 row of numbers, expected at least 2", "", None),
        ("s [m], z [mm]\n", "it has 0 rows", "", None),
        (b"\xff\xfe\x00s\x00", "it is not a text (UTF-8)", "", None),
    ],
)
def test_messages(csv, message, hint, line, folder):
    with pytest.raises(ModelError) as problem:
        mbdsl.load(model(folder, csv))
    found = problem.value
    assert message in found.message
    assert "`road.csv`" in found.message
    assert hint in (found.hint or "")
    assert found.span.line == 4  # of the model
    if line is not None:
        ((_, place),) = found.notes
        assert (os.path.basename(place.file), place.line) == ("road.csv", line)
        text = csv.split("\n")[line - 1]
        assert place.text.replace(" ", "") == text.replace(" ", "")


@pytest.mark.parametrize(
    ("arguments", "message", "hint"),
    [
        ('file = "raod.csv"', "`raod.csv`: there is no such file", "road.csv"),
        ('file = "road.txt"', "`road.txt`: its suffix is none of .csv and .npz", ""),
        ('file = ""', "``: it names no file", ""),
        ("file = 3", "`file` of `profile`: found a number, expected a text", ""),
        ('file = "road.csv", x = 1', "`x` of `profile`: found a number, expected a text", ""),
        ('file = "road.csv", table = [0, 1; 2, 3]', "has both `table` and `file`", "leave one out"),
        ('table = [0, 1; 2, 3], x = "s"', "`x` names a column of `file`", ""),
        ('file = "road.csv", extrapolation = "periodic"', "is periodic, but begins with 0 and ends with 0.004", ""),
        ('files = "road.csv"', "a Table has no `files`", "file"),
        ("", "Table `profile` needs `table`", 'file = "road.csv"'),
        ('file = "run.npz"', "`run.npz`: it is not the npz of a run, or is damaged", ""),
    ],
)
def test_messages_of_arguments(arguments, message, hint, folder):
    (folder / "run.npz").write_bytes(b"PK nothing")
    path = model(folder, text=MODEL.replace('file = road, x = "s", y = "z"{more}', arguments))
    with pytest.raises(ModelError) as problem:
        mbdsl.load(path)
    assert message in problem.value.message
    assert hint in (problem.value.hint or "")


def test_damaged_archives_are_named(folder):
    """Each is either refused or read: no other exception leaves."""
    run = mbdsl.simulate(model(folder), step=0.1)
    run[["wheel.x"]].save(folder / "run.npz")
    whole = (folder / "run.npz").read_bytes()
    path = model(
        folder, None, MODEL.replace("road.csv", "run.npz").replace('x = "s", y = "z"', 'x = "time", y = "wheel.x"')
    )
    rng, refused = np.random.default_rng(3), 0
    for k in range(60):
        broken = bytearray(whole[: len(whole) - 7 * k] if k % 2 else whole)
        for at in rng.integers(0, len(broken), 4):
            broken[at] ^= 1 << int(rng.integers(8))
        (folder / "run.npz").write_bytes(broken)
        try:
            mbdsl.load(path)
        except ModelError as problem:
            refused += "run.npz" in problem.message
    assert refused > 30


def test_models_of_the_library_have_points():
    library = mbdsl.Builder("Car")
    with pytest.raises((ModelError, TypeError)):
        library.table("profile", file="road.csv")
