"""The benchmarks run and print what they should; no time is asserted."""

import importlib.util
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from mbdsl.integrators import compiled as methods
from mbdsl.plotting.pages import html


def script(name):
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_against_exudyn():
    if importlib.util.find_spec("exudyn") is None:  # not imported here: the script chooses the build
        pytest.skip("Exudyn is not installed: pip install 'mbdsl[bench]'")
    benchmark = script("against_exudyn")
    assert set(benchmark.METHODS) <= set(methods())
    assert all(case.path.exists() and case.steps % benchmark.TIMES == 0 for case in benchmark.CASES)
    small = tuple(case for case in benchmark.CASES if case.n is None or case.n < 10)
    text = benchmark.table(steps=40, repeats=1, cases=small)
    for case in small:
        assert f"\n{case.name}, " in text
    assert text.count("mbdsl hht-si2") == sum(case.halvings + 1 for case in small)
    assert len(re.findall(r" (met|MISSED)$", text, re.MULTILINE)) == len(small)
    assert "VOID" not in text  # the models are the same


def test_ratios_against_exudyn():
    """At equal step as they are; at equal error along straight lines between logarithms; the worst error counts."""
    benchmark = script("against_exudyn")
    case = benchmark.Case("pendulum", 1.0, 4, 0.5)
    found = benchmark.Comparison(case, [4, 8], 1.0)
    found.curves = {
        "hht-i3": benchmark.Curve([[1.0, 2.0]], [4e-4, 1e-4]),
        "hht-si2": benchmark.Curve([[4.0, 8.0]], [4e-4, 1e-4]),
        "dense": benchmark.Curve([[10.0, 20.0]], [1e-4, 2.5e-5]),
        "sparse": benchmark.Curve([[30.0, 10.0]], [1e-4, 2.5e-5]),
    }
    assert found.at_step("hht-i3", 0) == (0.1, 0.1)
    assert found.at_step("hht-i3", 1) == (0.2, 0.2)  # Exudyn by its fastest option there
    assert len(found.errors()) == 0  # their ranges of errors overlap only at 1e-4
    found.curves["dense"].errors = found.curves["sparse"].errors = [4e-4, 1e-4]
    assert found.errors() == pytest.approx([4e-4, 2e-4, 1e-4])
    assert found.at_error("hht-i3", 2e-4) == pytest.approx((0.1, 0.1))
    assert found.headline() == pytest.approx((0.2, 0.2))
    assert benchmark.verdict(found).endswith("0.50 met")
    found.void = "another model"
    assert "VOID" in benchmark.verdict(found)


def test_growth():
    benchmark = script("growth")
    text = benchmark.table(repeats=1, sizes={"chain": (2, 8), "four_bar": (1, 4)}, fresh=(2, 4, 8))
    assert text.count("memory: ") == len(benchmark.METHODS)
    assert text.count("grows with the power") == 2 * len(benchmark.METHODS) + 4  # and the steps of two models
    assert text.count("adding arrays: ") == 4
    assert "VOID" not in text
    rows = [line.split() for line in text.splitlines() if re.match(r"chain +\d+ \S+ +\d+ ", line)]
    assert len(rows) == 3 * len(benchmark.METHODS)
    for row in rows:
        *stages, total = (float(x) for x in row[6 : 7 + len(benchmark.STAGES)])
        assert sum(stages) == pytest.approx(total, abs=0.005 * (len(stages) + 1))  # they are rounded to 0.01 s


def test_growth_beyond_the_smallest_chain():
    """Of memory that is proportional to the number of links, and a constant."""
    power, each = script("growth").beyond({64: 50.0 + 6.4, 128: 50.0 + 12.8, 1024: 50.0 + 102.4})
    assert power == pytest.approx(1.0) and each == pytest.approx([0.1, 0.1])


def test_exponent_of_growth():
    benchmark = script("growth")
    assert benchmark.exponent([10, 20, 40], [3.0, 12.0, 48.0]) == pytest.approx(2.0)
    assert benchmark.met(1.1, 1.1) == "1.1 met"
    assert benchmark.met(1.2, 1.1) == "1.1 MISSED"


def test_sparse_solvers():
    """All of them solve the equations."""
    text = script("sparse_solvers").table(1, (("slider_crank", 0), ("four_bar", 2)))
    lines = text.splitlines()[1:]
    assert len(lines) == 8
    assert all(float(line.split()[-1]) < 1e-12 for line in lines)


def test_startup(monkeypatch):
    benchmark = script("startup")
    monkeypatch.setattr(benchmark, "QUIET", 0.1)
    text = benchmark.table(1, 2, [benchmark.Wait("--help", ["--help"], True)])
    assert len(text.splitlines()) == 2
    with pytest.raises(RuntimeError, match="returned 2"):
        benchmark.measure(1, 1, [benchmark.Wait("no model", ["check", "no_model.mbd"])])


