"""Tables as files: Markdown, LaTeX, and CSV from records. Cells keep their digits; names and texts are escaped."""

from __future__ import annotations

import csv
import io
import math
import os
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

from mbdsl.messages import cell, visible, width
from mbdsl.plotting.figures import TextTable
from mbdsl.plotting.html_tables import numeric_columns, without_empty
from mbdsl.storage.output_files import suffix_of, write_text

SUFFIXES = (".md", ".tex", ".csv")
LONG = 45  #: rows of a LaTeX table above which it continues on the next page
#: a number in a cell: sign, digits, exponent
_NUMBER = re.compile(r"(?<![\w.\-+])([-+−]?)(\d[\d,]*\.?\d*|\.\d+)(?:[eE]([-+]?\d+)|·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?(?![\w.])")
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_MARKDOWN = re.compile(r"([\\`*_|]|^#)")
_ENTITIES = (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("~~", "&#126;&#126;"))  #: that all dialects of it read
_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"$<$",
    ">": r"$>$",
    "|": r"$|$",
    '"': "''",
    "−": "$-$",
    "·": r"$\cdot$",
    "×": r"$\times$",
    "±": r"$\pm$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "≈": r"$\approx$",
    "°": r"$^\circ$",
    "µ": r"$\mu$",
    "…": r"\ldots{}",
    "–": "--",
    "—": "---",
    "ä": r"\"a",
    "ö": r"\"o",
    "ü": r"\"u",
    "ß": r"\ss{}",
} | {c: f"$^{{{c.translate(_SUPERSCRIPTS)}}}$" for c in "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"}
_GREEK = {
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "ε": "varepsilon", "ζ": "zeta", "η": "eta", "θ": "theta",
    "λ": "lambda", "μ": "mu", "ν": "nu", "ξ": "xi", "π": "pi", "ρ": "rho", "σ": "sigma", "τ": "tau", "φ": "varphi",
    "χ": "chi", "ψ": "psi", "ω": "omega", "Φ": "Phi", "Δ": "Delta", "Ω": "Omega", "Γ": "Gamma", "Λ": "Lambda",
}  # fmt: skip


def write(
    path: str | os.PathLike,
    tables: Sequence[TextTable],
    records: Sequence[Mapping],
    title: str = "",
    notes: Sequence[str] = (),
) -> None:
    """Write tables to a file.

    Parameters
    ----------
    path : path
        The file; its suffix selects the format: .md, .tex, or .csv.
    tables : sequence of Table
        Tables, for .md and .tex. Those without rows are omitted.
    records : sequence of mapping
        Rows with all digits, for .csv: column -> number or text. Columns that a row lacks are empty.
    title : str, optional
        Heading of the file.
    notes : sequence of str, optional
        Sentences after the tables.

    Raises
    ------
    UsageError
        If the suffix is unknown, or the file cannot be written.
    """
    suffix = suffix_of(path, SUFFIXES)
    if suffix == ".csv":
        write_text(path, as_csv(records))
    else:
        made = as_markdown if suffix == ".md" else as_latex
        write_text(path, made([without_empty(t) for t in tables if t.rows], title, notes))


def as_csv(records: Sequence[Mapping]) -> str:
    """Records as CSV (RFC 4180), with all digits of numbers; a value that is not finite is empty."""
    names = list(dict.fromkeys(name for record in records for name in record))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(cell, names))
    writer.writerows([_cell(record.get(name)) for name in names] for record in records)
    return text.getvalue()


def _cell(x: object) -> object:
    if isinstance(x, float):
        return repr(float(x)) if math.isfinite(x) else ""
    return cell(visible(x, line=True)) if isinstance(x, str) else x


