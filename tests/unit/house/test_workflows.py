"""The files for GitHub and for pre-commit: they satisfy the published schemas, and name programs that exist."""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed: pip install '.[docs]'")

ROOT = Path(__file__).parents[3]
GITHUB = ROOT / ".github"
CI = GITHUB / "workflows" / "ci.yml"
FORM = GITHUB / "ISSUE_TEMPLATE" / "bug.yml"
SCHEMAS = {
    "vendor.github-workflows": CI,
    "vendor.github-issue-forms": FORM,
    "vendor.github-issue-config": GITHUB / "ISSUE_TEMPLATE" / "config.yml",
    "vendor.citation-file-format": ROOT / "CITATION.cff",
}
installed = pytest.mark.skipif(
    not find_spec("check_jsonschema"), reason="check-jsonschema is not installed: pip install '.[test]'"
)


def checked(schema, *files):
    """Exit code and output of the check of files against a schema, which is part of its package."""
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def read(path):
    """The content of a YAML file; ``on`` is a word, which YAML 1.1 reads as true."""
    found = yaml.safe_load(path.read_text(encoding="utf-8"))
    return {"on" if key is True else key: value for key, value in found.items()}


@installed
@pytest.mark.parametrize("schema", SCHEMAS)
def test_schema(schema):
    code, said = checked(schema, SCHEMAS[schema])
    assert code == 0, said


@installed
def test_a_wrong_workflow_is_found(tmp_path):
    """A misspelt key of a job."""
    wrong = tmp_path / "ci.yml"
    wrong.write_text(CI.read_text(encoding="utf-8").replace("    runs-on:", "    run-on:", 1), encoding="utf-8")
    code, said = checked("vendor.github-workflows", wrong)
    assert code == 1
    assert "run-on" in said or "runs-on" in said


def commands():
    """Job -> the lines of its ``run`` steps."""
    return {
        name: [line for step in job["steps"] for line in step.get("run", "").splitlines()]
        for name, job in read(CI)["jobs"].items()
    }


def test_jobs():
    """Lint, types, the default suite on three systems with two versions of Python, everything each night, wheels."""
    workflow, said = read(CI), commands()
    jobs = workflow["jobs"]
    assert {"ruff check .", "ruff format --check ."} <= set(said["lint"])
    assert said["types"][-1] == "mypy"
    matrix = jobs["tests"]["strategy"]["matrix"]
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}
    assert matrix["python"] == ["3.10", "3.13"]
    assert said["tests"][-1] == "pytest -n auto"
    assert "schedule" in workflow["on"] and "'schedule'" in jobs["everything"]["if"]
    assert said["everything"][-1] == 'pytest -n auto -m "deep or not deep" ${{ matrix.options }}'
    assert {x["dependencies"] for x in jobs["everything"]["strategy"]["matrix"]["include"]} == {"lowest", "newest"}
    assert workflow["on"]["push"]["tags"] == ["v*"] and "refs/tags/v" in jobs["wheel"]["if"]
    assert "python -m build" in said["wheel"]


def test_jobs_wait_for_jobs_that_exist():
    jobs = read(CI)["jobs"]
    assert {other for job in jobs.values() for other in job.get("needs", [])} <= set(jobs)


def test_machine_code_is_kept_under_a_digest_of_the_package():
    workflow = read(CI)
    folder = workflow["env"]["MBDSL_CACHE_DIR"].rpartition("/")[2]
    for name in ("tests", "everything"):
        (kept,) = [step["with"] for step in workflow["jobs"][name]["steps"] if "actions/cache@" in step.get("uses", "")]
        assert kept["path"] == folder
        assert "hashFiles('mbdsl/**/*.py')" in kept["key"] and kept["key"].startswith(kept["restore-keys"])


def test_programs_of_the_project_exist():
    """Of the workflow and of pre-commit."""
    hooks = [hook for repository in read(ROOT / ".pre-commit-config.yaml")["repos"] for hook in repository["hooks"]]
    assert [hook["id"] for hook in hooks] == ["ruff-check", "ruff-format", "generated-files", "line-budgets"]
    lines = [hook["entry"] for hook in hooks] + [line for found in commands().values() for line in found]
    programs = [word for line in lines for word in line.split() if word.startswith((".ci/", "tests/"))]
    assert len(programs) >= 5
    assert not [program for program in programs if not (ROOT / program).exists()]
    for hook in hooks:
        assert hook["language"] == "system"
        re.compile(hook.get("files", ""))


def test_files_that_start_a_hook_exist():
    """``generated-files`` starts for each file that it writes."""
    hooks = [hook for repository in read(ROOT / ".pre-commit-config.yaml")["repos"] for hook in repository["hooks"]]
    starts = {hook["id"]: re.compile(hook["files"]) for hook in hooks if "files" in hook}
    program = (ROOT / ".ci" / "generated_files.py").read_text(encoding="utf-8")
    files = re.findall(r'"((?:docs|mbdsl|editors)/[\w./]+\.\w+)"', program)
    assert len(files) >= 6
    assert not [name for name in files if not starts["generated-files"].search(name)]
    assert starts["line-budgets"].search("mbdsl/cli/check.py") and not starts["line-budgets"].search("docs/index.md")


def test_the_form_asks_for_what_a_report_needs():
    fields = [field["id"] for field in read(FORM)["body"]]
    assert fields == ["model", "command", "version", "found", "expected", "source"]


def test_security_in_five_lines():
    lines = (ROOT / "SECURITY.md").read_text(encoding="utf-8").splitlines()
    assert [line[:2] for line in lines if line] == ["# ", *["- "] * 5]
    for word in ("data", "--method FILE", "cache", "Report", "release"):
        assert word in "\n".join(lines)