def test_method_costs():
    benchmark = script("method_costs")
    text = benchmark.table(repeats=1, steps=20)
    assert set(benchmark.METHODS) == set(methods()) - {"dop853"}  # models are stiff
    cases = len(benchmark.CASES) + len(benchmark.LARGER)
    for name in benchmark.METHODS:
        assert text.count(f"  {name} ") == cases + len(benchmark.CASES)  # its rows, and a bar for each case
    assert "VOID" not in text
    assert text.count("about 1.3\n") == 6  # two methods, three models


def test_ratios_of_method_costs():
    """Of the least times of the slices, and the median over rounds; a target is met by the former."""
    benchmark = script("method_costs")
    costs = {name: benchmark.Cost([[1.0, 1.0], [0.5, 3.5], [2.0, 8.0]]) for name in benchmark.METHODS}
    costs["hht-si2"] = benchmark.Cost([[0.5, 1.5], [0.4, 3.6], [3.0, 0.8]])
    assert benchmark.ratios(costs, "hht-si2") == pytest.approx((1.2 / 1.5, 1.0))
    case = benchmark.CASES[0]
    line = next(line for line in benchmark.rows(case, costs) if "hht-si2" in line and "nstiff" not in line)
    assert line.endswith("1.00 met")
    costs["hht-si2"] = benchmark.Cost([[1.0, 1.2], [0.6, 1.0], [2.0, 8.0]])
    assert "1.00 MISSED" in "".join(benchmark.rows(case, costs))


def test_general_path():
    benchmark = script("general_path")
    text = benchmark.table(repeats=1, steps=20)
    scenes = benchmark.cases()
    assert set(scenes) == {*(path.stem for path in benchmark.MODELS.glob("*.mbd")), "welded"}
    for path in benchmark.PATHS:
        assert text.count(f"  {path} ") == len(scenes)
    assert "VOID" not in text
    sizes = {path: cost.sizes for path, cost in benchmark.measure(scenes["welded"], 1, steps=20).items()}
    assert sizes["specialised"] == {"n": 6, "m": 4, "p": 0, "parts": 2}
    assert sizes["general"] == {"n": 24, "m": 22, "p": 0, "parts": 1}


def test_ratios_of_the_general_path():
    """Of the minima, and the median over rounds."""
    benchmark = script("general_path")
    costs = {"specialised": benchmark.Cost([1.0, 2.0, 4.0]), "general": benchmark.Cost([3.0, 2.2, 4.4])}
    assert benchmark.ratios(costs) == (2.2, 1.1)
    for cost in costs.values():
        cost.sizes = {"n": 1, "m": 0, "p": 0, "parts": 1}
    costs["general"].status = -1
    one, other = benchmark.rows("x", costs)[1:]
    assert one.count("VOID") == 0 and other.endswith("   VOID: stopped early")


def test_tolerances():
    benchmark = script("tolerances")
    assert set(benchmark.STEPS) == set(benchmark.names())
    text = benchmark.table(["rolling_disc"], ["hht-si2"], [1e-4, 1e-5])
    found = re.search(r"^rolling_disc +hht-si2 +\S+ +(\S+) +(\S+) ", text, re.MULTILINE)
    assert all(0.1 < float(x) < 2.0 for x in found.groups())


def test_flexible_bodies():
    benchmark = script("flexible_bodies")
    text = benchmark.table(steps=10, repeats=1, sizes=(2, 8))
    found = re.findall(r"^(modes|elements|ancf) +(\S+) +(\d+) ", text, re.MULTILINE)
    coordinates = {"modes": (2, 8), "elements": (8,), "ancf": (5, 9)}
    assert found == [(name, m, str(k)) for name in coordinates for m in benchmark.METHODS for k in coordinates[name]]


def test_discontinuities():
    located, without = list(script("discontinuities").lines([1e-3], ("hht-si2",), ("friction",)))[1:]
    assert int(located.split()[7]) == 4 and int(without.split()[7]) == 0


