"""The table of all integrators as Markdown, generated from their declarations; part of docs/methods.md.

``python -m mbdsl.integrators.method_reference docs/methods.md`` writes it into the page, between its two markers.
"""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path

from mbdsl.integrators import compiled, shipped_backends, uncompiled
from mbdsl.integrators.method import Method
from mbdsl.storage.output_files import write_text

BEGIN = "<!-- methods: made by `python -m mbdsl.integrators.method_reference docs/methods.md` -->"
END = "<!-- end of methods -->"


def reference() -> str:
    """The number of methods, and tables of their declarations."""
    own = compiled()
    others = {name: module.METHOD for name, module in shipped_backends().items()}
    lines = [
        BEGIN,
        "",
        f"{len(own)} methods are compiled into the step loop:",
        "",
        "| method | order | index | enforces | parameters |",
        "|---|---|---|---|---|",
        *(f"{_identity(method)} {_parameters(method)} |" for method in own.values()),
        "",
        "The steps of these methods are not compiled:",
        "",
        "| method | order | index | enforces | parameters |",
        "|---|---|---|---|---|",
        *(f"{_identity(module.METHOD)} {_parameters(module.METHOD)} |" for module in uncompiled().values()),
        "",
        f"{len(others)} are [integrators of other packages](backends.md). If the order varies, it is the highest one:",
        "",
        "| method | order | index | enforces | needs |",
        "|---|---|---|---|---|",
        *(f"{_identity(method)} {method.needs or 'SciPy, which is always installed'} |" for method in others.values()),
        "",
        END,
    ]
    return "\n".join(lines) + "\n"


def _identity(method: Method) -> str:
    return f"| `{method.name}` | {method.order} | {method.index} | {' and '.join(method.enforces)} |"


def _parameters(method: Method) -> str:
    """Names, defaults and bounds of the parameters; -1/3 and similar bounds as fractions."""
    texts = []
    for name, option in method.parameters.items():
        lower, upper = (Fraction(x).limit_denominator(12) for x in (option.lower, option.upper))
        default = "" if option.default is None else f" {option.default:g},"
        texts.append(f"`--{name}`{default} in [{lower}, {upper}]")
    return "; ".join(texts) or "none"


def insert(page: str) -> str:
    """The text of a page with the table between its markers."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END + "\n")
    return before + reference() + after


if __name__ == "__main__":
    target = Path(sys.argv[1])
    write_text(target, insert(target.read_text(encoding="utf-8")))
