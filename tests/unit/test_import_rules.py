"""Who may import whom. Kept by reading the files, and by looking at what a fresh process has loaded."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import mbdsl

PACKAGE = Path(mbdsl.__file__).parent
NUMERICS = ("numpy", "scipy", "numba", "matplotlib", "networkx", "pandas", "xarray")
#: part of the package -> what none of its files imports, not even inside a function
FORBIDDEN = {
    "elements": ("mbdsl.lang", "mbdsl.mechanism.graph", "mbdsl.integrators", "mbdsl.system", "mbdsl.cli", *NUMERICS),
    "bodies": (
        "mbdsl.lang",
        "mbdsl.mechanism.graph",
        "mbdsl.integrators",
        "mbdsl.mechanism.reduction",
        "mbdsl.compilation.code_cache",
        "mbdsl.cli",
    ),
    "lang": (
        "mbdsl.mechanism.graph",
        "mbdsl.system",
        "mbdsl.integrators",
        "mbdsl.compilation.code_cache",
        "mbdsl.cli",
        *NUMERICS,
    ),
    "mechanism/reduction": (
        "mbdsl.system",
        "mbdsl.integrators",
        "mbdsl.compilation.code_cache",
        "mbdsl.cli",
        *NUMERICS,
    ),
    "integrators": ("mbdsl.elements", "mbdsl.lang", "mbdsl.mechanism.graph", "mbdsl.cli"),
    "plotting": (
        "mbdsl.lang",
        "mbdsl.elements",
        "mbdsl.mechanism.graph",
        "mbdsl.system",
        "mbdsl.integrators",
        "mbdsl.cli",
    ),
    "results": (
        "mbdsl.lang",
        "mbdsl.elements",
        "mbdsl.mechanism.graph",
        "mbdsl.system",
        "mbdsl.integrators",
        "mbdsl.cli",
    ),
}
#: what none may import while it is itself imported: extras, and what is slow to load
LATE = {"mechanism/graph.py": NUMERICS, "cli": NUMERICS, "results": NUMERICS, ".": ("matplotlib", "pandas", "xarray")}


def imports(tree, inside_functions):
    """Names of the modules that a file imports; blocks for the type checker do not count."""
    for node in tree.body:
        yield from _imports(node, inside_functions)


def _imports(node, inside):
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        assert node.level == 0, "imports are absolute"
        yield from (f"{node.module}.{alias.name}" for alias in node.names)
    elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        return
    elif inside or not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        for child in ast.iter_child_nodes(node):
            yield from _imports(child, inside)


def offences(part, forbidden, inside_functions):
    root = PACKAGE / part
    for file in sorted(root.rglob("*.py")) if root.is_dir() else [root]:
        for name in imports(ast.parse(file.read_text(encoding="utf-8")), inside_functions):
            if any(name == f or name.startswith(f + ".") for f in forbidden):
                yield f"{file.relative_to(PACKAGE)} imports {name}"


@pytest.mark.parametrize("part", FORBIDDEN)
def test_no_part_reaches_where_it_must_not(part):
    assert list(offences(part, FORBIDDEN[part], True)) == []


@pytest.mark.parametrize("part", LATE)
def test_what_is_slow_or_optional_is_imported_where_it_is_used(part):
    assert list(offences(part, LATE[part], False)) == []


def test_the_reader_of_imports_sees_them():
    tree = ast.parse(
        "import a.b\nfrom c import d\nif TYPE_CHECKING:\n    import e\n"
        "class F:\n    def g(self):\n        import h\ntry:\n    import i\nexcept ImportError:\n    pass\n"
    )
    assert list(imports(tree, True)) == ["a.b", "c.d", "h", "i"]
    assert list(imports(tree, False)) == ["a.b", "c.d", "i"]


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["simulate", "--help"], ["check", "MODEL"]])
def test_quick_commands_load_no_numerics(arguments):
    model = Path(__file__).parents[2] / "models" / "slider_crank.mbd"
    arguments = [str(model) if a == "MODEL" else a for a in arguments]
    code = (
        "import sys, mbdsl.cli\ncode = mbdsl.cli.main(sys.argv[1:])\n"
        f"print(code, *sorted(set(sys.modules) & set({NUMERICS!r})), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    assert done.stdout
    assert done.stderr == "0\n"
