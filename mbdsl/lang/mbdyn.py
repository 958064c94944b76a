"""Recognition of MBDyn's input files, which have the same suffix."""

from __future__ import annotations

import re

from mbdsl.errors import SyntaxProblem
from mbdsl.lang.source import Source

_MBDYN = re.compile(
    r"\A(?:\s|#[^\n]*\n|//[^\n]*\n|/\*.*?\*/|(?:set|include|module load|remark|print symbol table)\b[^;\n]*;)*?"
    r"(begin\s*:\s*(?:data|initial value|control data|nodes|elements)\s*;)",
    re.DOTALL | re.IGNORECASE,
)


def refuse_mbdyn(source: Source) -> None:
    found = _MBDYN.match(source.text[:20_000])
    if found:
        raise SyntaxProblem(
            "this is an input file of MBDyn, which uses the same suffix .mbd; mbdsl cannot read it",
            source.span(*found.span(1)),
            "run it with `mbdyn`; a model of mbdsl begins with `model Name`",
        )