def test_event_costs():
    lines = list(script("event_costs").lines(10))
    assert [line.split()[-4] for line in lines[1:]] == ["10", "10", "100", "10", "100"]


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_work_precision(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("work_precision")
    monkeypatch.setattr(benchmark, "LEVELS", 3)
    study, theirs = benchmark.compare("slider_crank", 1, 20.0, stop=0.1, methods=["hht-i3"], steps=[1e-3, 5e-4, 2.5e-4])
    text = benchmark.as_text(benchmark.table(study, theirs))
    assert "hht-i3" in text and ("> " in text) == bool(theirs)
    errors, seconds = [r.error for r in theirs], [r.seconds[0] for r in theirs]
    assert errors == sorted(errors, reverse=True) and seconds == sorted(seconds)  # no run that another one beats
    assert "hht-i3" in html(benchmark.page(study, theirs))


def test_what_accuracy_costs_is_what_was_measured(monkeypatch):
    """The tables of the page are those of the stored runs; interpolation is linear in the logarithms."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("work_precision")
    page = benchmark.PAGE.read_text(encoding="utf-8")
    for name in benchmark.CASES:
        kept = json.loads((benchmark.PAGE.with_suffix("") / f"{name}.json").read_text(encoding="utf-8"))
        assert len(kept["table"]) == len(benchmark.DECADES)
        assert all(f"| {' | '.join(row)} |" in page for row in kept["table"])
    assert benchmark.at(1e-3, [1e-2, 1e-4], [1.0, 4.0]) == pytest.approx(2.0)
    assert benchmark.at(1e-1, [1e-2, 1e-4], [1.0, 4.0]) == 1.0
    assert benchmark.at(1e-5, [1e-2, 1e-4], [1.0, 4.0]) != benchmark.at(1e-5, [1e-2, 1e-4], [1.0, 4.0])  # unknown


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_against_mujoco(monkeypatch):
    """All programs come to the same reference."""
    if importlib.util.find_spec("mujoco") is None:
        pytest.skip("MuJoCo is not installed: pip install 'mbdsl[bench]'")
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("against_mujoco")
    decades = (3, 4)
    chain = benchmark.compare(2, 1, ["radau5"], decades)
    text = benchmark.report(chain, decades)
    assert text.count("\n 1e-") == 2 * len(decades) and "time over MuJoCo's" in text  # of two tables
    for program in ("mbdsl", "MuJoCo"):
        assert min(run.error for run in chain.of(program)) < 1e-4
    if importlib.util.find_spec("exudyn") is not None:
        for program in ("Exudyn explicit", "Exudyn implicit"):
            assert min(run.error for run in chain.of(program)) < 1e-4


def test_reference_of_chains(monkeypatch):
    """A chain of one link is a pendulum, whose energy is known."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    programs = script("chain_programs")
    reference = programs.Reference(1)
    phi, w = reference._solution.sol(reference.times)
    # m L^2/3 w^2/2 = -m g L/2 sin(phi), to the tolerance of 1e-13 with some digits lost over the run
    assert w**2 / 3.0 == pytest.approx(-programs.GRAVITY * programs.np.sin(phi) / programs.LENGTH, rel=1e-11)
    assert reference.error(reference.angles) == 0.0
    assert reference.error(reference.angles[:2]) == float("inf")


def test_page_has_what_was_measured_on_chains(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("against_mujoco")
    page = benchmark.PAGE.read_text(encoding="utf-8")
    for links in benchmark.LINKS:
        kept = json.loads((benchmark.PAGE.with_suffix("") / f"chain_{links}.json").read_text(encoding="utf-8"))
        assert len(kept["table"]) == len(benchmark.DECADES)
        assert all(f"| {' | '.join(row)} |" in page for row in kept["table"])


def test_everything(monkeypatch):
    """Every part of a page is measured by the command; conclusions follow from the stored numbers."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("everything")
    source = Path(benchmark.__file__).read_text(encoding="utf-8")
    parts = script("doc_parts")
    tables = [*benchmark.work_precision.CASES, *(f"chain_{n}" for n in benchmark.against_mujoco.LINKS)]
    for name, page in benchmark.PAGES.items():
        for part in parts.parts_of(page):
            assert f'"{name}: {part}"' in source or (name == "work-precision" and part in tables), part
    known = {
        name: json.loads((benchmark.FOLDER / f"{name}.json").read_text(encoding="utf-8"))["points"]
        for name in benchmark.work_precision.CASES
    }
    assert benchmark.conclusions(known) in benchmark.PAGES["work-precision"].read_text(encoding="utf-8")
    monkeypatch.setattr(benchmark, "CONSTRAINED", ("slider_crank",))
    found = benchmark.constraints(1)
    assert 1e-17 < float(found["README: positions"]) < 1e-12 and 1e-17 < float(found["README: velocities"]) < 1e-9


def test_parts_of_pages(monkeypatch, tmp_path):
    parts, page = script("doc_parts"), tmp_path / "page.md"
    page.write_text("It takes <!-- a -->1 s<!-- end -->, and\n<!-- b -->\n\nold\n\n<!-- end -->\n", encoding="utf-8")
    assert parts.parts_of(page) == ["a", "b"]
    parts.put(page, {"a": "2 s", "b": "new"})
    expected = "It takes <!-- a -->2 s<!-- end -->, and\n<!-- b -->\n\nnew\n\n<!-- end -->\n"
    assert page.read_text(encoding="utf-8") == expected
    with pytest.raises(ValueError, match="0 parts `<!-- c -->`"):
        parts.put(page, {"c": "3"})
    assert parts.spread([0.0712, 0.168]) == "0.07 to 0.2" and parts.spread([2340.0], 2) == "2,300"


def test_long_results(tmp_path, capsys):
    script("long_results").run(2000, tmp_path, "info")
    assert re.search(r"^info npz +[\d.]+ +[\d.]+ +\d+ +\d+ MB$", capsys.readouterr().out, re.MULTILINE)


def test_control_loop():
    lines = script("control_loop").table(repeats=1, number=2).splitlines()
    assert len(lines) == 12 and all(float(x) > 0.0 for line in lines[1:] for x in line.split()[-2:])


def test_explicit_method():
    """At equal error along straight lines between logarithms of error and time; nan below the least error."""
    benchmark = script("explicit_method")
    runs = [(1e-4, 1.0), (1e-6, 4.0), (1e-8, 16.0)]
    assert benchmark.seconds_at(1e-5, runs) == pytest.approx(2.0)
    assert benchmark.seconds_at(1e-2, runs) == pytest.approx(1.0)
    assert benchmark.seconds_at(1e-9, runs) != benchmark.seconds_at(1e-9, runs)
    text = benchmark.table(["pendulum"], 1)
    assert re.findall(r"^pendulum +1e-\d\d +[\d.]+ ms +[\d.]+ ms", text, re.MULTILINE)


def test_space_against_exudyn(monkeypatch):
    """Our runs of all cases, with few steps."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("space_against_exudyn")
    for case in benchmark.CASES[:4]:
        place, seconds = benchmark.ours(case, 50)
        assert place.shape == (3,) and seconds > 0.0


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_programs_in_space_are_the_same(monkeypatch):
    """Exudyn and MuJoCo come to the same place, in steps that leave errors of 1e-3 of the size."""
    if importlib.util.find_spec("exudyn") is None or importlib.util.find_spec("mujoco") is None:
        pytest.skip("Exudyn or MuJoCo is not installed: pip install 'mbdsl[bench]'")
    import exudyn

    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("space_against_exudyn")
    names = ("Haug's slider crank", "chain of 8 ball joints")
    for case in (replace(case, steps=(100, 200)) for case in benchmark.CASES if case.name in names):
        found = benchmark.compare(exudyn, case, 1)
        assert found.equal_error() and found.equal_step() > 0.0, "\n".join(found.lines())
        assert not case.links or found.against_mujoco()


def test_times_at_equal_error_in_space(monkeypatch):
    """Times at equal error follow the lines between logarithms; the fastest run of a program counts."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    benchmark = script("space_against_exudyn")
    # a program of order 2 with 4 us a step, and one that is as accurate with 1 us a step
    one = {100: (1e-4, 1e-4), 200: (2.5e-5, 2e-4)}
    other = {100: (1e-4, 4e-4), 200: (2.5e-5, 8e-4)}
    assert benchmark.at_equal_error([one], [other]) == pytest.approx([0.25] * 9)
    slow = {n: (error, 3 * seconds) for n, (error, seconds) in one.items()}
    assert benchmark.at_equal_error([slow, one], [other]) == pytest.approx([0.25] * 9)
    # more accurate with its largest step than the other with its smallest one, which would need 10 times the steps
    best = {100: (2.5e-7, 1e-4)}
    assert benchmark.at_equal_error([best], [other]) == pytest.approx([1e-4 / 8e-3])
    assert benchmark.at_equal_error([best], []) == []


def test_decisions(monkeypatch):
    """Those measured in seconds: the parser's, and the plot's; the compilers take their time in tests of the cache."""
    benchmark = script("decisions")
    monkeypatch.setattr(benchmark, "COPIES", 1)
    for name, rows in (("parser", 8), ("svg", 3)):
        lines = list(getattr(benchmark, name)(1))
        assert len(lines) == rows
        assert all(float(re.search(r"([\d.]+) s\b", line)[1]) >= 0.0 for line in lines if line.startswith("  "))


def test_extremes():
    benchmark = script("extremes")
    text = benchmark.table(repeats=1, cases={"pendulum": {"stop": 0.1}})
    assert re.search(r"^pendulum +\d+ +4 +[\d.]+ +[-+][\d.]+ % +[-+][\d.]+ % +[-+][\d.]+ % +-?\d+$", text, re.MULTILINE)
