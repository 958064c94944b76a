"""Imports stay within the model's folder, links followed, unless allowed; messages show no content of files that are
not models."""

import os
import pickle
from pathlib import Path

import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import ModelError

ARM = "model Arm Frame tip; Rod r(m = 1 kg, length = 1 m); Revolute j(tip, r.a); end Arm;"
MAIN = "{imports} model Main Ground g; Arm arm(g); annotation(experiment(StopTime = 2 ms)); end Main;"
SECRET = "root:$6$secret:0:0"


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """A folder of a model with a subfolder; outside of it one file that is a model and one that is not."""
    inner = tmp_path / "models" / "parts"
    inner.mkdir(parents=True)
    (tmp_path / "arm.mbd").write_text(ARM)
    (tmp_path / "secret").write_text(SECRET)
    (inner / "arm.mbd").write_text(ARM)
    (inner / "notes.mbd").write_text(SECRET)
    os.symlink(tmp_path / "arm.mbd", inner / "out.mbd")
    os.symlink(tmp_path, inner / "up")
    os.symlink(inner / "arm.mbd", inner / "stays.mbd")
    monkeypatch.chdir(tmp_path / "models")
    return tmp_path


def model(*imports):
    path = Path("main.mbd")
    path.write_text(MAIN.format(imports=" ".join(f'import "{name}";' for name in imports)))
    return path


@pytest.mark.parametrize(
    "name", ["parts/arm.mbd", "parts/stays.mbd", "../models/parts/arm.mbd", "parts/../parts/arm.mbd"]
)
def test_inside(name, folders):
    assert "arm.r" in mbdsl.load(model(name)).components


@pytest.mark.parametrize(
    "name", ["../arm.mbd", "parts/out.mbd", "parts/up/arm.mbd", "parts/../../arm.mbd", "../nowhere.mbd", "../secret"]
)
def test_outside(name, folders):
    """The message does not reveal whether a file exists."""
    for path in (model(name), (folders / "models" / "main.mbd")):
        with pytest.raises(ModelError) as caught:
            mbdsl.load(path)
        assert caught.value.message == f'the import "{name}" leads out of the folder of the model'
        assert (caught.value.span.line, caught.value.span.column) == (1, 8)
        assert "--allow-imports" in caught.value.hint
    if name.endswith(("arm.mbd", "out.mbd")):
        assert "arm.r" in mbdsl.load(path, allow_imports=True).components
        assert "arm.r" in mbdsl.load(path, allow_imports=folders).components
    with pytest.raises(ModelError, match="leads out"):
        mbdsl.load(path, allow_imports=folders / "models" / "parts")


def test_an_imported_file_is_bound_to_the_same_folder(folders):
    Path("parts/two.mbd").write_text('import "../../arm.mbd";')
    with pytest.raises(ModelError, match="leads out") as caught:
        mbdsl.load(model("parts/arm.mbd", "parts/two.mbd"))
    assert caught.value.span.file == "parts/two.mbd"
    Path("parts/two.mbd").write_text('import "../main.mbd";')  # up, but not out
    assert "arm.r" in mbdsl.load(model("parts/arm.mbd", "parts/two.mbd")).components


def test_a_model_from_a_text_is_bound_to_the_working_folder(folders):
    with pytest.raises(ModelError, match="leads out"):
        mbdsl.parse(MAIN.format(imports='import "../arm.mbd";'))
    assert "arm.r" in mbdsl.parse(MAIN.format(imports='import "../arm.mbd";'), allow_imports=True).components
    assert "arm.r" in mbdsl.parse(MAIN.format(imports='import "parts/arm.mbd";')).components


@pytest.mark.parametrize(("name", "allowed"), [("parts/notes.mbd", False), ("../secret", True)])
def test_nothing_is_shown_of_what_is_no_model(name, allowed, folders):
    with pytest.raises(ModelError) as caught:
        mbdsl.load(model(name), allow_imports=allowed)
    rendered = caught.value.render()
    assert "is not a model" in rendered
    assert not [word for word in ("root", "$6", "secret:") if word in rendered.replace("../secret", "")]
    assert caught.value.span.file == "main.mbd"


def test_nothing_is_shown_of_a_script(folders):
    Path("parts/script.mbd").write_text("import secrets\n")
    with pytest.raises(ModelError, match="is not a model") as caught:
        mbdsl.load(model("parts/script.mbd"))
    assert "secrets" not in caught.value.render()


def test_lines_of_imported_models_are_shown(folders):
    Path("parts/wrong.mbd").write_text("// a model\n/* with\n a mistake */ model Wrong\n  Rod r(;\nend Wrong;\n")
    with pytest.raises(mbdsl.SyntaxProblem) as caught:
        mbdsl.load(model("parts/wrong.mbd"))
    assert "  Rod r(;" in caught.value.render()


@pytest.mark.parametrize(
    "command",
    [
        ["check"],
        ["show", "--stage", "scene"],
        ["simulate", "--output", "r.csv", "--quiet"],
        ["static"],
        ["eigen"],
        ["explain", "--no-time"],
        ["recommend", "--error", "1e-3"],
        ["study", "convergence"],
    ],
    ids=" ".join,
)
def test_every_command_that_reads_a_model(command, folders, capsys):
    """The last two directly by their parsers: they run for seconds."""
    path = model("../arm.mbd")
    if command[0] in ("recommend", "study"):
        from mbdsl.cli import make_parser

        found = make_parser().parse_args([*command, str(path), "--allow-imports"])
        assert found.allow_imports is True
        return
    assert main([*command, str(path)]) == 2
    assert "leads out of the folder" in capsys.readouterr().err
    assert main([*command, str(path), "--allow-imports"]) == 0


def test_other_processes_of_a_study_get_what_was_read(folders):
    from mbdsl.lang.library import imports_allowed
    from mbdsl.studies.cases import Case, setting
    from mbdsl.studies.store import key_of

    path = model("../arm.mbd")
    with imports_allowed(True):
        of = setting(str(path))
    there, case = pickle.loads(pickle.dumps(of)), Case("hht-si2", 1e-3, None, ())
    assert "arm.r" in there.scene.components
    assert key_of(there, case) == key_of(of, case)


def test_shipped_models():
    """Models of models/hard that vary a model of models/ need it."""
    shipped = Path(__file__).parents[3] / "models"
    for path in sorted(shipped.rglob("*.mbd")):
        outside = 'import "../' in path.read_text(encoding="utf-8")
        mbdsl.load(path, allow_imports=shipped if outside else False)
        if outside:
            assert path.parent.name == "hard"
            with pytest.raises(ModelError, match="leads out"):
                mbdsl.load(path)