def as_markdown(tables: Sequence[TextTable], title: str = "", notes: Sequence[str] = ()) -> str:
    """Tables in Markdown (pipe tables), with columns that are aligned in the text, too."""
    parts = [f"# {_marked(title)}"] if title else []
    for table in tables:
        parts += [f"## {_marked(table.title)}"] if table.title else []
        rows = [[_marked(cell) for cell in row] for row in (table.columns, *table.rows)]
        right = numeric_columns(table)
        widths = [max(3, *(width(row[k]) for row in rows)) for k in range(len(table.columns))]
        lines = [_piped(rows[0], widths, right)]
        rule = ("-" * (n - 1) + ":" if r else "-" * n for n, r in zip(widths, right, strict=True))
        lines.append(f"| {' | '.join(rule)} |")
        lines += [_piped(row, widths, right) for row in rows[1:]]
        parts.append("\n".join(lines))
        parts += [_marked(table.note)] if table.note else []
    parts += map(_marked, notes)
    return "\n\n".join(parts) + "\n"


def _piped(row: Sequence[str], widths: Sequence[int], right: Sequence[bool]) -> str:
    blanks = (" " * (n - width(cell)) for cell, n in zip(row, widths, strict=True))
    cells = (b + cell if r else cell + b for cell, b, r in zip(row, blanks, right, strict=True))
    return f"| {' | '.join(cells)} |"


def _marked(text: str) -> str:
    found = _MARKDOWN.sub(r"\\\1", visible(" ".join(str(text).split()), line=True))
    for sign, entity in _ENTITIES:
        found = found.replace(sign, entity)
    return found


def as_latex(tables: Sequence[TextTable], title: str = "", notes: Sequence[str] = ()) -> str:
    """Tables in LaTeX, for \\input: ``tabular``, which needs no package, or ``longtable`` for long ones."""
    long = any(len(table.rows) > LONG for table in tables)
    parts = [f"% {_ascii(title)}"] if title else []
    parts += [r"% needs \usepackage{longtable}"] if long else []
    for table in tables:
        parts.append("\n".join(_tabular(table)))
    parts += (rf"\noindent {latex(note)}\par" for note in notes)
    return "\n\n".join(parts) + "\n"


def _tabular(table: TextTable) -> Iterable[str]:
    right = numeric_columns(table)
    head, rows = table.columns, table.rows
    kind = "longtable" if len(rows) > LONG else "tabular"
    if table.title:
        yield rf"\noindent\textbf{{{latex(table.title)}}}\par\smallskip"
    sides = "".join("r" if r else "l" for r in right)
    yield rf"{'' if kind == 'longtable' else chr(92) + 'noindent'}\begin{{{kind}}}{{{sides}}}"
    yield r"\hline"
    yield rf"{' & '.join(map(latex, head))} \\"
    yield r"\hline"
    if kind == "longtable":
        yield r"\endhead"
    yield from (rf"{' & '.join(map(_number, row))} \\" for row in rows)
    yield r"\hline"
    yield rf"\end{{{kind}}}"
    if table.note:
        yield rf"\par\smallskip\noindent {latex(table.note)}\par"


def _number(text: str) -> str:
    """A cell in LaTeX: 1.5e-07 as 1.5·10^-7 with a minus sign, other text escaped."""
    found, at = [], 0
    for match in _NUMBER.finditer(text):
        sign, digits, exponent, power = match.groups()
        exponent = exponent or (power.translate(_SUPERSCRIPTS) if power else None)
        if not sign and exponent is None:
            continue
        found.append(latex(text[at : match.start()]))
        sign = "-" if sign in ("-", "−") else sign
        times = rf"\cdot10^{{{int(exponent)}}}" if exponent is not None else ""
        found.append(f"${sign}{digits.replace(',', '{,}')}{times}$")
        at = match.end()
    return "".join([*found, latex(text[at:])])


def latex(text: str) -> str:
    """A text with the characters of LaTeX escaped; letters without a LaTeX name lose their accents, or become ``?``."""
    letters = "".join(_letter(c) for c in " ".join(str(text).split()))
    return letters.replace("--", "-{}-") if "--" in text else letters  # not the dash that LaTeX makes of two hyphens


def _letter(c: str) -> str:
    if c in _LATEX:
        return _LATEX[c]
    if c in _GREEK:
        return rf"$\{_GREEK[c]}$"
    return c if c.isascii() and c.isprintable() else _ascii(c) or "?"


def _ascii(text: str) -> str:
    return "".join(c for c in unicodedata.normalize("NFKD", text) if c.isascii() and c.isprintable())
