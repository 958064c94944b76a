"""The one place of specialisation: from the kinds present, a short module that calls their kernels and nothing else.

It evaluates ``sets`` of multipliers: 1 for lam in f, 2 for Phi_q^T mu as well, 3 for Phi_q^T psi with the Phi_q of the
start of the step as well.

``emit`` writes the text, ``load`` compiles it (or finds it compiled). The key is the structure of the scene and the
digest of the package, never a number of the model, so that changing a parameter or an expression compiles nothing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass

from mbdsl import jit, layout
from mbdsl.system import loops, tape
from mbdsl.system.blocks import Block

KIND_PREFIX = "mbdsl_kind_"


def emit(blocks: list[Block], has_tape: bool, sets: int) -> str:
    """The text of the module for these blocks, with so many sets of multipliers."""
    bodies = [(header(k), b) for k, b in enumerate(blocks) if b.role == "body"]
    pairs = [(header(k), b) for k, b in enumerate(blocks) if b.role in ("joint", "spring", "law")]
    roles = {b.role for b in blocks}
    evaluate = ["loops.start(Y, Z, F, I)"]
    if sets > 2:
        evaluate.append("loops.keep(Y, Z, C, I)")
    evaluate += [f"{b.name}.move({h}, Y, Z, F, I)" for h, b in bodies]
    if has_tape:
        evaluate.append("tape.run(t, 0, I[TAPE_LENGTH], Y, Z, F, I)")
    if "moving" in roles:
        evaluate.append("loops.carry(Z, F, I)")
    evaluate += [f"{b.name}.fill({h}, Z, C, F, I)" for h, b in pairs]
    if "joint" in roles:
        evaluate.append(f"loops.constraints{'_with_mu' if sets > 1 else ''}(Y, Z, C, F, I)")
    if any(b.driven for b in blocks):
        evaluate.append("loops.drive(Y, F, I)")
    if "gamma" in roles:
        evaluate.append("loops.gammas(Y, Z, F, I)")
    if "spring" in roles:
        evaluate.append("loops.springs(Z, C, F, I)")
    if "law" in roles:
        evaluate.append("loops.laws(Z, C, F, I)")
    collect = "collect_with_mu" if sets > 1 and "joint" in roles else "collect"
    evaluate += [f"{b.name}.{collect}({h}, Y, Z, I)" for h, b in bodies]
    if sets > 2 and "joint" in roles:
        evaluate.append("loops.remember(Y, Z, C, I)")
        evaluate += [f"{b.name}.collect_past({h}, Y, Z, I)" for h, b in bodies]

    tangent = ["loops.begin_matrix(cM, F, I, A)"]
    tangent += [f"{b.name}.jacobians({h}, Y, Z, F, I)" for h, b in bodies]
    if has_tape:
        tangent.append("tape.run(t, I[TAPE_LENGTH], I[GRADIENT_LENGTH], Y, Z, F, I)")
    tangent += [f"{b.name}.curve({h}, Z, C, F, I)" for h, b in pairs if b.curved]
    if "joint" in roles:
        tangent.append("loops.constraint_tangents(cK, cP, cN, Y, C, F, I, A)")
    if "gamma" in roles:
        tangent.append("loops.gamma_tangents(F.size - 72, cK, cD, cV, cW, Y, F, I, A)")
    if "spring" in roles:
        tangent.append("loops.spring_tangents(F.size - 72, cK, cD, C, F, I, A)")
    if "law" in roles:
        tangent.append("loops.law_tangents(F.size - 72, cK, cD, cL, C, F, I, A)")
    tangent += [f"{b.name}.stiffness({h}, cK, Z, I, A)" for h, b in bodies if b.module.stiffness is not None]

    lines = [
        f'"""Emitted by mbdsl for scenes of: {", ".join(dict.fromkeys(b.name for b in blocks))}."""',
        "",
        *dict.fromkeys(f"import {KIND_PREFIX}{b.name} as {b.name}" for h, b in pairs),
        "",
        *(f"from mbdsl.elements import {b.name}" for h, b in bodies),
        *(["from mbdsl.layout import GRADIENT_LENGTH, TAPE_LENGTH"] if has_tape else []),
        f"from mbdsl.system import loops{', tape' if has_tape else ''}",
        "",
        "",
        "def evaluate(t, Y, Z, C, F, I):",
        *(f"    {line}" for line in evaluate),
        "",
        "",
        "def tangent(t, cM, cK, cD, cL, cP, cN, cV, cW, Y, Z, C, F, I, A):",
        *(f"    {line}" for line in tangent),
        "",
    ]
    return "\n".join(lines)


def header(block: int) -> int:
    """Where the header of a block stands in I."""
    return layout.BLOCKS + layout.BLOCK * block


def emit_kind(block: Block) -> str:
    """The text of the module of one kind: its kernels under the loops, the same for every scene it is in."""
    name, rows = block.name, block.rows
    curve = f"""

def curve(block, Z, C, F, I):
    loops.curve(block, {rows}, {name}.hessian, Z, C, F, I)
"""
    return f'''"""Emitted by mbdsl: the loops of {name}."""

from mbdsl.elements import {name}
from mbdsl.system import loops


def fill(block, Z, C, F, I):
    loops.fill(block, {rows}, {name}.gradient, Z, C, F, I)
{curve if block.curved else ""}'''


@dataclass(frozen=True)
class Kernels:
    """The compiled functions of one structure."""

    evaluate: Callable
    tangent: Callable


def load(blocks: list[Block], has_tape: bool, sets: int) -> Kernels:
    """Compile the code of a structure, or find it compiled."""
    jit.activate(loops, tape, *{b.module for b in blocks})
    for block in blocks:
        if block.role in ("joint", "spring", "law"):
            jit.import_text(KIND_PREFIX + block.name, emit_kind(block), {"fill": None, "curve": None})
    text = emit(blocks, has_tape, sets)
    functions = {"evaluate": evaluate_signature(), "tangent": tangent_signature()}
    module = jit.import_text(module_name(text), text, functions)
    return Kernels(module.evaluate, module.tangent)


def module_name(text: str) -> str:
    """The name under which emitted code is kept."""
    return "mbdsl_emitted_" + hashlib.sha256(text.encode()).hexdigest()[:16]


def array_types():
    """(float64 vector, float64 matrix, int64 vector, int64 matrix) as numba types."""
    types = jit.numba().types  # type: ignore[union-attr]
    return (
        types.Array(types.float64, 1, "C"),
        types.Array(types.float64, 2, "C"),
        types.Array(types.int64, 1, "C"),
        types.Array(types.int64, 2, "C"),
    )


def evaluate_signature():
    """evaluate(t, Y, Z, C, F, I), None where JIT is off."""
    if not jit.enabled():
        return None
    types = jit.numba().types  # type: ignore[union-attr]
    vector, matrix, ints, _ = array_types()
    return types.void(types.float64, matrix, matrix, matrix, vector, ints)


def tangent_signature():
    """tangent(t, cM, cK, cD, cL, cP, cN, cV, cW, Y, Z, C, F, I, A), None where JIT is off."""
    if not jit.enabled():
        return None
    types = jit.numba().types  # type: ignore[union-attr]
    vector, matrix, ints, _ = array_types()
    return types.void(*[types.float64] * 9, matrix, matrix, matrix, vector, ints, vector)
