"""Imports between rooms, checked by reading the files and by the modules that a fresh process has loaded."""

import ast
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import mbdsl

PACKAGE = Path(mbdsl.__file__).parent
NUMERICS = ("numpy", "scipy", "llvmlite", "matplotlib", "networkx", "pandas", "xarray")
AT_IMPORT, IN_FUNCTION, FOR_TYPES = "at import", "in a function", "for the type checker"
#: from the top down: a room imports from itself and from the rooms after it only
ROOMS = (
    *("__init__", "__main__", "notebook", "cli", "reporting", "api", "study", "studies", "analysis", "explanation"),
    "viewing",
    *("simulation", "statics", "initial", "integrators", "editor", "lang", "system", "mechanism"),
    *("elements", "bodies"),
    *("plotting", "results"),
    *(
        "expressions",
        "numerics",
        "compilation",
        "kernels",
        "storage",
        "errors",
        "messages",
        "version",
    ),
)
#: the imports that run upwards, with the reason
UPWARD = {
    ("mbdsl.errors", "mbdsl.simulation.trajectory"): "for type checkers: the results that an error brings with it",
    ("mbdsl.simulation.trajectory", "mbdsl.viewing.animation"): "in `animate`, which is called by users only",
}
#: the imports that close circles, with the reason; none of them is executed while a module is imported
CIRCLES = {
    ("mbdsl.analysis.response_results", "mbdsl.analysis.response_files"): "a Response writes itself to files",
    ("mbdsl.analysis.response_results", "mbdsl.analysis.response_tables"): "a Response prints and draws itself",
    ("mbdsl.explanation.receipt", "mbdsl.explanation.receipt_text"): "a receipt prints itself as text",
    ("mbdsl.mechanism.graph", "mbdsl.mechanism.scene_tables"): "a graph shows itself in a notebook",
    ("mbdsl.mechanism.scene", "mbdsl.mechanism.scene_tables"): "a Scene shows itself in a notebook",
    ("mbdsl.simulation.examined_run", "mbdsl.simulation.checkpoint"): "type: a run may keep checkpoints",
    ("mbdsl.simulation.examined_run", "mbdsl.simulation.streaming"): "type: a run may have a stream, which it warns of",
    ("mbdsl.simulation.run_options", "mbdsl.simulation.checkpoint"): "type: a checkpoint is an option of a run",
    ("mbdsl.simulation.result_file", "mbdsl.simulation.trajectory"): "type: a file is written from a Trajectory",
    ("mbdsl.simulation.trajectory", "mbdsl.simulation.signal_table"): "a Trajectory lists its signals as a table",
    ("mbdsl.studies.sweep_results", "mbdsl.studies.sweep_figures"): "a Sweep draws itself",
    ("mbdsl.viewing.structure", "mbdsl.viewing.structure_files"): "a Structure writes itself to files",
    ("mbdsl.viewing.structure", "mbdsl.viewing.structure_svg"): "a Structure shows itself in a notebook",
    ("mbdsl.viewing.structure", "mbdsl.viewing.structure_text"): "a Structure prints itself as text",
    ("mbdsl.elements.declaration", "mbdsl.elements"): "a kind is pickled by its name, and found again among all kinds",
    ("mbdsl.expressions.symbolic", "mbdsl.expressions.printing"): "an expression prints itself as text",
    ("mbdsl.lang.entities", "mbdsl.lang.flat_component"): "type: what a name stands for may be a component",
    ("mbdsl.lang.entities", "mbdsl.lang.flat_model"): "type: a namespace belongs to a flat model",
    ("mbdsl.lang.entities", "mbdsl.lang.scope"): "type: an entity's modifiers are read in a scope",
    ("mbdsl.lang.flat_component", "mbdsl.lang.flat_model"): "type: a component belongs to a flat model",
    ("mbdsl.lang.component_values", "mbdsl.lang.flat_component"): "type: the values are those of a component",
    ("mbdsl.lang.indices", "mbdsl.lang.scope"): "type: indices are evaluated in a scope",
    ("mbdsl.lang.instance_checks", "mbdsl.lang.instantiate"): "type: what is checked is an instance",
    ("mbdsl.lang.mistakes.references", "mbdsl.lang.scope"): "type: a name is unknown in a scope",
    ("mbdsl.lang.function_calls", "mbdsl.lang.scope"): "type: a function is called in a scope",
    ("mbdsl.lang.paths", "mbdsl.lang.flat_component"): "type: a path is that of a component",
    ("mbdsl.lang.modifiers", "mbdsl.lang.scope"): "type: modifiers are read in the scope that they were written in",
}
#: part of the package -> modules that it reaches by no number of imports, not even inside functions
FORBIDDEN = {
    "elements": ("mbdsl.errors", "mbdsl.storage", *NUMERICS),
    "bodies": ("mbdsl.errors", "mbdsl.storage", "mbdsl.expressions"),
    "editor": ("mbdsl.compilation", "mbdsl.system", *(name for name in NUMERICS if name != "networkx")),
    "lang": ("mbdsl.compilation", *NUMERICS),
    "mechanism": ("mbdsl.compilation", "mbdsl.numerics", *(name for name in NUMERICS if name != "networkx")),
    "mechanism/reduction": tuple(f"mbdsl.storage.{name}" for name in ("cache_folder", "folder_rights", "output_files")),
    "system": ("mbdsl.lang",),
    "integrators": ("mbdsl.lang", "mbdsl.initial"),
    "simulation": ("mbdsl.studies",),
    "analysis": ("mbdsl.studies", "mbdsl.explanation"),
    "plotting": ("mbdsl.expressions", "mbdsl.elements"),
    "results": ("mbdsl.expressions", "mbdsl.elements"),
}
#: part -> modules that its own files do not import: an integrator sees a System, and not the parts of a System
UNSEEN = {"integrators": ("mbdsl.elements", "mbdsl.bodies", "mbdsl.mechanism", "mbdsl.compilation.object_code")}
#: what the model says of its events is data that the integrators act on
SEEN = ("mbdsl.mechanism.events", "mbdsl.mechanism.contacts", "mbdsl.mechanism.sticking")
#: modules that are not loaded while a part is imported: extras, and packages that are slow to load
LATE = {
    "mechanism": NUMERICS,
    "lang": NUMERICS,
    "cli": (*NUMERICS, "pygls", "lsprotocol", "pygments"),
    "simulation": ("mbdsl.plotting", "mbdsl.results.stored", "matplotlib"),
    "results": NUMERICS,
    "errors.py": NUMERICS,
    "__init__.py": ("mbdsl", *NUMERICS),
    ".": ("matplotlib", "pandas", "xarray"),
}


