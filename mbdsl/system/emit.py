"""Code generation: a module that calls only the kernels of the kinds in a scene.

``evaluate`` has one, two or three ``sets`` of multipliers: lam in f; also Phi_q^T mu; also Phi_q^T psi, with the Phi_q
of the start of the step.

``emit`` writes the text; ``load`` compiles it or loads it from the cache. The key is the structure of the scene and the
digest of the package. It contains no number of the model, so that a changed parameter or expression compiles nothing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import NamedTuple

from mbdsl.compilation import code_cache
from mbdsl.elements import Declared
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.factors import Factors
from mbdsl.system import expression_tape, loops, row_kernels, tangent_loops
from mbdsl.system.structure import Block

KIND_PREFIX = "mbdsl_kind_"
#: evaluate(t, vectors, frames, gradients, numbers, layout)
EVALUATE = code_cache.Signature(("float", "matrix", "matrix", "matrix", "vector", "ints"))
#: factors of the terms of a matrix; see :mod:`mbdsl.integrators.loop.tangent_matrices`
FACTORS = Factors._fields
TANGENT_ARGUMENTS = f"t, {', '.join(FACTORS)}, vectors, frames, gradients, numbers, layout, matrix"
#: tangent(TANGENT_ARGUMENTS)
TANGENT = code_cache.Signature(
    ("float", *["float"] * len(FACTORS), "matrix", "matrix", "matrix", "vector", "ints", "vector")
)
#: inertia(task, row, target, vectors, numbers, layout): tasks of :mod:`mbdsl.kernels.buffer_layout`
INERTIA = code_cache.Signature(("int", "int", "int", "matrix", "vector", "ints"))
#: a repeated line of ``evaluate`` or ``tangent``: (count, arguments of tangent)
REPEATED = code_cache.Signature(("int", *TANGENT.takes))


class CodeLine(NamedTuple):
    """A statement of emitted code and its effect."""

    effect: str
    text: str


def evaluate_lines(blocks: list[Block], has_tape: bool, sets: int) -> list[CodeLine]:
    """The statements of ``evaluate``, in order."""
    bodies, pairs, roles = _loops(blocks)
    related = any(b.related for b in blocks)
    lines = [CodeLine("bodies", "loops.start(C, vectors, frames, numbers, layout)")]
    if sets > 2:
        lines += [
            CodeLine("bodies", f"{b.name}.keep({h}, numbers, layout)") for h, b in bodies if hasattr(b.module, "keep")
        ]
        if related:
            lines.append(CodeLine("joints", "relation_loops.keep(C, numbers, layout)"))
        lines.append(CodeLine("bodies", "loops.keep(C, vectors, frames, gradients, layout)"))
    lines += [CodeLine("bodies", f"{b.name}.move({h}, vectors, frames, numbers, layout)") for h, b in bodies]
    if has_tape:
        lines.append(
            CodeLine(
                "expressions", "expression_tape.run(t, 0, layout[L.TAPE_LENGTH], vectors, frames, numbers, layout)"
            )
        )
    if "moving" in roles:
        lines.append(CodeLine("moving frames", "loops.carry(C, frames, numbers, layout)"))
    if any(b.coupled for b in blocks):
        lines.append(CodeLine("joints", "loops.couple(numbers, layout)"))
    lines += [CodeLine(_effect(b), f"{b.name}.fill({h}, frames, gradients, numbers, layout)") for h, b in pairs]
    if "joint" in roles:
        constraints = "constraints_with_mu" if sets > 1 else "constraints"
        lines.append(CodeLine("joints", f"loops.{constraints}(C, vectors, frames, gradients, numbers, layout)"))
    if related:
        with_mu = int(sets > 1)
        lines.append(CodeLine("joints", f"relation_loops.values(C, {with_mu}, vectors, frames, numbers, layout)"))
    if any(b.driven for b in blocks):
        lines.append(CodeLine("drivers", "loops.drive(vectors, numbers, layout)"))
    if "gamma" in roles:
        lines.append(CodeLine("nonholonomic rows", "loops.gammas(C, vectors, frames, numbers, layout)"))
    if "spring" in roles:
        lines.append(CodeLine("springs", "loops.springs(C, frames, gradients, numbers, layout)"))
    if "law" in roles:
        lines.append(CodeLine("laws", "loops.laws(C, frames, gradients, numbers, layout)"))
    both = sets > 1 and "joint" in roles
    lines += [CodeLine("bodies", text) for h, b in bodies for text in _gathered(h, b, both)]
    if sets > 2 and "joint" in roles:
        lines.append(CodeLine("joints", "loops.remember(C, vectors, frames, gradients, layout)"))
        if related:
            lines.append(CodeLine("joints", "relation_loops.remember(C, vectors, frames, numbers, layout)"))
        lines += [CodeLine("bodies", _gather(h, b, "PAST_WRENCH", "PAST_LEVER", "PAST_FORCE")) for h, b in bodies]
    lines += [
        CodeLine("flexibility", f"{b.name}.forces({h}, vectors, numbers, layout)") for h, b in bodies if b.module.MASS
    ]
    for row, target in (("INERTIA_ROW", "MX"), ("INERTIA_ROW2", "MX2"))[: min(sets, 2)]:
        lines += [
            CodeLine("mass matrix", text) for text in _inertia(bodies, "L.TIMES", f"layout[L.{row}]", f"L.{target}")
        ]
    if sets > 2 and "joint" in roles:
        varies = [(h, b) for h, b in bodies if b.module.MASS > 1]
        lines += [CodeLine("mass matrix", f"{b.name}.carry_over({h}, vectors, numbers, layout)") for h, b in varies]
    return lines


def _gathered(header: int, block: Block, with_mu: bool) -> list[str]:
    """Statements that collect the forces on bodies, and the same of mu."""
    if with_mu and hasattr(block.module, "collect_with_mu"):
        return [f"{block.name}.collect_with_mu({header}, vectors, frames, {_F(block)}layout)"]
    found = [_gather(header, block, "WRENCH", "LEVER", "FORCE")]
    return [*found, _gather(header, block, "MU_WRENCH", "LEVER", "FORCE2")] if with_mu else found


def _gather(header: int, block: Block, wrench: str, lever: str, row: str) -> str:
    return f"{block.name}.gather({header}, C.{wrench}, C.{lever}, L.{row}, vectors, frames, {_F(block)}layout)"


def _F(block: Block) -> str:
    """The argument ``numbers``, which more kernels of flexible bodies take than of rigid ones."""
    return "numbers, " if block.module.MASS else ""


def _inertia(bodies: list[tuple[int, Block]], task: str, row: str, target: str) -> list[str]:
    """Statements of a task of the mass matrix; none if it is constant and diagonal."""
    if not any(b.module.MASS for _, b in bodies):
        return []
    own = [
        f"{b.name}.inertia({h}, {task}, {row}, {target}, vectors, numbers, layout)" for h, b in bodies if b.module.MASS
    ]
    return [f"loops.inertia({task}, {row}, {target}, vectors, numbers, layout)", *own]


def _tasks(lines: list[str], has_tape: bool) -> list[str]:
    """The body of ``inertia``: the tasks of the mass matrix, and that of when-equations."""
    if not has_tape:
        return [f"    {line}" for line in lines]
    return [
        "    if task == L.ACT:",
        "        o, t = layout[L.TICKS], numbers[layout[L.REGISTERS]]",
        "        expression_tape.run(t, layout[o], layout[o + 1], vectors, vectors, numbers, layout)",
        "    else:",
        *(f"        {line}" for line in lines),
    ]


def inertia_lines(blocks: list[Block]) -> list[str]:
    """The statements of ``inertia``."""
    return _inertia(_loops(blocks)[0], "task", "row", "target") or [
        "loops.inertia(task, row, target, vectors, numbers, layout)"
    ]


def tangent_lines(blocks: list[Block], has_tape: bool, sets: int) -> list[CodeLine]:
    """The statements of ``tangent``, in order."""
    bodies, pairs, roles = _loops(blocks)
    lines = [CodeLine("bodies", "tangent_loops.begin_matrix(cM, cE, numbers, layout, matrix)")]
    if any(b.module.MASS for _, b in bodies):
        lines.append(CodeLine("mass matrix", "tangent_loops.coupling_matrix(cM, numbers, layout, matrix)"))
    lines += [CodeLine("bodies", f"{b.name}.jacobians({h}, vectors, frames, numbers, layout)") for h, b in bodies]
    in_step = [(h, b) for h, b in bodies if hasattr(b.module, "step_jacobians")]
    lines += [
        CodeLine("bodies", f"{b.name}.step_jacobians({h}, cK, cD, vectors, frames, numbers, layout)")
        for h, b in in_step
    ]
    if has_tape:
        part = "layout[L.TAPE_LENGTH], layout[L.GRADIENT_LENGTH]"
        lines.append(CodeLine("expressions", f"expression_tape.run(t, {part}, vectors, frames, numbers, layout)"))
    if any(b.coupled for b in blocks):
        lines.append(CodeLine("joints", "loops.couple(numbers, layout)"))
    lines += [
        CodeLine(_effect(b), f"{b.name}.curve({h}, frames, gradients, numbers, layout)") for h, b in pairs if b.curved
    ]
    if "joint" in roles:
        arguments = "C, factors, vectors, gradients, numbers, layout, matrix"
        lines.append(CodeLine("joints", f"tangent_loops.constraint_tangents({arguments})"))
    if any(b.related for b in blocks):
        arguments = "C, factors, vectors, frames, numbers, layout, matrix"
        lines.append(CodeLine("joints", f"relation_loops.tangents({arguments})"))
    if "gamma" in roles:
        arguments = "C, factors, vectors, numbers, layout, matrix"
        lines.append(CodeLine("nonholonomic rows", f"tangent_loops.gamma_tangents({arguments})"))
    if "spring" in roles:
        lines.append(
            CodeLine("springs", "tangent_loops.spring_tangents(C, cK, cD, gradients, numbers, layout, matrix)")
        )
    if "law" in roles:
        lines.append(CodeLine("laws", "tangent_loops.law_tangents(C, factors, gradients, numbers, layout, matrix)"))
    curved = [(h, b) for h, b in bodies if hasattr(b.module, "stiffness")]
    lines += [CodeLine("bodies", f"{b.name}.stiffness({h}, cK, frames, {_F(b)}layout, matrix)") for h, b in curved]
    flexible = [(h, b) for h, b in bodies if b.module.MASS]
    lines += [
        CodeLine("flexibility", f"{b.name}.tangents({h}, factors, vectors, numbers, layout, matrix)")
        for h, b in flexible
    ]
    lines += [
        CodeLine("bodies", f"{b.name}.step_tangents({h}, factors, vectors, frames, numbers, layout, matrix)")
        for h, b in in_step
    ]
    if sets > 2 and in_step and "joint" in roles:
        related = any(b.related for b in blocks)
        lines += _columns("-cG", 0, related)
        lines += [CodeLine("bodies", f"{b.name}.past_jacobians({h}, cG, frames, numbers, layout)") for h, b in in_step]
        lines += _columns("cG", 1, related)
    return lines


def _columns(factor: str, past: int, related: bool) -> list[CodeLine]:
    """Statements that add ``factor`` Phi_q^T."""
    lines = [CodeLine("joints", f"tangent_loops.columns(C, {factor}, {past}, gradients, numbers, layout, matrix)")]
    return (
        lines + [CodeLine("joints", f"relation_loops.columns(C, {factor}, {past}, numbers, layout, matrix)")] * related
    )


def in_space(blocks: list[Block]) -> bool:
    """Whether a structure is that of a model in space."""
    return any(b.spatial or b.name.startswith("spatial_") for b in blocks)


def _loops(blocks: list[Block]) -> tuple[list[tuple[int, Block]], list[tuple[int, Block]], set[str]]:
    """Blocks of bodies, and of kernels for rows of the gradient table, with their headers; roles of all."""
    numbered = [(header(k), b) for k, b in enumerate(blocks)]
    bodies = [x for x in numbered if x[1].role == "body"]
    pairs = [x for x in numbered if x[1].role in ("joint", "spring", "law") and not x[1].related]
    return bodies, pairs, {b.role for b in blocks}


def _effect(block: Block) -> str:
    return {"joint": "joints", "spring": "springs", "law": "laws"}[block.role]


def emit(blocks: list[Block], has_tape: bool, sets: int) -> str:
    """The text of the module for these blocks and this number of sets of multipliers."""
    lines = [
        *_head(blocks, has_tape, "Emitted by mbdsl for scenes of"),
        "def evaluate(t, vectors, frames, gradients, numbers, layout):",
        *(f"    {line.text}" for line in evaluate_lines(blocks, has_tape, sets)),
        "",
        "",
        f"def tangent({TANGENT_ARGUMENTS}):",
        f"    factors = Factors({', '.join(FACTORS)})",
        *(f"    {line.text}" for line in tangent_lines(blocks, has_tape, sets)),
        "",
        "",
        "def inertia(task, row, target, vectors, numbers, layout):",
        *_tasks(inertia_lines(blocks), has_tape),
        "",
    ]
    return "\n".join(lines)


def _kind_module(block: Block) -> str:
    """The name of the emitted module of a kind."""
    return f"{KIND_PREFIX}{'in_space_' if block.spatial else ''}{block.name}"


def _head(blocks: list[Block], has_tape: bool, title: str) -> list[str]:
    bodies, pairs, _ = _loops(blocks)
    related = any(b.related for b in blocks)
    used = ["expression_tape"] * has_tape + ["loops", "tangent_loops"] + ["relation_loops"] * related
    return [
        f'"""{title}: {", ".join(dict.fromkeys(b.name for b in blocks))}."""',
        "",
        *dict.fromkeys(f"import {_kind_module(b)} as {b.name}" for _, b in pairs),
        "",
        *(f"from mbdsl.bodies import {b.name}" for _, b in bodies),
        "from mbdsl.kernels import buffer_layout as L",
        _columns_import(in_space(blocks)),
        "from mbdsl.kernels.factors import Factors",
        f"from mbdsl.system import {', '.join(used)}",
        "",
        "",
    ]


def _columns_import(spatial: bool) -> str:
    return f"from mbdsl.kernels.columns import {'SPACE' if spatial else 'PLANE'} as C"


def emit_repeated(blocks: list[Block], has_tape: bool, sets: int) -> tuple[str, list[CodeLine], list[CodeLine]]:
    """A module for measurements, in which every line of ``evaluate`` is a loop ``e0``, ``e1``, ... and every line of
    ``tangent`` a loop ``t0``, ...; and these lines."""
    evaluate, tangent = evaluate_lines(blocks, has_tape, sets), tangent_lines(blocks, has_tape, sets)
    text = _head(blocks, has_tape, "Emitted by mbdsl to measure scenes of")
    for name, lines in (("e", evaluate), ("t", tangent)):
        for k, line in enumerate(lines):
            head = f"def {name}{k}(count, {TANGENT_ARGUMENTS}):"
            text += [head, f"    factors = Factors({', '.join(FACTORS)})", "    for _ in range(count):"]
            text += [f"        {line.text}", "", ""]
    return "\n".join(text[:-1]), evaluate, tangent


def header(block: int) -> int:
    """The offset of the header of a block in layout."""
    return L.BLOCKS + L.BLOCK * block


def emit_kind(block: Block) -> str:
    """The text of the module of one kind: its kernels within the loops, the same in every scene."""
    name, rows, of = block.name, block.rows, block.module
    assert isinstance(of, Declared)
    kernels = row_kernels.module(of).__name__
    package, _, file = kernels.rpartition(".")
    imported = f"from {package} import {file}" if package else f"import {kernels}"
    as_name, end = ("", of.suffix) if file == name else (f" as {name}", of.suffix)
    curve = f"""

