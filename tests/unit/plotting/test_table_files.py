"""Tables as files: read back by Python-Markdown and csv, and compiled by LaTeX where it is installed."""

import csv
import io
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import markdown
import pytest

from mbdsl.errors import UsageError
from mbdsl.lang.load import load
from mbdsl.plotting.figures import TextTable
from mbdsl.plotting.table_files import LONG, as_csv, as_latex, latex, numeric_columns, write
from mbdsl.studies import tables
from mbdsl.studies.effects import EffectsStudy, Without

MODELS = Path(__file__).parents[3] / "models"
ODD = r"a_b|c & 50 % $x$ {y} #1 ~z^2 \n <i> `k` *m* é Ω α ° µ 10⁻³ × · − – … 漢 --tol \end{tabular}"
TABLE = TextTable(
    "Errors_1",
    ("method", "step [s]", "error [N.m]", "empty", "slope"),
    [
        ("hht-si2", "0.001", "1.50e-07", "", "1.99 ± 0.02"),
        (ODD, "-2.50", "(3e+10)", "", "failed"),
        ("short", "1,234"),
    ],
    "A note_2.",
)


def cells(html):
    root = ElementTree.fromstring(f"<x>{html}</x>")
    return [["".join(cell.itertext()).strip() for cell in row] for row in root.iter("tr")], root


def test_markdown(tmp_path):
    write(tmp_path / "a.md", [TABLE, TextTable("none", ("a",), ())], [], "T_i*t*le", ["Last_note_."])
    text = (tmp_path / "a.md").read_text(encoding="utf-8")
    (head, *rows), root = cells(markdown.markdown(text, extensions=["tables"]))
    assert head == ["method", "step [s]", "error [N.m]", "slope"]
    assert rows == [
        ["hht-si2", "0.001", "1.50e-07", "1.99 ± 0.02"],
        [ODD, "-2.50", "(3e+10)", "failed"],
        ["short", "1,234", "", ""],
    ]
    assert root.find("h1").text == "T_i*t*le" and root.find("h2").text == "Errors_1"
    assert [p.text for p in root.iter("p")] == ["A note_2.", "Last_note_."]
    assert not list(root.iter("em")) and not list(root.iter("i"))
    lines = [line for line in text.splitlines() if line.startswith("|") and ODD[:3] not in line.replace("\\", "")]
    assert len({len(line) for line in lines}) == 1  # aligned as text, too


def test_csv_has_all_digits_and_quotes():
    records = [{"x [m]": 0.1 + 0.2, "text": 'a,"b"\nc'}, {"x [m]": float("nan"), "n": 3}]
    rows = list(csv.DictReader(io.StringIO(as_csv(records))))
    assert float(rows[0]["x [m]"]) == 0.1 + 0.2 and rows[1] == {"x [m]": "", "text": "", "n": "3"}
    assert rows[0]["text"] == 'a,"b"\\nc'


def test_numbers_of_latex_keep_their_digits():
    text = as_latex([TABLE])
    assert r"$1.50\cdot10^{-7}$" in text and "$-2.50$" in text and r"($3\cdot10^{10}$)" in text
    assert "hht-si2" in text and "0.001" in text and "1,234" in text
    assert r"Errors\_1" in text and r"A note\_2." in text
    assert latex("a_1 & 5 %") == r"a\_1 \& 5 \%" and latex("--tol") == "-{}-tol"
    # all that is left of the special characters is in commands
    assert re.findall(r"(?<!\\)[&%#_]", latex(ODD)) == []


def test_alignment():
    assert numeric_columns(TABLE) == [False, True, True, False, False]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="LaTeX is not installed")
def test_latex_compiles(tmp_path):
    long = TextTable("Long", ("k", ODD), [(str(k), "1e-3") for k in range(2 * LONG)])
    write(tmp_path / "a.tex", [TABLE, long], [], ODD, [ODD])
    main = r"\documentclass{article}\usepackage{longtable}\begin{document}\input{a.tex}\end{document}"
    (tmp_path / "main.tex").write_text(main, encoding="utf-8")
    command = ("pdflatex", "-interaction=nonstopmode", "-halt-on-error", "main.tex")
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout[-2000:]


def test_suffixes(tmp_path):
    for name in ("a.xls", "a"):
        with pytest.raises(UsageError, match="suffix"):
            write(tmp_path / name, [TABLE], [])


def test_effects_as_tables(tmp_path):
    rows = (Without(("friction",), 1.25e-3, 0.5), Without(("gravity",), None, None, "does not run: no weight"))
    scene = load(MODELS / "pendulum.mbd")
    study = EffectsStudy(scene, "mass.x", "m", -1.0, 1.0, 1e-6, 0.01, rows, ("damping",))
    tables.write(study, tmp_path / "a.csv")
    found = list(csv.DictReader(io.StringIO((tmp_path / "a.csv").read_text(encoding="utf-8"))))
    assert found[0]["change [m]"] == "0.00125" and found[0]["outcome"] == "done"
    assert found[1]["change [m]"] == "" and "no weight" in found[1]["outcome"]
    tables.write(study, tmp_path / "a.md")
    text = (tmp_path / "a.md").read_text(encoding="utf-8")
    assert "change of mass.x [m]" in text and "1.250e-03" in text and "no weight" in text


def test_commands_write_tables(say, tmp_path):
    pendulum, crank = MODELS / "pendulum.mbd", MODELS / "slider_crank.mbd"
    study = ("study", "convergence", pendulum, "--methods", "hht-si2", "--steps", "20ms,10ms", "--stop", "1s")
    code, out, _ = say(*study, "--pictures", "pdf", "--table", "errors.tex")
    assert code == 0 and "errors.tex: tables" in out
    assert r"\begin{tabular}" in (tmp_path / "errors.tex").read_text(encoding="utf-8")
    pictures = sorted((tmp_path / "pendulum-convergence").glob("*.pdf"))
    assert "convergence-q.pdf" in [path.name for path in pictures]
    for path in pictures:
        assert b"/FontFile2" in path.read_bytes() and b"/Type3" not in path.read_bytes(), path
    code, _, err = say(*study, "--table", "errors.xls")
    assert code == 2 and "known suffixes are .md, .tex, .csv" in err
    code, _, err = say(*study, "--pictures", "pdf,gif")
    assert code == 2 and "known suffixes are png, svg, pdf" in err
    assert say("eigen", crank, "--output", "modes.md")[0] == 0
    assert "damped [Hz]" in (tmp_path / "modes.md").read_text(encoding="utf-8")
    assert say("linearise", crank, "--output", "linear.tex")[0] == 0
    text = (tmp_path / "linear.tex").read_text(encoding="utf-8")
    assert "Matrix A" in text and "O.phi" in text