def imports(node, when=AT_IMPORT):
    """(Name, time of the import) of the imports in a syntax tree."""
    if isinstance(node, ast.Import):
        yield from ((alias.name, when) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        assert node.level == 0, "imports are absolute"
        yield from ((f"{node.module}.{alias.name}", when) for alias in node.names)
    elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        for child in node.body:
            yield from imports(child, FOR_TYPES)
    else:
        inside = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and when == AT_IMPORT
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, ast.expr):  # which contains no import, and most of the nodes
                yield from imports(child, IN_FUNCTION if inside else when)


def name_of(file):
    parts = (PACKAGE.name, *file.relative_to(PACKAGE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {name_of(file): file for file in sorted(PACKAGE.rglob("*.py"))}


@cache
def arrows_of_imports():
    """Module -> {module, or name of another package: when it is imported, the first of the three}."""
    found = {}
    for name, file in FILES.items():
        found[name] = {}
        for target, when in imports(ast.parse(file.read_text(encoding="utf-8"))):
            while target.startswith("mbdsl.") and target not in FILES:
                target = target.rpartition(".")[0]
            target = target if target in FILES else target.partition(".")[0]
            known = found[name].get(target, FOR_TYPES)
            order = (AT_IMPORT, IN_FUNCTION, FOR_TYPES)
            if target != name:
                found[name][target] = min(known, when, key=order.index)
    return found


def closure(names, kinds):
    """Modules reached by imports of these kinds but those of UPWARD -> the path to them; importing a module imports its
    packages."""
    ways = {name: (name,) for name in names}
    pending = list(ways)
    while pending:
        name = pending.pop()
        targets = arrows_of_imports().get(name, {}).items()
        following = [target for target, when in targets if when in kinds and (name, target) not in UPWARD]
        if name in FILES and "." in name:
            following.append(name.rpartition(".")[0])
        for target in following:
            if target not in ways and target != "mbdsl":
                ways[target] = (*ways[name], target)
                pending.append(target)
    return ways


def modules(part):
    root = PACKAGE / part
    assert root.exists()
    return [name for name, file in FILES.items() if root in (file, *file.parents)]


def room(name):
    return name.split(".")[1] if "." in name else "__init__"


def reached(part, forbidden, kinds):
    ways = closure(modules(part), kinds)
    return [
        " -> ".join(way)
        for name, way in ways.items()
        if len(way) > 1 and any(name == f or name.startswith(f + ".") for f in forbidden)
    ]


def test_every_file_is_in_a_room():
    assert {room(name) for name in FILES} == set(ROOMS)
    assert {path.name for path in PACKAGE.iterdir() if path.is_file()} == {
        *("__init__.py", "__main__.py", "api.py", "errors.py", "messages.py", "study.py"),
        *("version.py", "py.typed"),
    }


def test_no_import_runs_up():
    """Imports for the type checker are included. As none runs upwards, no chain of them does."""
    floor = {name: k for k, name in enumerate(ROOMS)}
    up = {
        (name, target)
        for name, targets in arrows_of_imports().items()
        for target in targets
        if target in FILES and floor[room(target)] < floor[room(name)]
    }
    assert up == set(UPWARD)


def test_no_imports_go_round_in_circles():
    arrows = {(a, b): when for a, targets in arrows_of_imports().items() for b, when in targets.items() if b in FILES}
    assert {arrow for arrow in CIRCLES if arrows.get(arrow, AT_IMPORT) == AT_IMPORT} == set()
    left = {name: {b for a, b in arrows if a == name} for name in FILES}
    for a, b in {**CIRCLES, **UPWARD}:
        left[a].discard(b)
    assert len(_without_circles(left)) == len(FILES)
    back = {(a, b) for a, b in CIRCLES if a in _reach(b, arrows, UPWARD)}
    assert back == set(CIRCLES), "these close no circle any more: nothing is left to explain"


def _without_circles(left):
    """Modules in an order in which each comes after its imports."""
    left, done = {name: set(targets) for name, targets in left.items()}, []
    while ready := [name for name, targets in left.items() if targets <= set(done)]:
        done += ready
        for name in ready:
            del left[name]
    assert left == {}, "circles, or what leads into them"
    return done


def _reach(start, arrows, but):
    found, pending = {start}, [start]
    while pending:
        name = pending.pop()
        new = {b for a, b in arrows if a == name and (a, b) not in but} - found
        found |= new
        pending += new
    return found


@pytest.mark.parametrize("part", FORBIDDEN)
def test_no_part_reaches_where_it_must_not(part):
    assert reached(part, FORBIDDEN[part], (AT_IMPORT, IN_FUNCTION)) == []


@pytest.mark.parametrize("part", UNSEEN)
def test_no_part_imports_what_it_need_not_see(part):
    wrong = [
        f"{name} imports {target}"
        for name in modules(part)
        for target in arrows_of_imports()[name]
        if any(target == f or target.startswith(f + ".") for f in UNSEEN[part]) and not target.startswith(SEEN)
    ]
    assert wrong == []


@pytest.mark.parametrize("part", LATE)
def test_what_is_slow_or_optional_is_imported_where_it_is_used(part):
    assert reached(part, LATE[part], (AT_IMPORT,)) == []


def test_the_reader_of_imports_sees_them():
    tree = ast.parse(
        "import a.b\nfrom c import d\nif TYPE_CHECKING:\n    import e\n"
        "class F:\n    def g(self):\n        import h\ntry:\n    import i\nexcept ImportError:\n    pass\n"
        "from j import (\n    k,\n)\n"
    )
    found = {when: [name for name, w in imports(tree) if w == when] for when in (AT_IMPORT, IN_FUNCTION, FOR_TYPES)}
    assert found == {AT_IMPORT: ["a.b", "c.d", "i", "j.k"], IN_FUNCTION: ["h"], FOR_TYPES: ["e"]}


def test_the_closure_sees_far():
    """From the command line, through functions, to the kernels' marks; at import, not even to numpy."""
    ways = closure(["mbdsl.cli.simulate"], (AT_IMPORT, IN_FUNCTION))
    assert {"mbdsl.kernels.marks", "mbdsl.studies.ladder", "numpy"} <= set(ways)
    assert len(ways["mbdsl.kernels.marks"]) > 2
    assert "numpy" not in closure(["mbdsl.cli.simulate"], (AT_IMPORT,))


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["--version"],
        ["simulate", "--help"],
        ["help", "units"],
        ["help", "Revolute"],
        ["check", "chain.mbd"],  # a tree: nothing has to be assembled
        ["check", "slider_crank.mbd", "--quick"],
        ["signals", "slider_crank.mbd"],
    ],
)
def test_quick_commands_load_no_numerics(arguments):
    assert loaded(arguments, NUMERICS) == "0"