@rare
def curve(block, frames, gradients, numbers, layout):
    loops.curve(C, block, {rows}, {name}.hessian{end}, frames, gradients, numbers, layout)
"""
    return f'''"""Emitted by mbdsl: the loops of {name}."""

{imported}{as_name}
{_columns_import(block.spatial)}
from mbdsl.kernels.marks import rare
from mbdsl.system import loops


@rare
def fill(block, frames, gradients, numbers, layout):
    loops.fill(block, {rows}, {name}.gradient{end}, frames, gradients, numbers, layout)
{curve if block.curved else ""}'''


@dataclass(frozen=True)
class Kernels:
    """The compiled functions of one structure."""

    evaluate: Callable
    tangent: Callable
    inertia: Callable


def load(blocks: list[Block], has_tape: bool, sets: int) -> Kernels:
    """Compile the code of a structure or load it."""
    text = emit(blocks, has_tape, sets)
    signatures = {"evaluate": EVALUATE, "tangent": TANGENT, "inertia": INERTIA}
    return Kernels(*code_cache.functions(module_name(text), text, signatures, lambda: _modules(blocks)))


def _modules(blocks: list[Block]) -> list[ModuleType]:
    """The source of the kernels of a structure."""
    kinds = {b.name: b for _, b in _loops(blocks)[1]}.values()
    used = [loops, tangent_loops, expression_tape]
    if any(b.related for b in blocks):
        from mbdsl.system import relation_loops  # few models need it

        used.append(relation_loops)
    loops_of_kinds = [code_cache.import_text(_kind_module(b), emit_kind(b)) for b in kinds]
    declared = [b.module for b in blocks if isinstance(b.module, Declared)]
    kernels = [b.module for b in blocks if isinstance(b.module, ModuleType)]
    kernels += [file for x in declared for file in (x.file, row_kernels.module(x))]
    return [*used, *dict.fromkeys(kernels), *loops_of_kinds]


@dataclass(frozen=True)
class Repeated:
    """The lines of a structure's code, as functions of (count, arguments of ``tangent``) that repeat them."""

    evaluate: list[tuple[CodeLine, Callable]]
    tangent: list[tuple[CodeLine, Callable]]


def load_repeated(blocks: list[Block], has_tape: bool, sets: int) -> Repeated:
    """Compile the lines of a structure separately or load them."""
    text, evaluate, tangent = emit_repeated(blocks, has_tape, sets)
    names = [f"e{k}" for k in range(len(evaluate))] + [f"t{k}" for k in range(len(tangent))]
    found = code_cache.functions(module_name(text), text, dict.fromkeys(names, REPEATED), lambda: _modules(blocks))
    return Repeated(list(zip(evaluate, found, strict=False)), list(zip(tangent, found[len(evaluate) :], strict=True)))


def module_name(text: str) -> str:
    """The name of emitted code in the cache."""
    return "mbdsl_emitted_" + hashlib.sha256(text.encode()).hexdigest()[:16]
