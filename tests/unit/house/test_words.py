"""Words that mark sentences to be rewritten: see the rules in CONTRIBUTING.md."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[3]
MARKS = re.compile(r"\b(told|somebody|whoever)\b", re.IGNORECASE)
TEXTS = {".py", ".md", ".js", ".css", ".toml", ".yml", ".lark"}
#: stored texts of others, and this file
LEFT_OUT = ("tests/data/", "tests/unit/house/test_words.py")


def test_no_page_file_or_test_has_a_mark():
    files = [*ROOT.glob("*.*"), *(path for folder in ("docs", "mbdsl", "tests") for path in (ROOT / folder).rglob("*"))]
    names = {path.relative_to(ROOT).as_posix(): path for path in files if path.suffix in TEXTS}
    names = {name: path for name, path in names.items() if not name.startswith(LEFT_OUT)}
    assert len(names) > 350
    lines = [
        f"{name}:{number}: {line.strip()}"
        for name, path in names.items()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if MARKS.search(line)
    ]
    assert lines == []