def test_an_assembly_needs_no_compiler():
    assert loaded(["check", "slider_crank.mbd"], ("llvmlite", "scipy", "numpy")) == "0 numpy"


def test_a_run_loads_only_its_method(tmp_path):
    """Without options of methods; unknown words are looked for among the options of all of them."""
    run = ["simulate", "pendulum.mbd", "--method", "newmark", "--stop", "0.01", "--quiet"]
    run += ["--output", str(tmp_path / "out.csv")]
    others = tuple(f"mbdsl.integrators.methods.{name}" for name in ("radau5", "nstiff", "dop853"))
    all_others = " ".join(["", *sorted(others)])
    for more, expected in ([], ""), (["--gamma=0.7"], all_others):
        assert loaded([*run, *more], others, says="", MBDSL_NO_COMPILE="1") == f"0{expected}"


def loaded(arguments, modules, says=None, **environment):
    """The exit code of a command, and those of the modules that it loads."""
    models = Path(__file__).parents[3] / "models"
    arguments = [str(models / a) if a.endswith(".mbd") else a for a in arguments]
    code = (
        "import sys, mbdsl.cli\ncode = mbdsl.cli.main(sys.argv[1:])\n"
        f"print(code, *sorted(set(sys.modules) & set({modules!r})), file=sys.stderr)"
    )
    environment = {**{k: value for k, value in os.environ.items() if k != "MBDSL_NO_COMPILE"}, **environment}
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True, env=environment
    )
    assert done.stdout if says is None else done.stdout == says
    return done.stderr.rstrip("\n")
