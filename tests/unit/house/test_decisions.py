"""Every decision has its five parts, a command that exists, and a place in the navigation."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "docs" / "decisions"
PAGES = sorted(path for path in FOLDER.glob("*.md") if path.name != "index.md")
PARTS = ["Context", "Decision", "Measurement", "Consequences", "Reconsider"]


def test_all_are_listed():
    index, navigation = (path.read_text(encoding="utf-8") for path in (FOLDER / "index.md", ROOT / "mkdocs.yml"))
    assert len(PAGES) >= 4
    assert sorted(re.findall(r"\(([\w-]+\.md)\)", index)) == [path.name for path in PAGES]
    assert sorted(re.findall(r"decisions/([\w-]+\.md)", navigation)) == sorted(["index.md", *(p.name for p in PAGES)])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page(page):
    """The command names a script, and with it a measurement that the script has; files named on the page exist."""
    text = page.read_text(encoding="utf-8")
    assert [part.rstrip(".") for part in re.findall(r"^\*\*(\w+\.?)\*\*", text, re.MULTILINE)] == PARTS
    (command,) = re.findall(r"^```bash\n(python .*)\n```$", text, re.MULTILINE)
    _, script, *names = command.split()
    source = (ROOT / script).read_text(encoding="utf-8")
    assert not [name for name in names if f"def {name}(" not in source]
    files = re.findall(r"`((?:mbdsl|models|tests)/[\w/]+\.\w+)`", text)
    assert files and not [name for name in files if not (ROOT / name).exists()]
    assert len(text.split()) < 450, "a page at most"
