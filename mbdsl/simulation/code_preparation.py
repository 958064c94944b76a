"""Compilation of machine code before it is needed: for images, for continuous integration, and after an update.

A :class:`EmittedModule` is the step loop of a method, or the equations of a structure. ``prepare`` compiles those that
are not in the cache folder, each in its own process and several at a time.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from mbdsl.compilation import code_cache
from mbdsl.integrators import compiled as chosen_methods
from mbdsl.integrators import declared, modules
from mbdsl.integrators.loop import compiled_loop
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import reduce
from mbdsl.mechanism.scene import Scene
from mbdsl.system import System, build, paths

PAUSE = 0.05  #: seconds between two checks of the other processes


@dataclass(frozen=True)
class EmittedModule:
    """One emitted module: its description, its name in the cache, and how it is made here and in another process."""

    what: str
    name: str
    here: Callable[[], object]
    beside: Callable[[], subprocess.Popen | None]

    @property
    def is_ready(self) -> bool:
        return code_cache.is_compiled(self.name)


@dataclass(frozen=True)
class PreparationProgress:
    """Number of modules that are ready, of all, the modules that are being compiled, and seconds since the start."""

    done: int
    total: int
    what: str
    seconds: float


def loop_code(method: str) -> EmittedModule:
    """The step loop of a method."""
    module = modules()[method]
    return EmittedModule(
        f"step loop of {method if module.METHOD.chosen else 'models without degrees of freedom'}",
        compiled_loop.loop_name(method),
        lambda: compiled_loop.compiled(method, module),
        lambda: code_cache.beside(__name__, method),
    )


def main(method: str) -> None:
    """Compile the step loop of a method, in another process."""
    compiled_loop.compiled(method, modules()[method])


def structure_code(system: System, sets: int, whose: str) -> EmittedModule:
    """The equations of a structure, for methods with ``sets`` sets of multipliers."""
    kind = {1: "index 3", 2: "index 2", 3: "additive index 2"}.get(sets, f"{sets} sets of multipliers")
    return EmittedModule(
        f"equations of {whose}, {kind}",
        system.module_name(sets),
        lambda: system.kernels(sets),
        lambda: system.compile_beside(sets),
    )


def codes(scenes: Iterable[tuple[str, Scene]], methods: Sequence[str] = ()) -> list[EmittedModule]:
    """The code of methods (default: all), and of models.

    Parameters
    ----------
    scenes : iterable of (str, Scene)
        Name and content of each model.
    methods : sequence of str
        Names of methods; third-party integrators need only the code of the equations.

    Returns
    -------
    list of Code
        Each module once.
    """
    chosen = list(methods) or [*chosen_methods()]
    names = [*chosen, *(name for name in modules() if not modules()[name].METHOD.chosen)]
    found = [loop_code(name) for name in names if name in modules()]
    numbers = sorted({declared(name).sets for name in names}, reverse=True)
    scenes = list(scenes)
    for whose, system in _systems(scenes):
        found += [structure_code(system, sets, whose) for sets in numbers]
    found += [structure_code(system, 1, whose) for whose, system in _assembled(scenes)]
    found.append(EmittedModule("bounds of laws", paths.NAME, paths.kernels, lambda: None))
    return list({code.name: code for code in found}.values())


def _systems(scenes: Iterable[tuple[str, Scene]]) -> Iterator[tuple[str, System]]:
    """The systems whose code is compiled: of each model as written, and of its parts."""
    for whose, scene in scenes:
        mechanism = graph.build(scene)
        whole = build(scene, mechanism)
        yield whose, whole
        size = whole.tables.size
        for part in () if (reduction := reduce(mechanism)).nothing_done else reduction.parts:
            for each in (part.graph, part.dynamic):
                if each is not None:
                    yield whose, build(each.scene, each, size=size)


def _assembled(scenes: Iterable[tuple[str, Scene]]) -> Iterator[tuple[str, System]]:
    """The systems in space that are only assembled, as their motion is solved in a plane."""
    for whose, scene in scenes:
        for flat in reduce(graph.build(scene)).flattened if scene.spatial else ():
            yield whose, build(flat.motion.graph.scene, flat.motion.graph)


def prepare(
    given: Sequence[EmittedModule],
    jobs: int,
    tell: Callable[[PreparationProgress], None],
    done: Callable[[EmittedModule, float], None],
) -> None:
    """Compile the code that is not ready.

    Parameters
    ----------
    given : sequence of Code
    jobs : int
        Largest number of processes at the same time.
    tell : callable
        Called with the progress.
    done : callable
        Called with a Code and the seconds that its compilation took.

    Raises
    ------
    MbdslError
        If a method of a file cannot be compiled.
    """
    began = time.perf_counter()
    waiting = [code for code in given if not code.is_ready]
    running: list[tuple[EmittedModule, subprocess.Popen, float]] = []
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                code = waiting.pop(0)
                process, now = code.beside(), time.perf_counter()
                if process is not None:
                    running.append((code, process, now))
                else:
                    _here(code)
                    done(code, time.perf_counter() - now)
            what = ", ".join(code.what for code, _, _ in running)
            ready = len(given) - len(waiting) - len(running)
            tell(PreparationProgress(ready, len(given), what, time.perf_counter() - began))
            time.sleep(PAUSE)
            for entry in [entry for entry in running if entry[1].poll() is not None]:
                running.remove(entry)
                _here(entry[0])
                done(entry[0], time.perf_counter() - entry[2])
    finally:
        for _, process, _ in running:
            process.terminate()
            process.wait()


def _here(code: EmittedModule) -> None:
    """Compile in this process if another process could not, so that the error is reported."""
    if not code.is_ready:
        code.here()
