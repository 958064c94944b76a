"""Digests of the results of every shipped model with every compiled method, for changes that must not change results.

``tests/data/digests.json`` has a line for each model and method: the numbers of steps, iterations and evaluations, the
hashes of q, v and lam at 50 outputs, their largest absolute values, and the beginning of the error that ended the run.
The runs are those of ``tests/data/runs.json``. After a change that is meant to change results::

    python tests/verification/test_digests.py [MODEL ...]

records the digests anew, of all models or of some, and prints which have changed.

Results are the same to the last bit on machines of the same platform: processor, C library, compiler and libraries; in
every process, whatever the order of sets and the number of threads. On other platforms sums are rounded differently:
other kernels of the same BLAS change the bits of most lines. Then only counts and largest values are compared:

- with fixed steps the number of steps is the same, and the largest values agree except for the last of their six
  digits. Newton's iteration stops near the level of rounding, in some steps an iteration earlier or later: with other
  kernels of BLAS the numbers of iterations differ by up to 6 %.
- with a tolerance, two runs may have different steps; their positions and velocities are both exact to the tolerance.
- runs that end with an error are not compared: rounding decides in which step, and has grown until then.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import re
import sys
from pathlib import Path

import numpy as np
from llvmlite import binding

import mbdsl
from mbdsl.integrators import compiled
from mbdsl.simulation.plan import DEFAULT_ERROR, DEFAULT_METHOD
from mbdsl.simulation.provenance import versions

TESTS = Path(__file__).parents[1]
MODELS = TESTS.parent / "models"
RUNS_FILE = TESTS / "data" / "runs.json"
RUNS = json.loads(RUNS_FILE.read_text(encoding="utf-8"))
FILE = TESTS / "data" / "digests.json"
OUTPUTS = 50
CONTROLLED = f"{DEFAULT_METHOD} --tol {DEFAULT_ERROR:g}"
WAYS = (*compiled(), CONTROLLED)
LEFT_OUT = {
    f"hard/sign_friction, {CONTROLLED}": "it ends with an error at a step that depends on the duration of steps: the "
    "run is advanced in slices of a tenth of a second",
    f"hard/pole, {CONTROLLED}": "it stands still, which is found at a step that depends on the duration of steps",
    f"gallery/trebuchet, {CONTROLLED}": "868 or 2424 steps: the run is not the same with other slices",
    "third-party integrators": "their results are not those of this code",
}


#: models that pass a pose from which two motions go on: rounding decides which one, and whether a method fails there
SINGULAR = ("hard/flat_four_bar", "hard/folding_crank", "hard/parallelogram")
DIGITS, ITERATIONS = 1e-5, 0.1  #: relative differences of largest values and of counts between platforms


def platform_of_results() -> dict[str, str]:
    """The properties of this machine that the last bits of results depend on."""
    known, blas = versions(), np.show_config(mode="dicts")["Build Dependencies"]["blas"]
    processor = os.environ.get("MBDSL_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("MBDSL_CPU_FEATURES") or binding.get_host_cpu_features().flatten()
    return {
        "system": f"{platform.system()} {platform.machine()}, {' '.join(platform.libc_ver())}",
        "processor": f"{processor}, features {short_hash(features.encode())}",
        "llvm": ".".join(map(str, binding.llvm_version_info)),
        "python": ".".join(known["python"].split(".")[:2]),
        "numpy": known["numpy"],
        "scipy": known["scipy"],
        "blas": f"{blas['name']} {blas['version']} {os.environ.get('OPENBLAS_CORETYPE', '')}".strip(),
    }


def short_hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:8]


def digest(model: str, way: str) -> str:
    """The line of a run: "steps iterations evaluations, hashes of q v lam, largest q v lam, error"; the error alone if
    there are no results."""
    stop, step, parameters = RUNS[model]
    scene = mbdsl.load(MODELS / f"{model}.mbd", parameters, allow_imports=MODELS)
    given = {"tol": DEFAULT_ERROR} if way == CONTROLLED else {"step": step}
    try:
        found, error = mbdsl.simulate(scene, method=way.split()[0], stop=stop, interval=stop / OUTPUTS, **given), ""
    except mbdsl.MbdslError as problem:
        found, error = getattr(problem, "trajectory", None), beginning(problem.message)
    if found is None:
        return error
    counts = [str(found.stats[key]) for key in ("steps", "iterations", "evaluations")]
    states = [np.ascontiguousarray(x) for x in (found.q, found.v, found.lam)]
    norms = [f"{np.abs(x).max(initial=0.0):.6g}" for x in states]
    words = [" ".join(counts), " ".join(short_hash(x.tobytes()) for x in states), " ".join(norms), error]
    return ", ".join(word for word in words if word)


def beginning(message: str) -> str:
    """A message without the numbers and names that depend on the step that failed."""
    return re.split(r"[;:`(]| in the step | at t = |, but ", message)[0].strip().replace(", ", " ")


def parts(line: str) -> tuple[list[int], list[float], str]:
    """Counts, largest values and error of a line."""
    words = line.split(", ")
    if len(words) < 3:
        return [], [], line
    return [int(x) for x in words[0].split()], [float(x) for x in words[2].split()], "".join(words[3:])


def relative_changes(before: list[float], now: list[float]) -> list[float]:
    """Of each largest value; 0 if both are the same or not numbers, 1 if one of them is 0."""
    found = [abs(y - x) / max(abs(x), abs(y)) if x != y else 0.0 for x, y in zip(before, now, strict=True)]
    return [0.0 if math.isnan(x) and math.isnan(y) else d for d, x, y in zip(found, before, now, strict=True)]


def change(before: str, now: str) -> str:
    """The difference between two lines in words."""
    (counts, norms, error), (new_counts, new_norms, new_error) = parts(before), parts(now)
    if not counts or not new_counts:
        return f"was `{before}`, is `{now}`"
    relative = ", ".join(f"{x:.0e}" for x in relative_changes(norms, new_norms))
    found = [f"steps {counts[0]} -> {new_counts[0]}", f"largest q, v, lam changed by {relative} (relative)"]
    if counts[1:] != new_counts[1:]:
        found.append(f"iterations and evaluations {counts[1:]} -> {new_counts[1:]}")
    if error != new_error:
        found.append(f"error `{error}` -> `{new_error}`")
    return "; ".join(found)


def agrees(name: str, way: str, before: str, now: str) -> bool:
    """Whether a line agrees with that of another platform."""
    (counts, norms, error), (new_counts, new_norms, new_error) = parts(before), parts(now)
    if name in SINGULAR or (counts and error):
        return True
    if error != new_error or len(counts) != len(new_counts):
        return False
    relative = relative_changes(norms, new_norms)
    if way == CONTROLLED:
        return max(relative[:2], default=0.0) <= 2.0 * DEFAULT_ERROR  # it is not the tolerance of reactions
    close = [abs(y - x) <= ITERATIONS * x for x, y in zip(counts[1:], new_counts[1:], strict=True)]
    return counts[:1] == new_counts[:1] and all(close) and max(relative, default=0.0) <= DIGITS


def test_every_model_and_method_has_a_digest():
    known = json.loads(FILE.read_text(encoding="utf-8"))
    assert set(RUNS) == {path.relative_to(MODELS).with_suffix("").as_posix() for path in MODELS.rglob("*.mbd")}
    assert known["left out"] == LEFT_OUT
    for name in RUNS:
        assert known["digests"][name].keys() == {way for way in WAYS if f"{name}, {way}" not in LEFT_OUT}, name


def test_results_are_as_recorded():
    known, here = json.loads(FILE.read_text(encoding="utf-8")), platform_of_results()
    other = {key: (x, here[key]) for key, x in known["platform"].items() if x != here[key]}
    where = f"on another platform, by counts and largest values only: {other}" if other else "by all bits"
    print(f"compared {where}")
    changed = []
    for name, lines in known["digests"].items():
        for way, before in lines.items():
            now = digest(name, way)
            if not (agrees(name, way, before, now) if other else now == before):
                changed.append(f"{name}, {way}: {change(before, now)}")
    assert not changed, "\n".join([f"{len(changed)} results have changed (compared {where}):", *changed])


LINE = "500 843 0, 5d1f03a2 88a1b2c3 99001122, 1.23457 2.34568 9.81"


def test_a_change_is_described():
    now = "501 850 0, 5d1f03a2 88a1b2c3 00000000, 1.23457 2.34568 9.91, the model is stiff"
    assert change(LINE, now) == (
        "steps 500 -> 501; largest q, v, lam changed by 0e+00, 0e+00, 1e-02 (relative); iterations and evaluations "
        "[843, 0] -> [850, 0]; error `` -> `the model is stiff`"
    )
    assert change(LINE, "no mass") == f"was `{LINE}`, is `no mass`"


def test_another_platform_may_change_the_last_digit_and_no_more():
    def agree(now, before=LINE, way="hht-si2", name="pendulum"):
        return agrees(name, way, before, now)

    other = LINE.replace("99001122", "0badcafe")
    assert agree(other) and agree(other.replace("9.81", "9.81001")) and agree(other.replace("843", "850"))
    assert not agree(other.replace("9.81", "9.8111")) and not agree(other.replace("500", "501"))
    assert not agree(other.replace("843", "943")) and not agree(f"{other}, the model is stiff") and not agree("no mass")
    assert agree("no mass", "no mass") and agree("1 2 0, a b c, 1 2 3", f"{LINE}, the model is stiff")
    assert agree(other.replace("500", "501").replace("2.34568", "2.3458"), way=CONTROLLED)
    assert not agree(other.replace("2.34568", "2.3468"), way=CONTROLLED)


def record(names: list[str]) -> None:
    """Write the digests of some models anew, of all if there are no names, and print which have changed."""
    known = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {"platform": {}, "digests": {}}
    before, here = known["digests"], platform_of_results()
    if unknown := set(names) - set(RUNS):
        sys.exit(f"not in {RUNS_FILE.name}: {', '.join(sorted(unknown))}")
    if names and known["platform"] != here:
        sys.exit("the digests were recorded on another platform: record those of all models")
    found = {}
    for name in RUNS:
        if names and name not in names:
            found[name] = before.get(name, {})
            continue
        found[name] = {way: digest(name, way) for way in WAYS if f"{name}, {way}" not in LEFT_OUT}
        for way, line in found[name].items():
            old = before.get(name, {}).get(way, "nothing")
            if line != old:
                print(f"{name}, {way}: {change(old, line)}", flush=True)
    models = []
    for name, lines in found.items():
        rows = ",\n".join(f"   {json.dumps(way)}: {json.dumps(line)}" for way, line in lines.items())
        models.append(f"  {json.dumps(name)}: {{\n{rows}\n  }}")
    top = json.dumps({"platform": here, "left out": LEFT_OUT}, indent=1).removesuffix("\n}")
    FILE.write_text(f'{top},\n "digests": {{\n' + ",\n".join(models) + "\n }\n}\n", encoding="utf-8")


if __name__ == "__main__":
    record(sys.argv[1:])
