"""Kernels from the rows of a kind: the text of ``gradient`` and ``hessian`` (:class:`mbdsl.elements.kind.PairKind`).

With the rows g and the motions z of both frames, ``gradient`` writes g and G = dg/dz, ``hessian`` adds d(G^T s)/dz.
The text is compiled like written kernels. Equal subexpressions are one node (:mod:`mbdsl.expressions.symbolic`), and
are computed once. The text is kept in the cache, by a digest of the rows.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from types import ModuleType

from mbdsl.compilation import code_cache
from mbdsl.elements import Declared, row_derivatives
from mbdsl.elements.kind import PairKind
from mbdsl.elements.row_derivatives import PORTS, by_motions, by_rates, functions, rows
from mbdsl.expressions import formulas, spatial_coordinates, symbolic
from mbdsl.expressions.symbolic import Expr, const, coordinate, is_const, walk
from mbdsl.kernels.columns import columns_of
from mbdsl.storage import cache_folder
from mbdsl.system.structure import Block

PREFIX = "mbdsl_rows_"
_OPERATORS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def module(of: Declared) -> ModuleType:
    """The module with the kernels of a kind: that of its file, or made from its rows."""
    if not of.made:
        return of.file
    name = f"{PREFIX}{'in_space_' if of.KIND.spatial else ''}{of.name}"
    return code_cache.import_text(name, text(of.pair, of.name))


def texts_of(blocks: Iterable[Block]) -> list[str]:
    """The texts of the kernels of a structure that are made from rows."""
    declared = dict.fromkeys(b.module for b in blocks if isinstance(b.module, Declared) and b.module.made)
    return [text(x.pair, x.name) for x in declared]


def text(kind: PairKind, name: str) -> str:
    """The text of the kernels of a kind, from the cache or made from its rows."""
    asked = [str(kind.spatial), repr(getattr(kind, "functions", ())), *kind.held.formulas, _own_digest()]
    key = f"rows/{hashlib.sha256(chr(0).join(asked).encode()).hexdigest()[:32]}.py"
    kept = cache_folder.read(key)
    if kept is None:
        kept = _text(kind).encode()
        cache_folder.keep(key, kept)
    return f'"""Made by mbdsl from the rows of {name}."""\n\n{kept.decode()}'


@cache
def _own_digest() -> str:
    """Digest of the code that makes the text."""
    files = (__file__, row_derivatives.__file__, formulas.__file__, symbolic.__file__, spatial_coordinates.__file__)
    return hashlib.sha256(b"".join(Path(str(file)).read_bytes() for file in files)).hexdigest()


def _text(kind: PairKind) -> str:
    layout = columns_of(kind.spatial)
    found, counted = rows(kind), 2 * kind.held.counted
    links, numbers = functions(kind)
    numbers = [*numbers, *map(symbolic.input_signal, kind.held.parameters)]
    names = {x: f"p[{counted + k}]" for k, x in enumerate(numbers)}
    keys = spatial_coordinates.POSITIONS if kind.spatial else symbolic.COORDINATES[:3]
    for port, frame in zip(PORTS, "ab", strict=True):
        names |= {coordinate(port, key): f"frames[{frame}, {i}]" for i, key in enumerate(keys)}
    multipliers = [symbolic.input_signal(f"s[{k}]") for k in range(len(found))]
    names |= {s: f"s[{k}]" for k, s in enumerate(multipliers)}
    angles = {n: k for k, n in enumerate(n for n in walk(*found) if n.op == "angle")}
    entries: dict[str, Expr] = {}
    total = [const(0.0)] * layout.PAIR_POSE
    for k, row in enumerate(found):
        if kind.held.rates[k]:
            gradient = by_rates(row, kind.spatial)
        else:
            entries[f"G[{k}, {layout.VALUE}]"], gradient = row, by_motions(row, kind.spatial, links)
        entries |= {f"G[{k}, {i}]": g for i, g in enumerate(gradient) if not is_const(g, 0.0)}
        total = [x + multipliers[k] * g for x, g in zip(total, gradient, strict=True)]
    second = {
        f"H[{i}, {j}]": h
        for i, g in enumerate(total)
        for j, h in enumerate(by_motions(g, kind.spatial, links))
        if not is_const(h, 0.0)
    }
    evaluated = {n: f"counted({{}}, {{}}, p[{2 * k} : {2 * k + 2}])" for n, k in angles.items()}
    kernels = [_function("gradient", "p, G", entries, "=", names, evaluated)]
    if second:
        kept = {n: f"p[{2 * k + 1}]" for n, k in angles.items()}
        kernels.append(_function("hessian", "p, s, H", second, "+=", names, kept))
    math = sorted({x for x in ("atan2", "cos", "floor", "sin", "sqrt") if any(f"{x}(" in y for y in kernels)})
    head = [f"from math import {', '.join(math)}"] if math else []
    head += ["from mbdsl.kernels.marks import kernel"]
    head += ["from mbdsl.elements.counted_angle import counted"] if angles else []
    return "\n".join([*head, "", "", "\n\n\n".join(kernels), ""])


def _function(
    name: str,
    arguments: str,
    entries: Mapping[str, Expr],
    assign: str,
    names: Mapping[Expr, str],
    angles: Mapping[Expr, str],
) -> str:
    """A kernel that computes expressions and assigns them to entries of an array; numbers are read before. ``angles``
    are the values of angles that count turns, for their arguments."""
    order = walk(*entries.values())
    uses: dict[Expr, int] = {}
    for n in order:
        for x in n.args:
            uses[x] = uses.get(x, 0) + 1
    for x in entries.values():
        uses[x] = uses.get(x, 0) + 1
    lines, known = [], dict[Expr, str]()
    for n in order:
        if n.op == "const":
            known[n] = repr(n.value)
        elif n in names:
            known[n] = _leaf(n)
            lines.append(f"{known[n]} = {names[n]}")
        elif n in angles:
            known[n] = f"c{len(lines)}"
            lines.append(f"{known[n]} = {angles[n].format(*(_bare(known[x]) for x in n.args))}")
        elif uses[n] > 1 and n.op != "neg":
            known[n] = f"c{len(lines)}"
            lines.append(f"{known[n]} = {_term(n, known, False)}")
        else:
            known[n] = _term(n, known)
    lines += [f"{entry} {assign} {_bare(known[x])}" for entry, x in entries.items()]
    body = "\n".join(f"    {x}" for x in lines or ["pass"])
    return f"@kernel\ndef {name}(frames, a, b, {arguments}):\n{body}"


def _leaf(n: Expr) -> str:
    """The name of a number that is read: ``a_xx`` of frame_a, ``s_0``."""
    return f"{n.value[0][-1]}_{n.value[1]}" if n.op == "coordinate" else str(n.value).replace("[", "_").rstrip("]")


def _term(n: Expr, known: Mapping[Expr, str], inside: bool = True) -> str:
    args = [known[x] for x in n.args]
    if n.op == "neg":
        return f"(-{args[0]})" if inside else f"-{args[0]}"
    if n.op in _OPERATORS:
        found = f" {_OPERATORS[n.op]} ".join(args)
        return f"({found})" if inside else found
    if n.op == "ratio":
        return f"({args[0]} / {args[1]} if {args[1]} != 0.0 else 0.0)"
    return f"{n.op}({', '.join(map(_bare, args))})"


def _bare(x: str) -> str:
    """A term without the parentheses around it."""
    if not x.startswith("(") or " if " in x:
        return x
    depth = 0
    for k, c in enumerate(x):
        depth += (c == "(") - (c == ")")
        if depth == 0:
            return x[1:-1] if k == len(x) - 1 else x
    return x
